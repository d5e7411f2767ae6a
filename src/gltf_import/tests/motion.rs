use super::*;
use gibs_passes::scene::{Interpolation, Keyframes, LocalTransform};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;

#[test]
fn nodes_keep_their_transforms_and_hierarchy() {
    let mut gltf = Gltf::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    gltf.root["nodes"] = json!([
        {"name": "leaf", "mesh": 0, "translation": [1, 0, 0]},
        {"name": "root", "children": [2, 0], "rotation": [0, 0, half, half], "scale": [1, -2, 1]},
        {"name": "fixed", "matrix": [0,0,1,0, 0,1,0,0, -1,0,0,0, 5,6,7,1]},
    ]);
    let scene = gltf.scene();
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["root", "fixed", "leaf"]);
    assert_eq!(scene.nodes[2].parent, Some(0));
    let matrix3 = DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::NEG_X);
    let expected = DAffine3 {
        matrix3,
        translation: DVec3::new(5.0, 6.0, 7.0),
    };
    assert_eq!(scene.nodes[1].local, LocalTransform::Affine(expected));
    let world = scene.pose(&[]).world;
    // The file's f32 rotation is made unit, so only f64 rounding is left.
    assert!(
        (world[2].translation - DVec3::Y).length() < 1e-14,
        "{}",
        world[2].translation
    );
    // (5, 6, 7) scaled to (5, -12, 7) and turned by a quarter.
    assert!((world[1].translation - DVec3::new(12.0, 5.0, 7.0)).length() < 1e-13);
}

#[test]
fn the_default_scene_else_the_first_else_all_roots() {
    let mut gltf = Gltf::triangle();
    gltf.root["nodes"] =
        json!([{"name": "a", "mesh": 0}, {"name": "b", "children": [2]}, {"name": "c"}]);
    let names = |gltf: &Gltf| {
        gltf.scene()
            .nodes
            .iter()
            .map(|node| node.name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&gltf), ["a", "b", "c"]);
    gltf.root["scenes"] = json!([{"nodes": [1]}, {"nodes": [0]}, {}]);
    assert_eq!(names(&gltf), ["b", "c"]);
    // What the scene does not draw is not read.
    assert!(gltf.scene().meshes.is_empty());
    gltf.root["scene"] = json!(1);
    assert_eq!(names(&gltf), ["a"]);
    gltf.root["scene"] = json!(2);
    only_warning(&gltf.import(), "no nodes");
}

#[test]
fn cameras_look_along_minus_z_of_their_node() {
    let mut gltf = Gltf::triangle();
    gltf.root["cameras"] = json!([
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 1, "znear": 0}},
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
    ]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    gltf.root["nodes"] = json!([
        {"camera": 0},
        {"translation": [1, 2, 3], "scale": [2, 2, 2], "children": [2]},
        {"camera": 1, "rotation": [0, half, 0, half]},
    ]);
    let imported = gltf.import();
    only_warning(&imported, "cameras[0]");
    let [(node, camera)] = imported.scene.cameras[..] else {
        panic!("one camera")
    };
    assert_eq!(
        (node, camera.position, camera.vfov),
        (2, DVec3::new(1.0, 2.0, 3.0), 0.5)
    );
    // A quarter turn about +y takes -z to -x.
    assert!(
        (camera.target - DVec3::new(0.0, 2.0, 3.0)).length() < 1e-14,
        "{}",
        camera.target
    );
    assert!((camera.up - DVec3::Y).length() < 1e-14);
}

/// The triangle with two joints at nodes 1 and 2; weights in two sets that sum to two, joint 1 named twice.
fn skinned() -> Gltf {
    let mut gltf = Gltf::triangle();
    let joints = gltf.accessor(
        UNSIGNED_BYTE,
        "VEC4",
        3,
        &[0, 0, 0, 0, 0, 1, 1, 99, 1, 0, 0, 0],
    );
    let weights = gltf.floats(
        "VEC4",
        &[1., 0., 0., 0., 0.5, 0.25, 0.25, 0., 1., 0., 0., 0.],
    );
    let second = gltf.accessor(
        UNSIGNED_SHORT,
        "VEC4",
        3,
        &[1, 0, 0, 0, 0, 0, 0, 0].repeat(3),
    );
    let second_weights = gltf.accessor(
        UNSIGNED_BYTE,
        "VEC4",
        3,
        &[0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0],
    );
    gltf.root["accessors"][second_weights]["normalized"] = json!(true);
    let attributes = &mut gltf.primitive()["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["JOINTS_1"] = json!(second);
    attributes["WEIGHTS_1"] = json!(second_weights);
    let mut binds = [0.0f32; 32];
    for m in 0..2 {
        for d in 0..4 {
            binds[16 * m + 5 * d] = 1.0;
        }
    }
    binds[16 + 12] = -3.0;
    let binds = gltf.floats("MAT4", &binds);
    gltf.root["nodes"] =
        json!([{"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {}, {"translation": [3, 0, 0]}]);
    gltf.root["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    gltf
}

#[test]
fn skins_are_read_with_normalized_weights() {
    let scene = skinned().scene();
    let weights: Vec<_> = scene.meshes[0]
        .skin
        .iter()
        .map(|v| v.weights.clone())
        .collect();
    assert_eq!(
        weights,
        [vec![(0, 1.0)], vec![(0, 0.25), (1, 0.75)], vec![(1, 1.0)]]
    );
    assert_eq!(scene.nodes[0].skin, Some(0));
    let skin = &scene.skins[0];
    assert_eq!(skin.joints, [1, 2]);
    assert_eq!(skin.inverse_bind[0], DAffine3::IDENTITY);
    assert_eq!(skin.inverse_bind[1].translation, DVec3::new(-3.0, 0.0, 0.0));
    let posed = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert_eq!(posed.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(posed.dominant_joint, [1, 2, 2]);
}

#[test]
fn without_bind_matrices_they_are_identities() {
    let mut gltf = skinned();
    gltf.root["skins"][0]
        .as_object_mut()
        .unwrap()
        .remove("inverseBindMatrices");
    assert_eq!(gltf.scene().skins[0].inverse_bind, [DAffine3::IDENTITY; 2]);
}

#[test]
fn a_skin_whose_joints_are_elsewhere_leaves_the_mesh_rigid() {
    let mut gltf = skinned();
    gltf.root["scenes"] = json!([{"nodes": [0, 1]}]);
    let imported = gltf.import();
    only_warning(&imported, "joint node 2");
    assert_eq!(imported.scene.nodes[0].skin, None);
    assert!(imported.scene.skins.is_empty());
}

#[test]
fn animations_keep_their_numbers_and_move_nodes() {
    let mut gltf = Gltf::triangle();
    let times = gltf.floats("SCALAR", &[0., 2.]);
    let moves = gltf.floats("VEC3", &[0., 0., 0., 4., 0., 0.]);
    let turns = gltf.accessor(
        SHORT,
        "VEC4",
        2,
        &[0, 0, 0, 0, 0, 0, 0xff, 0x7f, 0, 0, 0xff, 0x7f, 0, 0, 0, 0],
    );
    gltf.root["accessors"][turns]["normalized"] = json!(true);
    let spline = gltf.floats(
        "VEC3",
        &[
            0., 0., 0., 1., 1., 1., 0., 0., 0., 0., 0., 0., 3., 3., 3., 0., 0., 0.,
        ],
    );
    gltf.root["animations"] = json!([
        {"channels": [], "samplers": []},
        {"name": "all", "samplers": [
            {"input": times, "output": moves},
            {"input": times, "output": turns, "interpolation": "LINEAR"},
            {"input": times, "output": spline, "interpolation": "CUBICSPLINE"},
            {"input": times, "output": moves, "interpolation": "STEP"},
        ], "channels": [
            {"sampler": 0, "target": {"node": 0, "path": "translation"}},
            {"sampler": 1, "target": {"node": 0, "path": "rotation"}},
            {"sampler": 2, "target": {"node": 0, "path": "scale"}},
            {"sampler": 3, "target": {"node": 1, "path": "translation"}},
        ]},
    ]);
    gltf.root["nodes"] = json!([{"mesh": 0}, {}]);
    let scene = gltf.scene();
    assert_eq!(scene.animations.len(), 2);
    let channels = &scene.animations[1].channels;
    assert_eq!(channels[2].interpolation, Interpolation::CubicSpline);
    assert!(
        matches!(&channels[1].keyframes, Keyframes::Rotation(q) if q[1] == DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0))
    );
    let world = scene.pose(&[(1, 1.0)]).world;
    assert_eq!(world[1].translation, DVec3::ZERO);
    // Half way: moved by 2, half of a half turn about y, scale midway between 1 and 3.
    let expected = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.0),
        DQuat::from_rotation_y(FRAC_PI_2),
        DVec3::new(2.0, 0.0, 0.0),
    );
    assert!(world[0].abs_diff_eq(expected, 1e-14), "{:?}", world[0]);
}

#[test]
fn channels_that_move_no_node_are_passed_over() {
    let mut gltf = Gltf::triangle();
    let times = gltf.floats("SCALAR", &[0.]);
    let moves = gltf.floats("VEC3", &[1., 0., 0.]);
    let channel = |target: Value| json!({"sampler": 0, "target": target});
    gltf.root["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}],
        "channels": [
            channel(json!({"path": "translation"})),
            channel(json!({"node": 0, "path": "weights"})),
            channel(json!({"node": 0, "path": "pointer"})),
            channel(json!({"node": 1, "path": "translation"})),
            channel(json!({"node": 0, "path": "translation"})),
        ],
    }]);
    gltf.root["nodes"] = json!([{"mesh": 0}, {}]);
    gltf.root["scenes"] = json!([{"nodes": [0]}]);
    let imported = gltf.import();
    assert_eq!(imported.warnings.len(), 3, "{:?}", imported.warnings);
    assert_eq!(imported.scene.animations[0].channels.len(), 1);
}
