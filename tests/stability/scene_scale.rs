//! The same scene as a model of millimetres and as a landscape of kilometres. What has a length built into it shows here.
use super::build::{LAMP, LAMP_INTENSITY, room};
use super::common::all_backends;
use super::measure::{
    Noise, SIZE, U, assert_same_light, bits, draw, levels, positions, relative, settings,
};
use super::pictures;
use gibs::passes::scene::{LocalTransform, Scene};
use gibs::view::View;
use glam::Vec3;

const FRAMES: u32 = 48;

/// Lengths times `scale`, and intensities times its square, which leaves irradiance as it is. Radiance stays.
fn scaled(scale: f64) -> (Scene, View) {
    let (mut scene, mut view) = room();
    for mesh in &mut scene.meshes {
        for p in &mut mesh.positions {
            *p = (p.as_dvec3() * scale).as_vec3();
        }
    }
    for node in &mut scene.nodes {
        if let LocalTransform::Parts { translation, .. } = &mut node.local {
            *translation *= scale;
        }
    }
    for light in &mut scene.lights {
        let intensity = light.intensity.as_dvec3() * (scale * scale);
        light.intensity = Vec3::new(intensity.x as f32, intensity.y as f32, intensity.z as f32);
    }
    view.camera.position *= scale;
    view.camera.target *= scale;
    (scene, view)
}

/// Multiplying by a power of two is exact in `f32`, and the eye at the world's origin keeps the floating origin there. Where
/// nothing has a length of its own, every ratio of lengths is then the same number. The bound is equality of all bits.
#[test]
fn powers_of_two_change_no_bit() {
    for backend in all_backends() {
        let name = backend.name();
        let drawn = |scale| {
            draw(
                backend.as_ref(),
                &scaled(scale),
                SIZE,
                FRAMES,
                &settings(),
                0,
            )
        };
        let one = drawn(1.0);
        for power in [-10, 13, 20] {
            let other = drawn(2f64.powi(power));
            for layer in ["E", "direct"] {
                let same = bits(&one, layer) == bits(&other, layer);
                assert!(same, "{name}: {layer} at 2^{power}");
            }
            println!(
                "{name}: lengths times 2^{power}: every bit of E and direct light is the same"
            );
        }
    }
}

/// Other factors round each coordinate anew. Over lengths, that is the displacement of `far_away`, with R = 16 at scale one:
/// direct light within `8 I d / r^3`, `d = 2 * 16 * U * R`, and a rounding of the intensity; indirect light as two draws.
#[test]
fn other_factors_leave_what_f32_leaves() {
    let noise = Noise::of(&room(), SIZE, FRAMES, &settings());
    let place = 2.0 * 16.0 * U * 16.0;
    for backend in all_backends() {
        let name = backend.name();
        let drawn = |scale| {
            draw(
                backend.as_ref(),
                &scaled(scale),
                SIZE,
                FRAMES,
                &settings(),
                0,
            )
        };
        let one = drawn(1.0);
        for scale in [1e-3, 1e4] {
            let other = drawn(scale);
            let (a, b) = (levels(&one, "direct"), levels(&other, "direct"));
            let mut worst = 0f64;
            for (i, p) in positions(&one).into_iter().enumerate() {
                let Some(p) = p else { continue };
                let bound =
                    8.0 * LAMP_INTENSITY * place / (p - LAMP).length().powi(3) + 4.0 * U * a[i];
                let share = (b[i] - a[i]).abs() / bound;
                assert!(share <= 1.0, "{name}: {scale}: direct at {p}: {share}");
                worst = worst.max(share);
            }
            println!("{name}: lengths times {scale}: direct light at most {worst:.3} of its bound");
            assert_same_light(&one, &other, &noise, &format!("{name}: times {scale}"));
            let errors = relative(&one, &other);
            pictures::errors(&format!("scene-scale-{scale}"), name, &one, &errors, 0.5);
        }
    }
}
