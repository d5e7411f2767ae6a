use super::{node, triangle};
use crate::scene::{LocalTransform, Scene, Skin, SkinVertex};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;

/// The triangle bound to joints in nodes 1 and 2, with the given weights per vertex.
fn bound(weights: [&[(u16, f32)]; 3]) -> Scene {
    let mut scene = triangle();
    scene.nodes.push(node(None, DVec3::ZERO));
    scene.nodes.push(node(None, DVec3::ZERO));
    scene.nodes[0].skin = Some(0);
    scene.meshes[0].skin = weights
        .map(|w| SkinVertex {
            weights: w.to_vec(),
        })
        .to_vec();
    scene.skins.push(Skin {
        joints: vec![1, 2],
        inverse_bind: vec![DAffine3::IDENTITY; 2],
    });
    scene
}

fn place(scene: &mut Scene, node: usize, affine: DAffine3) {
    scene.nodes[node].local = LocalTransform::Affine(affine);
}

#[test]
fn rigid_meshes_follow_their_node() {
    let mut scene = triangle();
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(-2.0, 1.0, 0.5),
        DQuat::from_rotation_x(FRAC_PI_2),
        DVec3::X,
    );
    place(&mut scene, 0, map);
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    let expected = [
        DVec3::X,
        DVec3::new(-1.0, 0.0, 0.0),
        DVec3::new(1.0, 0.0, 1.0),
    ];
    for (found, expected) in mesh.positions.iter().zip(expected) {
        assert!((*found - expected).length() < 1e-15, "{found}");
    }
    // +z turned about x by a quarter is -y; neither the mirroring nor the scale changes that.
    for normal in &mesh.normals {
        assert!((*normal - Vec3::NEG_Y).length() < 1e-7, "{normal}");
    }
    assert_eq!(mesh.dominant_joint, [0; 3]);
}

/// Normals stay perpendicular to the surface under uneven scale.
#[test]
fn normals_go_through_the_inverse_transpose() {
    let mut scene = triangle();
    scene.meshes[0].normals = vec![Vec3::new(1.0, 1.0, 0.0).normalize(); 3];
    place(
        &mut scene,
        0,
        DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0)),
    );
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    let expected = Vec3::new(0.5, 1.0, 0.0).normalize();
    assert!(
        (mesh.normals[0] - expected).length() < 1e-7,
        "{}",
        mesh.normals[0]
    );
    // A flattened mesh has its flat side's normal, and what has none keeps its own.
    scene.meshes[0].normals[1] = Vec3::Z;
    place(
        &mut scene,
        0,
        DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)),
    );
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert_eq!(mesh.normals[1], Vec3::Z);
    assert_eq!(mesh.normals[0], scene.meshes[0].normals[0]);
}

#[test]
fn joints_blend_linearly_and_the_node_does_not_count() {
    let mut scene = bound([&[(0, 1.0)], &[(0, 0.75), (1, 0.25)], &[(1, 1.0)]]);
    place(
        &mut scene,
        0,
        DAffine3::from_translation(DVec3::splat(100.0)),
    );
    place(
        &mut scene,
        2,
        DAffine3::from_translation(DVec3::new(0.0, 0.0, 4.0)),
    );
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert_eq!(
        mesh.positions,
        [
            DVec3::ZERO,
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(0.0, 1.0, 4.0)
        ]
    );
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    assert_eq!(mesh.dominant_joint, [1, 1, 2]);
}

/// The average of no turn and a half turn about z flattens x and y: linear blending's known collapse.
#[test]
fn opposite_rotations_collapse_as_linear_blending_does() {
    let mut scene = bound([&[(0, 0.5), (1, 0.5)]; 3]);
    place(&mut scene, 2, DAffine3::from_rotation_z(2.0 * FRAC_PI_2));
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    for position in &mesh.positions {
        assert!(position.length() < 1e-15, "{position}");
    }
}

#[test]
fn the_bind_pose_leaves_vertices_where_they_are() {
    let mut scene = bound([&[(0, 0.1), (1, 0.9)], &[(0, 0.5), (1, 0.5)], &[(1, 1.0)]]);
    let maps = [
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0),
            DQuat::from_rotation_y(0.7),
            DVec3::X,
        ),
        DAffine3::from_rotation_translation(
            DQuat::from_rotation_x(-0.4),
            DVec3::new(3.0, 2.0, 1.0),
        ),
    ];
    for (joint, map) in maps.into_iter().enumerate() {
        place(&mut scene, joint + 1, map);
        scene.skins[0].inverse_bind[joint] = map.inverse();
    }
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    for (found, rest) in mesh.positions.iter().zip(&scene.meshes[0].positions) {
        // Inverting and multiplying matrices of size 3 rounds a few times.
        assert!((*found - rest.as_dvec3()).length() < 1e-14, "{found}");
    }
}

/// Far from the origin, weights that sum to one only within f32 rounding must not pull vertices.
#[test]
fn rounded_weights_do_not_shift_far_vertices() {
    let mut scene = bound([&[(0, 0.1), (1, 0.2), (0, 0.7)]; 3]);
    let far = DAffine3::from_translation(DVec3::splat(1e6));
    place(&mut scene, 1, far);
    place(&mut scene, 2, far);
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert!((mesh.positions[0] - DVec3::splat(1e6)).length() < 1e-8);
}

#[test]
fn of_equal_weights_the_first_joint_dominates() {
    let scene = bound([
        &[(1, 0.5), (0, 0.5)],
        &[(0, 0.5), (1, 0.5)],
        &[(0, 0.4), (1, 0.6)],
    ]);
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert_eq!(mesh.dominant_joint, [1, 1, 2]);
}

#[test]
fn a_mesh_without_weights_is_rigid_even_beside_a_skin() {
    let mut scene = bound([&[(0, 1.0)]; 3]);
    scene.meshes[0].skin.clear();
    scene.meshes[0].normals.clear();
    place(&mut scene, 0, DAffine3::from_translation(DVec3::Y));
    let mesh = scene.skinned_positions(&scene.pose(&[]), 0, 0);
    assert_eq!(mesh.positions[0], DVec3::Y);
    assert!(mesh.normals.is_empty());
    assert_eq!(mesh.dominant_joint, [0; 3]);
}
