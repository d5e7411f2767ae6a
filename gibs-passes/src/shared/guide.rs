//! Ray guiding (GIBS, "Ray Guiding"): a moving average of luminance over a surfel's hemisphere, in a square of 6x6 texels
//! (hemi-octahedral, Cigolle et al. 2014), that rays are drawn from by walking its distribution.
use super::octahedral::{hemisphere_decode, hemisphere_encode};
use crate::data::SurfelGuide;
use glam::{Vec2, Vec3};

/// Texels along each side.
pub const SIDE: u32 = 6;

/// Texels of a guide.
pub const TEXELS: usize = (SIDE * SIDE) as usize;

/// Integral of the cosine over a texel, by its distances from the nearest edges: what its luminance counts in irradiance.
/// All 36 sum to pi.
pub const COSINES: [f32; 9] = [
    0.014_422_3,
    0.040_069,
    0.065_883_4,
    0.040_069,
    0.116_111_7,
    0.167_854_8,
    0.065_883_4,
    0.167_854_8,
    0.107_249_8,
];

/// Rays that a guide has learned from before it is used.
pub const LEAST_RAYS: u32 = 32;

/// Rays that it has learned from when it is used in full.
pub const FULL_RAYS: u32 = 256;

/// Share of the rays that follow a guide in full use, of those that do not go to emitters: the rest keeps to the cosine
/// lobe, so that nothing is left unsampled.
pub const MOST_GUIDED: f32 = 0.5;

/// Least share of a new ray in a texel's average.
pub const BLEND: f32 = 0.05;

/// Brightest luminance that a guide holds; beyond, it only stops telling brightness apart.
pub const MOST_LUMINANCE: f32 = 1e30;

/// A texel's value, in steps.
#[inline]
pub fn texel(guide: &SurfelGuide, index: u32) -> u32 {
    guide.texels[(index / 4) as usize] >> (index % 4 * 8) & 0xff
}

#[inline]
fn cosine_integral(index: u32) -> f32 {
    let (x, y) = (index % SIDE, index / SIDE);
    COSINES[(y.min(SIDE - 1 - y) * 3 + x.min(SIDE - 1 - x)) as usize]
}

/// What a texel counts in the distribution.
#[inline]
fn mass(guide: &SurfelGuide, index: u32) -> f32 {
    texel(guide, index) as f32 * cosine_integral(index)
}

/// Sum of the distribution; zero for a guide that knows nothing.
#[inline]
pub fn total(guide: &SurfelGuide) -> f32 {
    (0..TEXELS as u32).fold(0.0, |sum, index| sum + mass(guide, index))
}

/// Share of the rays that follow the guide, of those that do not go to emitters.
#[inline]
pub fn share(guide: &SurfelGuide, total: f32) -> f32 {
    let rays = guide.scale & 0xffff;
    if rays < LEAST_RAYS || total <= 0.0 {
        return 0.0;
    }
    (rays as f32 / FULL_RAYS as f32).min(1.0) * MOST_GUIDED
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

/// A direction of the surfel's frame, from two numbers in `[0, 1)`: the first one walks the texels, and what is left of
/// it places the direction within the one where it stops.
#[inline]
pub fn draw(guide: &SurfelGuide, total: f32, (u, v): (f32, f32)) -> Vec3 {
    let mut left = u * total;
    let mut chosen = 0;
    let mut within = 0.0;
    for index in 0..TEXELS as u32 {
        let mass = mass(guide, index);
        if mass > 0.0 {
            chosen = index;
            within = (left / mass).min(ALMOST_ONE);
            if left < mass {
                break;
            }
        }
        left -= mass;
    }
    let (x, y) = (chosen % SIDE, chosen / SIDE);
    hemisphere_decode(Vec2::new(
        (x as f32 + within) / SIDE as f32,
        (y as f32 + v) / SIDE as f32,
    ))
}

/// The largest number below one.
const ALMOST_ONE: f32 = 1.0 - 1.0 / 16_777_216.0;

/// Luminances of all texels.
#[inline]
pub fn unpack(guide: &SurfelGuide) -> [f32; TEXELS] {
    let step = f32::from_bits(guide.scale & 0xffff_0000);
    std::array::from_fn(|index| texel(guide, index as u32) as f32 * step)
}

/// A guide of these luminances that has learned from so many rays, with steps as small as the brightest texel allows.
/// `dither(index)` in `[0, 1)` rounds up or down, so that averages survive the rounding.
#[inline]
pub fn pack(luminances: &[f32; TEXELS], rays: u32, dither: impl Fn(u32) -> f32) -> SurfelGuide {
    let brightest = luminances
        .iter()
        .fold(0.0f32, |a, &b| a.max(b))
        .min(MOST_LUMINANCE);
    let mut guide = SurfelGuide {
        scale: rays.min(0xffff),
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

    fn guide(seed: u32) -> SurfelGuide {
        let luminances = std::array::from_fn(|i| {
            let x = hash::unit(hash::hash2(i as u32, seed));
            if x < 0.3 { 0.0 } else { x * x * 10.0 }
        });
        pack(&luminances, 1000, |_| 0.5)
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
    fn the_cosines_of_all_texels_sum_to_pi() {
        let sum: f64 = (0..36).map(|i| f64::from(cosine_integral(i))).sum();
        assert!((sum - PI).abs() < 1e-5, "{sum}");
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
                (of(index) - f64::from(cosine_integral(index))).abs() < 2e-4,
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
            let d = draw(&guide, total, sampling::r2(i, (77, 99)));
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
            let share = share(&guide, total);
            assert!((share - MOST_GUIDED).abs() < 1e-6);
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..N {
                let random = |k| hash::unit(hash::hash3(i, seed, k));
                let uv = (random(0), random(1));
                let d = match random(2) < share {
                    true => draw(&guide, total, uv),
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

    #[test]
    fn packing_keeps_the_extremes_and_averages_of_the_rest() {
        for brightest in [1e-30f32, 1e-3, 1.0, 255.0, 1e13] {
            let mut luminances = [0.3 * brightest; TEXELS];
            luminances[5] = brightest;
            luminances[6] = 0.0;
            let mut mean = 0.0;
            for i in 0..4000 {
                let packed = pack(&luminances, 70_000, |t| hash::unit(hash::hash2(i, t)));
                assert_eq!(packed.scale & 0xffff, 0xffff);
                let back = unpack(&packed);
                assert!(
                    (back[5] / brightest - 1.0).abs() < 0.012,
                    "{} of {brightest}",
                    back[5]
                );
                assert_eq!(back[6], 0.0);
                mean += back[20] / brightest / 4000.0;
                let again = pack(&back, 0, |t| hash::unit(hash::hash2(i + 1, t)));
                let drift = unpack(&again);
                assert!(
                    back.iter()
                        .zip(&drift)
                        .all(|(a, b)| (a - b).abs() <= 0.01 * brightest)
                );
            }
            assert!((mean - 0.3).abs() < 3e-4, "{mean}");
        }
        let dark = pack(&[0.0; TEXELS], 10, |_| 0.9);
        assert_eq!((dark.texels, dark.scale), ([0; 9], 10));
        assert_eq!(total(&dark), 0.0);
        assert_eq!(share(&dark, 0.0), 0.0);
    }
}
