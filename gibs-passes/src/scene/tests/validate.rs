use super::{node, triangle};
use crate::scene::{
    Animation, Camera, Channel, Interpolation, Keyframes, Light, LightKind, LocalTransform,
    Material, Sampler, Scene, SceneDataError, Skin, SkinVertex, Texture, TextureRef,
};
use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2, Vec3};

/// A scene with one of everything, valid.
fn full() -> Scene {
    let mut scene = triangle();
    let texture = TextureRef {
        texture: 0,
        sampler: Sampler::default(),
        transform: Affine2::IDENTITY,
    };
    scene.materials.push(Material {
        base_color_texture: Some(texture),
        ..Material::default()
    });
    scene.textures.push(Texture {
        name: "t".to_owned(),
        width: 1,
        height: 2,
        texels: vec![[0; 4]; 2],
    });
    scene.meshes[0].uvs = vec![Vec2::ZERO; 3];
    scene.meshes[0].skin = vec![
        SkinVertex {
            weights: vec![(0, 1.0)]
        };
        3
    ];
    scene.nodes.push(node(Some(0), DVec3::ZERO));
    scene.nodes[0].skin = Some(0);
    scene.skins.push(Skin {
        joints: vec![1],
        inverse_bind: vec![DAffine3::IDENTITY],
    });
    scene.animations.push(Animation {
        name: "walk".to_owned(),
        channels: vec![Channel {
            node: 1,
            times: vec![0.0, 1.0],
            keyframes: Keyframes::Rotation(vec![DQuat::IDENTITY; 2]),
            interpolation: Interpolation::Linear,
        }],
    });
    let kind = LightKind::Spot {
        inner: 0.1,
        outer: 0.2,
    };
    scene.lights.push(Light {
        node: 0,
        kind,
        intensity: Vec3::ONE,
    });
    let camera = Camera {
        position: DVec3::Z,
        target: DVec3::ZERO,
        up: DVec3::Y,
        vfov: 1.0,
    };
    scene.cameras.push((1, camera));
    scene
}

/// A broken scene must be refused with a text that has all the given parts.
fn refused(breaking: impl FnOnce(&mut Scene), parts: &[&str]) {
    let mut scene = full();
    breaking(&mut scene);
    match scene.validate() {
        Ok(_) => panic!("accepted, expected {parts:?}"),
        Err(error) => {
            let text = error.to_string();
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{text:?} lacks one of {parts:?}"
            );
        }
    }
}

/// A scene with a blemish must pass with one warning that has the given part, and pass again without.
fn repaired(breaking: impl FnOnce(&mut Scene), part: &str) -> Scene {
    let mut scene = full();
    breaking(&mut scene);
    let warnings = scene.validate().unwrap();
    assert!(
        warnings.len() == 1 && warnings[0].contains(part),
        "{warnings:?} lacks {part:?}"
    );
    assert_eq!(scene.validate(), Ok(Vec::new()), "a second call");
    scene
}

#[test]
fn a_sound_scene_passes_unchanged() {
    let mut scene = full();
    assert_eq!(scene.validate(), Ok(Vec::new()));
    assert_eq!(format!("{scene:?}"), format!("{:?}", full()));
    let mut empty = Scene::default();
    assert_eq!(empty.validate(), Ok(Vec::new()));
    assert_eq!(empty.materials.len(), 1);
}

#[test]
fn indices_out_of_range_are_named() {
    refused(
        |s| s.meshes[0].triangles[0][1] = 3,
        &["mesh 0 \"tri\", triangle 0", "vertex 3", "there are 3"],
    );
    refused(|s| s.meshes[0].material = 7, &["mesh 0", "material 7"]);
    refused(|s| s.nodes[1].meshes.push(4), &["node 1", "mesh 4"]);
    refused(|s| s.nodes[0].skin = Some(2), &["node 0", "skin 2"]);
    refused(|s| s.skins[0].joints[0] = 9, &["skin 0", "joint node 9"]);
    refused(
        |s| s.meshes[0].skin[2].weights[0].0 = 5,
        &["mesh 0", "vertex 2", "joint 5"],
    );
    refused(
        |s| s.animations[0].channels[0].node = 8,
        &["animation 0 \"walk\", channel 0", "node 8"],
    );
    refused(|s| s.lights[0].node = 8, &["light 0", "node 8"]);
    refused(|s| s.cameras[0].0 = 8, &["camera 0", "node 8"]);
    refused(
        |s| s.textures.clear(),
        &["material 0", "texture 0", "there are 0"],
    );
}

#[test]
fn lengths_that_disagree_are_named() {
    refused(
        |s| s.meshes[0].normals.truncate(2),
        &["mesh 0", "2 normals", "3"],
    );
    refused(|s| s.meshes[0].uvs.truncate(1), &["1 texture coordinates"]);
    refused(|s| s.meshes[0].skin.truncate(1), &["1 skin vertices"]);
    refused(
        |s| s.skins[0].inverse_bind.clear(),
        &["skin 0", "0 inverse bind matrices"],
    );
    refused(
        |s| s.animations[0].channels[0].times.push(2.0),
        &["2 keyframe values", "1 for each of 3"],
    );
    refused(
        |s| s.animations[0].channels[0].interpolation = Interpolation::CubicSpline,
        &["3 for each of 2"],
    );
    refused(
        |s| s.animations[0].channels[0].times.clear(),
        &["0 keyframe times"],
    );
    refused(
        |s| s.textures[0].height = 3,
        &["texture 0 \"t\"", "2 texels", "width 1 x height 3"],
    );
    refused(
        |s| s.textures[0] = Texture::default(),
        &["texture 0", "0 texels"],
    );
    // The product of the sides must not wrap around to a small number.
    refused(
        |s| (s.textures[0].width, s.textures[0].height) = (1 << 31, 1 << 31),
        &["texels"],
    );
}

#[test]
fn numbers_without_meaning_are_named() {
    refused(
        |s| s.meshes[0].positions[1].y = f32::NAN,
        &["mesh 0 \"tri\", vertex 1", "position", "NaN"],
    );
    refused(
        |s| s.meshes[0].skin[1].weights[0].1 = -0.5,
        &["vertex 1", "weight of joint 0", "-0.5"],
    );
    refused(
        |s| s.materials[0].emission.x = -1.0,
        &["material 0", "emission"],
    );
    refused(|s| s.materials[0].alpha = f32::NAN, &["alpha"]);
    refused(
        |s| s.lights[0].intensity.z = f32::INFINITY,
        &["light 0", "intensity", "inf"],
    );
    refused(
        |s| {
            s.lights[0].kind = LightKind::Spot {
                inner: 0.0,
                outer: 0.0,
            }
        },
        &["light 0", "cone"],
    );
    refused(
        |s| s.cameras[0].1.vfov = 0.0,
        &["camera 0", "field of view", "0"],
    );
    refused(
        |s| s.skins[0].inverse_bind[0].translation.x = f64::NAN,
        &["skin 0", "inverse bind matrix 0"],
    );
    refused(
        |s| s.animations[0].channels[0].times[1] = -1.0,
        &["time of keyframe 1", "-1"],
    );
    refused(
        |s| s.nodes[1].local = LocalTransform::Affine(DAffine3::NAN),
        &["node 1", "transform"],
    );
    refused(
        |s| {
            let LocalTransform::Parts { scale, .. } = &mut s.nodes[0].local else {
                return;
            };
            scale.x = f64::INFINITY;
        },
        &["node 0", "scale"],
    );
}

#[test]
fn parents_stand_before_children() {
    refused(
        |s| s.nodes[0].parent = Some(1),
        &["node 0", "node 1 as parent"],
    );
    let mut scene = full();
    scene.nodes[1].parent = Some(1);
    let error = SceneDataError::Hierarchy {
        element: "node 1".to_owned(),
        parent: 1,
    };
    assert_eq!(scene.validate(), Err(error));
}

#[test]
fn flat_triangles_are_dropped() {
    let flat = |s: &mut Scene| {
        s.meshes[0].positions.push(Vec3::X * 2.0);
        s.meshes[0].normals.push(Vec3::Z);
        s.meshes[0].uvs.push(Vec2::ZERO);
        s.meshes[0].skin.push(SkinVertex {
            weights: vec![(0, 1.0)],
        });
        // Twice the same corner, three corners on a line, and one that stays.
        s.meshes[0].triangles = vec![[0, 0, 1], [0, 1, 3], [0, 3, 2]];
    };
    let scene = repaired(
        flat,
        "2 triangles without area dropped (first in mesh 0 \"tri\")",
    );
    assert_eq!(scene.meshes[0].triangles, [[0, 3, 2]]);
}

#[test]
fn normals_without_length_become_the_triangles_own() {
    let broken = |s: &mut Scene| s.meshes[0].normals = vec![Vec3::ZERO, Vec3::NAN, Vec3::X * 3.0];
    let scene = repaired(broken, "2 normals of no usable length");
    assert_eq!(scene.meshes[0].normals, [Vec3::Z, Vec3::Z, Vec3::X]);
}

#[test]
fn weights_sum_to_one() {
    let mut scene = full();
    scene.skins[0] = Skin {
        joints: vec![1, 0],
        inverse_bind: vec![DAffine3::IDENTITY; 2],
    };
    scene.meshes[0].skin[0].weights = vec![(0, 3.0), (1, 1.0), (1, 0.0)];
    assert_eq!(scene.validate(), Ok(Vec::new()));
    assert_eq!(scene.meshes[0].skin[0].weights, [(0, 0.75), (1, 0.25)]);
    let scene = repaired(
        |s| s.meshes[0].skin[1].weights.clear(),
        "1 vertex without skin weights",
    );
    assert_eq!(scene.meshes[0].skin[1].weights, [(0, 1.0)]);
}

#[test]
fn blemishes_are_repaired_with_one_warning() {
    let scene = repaired(
        |s| s.materials[0].base_color.x = 1.5,
        "1 material had a factor outside 0..1",
    );
    assert_eq!(scene.materials[0].base_color, Vec3::ONE);
    let scene = repaired(
        |s| s.meshes[0].uvs[0].x = f32::NAN,
        "1 texture coordinate not finite",
    );
    assert_eq!(scene.meshes[0].uvs[0], Vec2::ZERO);
    let wide = LightKind::Spot {
        inner: 3.0,
        outer: 3.0,
    };
    let scene = repaired(|s| s.lights[0].kind = wide, "1 spot light had angles");
    let LightKind::Spot { inner, outer } = scene.lights[0].kind else {
        panic!("a spot light")
    };
    assert!(inner < outer && outer <= std::f32::consts::FRAC_PI_2);
    let none = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let scene = repaired(
        |s| {
            s.animations[0].channels[0].keyframes =
                Keyframes::Rotation(vec![none, DQuat::from_xyzw(0.0, 0.0, 2.0, 0.0)])
        },
        "1 keyframe had a rotation of no length",
    );
    let Keyframes::Rotation(values) = &scene.animations[0].channels[0].keyframes else {
        panic!("rotations")
    };
    assert_eq!(
        values[..],
        [DQuat::IDENTITY, DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0)]
    );
}
