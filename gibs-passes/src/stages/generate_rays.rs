//! `persistent/generate_rays`: rays over each surfel's cosine lobe (I1), and to emitters (L6).
use crate::data::{
    Emitter, Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings,
};
use crate::shared::{hash, mixture, sampling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::Vec3;

stage! {
    /// Draws each surfel's rays with density `cos / pi` (GIBS, "Importance Sampling the BRDF") from its own shifted
    /// low-discrepancy sequence, which goes on from frame to frame. In a scene with emissive triangles, a share of them
    /// goes to points on those, drawn by power.
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
            optional_read emitters: Emitter,
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
    let emitters = !p.emitters.is_empty();
    for i in group.range(p.poses.len() as u32) {
        let (first, last) = (p.offsets[i], p.offsets[i + 1]);
        let pose = &p.poses[i];
        let surfel = hash::hash2(pose.identity, p.frame.seed);
        let shift = (hash::hash2(surfel, 0), hash::hash2(surfel, 1));
        for ray in first..last {
            let index = p.irradiance[i].samples + (ray - first);
            let seed = hash::hash3(surfel, p.frame.number, ray - first);
            let uv = sampling::r2(index, shift);
            let drawn = if emitters && mixture::goes_to_emitter(index, hash::hash2(surfel, 2)) {
                mixture::to_emitter(&p.emitters, pose.position, pose.normal, uv, seed)
            } else {
                mixture::over_the_lobe(pose.normal, uv, emitters)
            };
            let direction = drawn.direction;
            let origin = sampling::start(pose.position, pose.normal, p.births[i].offset, direction);
            p.rays.set(
                ray as usize,
                Ray {
                    origin,
                    t_min: 0.0,
                    direction,
                    t_max: drawn.t_max,
                },
            );
            p.paths.set(
                ray as usize,
                Path {
                    throughput: Vec3::ONE,
                    root: ray,
                    seed,
                    remaining: p.settings.continuations,
                    cosine: drawn.cosine,
                    density: drawn.density,
                },
            );
        }
    }
}
