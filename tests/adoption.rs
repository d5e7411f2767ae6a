//! What an engine changes between frames costs no surfel that could be kept.
mod common;

use common::{all_backends, cpu, mean, settings};
use gibs::graph::{Backend, BackendError, Executable, Initial, Kind, ResourceId, Schedule};
use gibs::passes::data::{HostGbuffer, SurfelBirth, SurfelCounters, SurfelPose};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{AlphaMode, Light, LightKind, Material, Mesh, Node, Scene};
use gibs::passes::shared::mark;
use gibs::view::View;
use gibs::{Gi, RenderError, Renderer, builtin};
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

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
            let same = mark::identity(moved[slot].mark) == mark::identity(poses[slot].mark)
                && poses[slot].radius > 0.0;
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

/// The origin moves and nothing else: no state changes until the next frame, which finds every surfel where it was in the
/// world, and lights the picture as if the origin had stayed.
#[test]
fn an_origin_that_shifts_keeps_every_surfel_and_its_light() {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        let (_, _, mut stays) = box_with_surfels(backend.as_ref());
        let before = states(&mut renderer);
        let births: Vec<SurfelBirth> = state(renderer.executable(), "surfel_births");
        let poses: Vec<SurfelPose> = state(renderer.executable(), "surfel_poses");
        let origin = renderer.gi().scene().origin;
        let mut away = view.camera;
        away.position += DVec3::new(100.0, 0.0, -40.0);
        renderer.set_camera(away);
        renderer.shift_origin(&scene).expect("a shift");
        let shift = (renderer.gi().scene().origin - origin).as_vec3();
        assert!(shift.length() > 90.0, "{shift}");
        assert!(states(&mut renderer) == before, "{}", backend.name());
        renderer.set_camera(view.camera);
        renderer.frame().expect("a frame");
        stays.frame().expect("a frame");

        let moved: Vec<SurfelPose> = state(renderer.executable(), "surfel_poses");
        let after: Vec<SurfelBirth> = state(renderer.executable(), "surfel_births");
        let mut followed = 0;
        for slot in 0..poses.len() {
            if mark::identity(moved[slot].mark) != mark::identity(poses[slot].mark)
                || poses[slot].radius <= 0.0
            {
                continue;
            }
            assert_eq!(births[slot].position, after[slot].position);
            let off = moved[slot].position + shift - poses[slot].position;
            // A coordinate of up to 128 m is rounded to 2^-18 m twice.
            assert!(off.abs().max_element() < 1e-5, "{off} of slot {slot}");
            followed += 1;
        }
        assert!(followed > 50, "{followed} on {}", backend.name());

        let (moved, stayed) = (
            renderer.picture().expect("a picture"),
            stays.picture().expect("a picture"),
        );
        let difference = mean(&moved, "E") / mean(&stayed, "E") - 1.0;
        println!("{}: {:+.4} %", backend.name(), difference * 100.0);
        // Rounding moves a ray across an edge here and there, and no more.
        assert!(difference.abs() < 0.005, "{difference}");
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

/// A state of a stage that extends the frame is none of the surfels' business.
#[test]
fn less_room_leaves_other_states_alone() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let mut renderer = Renderer::extended(
            backend.as_ref(),
            &scene,
            &view,
            SIZE,
            &settings(1000),
            0,
            |g, _| {
                let (state, buffer) = g.state::<u32>("of_another", 3, Initial::Zero);
                g.output("of_another", &buffer);
                g.keep(state, buffer);
            },
        )
        .expect("prepares");
        renderer.frame().expect("a frame");
        let exec = renderer.executable();
        let id = exec.schedule().resource("of_another").expect("declared");
        let written = bytemuck::cast_slice(&[7u32, 8, 9]).to_vec();
        exec.upload(id, 0, &written).expect("written");
        let settings = Settings {
            surfels: 500,
            ..settings(1000)
        };
        renderer.set_settings(&settings).expect("less room");
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        assert_eq!(
            state::<u32>(renderer.executable(), "of_another"),
            [7, 8, 9],
            "{}",
            backend.name()
        );
    }
}

/// After a reset come the frames that a new renderer would make.
#[test]
fn a_reset_starts_over() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let (first, picture) = (
            states(&mut renderer),
            renderer.picture().expect("a picture"),
        );
        renderer.reset().expect("a reset");
        assert_eq!(renderer.gi().frames(), 0);
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        assert!(matches!(
            renderer.picture(),
            Err(RenderError::NoFrame { .. })
        ));
        for _ in 0..6 {
            renderer.frame().expect("a frame");
        }
        assert!(states(&mut renderer) == first, "{}", backend.name());
        assert!(renderer.picture().expect("a picture") == picture);
    }
}

/// Where nothing but values changes, the schedule stays, and with it all that belongs to it.
#[test]
fn values_need_no_other_schedule() {
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        renderer.set_lights(&with_lamp(&scene), &view).expect("set");
        let schedule = renderer.gi().schedule().clone();
        let mut brighter = with_lamp(&scene);
        brighter.lights[0].intensity *= 4.0;
        let direct = |renderer: &mut Renderer| {
            renderer.frame().expect("a frame");
            renderer.output::<Vec4>("direct").expect("lit")
        };
        let once = direct(&mut renderer);
        renderer.set_lights(&brighter, &view).expect("brighter");
        assert!(Arc::ptr_eq(&schedule, renderer.gi().schedule()));
        for (a, b) in once.iter().zip(direct(&mut renderer)) {
            assert_eq!(a.truncate() * 4.0, b.truncate(), "{}", backend.name());
        }
        let settings = Settings {
            coverage: 2.0,
            lookup: 32,
            ..settings(4000)
        };
        renderer.set_settings(&settings).expect("set");
        assert!(Arc::ptr_eq(&schedule, renderer.gi().schedule()));
        // What moves changes what inputs hold, and nothing else.
        let mut moved = brighter.clone();
        let drawn = moved.nodes.iter_mut().find(|node| !node.meshes.is_empty());
        let away = DVec3::new(0.0, 0.01, 0.0);
        drawn.expect("something is drawn").local =
            gibs::passes::scene::LocalTransform::Affine(glam::DAffine3::from_translation(away));
        renderer.set_scene(&moved, &view).expect("moved");
        let lit = Renderer::new(backend.as_ref(), &moved, &view, SIZE, &settings, 0);
        let mut anew = lit.expect("prepares");
        let (changed, anew) = (direct(&mut renderer), direct(&mut anew));
        assert_eq!(changed, anew, "{}", backend.name());
        renderer.resize([96, 64]).expect("resized");
        assert!(!Arc::ptr_eq(&schedule, renderer.gi().schedule()));
    }
}

/// Between a change and the next frame there is nothing to see.
#[test]
fn a_change_leaves_no_picture_until_the_next_frame() {
    type Change = fn(&mut Renderer, &Scene, &View) -> Result<(), RenderError>;
    let changes: [(&str, Change); 4] = [
        ("size", |r, _, _| r.resize([32, 48])),
        ("lights", |r, scene, view| r.set_lights(scene, view)),
        ("scene", |r, scene, view| r.set_scene(scene, view)),
        ("settings", |r, _, _| r.set_settings(&settings(2000))),
    ];
    let backend = cpu();
    let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
    for (what, change) in changes {
        change(&mut renderer, &scene, &view).expect("a change");
        let refused = renderer.picture().expect_err("too early");
        assert!(
            refused.to_string().contains("call `frame` first"),
            "{what}: {refused}"
        );
        assert!(renderer.counters().is_err(), "{what}");
        renderer.frame().expect("a frame");
        renderer.picture().expect("a picture");
        renderer.counters().expect("counters");
    }
}

/// Every call that takes an executable refuses that of another.
#[test]
fn an_executable_belongs_to_its_gi() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let backend = cpu();
    let gi = |name: &str| {
        let (scene, view) = builtin::by_name(name).expect("built in");
        Gi::new(&scene, &view, SIZE, &settings(100), Screen::Traced).expect("a frame")
    };
    let (mut gi, other) = (gi("cornell"), gi("many-lights"));
    let mut exec = backend.prepare(other.schedule().clone()).expect("prepares");
    let exec = exec.as_mut();
    let host = HostGbuffer::perspective(0.1, None, true).expect("planes");
    let mut lit = view.clone();
    lit.environment = gibs::passes::scene::Environment::Constant(Vec3::ONE);
    let refused = [
        ("upload_scene", gi.upload_scene(exec)),
        ("begin_frame", gi.begin_frame(exec, &view.camera, None)),
        (
            "begin_frame",
            gi.begin_frame(exec, &view.camera, Some(&host)),
        ),
        ("irradiance", gi.irradiance(exec, &[], &[]).map(drop)),
        ("resize", gi.resize(exec, [10, 10], &view.camera)),
        (
            "set_settings",
            gi.set_settings(exec, &settings(200), &view.camera),
        ),
        ("set_lights", gi.set_lights(exec, &scene, &lit)),
        ("set_scene", gi.set_scene(exec, &scene, &view)),
        ("shift_origin", gi.shift_origin(exec, &scene, &view)),
        ("cut", gi.cut(exec, &scene, &view)),
        ("reset", gi.reset(exec)),
    ];
    for (call, result) in refused {
        assert!(
            matches!(result, Err(RenderError::Executable)),
            "{call}: {result:?}"
        );
    }
    assert_eq!(gi.size(), SIZE);
    // An executable that did not go through a change is left behind by it.
    let mut own = backend.prepare(gi.schedule().clone()).expect("prepares");
    let mut left_behind = backend.prepare(gi.schedule().clone()).expect("prepares");
    gi.upload_scene(own.as_mut()).expect("uploaded");
    gi.resize(own.as_mut(), [32, 32], &view.camera)
        .expect("resized");
    gi.begin_frame(own.as_mut(), &view.camera, None)
        .expect("begun");
    let result = gi.begin_frame(left_behind.as_mut(), &view.camera, None);
    assert!(matches!(result, Err(RenderError::Executable)), "{result:?}");
}

/// Geometry that changed is for another call, which the error names.
#[test]
fn lights_are_all_that_set_lights_changes() {
    let backend = cpu();
    let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
    let drawn = scene.nodes.iter().position(|node| !node.meshes.is_empty());
    let drawn = drawn.expect("something is drawn");
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut changed = scene.clone();
        change(&mut changed);
        changed
    };
    let cases = [
        ("meshes instead of", with_pane(&scene)),
        (
            "materials instead of",
            changed(&|s| s.materials.push(Material::default())),
        ),
        (
            "has other vertices or triangles",
            changed(&|s| s.meshes[0].triangles.truncate(1)),
        ),
        (
            "nodes that draw instead of",
            changed(&|s| s.nodes[drawn].meshes.clear()),
        ),
        (
            "draws other meshes",
            changed(&|s| s.nodes[drawn].meshes.push(0)),
        ),
        (
            "has moved",
            changed(&|s| {
                let up = glam::DAffine3::from_translation(DVec3::Y);
                s.nodes[drawn].local = gibs::passes::scene::LocalTransform::Affine(up);
            }),
        ),
    ];
    let before = states(&mut renderer);
    for (expected, scene) in cases {
        let error = renderer.set_lights(&scene, &view).expect_err(expected);
        let text = error.to_string();
        assert!(matches!(error, RenderError::Lights { .. }), "{text}");
        assert!(
            text.contains(expected) && text.contains("set_scene"),
            "{text}"
        );
    }
    assert!(states(&mut renderer) == before);
    renderer.frame().expect("a frame");
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
        assert_eq!(renderer.gi().size(), SIZE);
        assert!(states(&mut renderer) == before, "{}", backend.name());
        renderer.frame().expect("a frame");
        renderer.set_scene(&scene, &view).expect("the same scene");
    }
}

/// What the executable refuses to adopt changes nothing either. Every value is one that the library takes; the device
/// has less.
#[test]
fn after_a_limit_of_the_device_the_frame_goes_on() {
    const LARGEST: [u32; 2] = [8192, 8192];
    for backend in all_backends() {
        let (scene, view, mut renderer) = box_with_surfels(backend.as_ref());
        let gi = Gi::new(&scene, &view, LARGEST, &settings(4000), Screen::Traced).expect("valid");
        let device = &backend.device().name;
        if backend.capabilities().check(device, gi.schedule()).is_ok() {
            // The processor has no limits; of devices, lavapipe's binding of 128 MiB is far too small.
            eprintln!("{} takes {LARGEST:?}", backend.name());
            continue;
        }
        let schedule = renderer.gi().schedule().clone();
        let before = states(&mut renderer);
        let refused = renderer
            .resize(LARGEST)
            .expect_err("more than the device has");
        assert!(
            matches!(refused, RenderError::Backend(BackendError::Limit { .. })),
            "{}: {refused}",
            backend.name()
        );
        assert_eq!(renderer.gi().size(), SIZE);
        assert!(Arc::ptr_eq(&schedule, renderer.gi().schedule()));
        assert!(states(&mut renderer) == before, "{}", backend.name());
        renderer.picture().expect("the picture is still there");
        renderer.frame().expect("a frame");
    }
}

/// An executable that never adopts anything.
struct Refusing(Box<dyn Executable>);

impl Executable for Refusing {
    fn schedule(&self) -> &Arc<Schedule> {
        self.0.schedule()
    }
    fn upload(&mut self, id: ResourceId, at: u64, bytes: &[u8]) -> Result<(), BackendError> {
        self.0.upload(id, at, bytes)
    }
    fn run(&mut self) -> Result<(), BackendError> {
        self.0.run()
    }
    fn rotate(&mut self) -> Result<(), BackendError> {
        self.0.rotate()
    }
    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        self.0.run_step(step)
    }
    fn read(&mut self, id: ResourceId) -> Result<Vec<u8>, BackendError> {
        self.0.read(id)
    }
    fn reset(&mut self) -> Result<(), BackendError> {
        self.0.reset()
    }
    fn wait(&mut self) -> Result<(), BackendError> {
        self.0.wait()
    }
    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        Err(BackendError::Limit {
            what: schedule.name.clone(),
            need: 1,
            limit: 0,
            device: "nothing".into(),
            remedy: "give up".into(),
        })
    }
}

/// After every change that an executable refuses, the next frame is the one that would have come.
#[test]
fn a_change_that_is_refused_is_taken_back() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let color = |changes: bool| {
        let mut gi = Gi::new(&scene, &view, SIZE, &settings(4000), Screen::Traced).expect("valid");
        let prepared = cpu().prepare(gi.schedule().clone()).expect("prepares");
        let mut exec = Refusing(prepared);
        gi.upload_scene(&mut exec).expect("uploaded");
        let mut day = view.clone();
        day.environment = gibs::passes::scene::Environment::Constant(Vec3::ONE);
        for _ in 0..3 {
            if changes {
                let camera = &view.camera;
                let refused = [
                    gi.set_lights(&mut exec, &with_lamp(&scene), &day),
                    gi.set_scene(&mut exec, &with_pane(&scene), &day),
                    gi.resize(&mut exec, [32, 32], camera),
                    gi.set_settings(&mut exec, &settings(100), camera),
                ];
                for result in refused {
                    assert!(matches!(result, Err(RenderError::Backend(_))), "{result:?}");
                }
                assert!(gi.scene().lights.is_empty());
            }
            gi.begin_frame(&mut exec, &view.camera, None)
                .expect("begun");
            exec.run().expect("a frame");
        }
        let id = gi.schedule().output("color").expect("an output");
        exec.read(id).expect("readable")
    };
    assert!(color(true) == color(false));
}
