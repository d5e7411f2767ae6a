//! A scene with what no built-in one has.
use crate::guiding;
use crate::view::View;
use gibs_passes::scene::{Environment, Light, LightKind, LocalTransform, Node, Scene};
use glam::{DQuat, DVec3, Vec3};

/// The same scene with a red light at the eye and every other light a spot; with one node there twice, so that rays hit two
/// instances at one distance; with a third of the triangles turned over, so that rays meet their backs; and under a sky
/// with a small sun.
pub(super) fn enriched((scene, view): &(Scene, View)) -> (Scene, View) {
    let (mut scene, mut view) = (scene.clone(), view.clone());
    for light in scene.lights.iter_mut().step_by(2) {
        light.kind = LightKind::Spot {
            inner: 0.3,
            outer: 1.2,
        };
    }
    scene.lights.push(Light {
        node: scene.nodes.len() as u32,
        kind: LightKind::Point,
        intensity: Vec3::X,
    });
    scene.nodes.push(Node {
        local: LocalTransform::Parts {
            translation: view.camera.position,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
        },
        ..Node::default()
    });
    let rigid = |node: &&Node| !node.meshes.is_empty() && node.skin.is_none();
    if let Some(node) = scene.nodes.iter().rfind(rigid) {
        scene.nodes.push(node.clone());
    }
    for mesh in &mut scene.meshes {
        let some = mesh.triangles.iter_mut().step_by(3);
        some.for_each(|corners| corners.swap(1, 2));
    }
    view.environment = sky();
    (scene, view)
}

/// The same scene without lights, under a sky with a small sun, with whatever emits in it.
pub(super) fn under_sky((scene, view): &(Scene, View)) -> (Scene, View) {
    let (mut scene, mut view) = (scene.clone(), view.clone());
    scene.lights.clear();
    view.sun = None;
    view.environment = sky();
    (scene, view)
}

/// The scene in the dark, but for its own light.
pub(super) fn without_sky((scene, view): &(Scene, View)) -> (Scene, View) {
    let mut view = view.clone();
    view.sun = None;
    view.environment = Environment::default();
    (scene.clone(), view)
}

/// A sky with a small sun.
pub(super) fn sky() -> Environment {
    guiding::built_in("sun").map_or_else(Environment::default, Environment::Map)
}
