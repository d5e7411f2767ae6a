//! `persistent/update_depth`: distances of rays into the depth functions (S14).
use crate::data::{Hit, Ray, SurfelDepth, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::lookup::{DEPTH_SIDE, moments, pack_moments};
use crate::shared::{octahedral, sampling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{Vec2, Vec3};

stage! {
    /// Feeds each ray's distance to the depth function of its surfel (GIBS, "Radial Gaussian Depth"): those that go
    /// farther than the diameter count as the diameter. Where rays were sorted, `places` tells where each went.
    pub stage UpdateDepth {
        wgsl: gibs_shaders::stages::UPDATE_DEPTH,
        workgroup: [64, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            read offsets: u32,
            read rays: Ray,
            read hits: Hit,
            optional_read places: u32,
            read_write depths: SurfelDepth,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

/// Rays after which a texel's share of a new distance has halved from all.
pub const DEPTH_SETTLES: f32 = 32.0;

/// Share of a new distance in a texel's moments: the first ones replace the initial diameter, which is a guess; the
/// share then falls to that of the moving average.
#[inline]
pub fn depth_blend(samples: u32, least: f32) -> f32 {
    least.max(DEPTH_SETTLES / (DEPTH_SETTLES + samples as f32))
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
        let (first, last) = (p.offsets[i] as usize, p.offsets[i + 1] as usize);
        if first == last {
            continue;
        }
        let pose = &p.poses[i];
        let before = p.irradiance[i].drawn;
        let mut depth = p.depths.get(i);
        for ray in first..last {
            let local = sampling::to_local(p.rays[ray].direction, pose.normal);
            let uv = octahedral::hemisphere_encode(Vec3::new(local.x, local.y, local.z.max(0.0)));
            let at = |x: f32| ((x * DEPTH_SIDE as f32) as u32).min(DEPTH_SIDE - 1);
            let texel = (at(uv.y) * DEPTH_SIDE + at(uv.x)) as usize;
            let hit = p.places.get(ray).map_or(ray, |&place| place as usize);
            let t = (p.hits[hit].t / (2.0 * pose.radius)).min(1.0);
            let blend = depth_blend(before + (ray - first) as u32, p.settings.depth_blend);
            let old = moments(depth.texels[texel]);
            let new = old + (Vec2::new(t, t * t) - old) * blend;
            depth.texels[texel] = pack_moments(new);
        }
        p.depths.set(i, depth);
    }
}
