//! `persistent/update_depth`: distances of rays into the depth functions (S14).
use crate::data::{Hit, Ray, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::depth::{
    FARTHEST, KNOWN, RADIUS_STEPS, UNKNOWN, count, guess, index, is_known, moments, pack_moments,
};
use crate::shared::{octahedral, plane, requests, sampling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec2, Vec3};
use std::ops::Range;

stage! {
    /// Feeds each ray's distance to the depth function of its surfel (GIBS, "Radial Gaussian Depth"): those that go
    /// farther than the diameter count as the diameter, and those that go below the surface for nothing. What a young
    /// surfel's rays have not reached takes the distance of what is close beside it. Where rays were sorted, `places` tells where each went.
    pub stage UpdateDepth {
        wgsl: gibs_shaders::stages::UPDATE_DEPTH,
        workgroup: [64, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            read spans: UVec2,
            read rays: Ray,
            read hits: Hit,
            optional_read places: u32,
            read_write depths: u32,
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
/// rim across the corners of the square see one ray in forty, and would stay half open or half closed for long.
#[inline]
pub fn learn(texel: u32, t: f32, blend: f32) -> u32 {
    let mut new = Vec2::new(t, t * t);
    if is_known(texel) {
        let old = moments(texel);
        new = old + (new - old) * blend;
    }
    pack_moments(new.max(KNOWN))
}

/// Rays that a surfel has drawn when it stops to guess, and takes what none has reached for open: the fourth power of the side. The
/// corners of the square meet the fewest rays, one in 45 of 4x4 texels and one in 636 of 8x8; they have met one by then but
/// for three times in a thousand.
#[inline]
pub fn guesses_for(side: u32) -> u32 {
    side * side * side * side
}

/// What surfels learn distances from.
#[derive(Clone, Copy, Debug)]
pub struct Distances<'a> {
    /// Surfels.
    pub poses: &'a [SurfelPose],
    /// How many rays each has drawn before.
    pub irradiance: &'a [SurfelIrradiance],
    /// First ray of each surfel, and how many.
    pub spans: &'a [UVec2],
    /// Rays.
    pub rays: &'a [Ray],
    /// Their hits.
    pub hits: &'a [Hit],
    /// Of each ray the place of its hit; empty where that is its own.
    pub places: &'a [u32],
    /// Least share of a new distance.
    pub least: f32,
    /// Texels along each side of a depth function.
    pub side: u32,
}

impl<'a> Distances<'a> {
    fn of(p: &Views<'a>) -> Self {
        Self {
            poses: p.poses.slice(),
            irradiance: p.irradiance.slice(),
            spans: p.spans.slice(),
            rays: p.rays.slice(),
            hits: p.hits.slice(),
            places: p.places.slice(),
            least: p.settings.depth_blend,
            side: p.settings.depth_side,
        }
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.poses.len() as u32);
    let (get, set) = (|i| p.depths.get(i), |i, texel| p.depths.set(i, texel));
    simd::update_depth(&Distances::of(p), range.clone(), get, set);
    guess_each(&Distances::of(p), range, get, set);
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.poses.len() as u32);
    let (get, set) = (|i| p.depths.get(i), |i, texel| p.depths.set(i, texel));
    update_each(&Distances::of(p), range.clone(), get, set);
    guess_each(&Distances::of(p), range, get, set);
}

/// Feeds the distances of a range of surfels to their depth functions, whose texels `get` and `set` read and replace.
#[inline]
pub fn update_each(
    d: &Distances<'_>,
    range: Range<usize>,
    get: impl Fn(usize) -> u32,
    mut set: impl FnMut(usize, u32),
) {
    for i in range {
        let (first, last) = requests::range(d.spans[i]);
        if first == last {
            continue;
        }
        let pose = &d.poses[i];
        let across = plane::unpack(pose.mark);
        let before = d.irradiance[i].drawn;
        for ray in first as usize..last as usize {
            let Ray {
                direction, t_max, ..
            } = d.rays[ray];
            // One that could not reach the emitter it was drawn for went nowhere; one that goes below the surface, as some do
            // where the normal leans away from that, tells of what lies behind it, and nothing of what stands on it.
            if t_max <= 0.0 || direction.dot(across) < 0.0 {
                continue;
            }
            let local = sampling::to_local(direction, pose.normal);
            let uv = octahedral::hemisphere_encode(Vec3::new(local.x, local.y, local.z.max(0.0)));
            let texel = index(uv.y, d.side) * d.side + index(uv.x, d.side);
            let texel = i * count(d.side) + texel as usize;
            let hit = d.places.get(ray).map_or(ray, |&place| place as usize);
            let t = (d.hits[hit].t / (2.0 * pose.radius)).min(FARTHEST);
            let blend = depth_blend(before + (ray as u32 - first), d.least);
            set(texel, learn(get(texel), t, blend));
        }
    }
}

/// Where no ray of a young surfel has been, it takes surfaces to be as close as the closest that it found beside: a sixteenth of
/// the texels' number away, rows and columns together, one of 4x4 and four of 8x8, where as many rays reach a quarter of them.
/// With the dozen rays of its first frame most of what hides it from a wall's other side would be open.
fn guess_each(
    d: &Distances<'_>,
    range: Range<usize>,
    get: impl Fn(usize) -> u32,
    mut set: impl FnMut(usize, u32),
) {
    let texels = count(d.side);
    for i in range {
        let before = d.irradiance[i].drawn;
        if d.spans[i].y == 0 || before >= guesses_for(d.side) {
            continue;
        }
        let is_last = before + d.spans[i].y >= guesses_for(d.side);
        for texel in 0..texels {
            if is_known(get(i * texels + texel)) {
                continue;
            }
            let (row, column) = (texel as u32 / d.side, texel as u32 % d.side);
            let mut nearest = RADIUS_STEPS;
            let reach = (d.side * d.side / 16).max(1);
            for other_row in row.saturating_sub(reach)..=(row + reach).min(d.side - 1) {
                let along = reach - row.abs_diff(other_row);
                for other in column.saturating_sub(along)..=(column + along).min(d.side - 1) {
                    let other = get(i * texels + (other_row * d.side + other) as usize);
                    if is_known(other) {
                        nearest = nearest.min(other & 0xffff);
                    }
                }
            }
            let guess = if is_last { UNKNOWN } else { guess(nearest) };
            set(i * texels + texel, guess);
        }
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
        for t in [0.0, 1e-4, 0.5, FARTHEST] {
            let mut texel = UNKNOWN;
            for _ in 0..100 {
                texel = learn(texel, t, 1.0);
                assert!(is_known(texel), "{t}");
            }
        }
    }

    /// In a function of 3x3 texels whose middle one alone has been reached.
    #[test]
    fn what_no_ray_has_reached_is_as_close_as_what_is_beside() {
        let guessed = |mut texels: [u32; 9], drawn: u32| {
            let depths = std::cell::RefCell::new(&mut texels);
            let irradiance = [SurfelIrradiance {
                drawn,
                ..SurfelIrradiance::default()
            }];
            let distances = Distances {
                poses: &[SurfelPose::default()],
                irradiance: &irradiance,
                spans: &[UVec2::new(0, 1)],
                rays: &[],
                hits: &[],
                places: &[],
                least: 0.0,
                side: 3,
            };
            let get = |i: usize| depths.borrow()[i];
            guess_each(&distances, 0..1, get, |i, texel| {
                depths.borrow_mut()[i] = texel
            });
            texels
        };
        let reached = |t: f32| {
            let mut texels = [UNKNOWN; 9];
            texels[4] = learn(UNKNOWN, t, 1.0);
            texels
        };
        let near = guessed(reached(0.2), 0);
        for beside in [1, 3, 5, 7] {
            assert!(!is_known(near[beside]));
            assert!((moments(near[beside]).x - 0.2).abs() < 1e-4);
            // The first ray that reaches it replaces it.
            assert_eq!(learn(near[beside], 0.9, 0.1), learn(UNKNOWN, 0.9, 0.1));
        }
        assert!([0, 2, 6, 8].iter().all(|&corner| near[corner] == UNKNOWN));
        assert_eq!(
            guessed(reached(0.51), 0),
            reached(0.51),
            "not within the radius"
        );
        assert_eq!(
            guessed(near, guesses_for(3) - 1),
            reached(0.2),
            "no guess stays"
        );
        assert_eq!(
            guessed(near, guesses_for(3)),
            near,
            "nor is looked for again"
        );
    }
}
