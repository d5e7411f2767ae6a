//! `*/gather_direct`: irradiance that comes straight from lights.
use crate::data::{Frame, LightSample};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{Vec3, Vec4};

stage! {
    /// Sums the light samples of each point that nothing shadows, W/m^2.
    pub stage GatherDirect {
        wgsl: gibs_shaders::stages::GATHER_DIRECT,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            read samples: LightSample,
            read visible: u32,
            write direct: Vec4,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Irradiance of element `i` from the sun and the lights, W/m^2; none in a frame without `direct`.
#[inline]
pub fn direct_irradiance(direct: &[Vec4], i: usize) -> Vec3 {
    direct.get(i).map_or(Vec3::ZERO, |d| d.truncate())
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let each = p.frame.lights_per_point as usize;
    for i in group.range(p.batch.count) {
        let mut sum = Vec3::ZERO;
        for k in i * each..(i + 1) * each {
            if p.visible[k] != 0 {
                sum += p.samples[k].irradiance;
            }
        }
        p.direct.set(i, sum.extend(0.0));
    }
}
