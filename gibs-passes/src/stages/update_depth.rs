//! `persistent/update_depth`: distances of rays into the depth functions (S14).
use crate::data::{Hit, Ray, SurfelDepth, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::lookup::{DEPTH_SIDE, FARTHEST, UNKNOWN, moments, pack_moments};
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

/// Share of a new distance in a texel's moments: the first ones count for much, since their mean is of few; the share
/// then falls to that of the moving average.
#[inline]
pub fn depth_blend(samples: u32, least: f32) -> f32 {
    least.max(DEPTH_SETTLES / (DEPTH_SETTLES + samples as f32))
}

/// Takes a distance, in diameters, into a texel. The first one replaces what was there, which is a guess: the texels at the
/// rim across the corners of the square see one ray in forty, and would stay half open beside a wall for long.
#[inline]
pub fn learn(texel: u32, t: f32, blend: f32) -> u32 {
    let new = Vec2::new(t, t * t);
    if texel == UNKNOWN {
        return pack_moments(new);
    }
    let old = moments(texel);
    pack_moments(old + (new - old) * blend)
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
            // One that could not reach the emitter it was drawn for went nowhere.
            if p.rays[ray].t_max <= 0.0 {
                continue;
            }
            let local = sampling::to_local(p.rays[ray].direction, pose.normal);
            let uv = octahedral::hemisphere_encode(Vec3::new(local.x, local.y, local.z.max(0.0)));
            let at = |x: f32| ((x * DEPTH_SIDE as f32) as u32).min(DEPTH_SIDE - 1);
            let texel = (at(uv.y) * DEPTH_SIDE + at(uv.x)) as usize;
            let hit = p.places.get(ray).map_or(ray, |&place| place as usize);
            let t = (p.hits[hit].t / (2.0 * pose.radius)).min(FARTHEST);
            let blend = depth_blend(before + (ray - first) as u32, p.settings.depth_blend);
            depth.texels[texel] = learn(depth.texels[texel], t, blend);
        }
        p.depths.set(i, depth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A blend of a sixth, as after 160 rays, would leave five sixths of the guess.
    #[test]
    fn the_first_ray_of_a_texel_replaces_the_guess() {
        let learned = learn(UNKNOWN, 0.2, 1.0 / 6.0);
        assert!(
            (moments(learned) - Vec2::new(0.2, 0.04))
                .abs()
                .max_element()
                < 1e-4
        );
        let again = moments(learn(learned, 0.8, 0.5));
        assert!((again - Vec2::new(0.5, 0.34)).abs().max_element() < 1e-4);
    }

    #[test]
    fn a_texel_that_has_learned_is_known() {
        let mut texel = UNKNOWN;
        for _ in 0..100 {
            texel = learn(texel, FARTHEST, 1.0);
            assert_ne!(texel, UNKNOWN);
        }
    }
}
