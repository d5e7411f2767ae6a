//! Which changes need another schedule, what they leave to see, and which executable they go with.
use crate::common::{all_backends, cpu, settings};
use crate::harness::{SIZE, box_with_surfels, with_lamp};
use gibs::passes::data::HostGbuffer;
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::Scene;
use gibs::view::View;
use gibs::{Gi, RenderError, Renderer, builtin};
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;

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
