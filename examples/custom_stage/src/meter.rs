//! `apply/meter`: how bright the picture is.
use gibs::graph::glam::Vec4;
use gibs::graph::{DispatchArgs, WgslSource, Workgroup, stage};
use gibs::passes::shared::estimator::luminance;

/// Invocations of the one workgroup.
const LANES: usize = 64;
/// What the mean luminance is brought to.
const GREY: f32 = 0.18;
/// Share of the way to a new exposure that a frame goes.
const SPEED: f32 = 0.25;

stage! {
    /// Follows the exposure that brings the mean luminance of the picture to middle grey. One workgroup: each
    /// invocation sums every 64th pixel, and the first one then adds the sums up in a fixed order.
    pub stage Meter {
        wgsl: WgslSource {
            name: "meter",
            text: include_str!("meter.wgsl"),
            modules: gibs::shaders::MODULES,
            features: &[],
        },
        workgroup: [64, 1, 1],
        ports: { uniform batch: DispatchArgs, read color: Vec4, read_write exposure: f32 },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut sums = [0.0_f32; LANES];
    for (i, color) in p.color[..p.batch.count as usize].iter().enumerate() {
        sums[i % LANES] += luminance(color.truncate());
    }
    let mean = sums.iter().fold(0.0, |all, sum| all + sum) / p.batch.count as f32;
    let target = GREY / mean.max(1e-4);
    p.exposure.update(0, |e| *e += (target - *e) * SPEED);
}
