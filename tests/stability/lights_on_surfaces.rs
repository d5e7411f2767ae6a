//! Lights at which a distance or a cosine is zero, or nearly: in a floor, in a wall, and along the floor.
use super::build::Build;
use super::common::all_backends;
use super::measure::{PACKED, U, draw, levels, positions, settings};
use super::pictures;
use gibs::passes::scene::{LightKind, Sun};
use gibs::picture::Picture;
use glam::{DVec3, Vec3};

/// A floor of 8 m and a wall at x = -2 that faces it, seen from above.
fn corner(name: &str) -> Build {
    let mut corner = Build::new(name, [3.0, 3.0, 4.0], [-1.0, 0.5, 0.0], 1.0);
    let grey = corner.paint(0.5, 0.0);
    corner.floor(grey, [0.0; 3], 4.0);
    let wall = [(0.0, -4.0), (4.0, -4.0), (4.0, 4.0), (0.0, 4.0)];
    let wall = wall.map(|(y, z)| Vec3::new(-2.0, y, z));
    corner.mesh(grey, wall.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    corner
}

fn is_floor(p: DVec3) -> bool {
    p.y < 1e-3
}

/// Direct light of each pixel that sees something, with its place.
fn direct(picture: &Picture) -> impl Iterator<Item = (DVec3, f64)> {
    let at = positions(picture).into_iter();
    at.zip(levels(picture, "direct"))
        .filter_map(|(p, d)| Some((p?, d)))
}

/// A point light in the plane of a floor gives it nothing, and one in a wall nothing to the wall: the cosine is zero. All else
/// has `I cos / r^2`.
///
/// A place is right to `d = 16 U * 8 m`, and a normal to [`PACKED`]; with `|grad(cos / r^2)| <= 4 / r^3` the bound is
/// `I (4 d / r + PACKED) / r^2`. It holds where the cosine should be zero as well.
#[test]
fn a_light_in_a_surface_lights_what_faces_it() {
    const INTENSITY: f64 = 100.0;
    let place = 16.0 * U * 8.0;
    for (what, at) in [
        ("floor", [0.5, 0.0, 0.25]),
        ("wall", [-2.0, 1.0, 0.5]),
        ("edge", [-2.0, 0.0, 0.5]),
    ] {
        let mut scene = corner("light in a surface");
        scene.light(LightKind::Point, at, INTENSITY as f32);
        let scene = scene.done();
        for backend in all_backends() {
            let name = backend.name();
            let picture = draw(backend.as_ref(), &scene, [64, 36], 8, &settings(), 0);
            let mut worst = 0f64;
            for (p, found) in direct(&picture) {
                let d = DVec3::from(at) - p;
                let r = d.length();
                let cosine = if is_floor(p) { d.y } else { d.x } / r;
                let exact = INTENSITY * cosine.max(0.0) / (r * r);
                let bound = INTENSITY * (4.0 * place / r + PACKED) / (r * r);
                let share = (found - exact).abs() / bound;
                assert!(share <= 1.0, "{name}: {what}: {found} at {p}, not {exact}");
                worst = worst.max(share);
            }
            println!("{name}: a light in the {what}: at most {worst:.3} of the bound");
            pictures::irradiance(&format!("light-in-the-{what}"), name, &picture);
        }
    }
}

/// A sun at the height h above the horizon gives a floor `E sin h`. The normal is right to [`PACKED`] and the direction to a
/// rounding, so that the bound is `E (PACKED + 4 U)`, whatever the height: below [`PACKED`], 13 seconds of arc, a packed normal
/// cannot tell day from night. A wall that faces the sun has all of it, and no floor shadows itself.
#[test]
fn a_grazing_sun_has_the_sine_of_its_height() {
    const IRRADIANCE: f64 = 1000.0;
    for backend in all_backends() {
        let name = backend.name();
        for height in [1e-1f64, 1e-2, 1e-3, 1e-5, 0.0] {
            let mut scene = corner("grazing sun");
            scene.view.sun = Some(Sun {
                direction: DVec3::new(-height.cos(), -height.sin(), 0.0),
                irradiance: Vec3::splat(IRRADIANCE as f32),
            });
            let picture = draw(backend.as_ref(), &scene.done(), [64, 36], 8, &settings(), 0);
            let bound = IRRADIANCE * (PACKED + 4.0 * U);
            let mut worst = 0f64;
            for (p, found) in direct(&picture) {
                let sine = if is_floor(p) {
                    height.sin()
                } else {
                    height.cos()
                };
                let off = (found - IRRADIANCE * sine).abs();
                assert!(off <= bound, "{name}: {height}: off by {off} at {p}");
                worst = worst.max(off);
            }
            println!(
                "{name}: sun {height} rad high: off by {:.2e} of its irradiance (bound {:.2e})",
                worst / IRRADIANCE,
                bound / IRRADIANCE
            );
            pictures::irradiance(&format!("grazing-sun-{height}"), name, &picture);
        }
    }
}
