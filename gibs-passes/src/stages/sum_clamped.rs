//! `filtering/clamped`: what the firefly clamp has taken in all (I3).
use crate::data::ClampedLight;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Adds up what the clamp took from each surfel, in a fixed order: each of the workgroup's lanes every 256th surfel, then
    /// pairs of lanes, then the frames before.
    pub stage SumClamped {
        wgsl: gibs_shaders::stages::SUM_CLAMPED,
        workgroup: [256, 1, 1],
        ports: {
            read clamped: ClampedLight,
            read_write total: ClampedLight,
        },
        cpu: kernel,
        wide: None,
    }
}

const LANES: usize = 256;

fn plus(a: ClampedLight, b: &ClampedLight) -> ClampedLight {
    ClampedLight {
        taken: a.taken + b.taken,
        brought: a.brought + b.brought,
        samples: a.samples.wrapping_add(b.samples),
        pad: 0,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut sums = [ClampedLight::default(); LANES];
    for (lane, sum) in sums.iter_mut().enumerate() {
        let own = p.clamped.iter().skip(lane).step_by(LANES);
        *sum = own.fold(ClampedLight::default(), plus);
    }
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] = plus(sums[lane], &sums[lane + half]);
        }
        half /= 2;
    }
    p.total.set(0, plus(p.total.get(0), &sums[0]));
}
