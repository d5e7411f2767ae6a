//! `persistent/update_guide`: what a surfel's rays brought, into its guide (I6).
use crate::data::{Frame, Path, Ray, SurfelGuide, SurfelIrradiance, SurfelPose};
use crate::shared::{estimator, guide, hash, sampling};
use gibs_graph::{Workgroup, stage};
use glam::Vec4;
use std::f32::consts::PI;

stage! {
    /// Feeds the luminance that came along each ray to the moving average of its texel, and renormalizes the guide (GIBS,
    /// "Ray Guiding"). A path's light counts as far as the lobe is there to find it: what emitter sampling finds as well
    /// counts by the lobe's share of the balance heuristic, and rays to emitters teach nothing.
    pub stage UpdateGuide {
        wgsl: gibs_shaders::stages::UPDATE_GUIDE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            read poses: SurfelPose,
            read offsets: u32,
            read rays: Ray,
            read paths: Path,
            read radiance: Vec4,
            read irradiance: SurfelIrradiance,
            read_write guides: SurfelGuide,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let (first, last) = (p.offsets[i] as usize, p.offsets[i + 1] as usize);
        if first == last {
            continue;
        }
        let pose = &p.poses[i];
        // Before its first rays are integrated, a surfel's guide is that of the one that had the slot before.
        let old = match p.irradiance[i].samples {
            0 => SurfelGuide::default(),
            _ => p.guides.get(i),
        };
        let mut luminances = guide::unpack(&old);
        let mut known = old.scale & 0xffff;
        for ray in first..last {
            let path = &p.paths[ray];
            if path.density <= 0.0 || path.cosine <= 0.0 {
                continue;
            }
            let brought = estimator::luminance(p.radiance[ray].truncate());
            let luminance = brought * (path.density * PI / path.cosine);
            let local = sampling::to_local(p.rays[ray].direction, pose.normal);
            let texel = guide::texel_of(local) as usize;
            let blend = (1.0 / (1.0 + known as f32 / guide::TEXELS as f32)).max(guide::BLEND);
            luminances[texel] += (luminance - luminances[texel]) * blend;
            known += 1;
        }
        let seed = hash::hash3(pose.identity, p.frame.number, p.frame.seed);
        let packed = guide::pack(&luminances, known, |t| hash::unit(hash::hash2(seed, t)));
        p.guides.set(i, packed);
    }
}
