//! What an engine changes between frames costs no surfel that could be kept.
mod common;

use common::{all_backends, cpu, settings};
use gibs::graph::{Backend, Executable, Kind};
use gibs::passes::data::{SurfelBirth, SurfelCounters, SurfelPose};
use gibs::passes::frame::Settings;
use gibs::passes::scene::{AlphaMode, Light, LightKind, Material, Mesh, Node, Scene};
use gibs::view::View;
use gibs::{RenderError, Renderer, builtin};
use glam::{DVec3, Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};

const SIZE: [u32; 2] = [64, 64];

/// Every state of the frame, by key.
fn states(renderer: &mut Renderer) -> BTreeMap<String, Vec<u8>> {
    let schedule = renderer.gi().schedule().clone();
    let exec = renderer.executable();
    (0..)
        .zip(&schedule.resources)
        .filter(|(_, r)| matches!(r.kind, Kind::State(_) | Kind::History(_)))
        .map(|(id, r)| (r.key.clone(), exec.read(id).expect("readable")))
        .collect()
}

fn state<T: bytemuck::Pod>(exec: &mut dyn Executable, key: &str) -> Vec<T> {
    let id = exec.schedule().resource(key).expect("a state");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

fn live(renderer: &mut Renderer) -> u32 {
    state::<SurfelCounters>(renderer.executable(), "surfel_counters")[0].live
}

fn box_with_surfels(backend: &dyn Backend) -> (Scene, View, Renderer) {
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
fn with_lamp(scene: &Scene) -> Scene {
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
fn with_pane(scene: &Scene) -> Scene {
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

/// Makes a change and runs a frame; `change` may not touch a bit of any state.
fn keeps_every_bit(
    what: &str,
    change: impl Fn(&mut Renderer, &Scene, &View) -> Result<(), RenderError>,
) {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        let before = states(&mut renderer);
        change(&mut renderer, &scene, &view)
            .unwrap_or_else(|e| panic!("{what} on {}: {e}", backend.name()));
        let after = states(&mut renderer);
        assert_eq!(
            before.keys().collect::<Vec<_>>(),
            after.keys().collect::<Vec<_>>(),
            "{what}"
        );
        for (key, bytes) in &before {
            assert!(after[key] == *bytes, "{what} on {}: {key}", backend.name());
        }
        let had = live(&mut renderer);
        for _ in 0..2 {
            renderer.frame().expect("a frame");
        }
        assert!(live(&mut renderer) >= had, "{what} on {}", backend.name());
        let picture = renderer.picture().expect("a picture");
        let finite = |values: &Vec<f32>| values.iter().all(|x| x.is_finite());
        assert!(picture.channels.values().all(finite), "{what}");
    }
}

#[test]
fn adding_a_light_keeps_every_surfel() {
    keeps_every_bit("a light", |renderer, scene, view| {
        assert!(renderer.gi().schedule().output("direct").is_none());
        renderer.set_lights(&with_lamp(scene), view)?;
        assert!(renderer.gi().schedule().output("direct").is_some());
        Ok(())
    });
}

/// And the lamp shines, as it does for a renderer that had it from the start.
#[test]
fn a_light_that_is_added_shines() {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        renderer.set_lights(&with_lamp(&scene), &view).expect("set");
        renderer.frame().expect("a frame");
        let added = renderer.picture().expect("a picture");
        let lit = with_lamp(&scene);
        let mut anew = Renderer::new(backend.as_ref(), &lit, &view, SIZE, &settings(4000), 0)
            .expect("prepares");
        anew.frame().expect("a frame");
        let anew = anew.picture().expect("a picture");
        for (a, b) in added.rgb("direct").iter().zip(anew.rgb("direct")) {
            assert!(a.iter().flat_map(|c| c.iter()).any(|&d| d > 0.0));
            assert_eq!(*a, b, "{}", backend.name());
        }
    }
}

#[test]
fn another_budget_of_rays_keeps_every_surfel() {
    keeps_every_bit("a budget", |renderer, _, _| {
        renderer.set_settings(&settings(1000))
    });
}

#[test]
fn a_transparent_thing_keeps_every_surfel() {
    keeps_every_bit("a pane", |renderer, scene, view| {
        let binds = |renderer: &Renderer| {
            let mut stages = renderer.gi().schedule().dispatches();
            let mut trace = stages.find(|(_, step, _)| step.label == "gbuffer/ray_trace");
            let (_, _, trace) = trace.take().expect("rays are traced");
            trace.ports.iter().any(|port| port.name == "materials")
        };
        assert!(!binds(renderer));
        renderer.set_scene(&with_pane(scene), view)?;
        assert!(binds(renderer), "the alpha test needs materials");
        Ok(())
    });
}

#[test]
fn another_size_keeps_every_surfel() {
    keeps_every_bit("a size", |renderer, _, _| {
        renderer.resize([97, 51])?;
        assert_eq!(renderer.gi().size(), [97, 51]);
        Ok(())
    });
}

#[test]
fn a_cut_keeps_every_surfel() {
    keeps_every_bit("a cut", |renderer, scene, view| {
        let mut there = view.clone();
        there.camera.vfov *= 0.5;
        renderer.cut(scene, &there)
    });
}

#[test]
fn another_sky_keeps_every_surfel() {
    keeps_every_bit("a sky", |renderer, scene, view| {
        let mut day = view.clone();
        day.environment = gibs::passes::scene::Environment::Constant(Vec3::ONE);
        renderer.set_lights(scene, &day)
    });
}

/// Surfels are moved with the origin: their births, which count from their nodes, stay; their poses move by the shift.
#[test]
fn surfels_follow_the_origin() {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        let births: Vec<SurfelBirth> = state(renderer.executable(), "surfel_births");
        let poses: Vec<SurfelPose> = state(renderer.executable(), "surfel_poses");
        let before = renderer.gi().scene().origin;
        let mut there = view.clone();
        there.camera.position += DVec3::new(100.0, 0.0, -40.0);
        renderer.cut(&scene, &there).expect("a cut");
        let shift = (renderer.gi().scene().origin - before).as_vec3();
        assert!(shift.length() > 90.0, "{shift}");
        renderer.set_camera(view.camera);
        renderer.frame().expect("a frame");
        let moved: Vec<SurfelPose> = state(renderer.executable(), "surfel_poses");
        let after: Vec<SurfelBirth> = state(renderer.executable(), "surfel_births");
        let mut followed = 0;
        for slot in 0..poses.len() {
            let same = moved[slot].identity == poses[slot].identity && poses[slot].radius > 0.0;
            if !same {
                continue;
            }
            assert_eq!(births[slot].position, after[slot].position);
            let off = moved[slot].position + shift - poses[slot].position;
            // A coordinate of up to 128 m is rounded to 2^-18 m twice.
            assert!(off.abs().max_element() < 1e-5, "{off} of slot {slot}");
            followed += 1;
        }
        assert!(followed > 50, "{followed} on {}", backend.name());
    }
}

/// A capacity that grows keeps what is there, and the new slots are free.
#[test]
fn more_room_keeps_every_surfel() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let had = live(&mut renderer);
        let before = states(&mut renderer);
        let settings = Settings {
            surfels: 10_000,
            ..settings(4000)
        };
        renderer.set_settings(&settings).expect("more room");
        assert_eq!(live(&mut renderer), had);
        let after = states(&mut renderer);
        for (key, bytes) in &before {
            let kept = &after[key][..bytes.len()];
            assert!(kept == bytes, "{key} on {}", backend.name());
        }
        for _ in 0..4 {
            renderer.frame().expect("a frame");
            let exec = renderer.executable();
            let stack: Vec<u32> = state(exec, "surfel_free_slots");
            let poses: Vec<SurfelPose> = state(exec, "surfel_poses");
            let live = state::<SurfelCounters>(exec, "surfel_counters")[0].live;
            let free: BTreeSet<u32> = stack[live as usize..].iter().copied().collect();
            assert_eq!(free.len(), 10_000 - live as usize, "a slot is free twice");
            let is_free = |slot: &u32| poses[*slot as usize].radius <= 0.0;
            assert!(free.iter().all(is_free), "{}", backend.name());
        }
        assert!(live(&mut renderer) > had);
    }
}

/// Less room starts over: a slot beyond the end has no place to go.
#[test]
fn less_room_starts_over() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let settings = Settings {
            surfels: 500,
            ..settings(4000)
        };
        renderer.set_settings(&settings).expect("less room");
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        renderer.frame().expect("a frame");
        assert!(live(&mut renderer) > 0, "{}", backend.name());
    }
}

/// Depth functions that begin late hide nothing at first: no surfel goes dark.
#[test]
fn depth_functions_may_come_and_go() {
    let backend = cpu();
    let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
    let with = settings(4000);
    let without = Settings {
        depth: false,
        ..with.clone()
    };
    let mean = |renderer: &mut Renderer| {
        renderer.frame().expect("a frame");
        let picture = renderer.picture().expect("a picture");
        let [red, ..] = picture.rgb("E").expect("irradiance");
        red.iter().sum::<f32>() / red.len() as f32
    };
    let had = live(&mut renderer);
    renderer.set_settings(&without).expect("off");
    assert!(renderer.gi().schedule().resource("surfel_depths").is_none());
    let off = mean(&mut renderer);
    renderer.set_settings(&with).expect("on");
    let on = mean(&mut renderer);
    assert!(live(&mut renderer) >= had);
    assert!((on / off - 1.0).abs() < 0.1, "{off} without, {on} with");
}

/// What cannot be had changes nothing.
#[test]
fn after_an_error_the_frame_goes_on() {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        let before = states(&mut renderer);
        let bad = Settings {
            rays: u32::MAX,
            ..settings(0)
        };
        assert!(renderer.set_settings(&bad).is_err());
        assert!(renderer.resize([0, 10]).is_err());
        let mut broken = scene.clone();
        broken.meshes[0].positions[0] = Vec3::NAN;
        assert!(renderer.set_scene(&broken, &view).is_err());
        if backend.name() != "cpu" {
            // More than a binding holds, or than there is memory.
            assert!(renderer.resize([32_768, 32_768]).is_err());
        }
        assert_eq!(renderer.gi().size(), SIZE);
        assert!(states(&mut renderer) == before, "{}", backend.name());
        renderer.frame().expect("a frame");
        renderer.set_scene(&scene, &view).expect("the same scene");
    }
}
