//! Scenes built in memory with values that are refused, and those that are repaired with a warning.
use super::memory::{Breaking, Running, SIZE, repaired, settings, whole};
use gibs::Gi;
use gibs::graph::{Backend, NullBackend};
use gibs::passes::frame::Screen;
use gibs::passes::scene::{
    Environment, EnvironmentMap, Keyframes, LightKind, LocalTransform, Material, Scene,
};
use gibs::view::View;
use glam::{DQuat, DVec3, Vec3};

fn map(width: u32, height: u32, texels: Vec<Vec3>) -> Environment {
    Environment::Map(EnvironmentMap {
        width,
        height,
        texels,
        rotation_y: 0.0,
    })
}

#[test]
fn a_scene_without_materials_is_white() {
    let bare = repaired(&|s, _| s.materials.clear(), &[]);
    let white = repaired(&|s, _| s.materials = vec![Material::default()], &[]);
    assert_eq!(bare.channels, white.channels);
}

/// Numbers that are sound one by one, and together move a vertex out of range.
#[test]
fn a_skin_that_poses_vertices_out_of_range_is_named() {
    Running::new(Screen::Traced).refuses(
        &|s, _| s.skins[0].inverse_bind[0].translation.x = 1e13,
        &[
            "mesh 1 \"flag\", vertex 0",
            "node 1 \"pole\"",
            "bring the joints closer",
        ],
    );
}

#[test]
fn lights_that_are_none_are_named() {
    let mut running = Running::new(Screen::Traced);
    for (value, text) in [
        (f32::NAN, "NaN"),
        (-1.0, "-1"),
        (f32::INFINITY, "inf"),
        (1e14, "100000000000000"),
    ] {
        let parts = [text, "must be finite, not negative and at most 1e13"];
        let named = |name: &'static str| [&[name][..], &parts].concat();
        running.refuses_everywhere(
            &|s, _| s.lights[0].intensity.y = value,
            &named("light 0: intensity"),
        );
        running.refuses_everywhere(
            &|_, v| v.sun.as_mut().expect("a sun").irradiance.y = value,
            &named("the view cannot be rendered: the sun: irradiance"),
        );
        running.refuses_everywhere(
            &|_, v| v.environment = Environment::Constant(Vec3::splat(value)),
            &named("the sky: radiance"),
        );
        running.refuses_everywhere(
            &|s, _| s.materials[0].emission.y = value,
            &named("material 0 \"paint\": emission"),
        );
    }
}

#[test]
fn a_sun_without_a_direction_is_named() {
    let mut running = Running::new(Screen::Traced);
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        let value = direction.to_string();
        running.refuses_everywhere(
            &|_, v| v.sun.as_mut().expect("a sun").direction = direction,
            &["the sun: direction", &value, "finite and have a length"],
        );
    }
}

#[test]
fn the_length_of_the_suns_direction_counts_for_nothing() {
    let expected = repaired(&|_, _| (), &[]);
    for length in [1e-200, 3.0, 1e200] {
        let long = |_: &mut Scene, v: &mut View| {
            v.sun.as_mut().expect("a sun").direction *= length;
        };
        assert_eq!(repaired(&long, &[]).channels, expected.channels, "{length}");
    }
}

#[test]
fn environment_maps_with_too_few_texels_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses_everywhere(
        &|_, v| v.environment = map(4, 2, vec![Vec3::ONE; 7]),
        &[
            "environment map has 7 texels",
            "width 4 x height 2",
            "give exactly as many",
        ],
    );
    running.refuses_everywhere(
        &|_, v| v.environment = map(0, 0, Vec::new()),
        &["environment map has 0 texels", "at least one"],
    );
    running.refuses_everywhere(
        &|_, v| {
            let mut turned = map(1, 1, vec![Vec3::ONE]);
            if let Environment::Map(map) = &mut turned {
                map.rotation_y = f64::NAN;
            }
            v.environment = turned;
        },
        &["environment map: rotation is NaN", "must be finite"],
    );
}

#[test]
fn texels_of_environment_maps_are_clamped_with_a_warning() {
    let bad = [Vec3::NAN, Vec3::NEG_ONE, Vec3::ONE, Vec3::splat(1e20)];
    let clamped = [Vec3::ZERO, Vec3::ZERO, Vec3::ONE, Vec3::splat(1e13)];
    let warning = ["environment map: 3 of 4 texels", "were clamped"];
    let got = repaired(&|_, v| v.environment = map(2, 2, bad.to_vec()), &warning);
    let want = repaired(&|_, v| v.environment = map(2, 2, clamped.to_vec()), &[]);
    assert_eq!(got.channels, want.channels);
}

#[test]
fn materials_that_are_no_numbers_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses_everywhere(
        &|s, _| s.materials[0].base_color.x = f32::NAN,
        &["material 0 \"paint\": base colour", "NaN", "must be finite"],
    );
    running.refuses_everywhere(
        &|s, _| s.materials[0].alpha = f32::INFINITY,
        &["material 0 \"paint\": alpha is inf", "must be finite"],
    );
    running.refuses_everywhere(
        &|s, _| {
            let used = s.materials[0].base_color_texture.as_mut();
            used.expect("a texture").transform.translation.x = f32::NAN;
        },
        &["material 0 \"paint\": texture transform", "must be finite"],
    );
}

#[test]
fn an_albedo_above_one_is_clamped_with_a_warning() {
    let warning = [
        "1 material had a factor outside 0..1",
        "material 0 \"paint\"",
    ];
    let got = repaired(
        &|s, _| s.materials[0].base_color = Vec3::splat(10.0),
        &warning,
    );
    let white = repaired(&|s, _| s.materials[0].base_color = Vec3::ONE, &[]);
    assert_eq!(got.channels, white.channels);
}

#[test]
fn normals_that_are_none_are_replaced_with_a_warning() {
    let expected = repaired(&|_, _| (), &[]);
    let warning = ["2 normals of no usable length", "mesh 0 \"wall\""];
    let broken = |s: &mut Scene, _: &mut View| {
        (s.meshes[0].normals[0], s.meshes[0].normals[2]) = (Vec3::NAN, Vec3::ZERO);
    };
    assert_eq!(repaired(&broken, &warning).channels, expected.channels);
    // The length of a normal counts for nothing.
    for length in [1e-15, 5.0, f32::MAX] {
        let long = |s: &mut Scene, _: &mut View| s.meshes[0].normals[1] *= length;
        assert_eq!(repaired(&long, &[]).channels, expected.channels, "{length}");
    }
}

#[test]
fn other_blemishes_are_repaired_with_a_warning() {
    let expected = repaired(&|_, _| (), &[]);
    let same = |breaking: Breaking<'_>, warning: &[&str]| {
        assert_eq!(repaired(breaking, warning).channels, expected.channels);
    };
    same(
        &|s, _| s.meshes[0].triangles.push([1, 1, 2]),
        &["1 triangle without area dropped", "mesh 0"],
    );
    same(
        &|s, _| s.meshes[0].uvs[1].x = f32::NAN,
        &["1 texture coordinate not finite", "mesh 0"],
    );
    same(
        &|s, _| s.meshes[1].skin[1].weights.clear(),
        &["1 vertex without skin weights", "mesh 1"],
    );
    // Weights count by their shares; what has none follows nothing.
    same(
        &|s, _| s.meshes[1].skin[1].weights = vec![(0, 7.0), (99, 0.0)],
        &[],
    );
    let none = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let turned = move |rotation| LocalTransform::Parts {
        translation: DVec3::ZERO,
        rotation,
        scale: DVec3::ONE,
    };
    same(
        &|s, _| s.nodes[0].local = turned(none),
        &["1 node had a rotation of no length", "node 0"],
    );
    same(
        &|s, _| s.nodes[0].local = turned(DQuat::IDENTITY * 3.0),
        &[],
    );
    same(
        &|s, _| s.animations[0].channels[0].keyframes = Keyframes::Rotation(vec![none]),
        &["1 keyframe had a rotation of no length", "animation 0"],
    );
    same(
        &|s, _| {
            let long = DQuat::IDENTITY * 3.0;
            s.animations[0].channels[0].keyframes = Keyframes::Rotation(vec![long]);
        },
        &[],
    );
    repaired(
        &|s, _| {
            s.lights[0].kind = LightKind::Spot {
                inner: 3.0,
                outer: 3.0,
            }
        },
        &["1 spot light had angles outside", "light 0"],
    );
}

/// What the lights have lost is told anew when they change, and what the geometry has lost is told still.
#[test]
fn warnings_follow_the_lights() {
    let (mut scene, view) = whole();
    scene.meshes[0].triangles.push([1, 1, 2]);
    let mut gi = Gi::new(&scene, &view, SIZE, &settings(), Screen::Traced).expect("a frame");
    let exec = NullBackend::new().prepare(gi.schedule().clone());
    let mut exec = exec.expect("prepares");
    for outer in [1.0f32, 3.0, 1.0] {
        scene.lights[0].kind = LightKind::Spot { inner: 0.0, outer };
        gi.set_lights(exec.as_mut(), &scene, &view)
            .expect("changes");
        let told = |part| {
            gi.scene()
                .warnings
                .iter()
                .filter(|w| w.contains(part))
                .count()
        };
        assert_eq!(told("without area"), 1, "{outer}");
        assert_eq!(told("spot light"), usize::from(outer > 2.0), "{outer}");
    }
}
