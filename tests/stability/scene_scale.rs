//! The same scene as a model of millimetres and as a landscape of kilometres. What has a length built into it shows here.
use super::build::room;
use super::common::all_backends;
use super::measure::{
    FRAMES, Noise, SIZE, assert_same_direct, assert_same_light, bits, draw, relative, settings,
};
use super::{measure, pictures};
use gibs::passes::scene::{LocalTransform, Scene};
use gibs::view::View;
use glam::Vec3;

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
        let one = measure::room(backend.as_ref());
        for power in [-10, 13] {
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

/// Other factors round each coordinate anew: at scale one, numbers below 16 m. Direct light is held to what that leaves, as
/// [`assert_same_direct`] derives, indirect light to chance, [`Noise`].
#[test]
fn other_factors_leave_what_f32_leaves() {
    let noise = Noise::of_room();
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
        let one = measure::room(backend.as_ref());
        for scale in [1e-3, 1e4] {
            let other = drawn(scale);
            let what = format!("{name}: lengths times {scale}");
            assert_same_direct(&one, &other, 16.0, 0.0, &what);
            assert_same_light(&one, &other, &noise, &what);
            let errors = relative(&one, &other);
            pictures::errors(&format!("scene-scale-{scale}"), name, &one, &errors, 0.5);
        }
    }
}
