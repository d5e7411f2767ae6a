//! `apply/expose`: the picture as a screen shows it.
use gibs::graph::glam::Vec4;
use gibs::graph::{DispatchArgs, WgslSource, Workgroup, stage};

stage! {
    /// Radiance times exposure, brought below 1 by the curve x / (1 + x).
    pub stage Expose {
        wgsl: WgslSource {
            name: "expose",
            text: include_str!("expose.wgsl"),
            modules: gibs::shaders::MODULES,
            features: &[],
        },
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read color: Vec4,
            read exposure: f32,
            write shown: Vec4,
        },
        cpu: kernel,
        wide: None,
    }
}

/// The curve.
pub fn curve(color: Vec4, exposure: f32) -> Vec4 {
    let x = color.truncate() * exposure;
    (x / (1.0 + x)).extend(color.w)
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        p.shown.set(i, curve(p.color[i], p.exposure[0]));
    }
}
