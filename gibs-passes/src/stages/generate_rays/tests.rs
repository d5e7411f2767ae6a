use super::*;
use crate::data::SurfacePoint;
use crate::shared::estimator::luminance;
use crate::shared::surface::EMITTER;
use crate::shared::{emitter, octahedral};
use crate::stages::shade_hits;
use std::f32::consts::PI;

const IDENTITY: u32 = 0x1234;

/// Two lamps over a surface that faces up, the smaller one the brighter.
fn lamps() -> (Vec<Emitter>, f32) {
    let lamp = |v0: Vec3, size: f32, radiance: f32| Emitter {
        v0,
        e1: Vec3::X * size,
        e2: Vec3::Y * size,
        // It shines on both sides.
        flags: 1,
        radiance: Vec3::splat(radiance),
        ..Emitter::default()
    };
    let mut lamps = vec![
        lamp(Vec3::new(0.3, 0.1, 0.7), 0.6, 4.0),
        lamp(Vec3::new(-0.8, -0.5, 0.5), 0.25, 30.0),
    ];
    let power = |lamp: &Emitter| luminance(lamp.radiance) * lamp.e1.cross(lamp.e2).length() * 0.5;
    let total: f32 = lamps.iter().map(power).sum();
    let mut before = 0.0;
    for lamp in &mut lamps {
        before += power(lamp) / total;
        lamp.cumulative = before;
    }
    (lamps, total)
}

/// Where a ray from the origin meets a lamp, and which.
fn met(lamps: &[Emitter], d: Vec3) -> Option<(&Emitter, Vec3)> {
    lamps.iter().find_map(|lamp| {
        let at = d * (lamp.v0.z / d.z.max(1e-9));
        let from_corner = (at - lamp.v0) / lamp.e1.x;
        let (a, b) = (from_corner.x, from_corner.y);
        (a >= 0.0 && b >= 0.0 && a + b <= 1.0).then_some((lamp, at))
    })
}

/// Radiance of the sky that shows beside the lamps.
fn sky(d: Vec3) -> f32 {
    0.2 + 2.0 * d.x.max(0.0).powi(4)
}

/// What the surface receives, W/m^2: the sum over a fine grid of the disc that directions project to, which has the cosine in it.
fn irradiance(lamps: &[Emitter]) -> f64 {
    const N: i32 = 2000;
    let mut sum = 0.0;
    for j in 0..N {
        for i in 0..N {
            let at = |i: i32| (i as f32 + 0.5) / N as f32 * 2.0 - 1.0;
            let (x, y) = (at(i), at(j));
            let squared = 1.0 - x * x - y * y;
            if squared > 0.0 {
                let d = Vec3::new(x, y, squared.sqrt());
                let light = met(lamps, d).map_or_else(|| sky(d), |(lamp, _)| lamp.radiance.x);
                sum += f64::from(light) * 4.0 / f64::from(N * N);
            }
        }
    }
    sum
}

/// What the rays of a surfel bring, each weighed as where it arrives: mean, and its standard error as if they were
/// independent.
fn estimate(lamps: &[Emitter], power: f32, guides: Guides<'_>) -> (f64, f64) {
    const N: u32 = 200_000;
    let frame = Frame {
        emitter_power: power,
        seed: 5,
        ..Frame::default()
    };
    let surfels = Surfels {
        frame: &frame,
        poses: &[SurfelPose {
            radius: 1.0,
            normal: Vec3::Z,
            mark: mark::of(IDENTITY, 0, false),
            ..SurfelPose::default()
        }],
        births: &[SurfelBirth::default()],
        irradiance: &[SurfelIrradiance::default()],
        spans: &[UVec2::new(0, N)],
        emitters: lamps,
        guides,
    };
    let (mut sum, mut squares) = (0.0, 0.0);
    generate_each(&surfels, 0..1, |_, ray, path| {
        let met = met(lamps, ray.direction);
        let point = met.map_or(crate::shared::surface::MISS, |(lamp, at)| SurfacePoint {
            position: at,
            geometric_normal: octahedral::pack(-Vec3::Z),
            albedo_b_flags: EMITTER,
            emission: emitter::radiance(lamp, ray.direction),
            ..SurfacePoint::default()
        });
        let light = met.map_or_else(|| sky(ray.direction), |(lamp, _)| lamp.radiance.x);
        let factor = shade_hits::factor(&frame, &path, &ray, &point);
        let value = f64::from(light * factor * PI);
        sum += value;
        squares += value * value;
    });
    let n = f64::from(N);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

/// With and without lamps to send rays to, over the lobe and by guides of each size: the mean is the integral, within five of its
/// standard errors and the 0.05 % that the integral's grid is off by. A guide that is wrong about the light changes nothing.
#[test]
fn every_mixture_has_the_mean_of_the_integral() {
    let (lamps, power) = lamps();
    let luminance = |i: u32| hash::unit(hash::hash2(i, 3)).powi(3);
    for lamps in [&lamps[..], &[]] {
        let exact = irradiance(lamps);
        for side in [0, 2, 4, 6, 8] {
            let luminances: Vec<f32> = (0..side * side).map(luminance).collect();
            let words = guide::pack(&luminances, IDENTITY, 1000, |_| 0.5);
            let guides = match side {
                0 => Guides::default(),
                _ => Guides::new(&words[..guide::words(side)], side),
            };
            if let Some(guide) = guides.get(0) {
                let share = guide.share(IDENTITY, guide.total());
                assert!(share > 0.1 * guide::MOST_GUIDED, "{share} with {side}");
            }
            let (mean, error) = estimate(lamps, power, guides);
            let off = (mean - exact).abs();
            let count = lamps.len();
            assert!(
                off < 5.0 * error + 5e-4 * exact,
                "{mean} for {exact}, {error}: {count} lamps, side {side}"
            );
            // Narrow enough that a share which is missing somewhere would show.
            assert!(error < 0.01 * exact, "{error} of {exact}");
        }
    }
}
