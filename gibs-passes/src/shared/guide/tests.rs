use super::*;
use crate::shared::{hash, mixture, sampling};
use std::f64::consts::PI;

const IDENTITY: u32 = 0x1234;

const SIDES: [u32; 4] = [2, 4, 6, 8];

/// A guide that owns its words.
struct Owned([u32; MOST_WORDS], u32);

impl Owned {
    fn pack(luminances: &[f32], side: u32) -> Self {
        Self(pack(luminances, IDENTITY, 1000, |_| 0.5), side)
    }

    fn guide(&self) -> Guide<'_> {
        Guide::new(&self.0, self.1)
    }
}

fn even(value: f32, side: u32) -> Vec<f32> {
    vec![value; (side * side) as usize]
}

fn noise(seed: u32, side: u32) -> Owned {
    let luminance = |i: u32| {
        let x = hash::unit(hash::hash2(i, seed));
        if x < 0.3 { 0.0 } else { x * x * 10.0 }
    };
    let luminances: Vec<f32> = (0..side * side).map(luminance).collect();
    Owned::pack(&luminances, side)
}

/// Calls `f` with the directions of a fine grid of the square, and the solid angle of each.
fn over_the_hemisphere(mut f: impl FnMut(Vec3, f64)) {
    const N: u32 = 600;
    for j in 0..N {
        for i in 0..N {
            let uv = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / N as f32;
            let d = hemisphere_decode(uv);
            let s = f64::from(d.x.abs() + d.y.abs() + d.z);
            f(d, 2.0 * s.powi(3) / f64::from(N * N));
        }
    }
}

/// Numerical integration over the hemisphere.
fn integrate(f: impl Fn(Vec3) -> f64) -> f64 {
    let mut sum = 0.0;
    over_the_hemisphere(|d, angle| sum += f(d) * angle);
    sum
}

#[test]
fn the_density_integrates_to_one() {
    assert!((integrate(|_| 1.0) / (2.0 * PI) - 1.0).abs() < 1e-4);
    for side in SIDES {
        for seed in 0..3 {
            let owned = noise(seed, side);
            let guide = owned.guide();
            let total = guide.total();
            let sum = integrate(|d| f64::from(guide.density(total, d)));
            assert!((sum - 1.0).abs() < 1e-3, "{sum} with {side}");
        }
    }
}

/// Shares of the lobe are off by half a step of 2^-16 at most, one that makes the sum exact by one and a half. The grid of the
/// integration is a multiple of each side, so that it cuts no texel.
#[test]
fn the_lobe_of_all_texels_sums_to_one() {
    for side in SIDES {
        let owned = Owned::pack(&even(1.0, side), side);
        let guide = owned.guide();
        let sum: f32 = (0..guide.texels()).map(|i| guide.lobe(i)).sum();
        assert_eq!(sum, 1.0, "with {side}");
        let mut shares = vec![0.0; guide.texels() as usize];
        over_the_hemisphere(|d, angle| {
            shares[guide.texel_of(d) as usize] += f64::from(d.z) * angle;
        });
        for (index, share) in (0..).zip(shares) {
            let lobe = f64::from(guide.lobe(index));
            assert!(
                (share / PI - lobe).abs() < 1.5 / 65536.0,
                "{index} with {side}"
            );
        }
    }
}

/// 100 000 directions: each texel's share is its mass, within 5 standard deviations of a binomial count, and within a
/// texel both halves of the square are met alike.
#[test]
fn directions_follow_the_density() {
    const N: u32 = 100_000;
    for side in SIDES {
        let owned = noise(9, side);
        let guide = owned.guide();
        let total = guide.total();
        let mut counts = vec![[0u32; 2]; guide.texels() as usize];
        for i in 0..N {
            let d = guide.draw(sampling::r2(i, (77, 99)));
            assert!((d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0);
            let half = (hemisphere_encode(d).x * side as f32).fract() < 0.5;
            counts[guide.texel_of(d) as usize][usize::from(half)] += 1;
        }
        for (index, [a, b]) in (0..).zip(counts) {
            let p = f64::from(guide.mass(index) / total);
            let allowed = 5.0 * (f64::from(N) * p * (1.0 - p)).sqrt() + 2.0;
            let off = (f64::from(a + b) - f64::from(N) * p).abs();
            assert!(off <= allowed, "{index} with {side}");
            let halves = 5.0 * f64::from(a + b).sqrt() + 2.0;
            let apart = (f64::from(a) - f64::from(b)).abs();
            assert!(apart <= halves, "{index} with {side}: {a} and {b}");
        }
    }
}

/// Of a function that the guide is wrong about, the mixture of guide and lobe still gives the integral: the mean of
/// 400 000 samples within 5 of its own standard errors.
#[test]
fn guided_sampling_is_unbiased() {
    const N: u32 = 400_000;
    let light = |d: Vec3| f64::from(d.x.max(0.0)).powi(8) * 20.0 + 0.1;
    let exact = integrate(|d| light(d) * f64::from(d.z));
    for (side, seed) in [
        (2, 0),
        (2, 3),
        (4, 0),
        (4, 3),
        (6, 0),
        (6, 2),
        (8, 0),
        (8, 1),
    ] {
        let owned = noise(seed, side);
        let guide = owned.guide();
        let total = guide.total();
        let share = guide.share(IDENTITY, total);
        assert!(
            share > 0.1 * MOST_GUIDED && share <= MOST_GUIDED,
            "{share} with {side}"
        );
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..N {
            let random = |k| hash::unit(hash::hash3(i, seed, k));
            let (follows, u) = mixture::follow_guide(random(0), share);
            let d = match follows {
                true => guide.draw((u, random(1))),
                false => sampling::cosine_hemisphere(u, random(1)),
            };
            let p = mixture::guided_density(d.z, guide.density(total, d), share, false);
            let value = light(d) * f64::from(d.z) / f64::from(p);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(N);
        let error = ((squares / f64::from(N) - mean * mean) / f64::from(N)).sqrt();
        let off = (mean - exact).abs();
        assert!(off < 5.0 * error, "{mean} for {exact}, {error} with {side}");
    }
}

/// An even hemisphere leaves all rays to the lobe, a single bright texel gets as many as there may be, and the
/// guide of another surfel none.
#[test]
fn guides_are_used_where_light_is_uneven() {
    for side in SIDES {
        let of = |luminances: &[f32], identity| {
            let owned = Owned::pack(luminances, side);
            owned.guide().share(identity, owned.guide().total())
        };
        let mut one = even(0.01, side);
        one[1] = 1.0;
        assert_eq!(of(&even(1.0, side), IDENTITY), 0.0);
        assert_eq!(of(&one, IDENTITY), MOST_GUIDED, "with {side}");
        assert_eq!(of(&one, IDENTITY + 1), 0.0);
    }
}

/// The walk splits the square along its axes: the numbers that lead to a texel are a rectangle, as wide as the texel's share of
/// what its row of blocks and its block's row have, and as high as those of all. Of a grid of 256 x 256 numbers it holds as many
/// as its area says, give or take a line of them along each of two edges. A walk along all texels in one line would be off by
/// more than that.
#[test]
fn even_points_stay_even() {
    const N: u32 = 256;
    for side in SIDES {
        let owned = noise(3, side);
        let guide = owned.guide();
        let mut counts = vec![0u32; guide.texels() as usize];
        for i in 0..N * N {
            let at = |i: u32| (i as f32 + 0.5) / N as f32;
            let d = guide.draw((at(i % N), at(i / N)));
            counts[guide.texel_of(d) as usize] += 1;
        }
        let mass = |y: u32, x: u32| f64::from(guide.mass(y * side + x));
        let pair = |y: u32, column: u32| mass(y, 2 * column) + mass(y, 2 * column + 1);
        let block = |row: u32, column: u32| pair(2 * row, column) + pair(2 * row + 1, column);
        let line = |row: u32| (0..side / 2).map(|column| block(row, column)).sum::<f64>();
        let total: f64 = (0..side / 2).map(line).sum();
        for (index, count) in (0..).zip(counts) {
            let (y, x) = (index / side, index % side);
            let (row, column) = (y / 2, x / 2);
            let share = |part: f64, of: f64| if part > 0.0 { part / of } else { 0.0 };
            let block = block(row, column);
            let wide = share(block, line(row)) * share(mass(y, x), pair(y, column));
            let high = share(line(row), total) * share(pair(y, column), block);
            let expected = wide * high * f64::from(N * N);
            let allowed = (wide + high) * f64::from(N) + 1.0;
            let off = (f64::from(count) - expected).abs();
            assert!(
                off <= allowed,
                "{index} with {side}: {count} for {expected}"
            );
        }
    }
}

/// With two texels along each side there is no room for what is looked at.
#[test]
fn packing_keeps_the_extremes_and_averages_of_the_rest() {
    for (side, brightest) in [
        (6, 1e-30f32),
        (6, 1e-3),
        (6, 1.0),
        (6, 255.0),
        (6, 1e13),
        (4, 1.0),
        (8, 1.0),
    ] {
        let last = (side * side - 1) as usize;
        let mut luminances = even(0.3 * brightest, side);
        luminances[5] = brightest;
        luminances[6] = 0.0;
        let mut mean = 0.0;
        for i in 0..4000 {
            let words = pack(&luminances, IDENTITY, 70_000, |t| {
                hash::unit(hash::hash2(i, t))
            });
            let packed = Guide::new(&words, side);
            assert_eq!(packed.rays(IDENTITY), 4092);
            assert_eq!(packed.rays(IDENTITY + 1), 0);
            let back = packed.unpack();
            let off = (back[5] / brightest - 1.0).abs();
            assert!(off < 0.012, "{} of {brightest}", back[5]);
            assert_eq!(back[6], 0.0);
            mean += back[last] / brightest / 4000.0;
            let again = pack(&back[..=last], IDENTITY, 0, |t| {
                hash::unit(hash::hash2(i + 1, t))
            });
            let drift = Guide::new(&again, side).unpack();
            let mut pairs = back.iter().zip(&drift);
            assert!(pairs.all(|(a, b)| (a - b).abs() <= 0.01 * brightest));
        }
        assert!((mean - 0.3).abs() < 3e-4, "{mean}");
    }
    let dark = pack(&[0.0; 36], 0, 10, |_| 0.9);
    let mut expected = [0; MOST_WORDS];
    expected[0] = 3;
    assert_eq!(dark, expected);
    let dark = Guide::new(&dark, 6);
    assert_eq!(dark.total(), 0.0);
    assert_eq!(dark.share(0, 0.0), 0.0);
}
