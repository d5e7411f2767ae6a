//! A box that holds surfels, what can be added to it, and the states of its frame.
use crate::common::settings;
use gibs::graph::{Backend, Executable, Kind};
use gibs::passes::data::SurfelCounters;
use gibs::passes::scene::{AlphaMode, Light, LightKind, Material, Mesh, Node, Scene};
use gibs::view::View;
use gibs::{Renderer, builtin};
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

pub(super) const SIZE: [u32; 2] = [64, 64];

/// Every state of the frame, by key.
pub(super) fn states(renderer: &mut Renderer) -> BTreeMap<String, Vec<u8>> {
    let schedule = renderer.gi().schedule().clone();
    let exec = renderer.executable();
    (0..)
        .zip(&schedule.resources)
        .filter(|(_, r)| matches!(r.kind, Kind::State(_) | Kind::History(_)))
        .map(|(id, r)| (r.key.clone(), exec.read(id).expect("readable")))
        .collect()
}

pub(super) fn state<T: bytemuck::Pod>(exec: &mut dyn Executable, key: &str) -> Vec<T> {
    let id = exec.schedule().resource(key).expect("a state");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

pub(super) fn live(renderer: &mut Renderer) -> u32 {
    state::<SurfelCounters>(renderer.executable(), "surfel_counters")[0].live
}

pub(super) fn box_with_surfels(backend: &dyn Backend) -> (Scene, View, Renderer) {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let mut renderer = Renderer::new(backend, &scene, &view, SIZE, &settings(4000), 0)
        .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
    for _ in 0..6 {
        renderer.frame().expect("a frame");
    }
    assert!(live(&mut renderer) > 50, "{}", backend.name());
    (scene, view, renderer)
}

/// The scene with a lamp in the middle of the box.
pub(super) fn with_lamp(scene: &Scene) -> Scene {
    let mut lit = scene.clone();
    let place = DVec3::new(0.0, 1.0, 0.0);
    lit.nodes.push(Node {
        local: gibs::passes::scene::LocalTransform::Affine(glam::DAffine3::from_translation(place)),
        ..Node::default()
    });
    lit.lights.push(Light {
        node: lit.nodes.len() as u32 - 1,
        kind: LightKind::Point,
        intensity: Vec3::splat(2.0),
    });
    lit
}

/// The scene with a pane that lets half of the light through.
pub(super) fn with_pane(scene: &Scene) -> Scene {
    let mut clear = scene.clone();
    clear.materials.push(Material {
        base_color: Vec3::splat(0.5),
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..Material::default()
    });
    let corner = |x: f32, y: f32| Vec3::new(x, 1.0 + y, 0.3);
    clear.meshes.push(Mesh {
        positions: vec![corner(-0.2, -0.2), corner(0.2, -0.2), corner(0.0, 0.2)],
        uvs: vec![Vec2::ZERO; 3],
        triangles: vec![[0, 1, 2]],
        material: clear.materials.len() as u32 - 1,
        ..Mesh::default()
    });
    clear.nodes.push(Node {
        meshes: vec![clear.meshes.len() as u32 - 1],
        ..Node::default()
    });
    clear
}
