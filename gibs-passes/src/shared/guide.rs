//! Ray guiding (GIBS, "Ray Guiding"): a moving average of luminance over a surfel's hemisphere, in a square of 6x6 texels
//! (hemi-octahedral, Cigolle et al. 2014), that rays are drawn from by walking its distribution.
//!
//! A texel holds the root of the mean square of luminance: the density of least variance is proportional to that times the
//! cosine, and not to the mean, where light varies within a texel (Rath et al. 2020, "Variance-Aware Path Guiding").
//!
//! A surfel learns from the rays of its neighbours and not from its own. There are more of those, and what its own sequence
//! of directions has visited says where the next ones go, so that a guide that knew it would bias the mean.
use super::hash::ALMOST_ONE;
use super::octahedral::{hemisphere_decode, hemisphere_encode};
use crate::data::SurfelGuide;
use glam::{Vec2, Vec3};

/// Texels along each side.
pub const SIDE: u32 = 6;

/// Texels of a guide.
pub const TEXELS: usize = (SIDE * SIDE) as usize;

/// Share of the cosine lobe in a texel, by its distances from the nearest edges: what its luminance counts in irradiance.
/// All 36 sum to one. They are whole multiples of 2^-16, so that sums of masses are exact in whatever order a device adds.
pub const LOBE: [f32; 9] = {
    const fn share(steps: u32) -> f32 {
        steps as f32 / 65536.0
    }
    let (a, b, c) = (share(301), share(836), share(1374));
    let (d, e, f) = (share(2422), share(3502), share(2237));
    [a, b, c, b, d, e, c, e, f]
};

/// Rays that a guide has learned from before it is used.
pub const LEAST_RAYS: u32 = 32;

/// Rays that it has learned from when it is used in full.
pub const FULL_RAYS: u32 = 256;

/// Share of the rays that follow a guide in full use, of those that do not go to emitters: the rest keeps to the cosine
/// lobe, so that nothing is left unsampled.
pub const MOST_GUIDED: f32 = 0.5;

/// Second moment of light between texels over the square of the first, below which a guide is not used; one above, it is
/// used in full. Over an even hemisphere, where it is one, the lobe is as good, and its points lie more evenly.
pub const LEAST_SPREAD: f32 = 1.25;

/// Rays up to which new ones move all texels towards their mean: until a texel is known, it counts as average.
pub const PRIOR_RAYS: u32 = 64;

/// Least share of a new ray in a texel's average.
pub const BLEND: f32 = 0.05;

/// Neighbours that a surfel learns from in a frame.
pub const NEIGHBOURS: u32 = 8;

/// Surfels of its cell that it looks at to find them.
pub const CANDIDATES: u32 = 16;

/// Cosine between the normals of surfels that learn from each other.
pub const ALIKE: f32 = 0.7;

/// Rays of a neighbour that are learned from in a frame.
pub const RAYS_OF_NEIGHBOUR: u32 = 32;

/// Brightest luminance that a guide holds; beyond, it only stops telling brightness apart. Its square is a finite `f32`.
pub const MOST_LUMINANCE: f32 = 1e18;

/// Rays in a step of the count that a guide keeps.
const RAYS_STEP: u32 = 4;

/// Largest count, in steps.
const MOST_STEPS: u32 = 0x3ff;

/// What tells a surfel's guide from that of the one that had the slot before, but for one in 64.
#[inline]
fn tag(identity: u32) -> u32 {
    identity & 0x3f
}

/// Rays that a guide of the surfel with this identity has learned from, up to 4092; none where it is another's.
#[inline]
pub fn rays(guide: &SurfelGuide, identity: u32) -> u32 {
    match guide.scale >> 10 & 0x3f == tag(identity) {
        true => (guide.scale & MOST_STEPS) * RAYS_STEP,
        false => 0,
    }
}

/// A texel's value, in steps.
#[inline]
pub fn texel(guide: &SurfelGuide, index: u32) -> u32 {
    guide.texels[(index / 4) as usize] >> (index % 4 * 8) & 0xff
}

#[inline]
fn lobe(index: u32) -> f32 {
    let (x, y) = (index % SIDE, index / SIDE);
    LOBE[(y.min(SIDE - 1 - y) * 3 + x.min(SIDE - 1 - x)) as usize]
}

/// What a texel counts in the distribution.
#[inline]
fn mass(guide: &SurfelGuide, index: u32) -> f32 {
    texel(guide, index) as f32 * lobe(index)
}

/// Sum of the distribution; zero for a guide that knows nothing.
#[inline]
pub fn total(guide: &SurfelGuide) -> f32 {
    (0..TEXELS as u32).fold(0.0, |sum, index| sum + mass(guide, index))
}

/// Share of the rays of the surfel with this identity that follow the guide, of those that do not go to emitters.
#[inline]
pub fn share(guide: &SurfelGuide, identity: u32, total: f32) -> f32 {
    let rays = rays(guide, identity);
    if rays < LEAST_RAYS || total <= 0.0 {
        return 0.0;
    }
    let squares = (0..TEXELS as u32).fold(0.0, |sum, index| {
        let value = texel(guide, index) as f32;
        // The constant first: a driver may move it there.
        sum + lobe(index) * (value * value)
    });
    let spread = squares / (total * total);
    let known = (rays as f32 / FULL_RAYS as f32).min(1.0);
    MOST_GUIDED * ((spread - LEAST_SPREAD).clamp(0.0, 1.0) * known)
}

/// Probability that a ray not to an emitter falls into a texel, where `share` of them follow the guide.
#[inline]
pub fn probability(guide: &SurfelGuide, total: f32, share: f32, index: u32) -> f32 {
    let lobe = lobe(index);
    if share <= 0.0 {
        return lobe;
    }
    lobe + (mass(guide, index) / total - lobe) * share
}

/// The texel of a direction of the surfel's frame.
#[inline]
pub fn texel_of(local: Vec3) -> u32 {
    let uv = hemisphere_encode(Vec3::new(local.x, local.y, local.z.max(0.0)));
    let at = |x: f32| ((x * SIDE as f32) as u32).min(SIDE - 1);
    at(uv.y) * SIDE + at(uv.x)
}

/// Density per solid angle, 1/sr, of [`draw`] in a direction of the surfel's frame: constant over the square within a
/// texel, over `2 (|x| + |y| + z)^3`, the solid angle per area of the square.
#[inline]
pub fn density(guide: &SurfelGuide, total: f32, local: Vec3) -> f32 {
    let s = local.x.abs() + local.y.abs() + local.z.max(0.0);
    mass(guide, texel_of(local)) / total * (TEXELS as f32 * 0.5) / (s * s * s)
}

/// A direction of the surfel's frame, from two numbers in `[0, 1)`: they walk a mip of 3x3 texels first, then the four of the
/// texel where they stop (McCool and Harwood 1997), each along one axis. What is left of them places the direction. Numbers
/// that are close give directions that are close, so that points spread evenly over the square stay so over the hemisphere.
#[inline]
pub fn draw(guide: &SurfelGuide, (u, v): (f32, f32)) -> Vec3 {
    let block = |row, column| {
        let at = |y, x| mass(guide, (row * 2 + y) * SIDE + column * 2 + x);
        [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
    };
    let sum = |row, column| {
        let [[a, b], [c, d]] = block(row, column);
        (a + b) + (c + d)
    };
    let line = |row| (sum(row, 0) + sum(row, 1)) + sum(row, 2);
    let (row, v) = walk(v, [line(0), line(1), line(2)]);
    let (column, u) = walk(u, [sum(row, 0), sum(row, 1), sum(row, 2)]);
    let texels = block(row, column);
    let (y, v) = walk(
        v,
        [
            texels[0][0] + texels[0][1],
            texels[1][0] + texels[1][1],
            0.0,
        ],
    );
    let [left, right] = texels[y as usize];
    let (x, u) = walk(u, [left, right, 0.0]);
    hemisphere_decode(Vec2::new(
        ((column * 2 + x) as f32 + u) / SIDE as f32,
        ((row * 2 + y) as f32 + v) / SIDE as f32,
    ))
}

/// Where a number in `[0, 1)` stops among masses, and how far within, in `[0, 1)`.
#[inline]
fn walk(u: f32, masses: [f32; 3]) -> (u32, f32) {
    let mut left = u * ((masses[0] + masses[1]) + masses[2]);
    let mut chosen = 0;
    let mut within = 0.0;
    for (index, mass) in (0..).zip(masses) {
        if mass > 0.0 {
            chosen = index;
            within = (left / mass).min(ALMOST_ONE);
            if left < mass {
                break;
            }
        }
        left -= mass;
    }
    (chosen, within)
}

/// Luminances of all texels.
#[inline]
pub fn unpack(guide: &SurfelGuide) -> [f32; TEXELS] {
    let step = f32::from_bits(guide.scale & 0xffff_0000);
    std::array::from_fn(|index| texel(guide, index as u32) as f32 * step)
}

/// A guide of these luminances that has learned from so many rays, with steps as small as the brightest texel allows.
/// `dither(index)` in `[0, 1)` rounds up or down, so that averages survive the rounding.
#[inline]
pub fn pack(
    luminances: &[f32; TEXELS],
    identity: u32,
    rays: u32,
    dither: impl Fn(u32) -> f32,
) -> SurfelGuide {
    let brightest = luminances
        .iter()
        .fold(0.0f32, |a, &b| a.max(b))
        .min(MOST_LUMINANCE);
    let mut guide = SurfelGuide {
        scale: rays.div_ceil(RAYS_STEP).min(MOST_STEPS) | tag(identity) << 10,
        ..SurfelGuide::default()
    };
    // The step is rounded up, so that the brightest texel still fits.
    let bits = ((brightest / 255.0).to_bits() + 0xffff) & 0xffff_0000;
    let step = f32::from_bits(bits);
    if brightest <= 0.0 || step <= 0.0 {
        return guide;
    }
    guide.scale |= bits;
    for (index, luminance) in (0..).zip(luminances) {
        let value = ((luminance / step + dither(index)) as u32).min(255);
        guide.texels[(index / 4) as usize] |= value << (index % 4 * 8);
    }
    guide
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::{hash, sampling};
    use std::f64::consts::PI;

    const IDENTITY: u32 = 0x1234;

    fn guide(seed: u32) -> SurfelGuide {
        let luminances = std::array::from_fn(|i| {
            let x = hash::unit(hash::hash2(i as u32, seed));
            if x < 0.3 { 0.0 } else { x * x * 10.0 }
        });
        pack(&luminances, IDENTITY, 1000, |_| 0.5)
    }

    /// Numerical integration over the hemisphere by a fine grid of the square.
    fn integrate(f: impl Fn(Vec3) -> f64) -> f64 {
        const N: u32 = 600;
        let mut sum = 0.0;
        for j in 0..N {
            for i in 0..N {
                let uv = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / N as f32;
                let d = hemisphere_decode(uv);
                let s = f64::from(d.x.abs() + d.y.abs() + d.z);
                sum += f(d) * 2.0 * s.powi(3) / f64::from(N * N);
            }
        }
        sum
    }

    #[test]
    fn the_density_integrates_to_one() {
        assert!((integrate(|_| 1.0) / (2.0 * PI) - 1.0).abs() < 1e-4);
        for seed in 0..5 {
            let guide = guide(seed);
            let total = total(&guide);
            let sum = integrate(|d| f64::from(density(&guide, total, d)));
            assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        }
    }

    #[test]
    fn the_lobe_of_all_texels_sums_to_one() {
        let sum: f64 = (0..36).map(|i| f64::from(lobe(i))).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        let of = |index| {
            integrate(|d| {
                if texel_of(d) == index {
                    f64::from(d.z)
                } else {
                    0.0
                }
            })
        };
        for index in [0, 1, 2, 7, 8, 14, 35] {
            assert!(
                (of(index) / PI - f64::from(lobe(index))).abs() < 1e-4,
                "{index}"
            );
        }
    }

    /// 100 000 directions: each texel's share is its mass, within 5 standard deviations of a binomial count, and within a
    /// texel both halves of the square are met alike.
    #[test]
    fn directions_follow_the_density() {
        const N: u32 = 100_000;
        let guide = guide(9);
        let total = total(&guide);
        let mut counts = [[0u32; 2]; TEXELS];
        for i in 0..N {
            let d = draw(&guide, sampling::r2(i, (77, 99)));
            assert!((d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0);
            let half = (hemisphere_encode(d).x * SIDE as f32).fract() < 0.5;
            counts[texel_of(d) as usize][usize::from(half)] += 1;
        }
        for (index, [a, b]) in counts.into_iter().enumerate() {
            let p = f64::from(mass(&guide, index as u32) / total);
            let allowed = 5.0 * (f64::from(N) * p * (1.0 - p)).sqrt() + 2.0;
            assert!(
                (f64::from(a + b) - f64::from(N) * p).abs() <= allowed,
                "{index}"
            );
            let halves = 5.0 * f64::from(a + b).sqrt() + 2.0;
            assert!(
                (f64::from(a) - f64::from(b)).abs() <= halves,
                "{index}: {a} and {b}"
            );
        }
    }

    /// Of a function that the guide is wrong about, the mixture of guide and lobe still gives the integral: the mean of
    /// 400 000 samples within 5 of its own standard errors.
    #[test]
    fn guided_sampling_is_unbiased() {
        const N: u32 = 400_000;
        let light = |d: Vec3| f64::from(d.x.max(0.0)).powi(8) * 20.0 + 0.1;
        let exact = integrate(|d| light(d) * f64::from(d.z));
        for seed in 0..4 {
            let guide = guide(seed);
            let total = total(&guide);
            let share = share(&guide, IDENTITY, total);
            assert!(share > 0.1 * MOST_GUIDED && share <= MOST_GUIDED);
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..N {
                let random = |k| hash::unit(hash::hash3(i, seed, k));
                let uv = (random(0), random(1));
                let d = match random(2) < share {
                    true => draw(&guide, uv),
                    false => sampling::cosine_hemisphere(uv.0, uv.1),
                };
                let lobe = d.z * std::f32::consts::FRAC_1_PI;
                let p = lobe + (density(&guide, total, d) - lobe) * share;
                let value = light(d) * f64::from(d.z) / f64::from(p);
                sum += value;
                squares += value * value;
            }
            let mean = sum / f64::from(N);
            let error = ((squares / f64::from(N) - mean * mean) / f64::from(N)).sqrt();
            assert!(
                (mean - exact).abs() < 5.0 * error,
                "{mean} for {exact}, {error}"
            );
        }
    }

    /// An even hemisphere leaves all rays to the lobe, a single bright texel gets as many as there may be, and the
    /// guide of another surfel none.
    #[test]
    fn guides_are_used_where_light_is_uneven() {
        let of = |luminances, identity| {
            let guide = pack(&luminances, IDENTITY, 1000, |_| 0.5);
            share(&guide, identity, total(&guide))
        };
        let mut one = [0.01; TEXELS];
        one[14] = 1.0;
        assert_eq!(of([1.0; TEXELS], IDENTITY), 0.0);
        assert_eq!(of(one, IDENTITY), MOST_GUIDED);
        assert_eq!(of(one, IDENTITY + 1), 0.0);
    }

    /// Numbers that are a little apart give directions that are: the walk splits the square along its axes, so that of 65536
    /// even points those in each half of a texel's column and row are as many as its mass says, to within a few.
    #[test]
    fn even_points_stay_even() {
        const N: u32 = 256;
        let guide = guide(3);
        let total = total(&guide);
        let mut counts = [0u32; TEXELS];
        for i in 0..N * N {
            let at = |i: u32| (i as f32 + 0.5) / N as f32;
            counts[texel_of(draw(&guide, (at(i % N), at(i / N)))) as usize] += 1;
        }
        for (index, count) in (0..).zip(counts) {
            let expected = f64::from(mass(&guide, index) / total * (N * N) as f32);
            // A texel is a rectangle within a rectangle: each of its edges cuts through at most a line of points.
            let allowed = 2.0 * f64::from(N);
            assert!(
                (f64::from(count) - expected).abs() <= allowed,
                "{index}: {count} for {expected}"
            );
        }
    }

    #[test]
    fn packing_keeps_the_extremes_and_averages_of_the_rest() {
        for brightest in [1e-30f32, 1e-3, 1.0, 255.0, 1e13] {
            let mut luminances = [0.3 * brightest; TEXELS];
            luminances[5] = brightest;
            luminances[6] = 0.0;
            let mut mean = 0.0;
            for i in 0..4000 {
                let packed = pack(&luminances, IDENTITY, 70_000, |t| {
                    hash::unit(hash::hash2(i, t))
                });
                assert_eq!(rays(&packed, IDENTITY), 4092);
                assert_eq!(rays(&packed, IDENTITY + 1), 0);
                let back = unpack(&packed);
                assert!(
                    (back[5] / brightest - 1.0).abs() < 0.012,
                    "{} of {brightest}",
                    back[5]
                );
                assert_eq!(back[6], 0.0);
                mean += back[20] / brightest / 4000.0;
                let again = pack(&back, IDENTITY, 0, |t| hash::unit(hash::hash2(i + 1, t)));
                let drift = unpack(&again);
                assert!(
                    back.iter()
                        .zip(&drift)
                        .all(|(a, b)| (a - b).abs() <= 0.01 * brightest)
                );
            }
            assert!((mean - 0.3).abs() < 3e-4, "{mean}");
        }
        let dark = pack(&[0.0; TEXELS], 0, 10, |_| 0.9);
        assert_eq!((dark.texels, dark.scale), ([0; 9], 3));
        assert_eq!(total(&dark), 0.0);
        assert_eq!(share(&dark, 0, 0.0), 0.0);
    }
}
