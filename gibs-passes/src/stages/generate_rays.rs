//! `persistent/generate_rays`: rays over each surfel's cosine lobe (I1).
use crate::data::{Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::{hash, sampling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::Vec3;

stage! {
    /// Draws each surfel's rays with density `cos / pi` (GIBS, "Importance Sampling the BRDF") from its own shifted
    /// low-discrepancy sequence, which goes on from frame to frame.
    pub stage GenerateRays {
        wgsl: gibs_shaders::stages::GENERATE_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read births: SurfelBirth,
            read irradiance: SurfelIrradiance,
            read offsets: u32,
            write rays: Ray,
            write paths: Path,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    simd::run(
        #[inline(always)]
        || kernel(p, group),
    );
}

#[inline(always)]
fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let (first, last) = (p.offsets[i], p.offsets[i + 1]);
        let pose = &p.poses[i];
        let seed = hash::hash2(pose.identity, p.frame.seed);
        let shift = (hash::hash2(seed, 0), hash::hash2(seed, 1));
        for ray in first..last {
            let (u, v) = sampling::r2(p.irradiance[i].samples + (ray - first), shift);
            let direction = sampling::to_world(sampling::cosine_hemisphere(u, v), pose.normal);
            let origin = sampling::start(pose.position, pose.normal, p.births[i].offset, direction);
            p.rays.set(
                ray as usize,
                Ray {
                    origin,
                    t_min: 0.0,
                    direction,
                    t_max: f32::MAX,
                },
            );
            let seed = hash::hash3(seed, p.frame.number, ray - first);
            p.paths.set(
                ray as usize,
                Path {
                    throughput: Vec3::ONE,
                    root: ray,
                    seed,
                    remaining: p.settings.continuations,
                    ..Path::default()
                },
            );
        }
    }
}
