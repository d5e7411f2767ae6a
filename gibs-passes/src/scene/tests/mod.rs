//! Poses, skinning and validation against closed forms.
mod pose;
mod skinning;
mod validate;

use super::{LocalTransform, Mesh, Node, Scene};
use glam::{DQuat, DVec3, Vec3};

/// A node with the given parent and translation.
fn node(parent: Option<u32>, translation: DVec3) -> Node {
    let local = LocalTransform::Parts {
        translation,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };
    Node {
        name: String::new(),
        parent,
        local,
        meshes: Vec::new(),
        skin: None,
    }
}

/// One node that draws one triangle in the plane z = 0.
fn triangle() -> Scene {
    let mesh = Mesh {
        name: "tri".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let mut root = node(None, DVec3::ZERO);
    root.meshes.push(0);
    Scene {
        meshes: vec![mesh],
        nodes: vec![root],
        ..Scene::default()
    }
}
