//! A change that is refused changes nothing.
use crate::common::{all_backends, cpu, settings};
use crate::harness::{SIZE, box_with_surfels, states, with_lamp, with_pane};
use gibs::graph::{BackendError, Executable, ResourceId, Schedule};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{Material, Scene};
use gibs::{Gi, RenderError, builtin};
use glam::{DVec3, Vec3};
use std::sync::Arc;

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
