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
    let each = p.frame.lights_per_point.max(1) as usize;
    let range = group.range(p.batch.count);
    let of_all = range.start * each..range.end * each;
    let (samples, visible) = (&p.samples[of_all.clone()], &p.visible[of_all]);
    let points = samples.chunks_exact(each).zip(visible.chunks_exact(each));
    for (i, (samples, visible)) in range.zip(points) {
        let mut sum = Vec4::ZERO;
        for (sample, _) in samples.iter().zip(visible).filter(|(_, v)| **v != 0) {
            sum += sample.irradiance.extend(0.0);
        }
        p.direct.set(i, sum);
    }
}
