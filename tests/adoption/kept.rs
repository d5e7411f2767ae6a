//! Changes that keep every bit of every state.
use crate::common::{all_backends, settings};
use crate::harness::{SIZE, box_with_surfels, live, states, with_lamp, with_pane};
use gibs::passes::scene::Scene;
use gibs::view::View;
use gibs::{RenderError, Renderer};
use glam::Vec3;

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

/// A larger one: of a smaller one surfels grow, and those that are too many go in time.
#[test]
fn another_budget_of_rays_keeps_every_surfel() {
    keeps_every_bit("a budget", |renderer, _, _| {
        renderer.set_settings(&settings(16_000))
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
