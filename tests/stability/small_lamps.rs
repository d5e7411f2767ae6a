//! Lamps of a centimetre that give 10^6 cd: a radiance of 10^10, and a point.
use super::build::Build;
use super::common::{all_backends, cpu};
use super::measure::{deviation, draw, levels, mean, positions};
use super::pictures;
use gibs::graph::Backend;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{LightKind, Scene};
use gibs::picture::Picture;
use gibs::view::View;
use glam::Vec3;
use std::f64::consts::PI;

const ALBEDO: f64 = 0.5;
/// Of the room, m^2.
const AREA: f64 = 24.0;
/// Of the lamp, m.
const SIDE: f32 = 0.01;
/// Through each of its faces, W/sr.
const INTENSITY: f32 = 1e6;

fn settings() -> Settings {
    Settings {
        surfels: 8192,
        rays: 8192,
        continuations: 16,
        ..Settings::default()
    }
}

/// A closed cube of 2 m about the origin. The eye lies in one wall and sees the opposite one, and nothing else: since a
/// perspective picture of a plane across the line of sight is that plane scaled, pixels are squares of equal size on the wall.
fn room(name: &str) -> Build {
    let eye = 0.999;
    let mut room = Build::new(
        name,
        [0.0, 0.0, eye],
        [0.0, 0.0, -1.0],
        2.0 * (1.0 / (1.0 + eye)).atan(),
    );
    let wall = room.paint(ALBEDO as f32, 0.0);
    room.cuboid(wall, Vec3::NEG_ONE, Vec3::ONE, true);
    room
}

fn with_point() -> (Scene, View) {
    let mut room = room("point");
    room.light(LightKind::Point, [0.0; 3], INTENSITY);
    room.done()
}

fn with_cube() -> (Scene, View) {
    let mut room = room("lamp");
    let lamp = room.paint(0.0, INTENSITY / (SIDE * SIDE));
    let half = Vec3::splat(SIDE / 2.0);
    room.cuboid(lamp, -half, half, false);
    room.done()
}

/// E of the pixels that see the wall. The lamp in front of it covers a few in the middle, in both scenes left out: E is
/// symmetric and flat there.
fn of_wall(picture: &Picture) -> Vec<f64> {
    let is_wall =
        |p: Option<glam::DVec3>| p.is_some_and(|p| p.z < -0.999 && p.x.abs().max(p.y.abs()) > 0.05);
    let seen = positions(picture).into_iter().map(is_wall);
    let e = levels(picture, "E").into_iter();
    e.zip(seen)
        .filter(|(_, wall)| *wall)
        .map(|(e, _)| e)
        .collect()
}

fn holds(case: &str, make: fn() -> (Scene, View), want: f64, model: f64) {
    let drawn =
        |backend: &dyn Backend, seed| draw(backend, &make(), [48, 48], 64, &settings(), seed);
    let means: Vec<f64> = (10..16)
        .map(|seed| mean(&of_wall(&drawn(cpu().as_ref(), seed))))
        .collect();
    let bound = model + 5.0 * deviation(&means) / want;
    for backend in all_backends() {
        let name = backend.name();
        let picture = drawn(backend.as_ref(), 0);
        let off = mean(&of_wall(&picture)) / want - 1.0;
        println!(
            "{name}: {case}: mean of E {:+.3} % of {want:.0} W/m^2 (bound {:.3} %)",
            off * 100.0,
            bound * 100.0
        );
        assert!(off.abs() <= bound, "{name}: {case}: {off}");
        pictures::irradiance(&format!("small-lamps-{case}"), name, &picture);
    }
}

/// All walls are alike, so that one has the mean irradiance of all. Of the flux `4 pi I` they receive all, and of what they
/// receive they send `a` on: indirect irradiance is `4 pi I a / (1 - a) / A` on average, and direct irradiance of each pixel
/// `I cos / r^2`, within 16 roundings of places a metre away and the 6.5e-5 of packed normals.
///
/// The bound on the mean: what the middle of each of 48 x 48 pixels says of it, below `(1/48)^2 = 0.05 %`; paths that end after
/// 17 segments, `0.5^17`; and 5 standard deviations over seeds.
#[test]
fn a_point_of_a_million_candela_has_its_energy() {
    let intensity = f64::from(INTENSITY);
    let want = 4.0 * PI * intensity * ALBEDO / (1.0 - ALBEDO) / AREA;
    for backend in all_backends() {
        let name = backend.name();
        let picture = draw(backend.as_ref(), &with_point(), [48, 48], 1, &settings(), 0);
        let mut worst = 0f64;
        for (p, direct) in positions(&picture)
            .into_iter()
            .zip(levels(&picture, "direct"))
        {
            let p = p.expect("the room is closed");
            let exact = intensity / p.length().powi(3);
            worst = worst.max((direct / exact - 1.0).abs());
        }
        println!("{name}: point: direct light is off by {worst:.2e} (bound 1e-4)");
        assert!(worst <= 1e-4, "{name}: {worst}");
    }
    holds("point", with_point, want, 0.0005);
}

/// A cube's face sends `pi L s^2`, and all six what the walls receive first: `6 pi I / (1 - a) / A` on average over the walls,
/// direct light of emitters being part of E. The lamp is black; of what the walls send it takes `6 s^2` in 24, which is 0.0025
/// %. The bound as for the point.
#[test]
fn a_lamp_of_a_centimetre_has_its_energy() {
    let want = 6.0 * PI * f64::from(INTENSITY) / (1.0 - ALBEDO) / AREA;
    holds("lamp", with_cube, want, 0.0005 + 0.000_025);
}
