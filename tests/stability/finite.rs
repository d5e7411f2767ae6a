//! Every channel of every picture is finite: `measure::draw` and `measure::go_on` hold all cases to that. Here are the debug
//! views, whose values are ratios of what may be zero.
use super::build::{Build, room};
use super::common::all_backends;
use super::measure::{go_on, settings};
use gibs::Renderer;
use gibs::passes::frame::{DebugView, Settings};
use gibs::passes::scene::{LightKind, Scene};
use gibs::view::View;
use glam::Vec3;

/// The brightest light that there may be, a nanometre above a floor that reaches from the eye to a thousand kilometres.
fn extreme() -> (Scene, View) {
    let mut scene = Build::new("extreme", [0.0, 1e-6, 0.0], [1.0, 0.0, 0.0], 1.5);
    let white = scene.paint(1.0, 0.0);
    scene.floor(white, [0.0; 3], 1e6);
    let lamp = scene.paint(0.0, 1e13);
    scene.cuboid(
        lamp,
        Vec3::new(2.0, 0.0, 0.0),
        Vec3::new(2.001, 1e-3, 1e-3),
        false,
    );
    scene.light(LightKind::Point, [1.0, 1e-9, 0.0], 1e13);
    scene.done()
}

/// No bound but finiteness: all numbers of a picture, and of each debug view, which are -1 or not negative.
#[test]
fn every_channel_of_every_view_is_finite() {
    for backend in all_backends() {
        let name = backend.name();
        for (what, (scene, view)) in [("the room", room()), ("the extremes", extreme())] {
            let on = Settings {
                guiding: true,
                clamp: true,
                hit_births: 64,
                ..settings()
            };
            let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [48, 27], &on, 0)
                .unwrap_or_else(|e| panic!("{name}: {what}: {e}"));
            go_on(&mut renderer, 8, &format!("{name}: {what}"));
            for &debug in DebugView::ALL {
                let debug = Some(debug);
                let settings = Settings {
                    debug,
                    ..on.clone()
                };
                renderer.set_settings(&settings).expect("other settings");
                let picture = go_on(&mut renderer, 1, &format!("{name}: {what}: {debug:?}"));
                let values = renderer.debug_picture().expect("a view");
                let sound = values.values().iter().all(|x| *x == -1.0 || *x >= 0.0);
                assert!(sound, "{name}: {what}: {debug:?}");
                assert!(picture.channels.len() > 20, "{name}: {what}");
            }
            println!(
                "{name}: {what}: {} views, every value finite",
                DebugView::ALL.len()
            );
        }
    }
}
