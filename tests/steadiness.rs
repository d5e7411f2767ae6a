//! Light that nothing changes stands still, and light whose source went out is soon gone: with the same settings, in one run.
mod common;
#[path = "../examples/steadiness/measure.rs"]
mod measure;

use common::{cpu, settings};
use gibs::{Renderer, builtin};
use measure::Frames;

/// As many rays a pixel as 100 000 are in a picture of 480x270. The bounds are what a viewer may notice: a change of 2 %
/// from one frame to the next, a lamp that glows on for half a second.
#[test]
fn light_stands_still_and_goes_out() {
    // Of the box all light goes. The atrium keeps that of its sky, 40 %; a change is slower to show than an end.
    for (name, size, rays) in [("cornell", [96, 54], 4000), ("atrium", [240, 135], 25_000)] {
        let (scene, view) = builtin::by_name(name).expect("built in");
        let backend = cpu();
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, size, &settings(rays), 0)
            .expect("prepares");
        let phases = Frames {
            settle: 256,
            watch: 16,
            dark: 60,
            end: 100,
        };
        let found = measure::measure(&mut renderer, &scene, &view, phases).expect("renders");
        let ([mean, p99], [lit, dark]) = (found.flicker, found.means);
        assert!(lit > 0.0 && dark < 0.5 * lit, "{name}: {lit}, then {dark}");
        let gone = found.gone(0.05);
        println!(
            "{name}: flicker {mean:.5}, 99th percentile {p99:.4}; 95 % gone after {gone:?} frames"
        );
        assert!(mean < 0.005 && p99 < 0.02, "{name}: flicker {mean}, {p99}");
        assert!(gone.is_some_and(|gone| gone <= 30), "{name}: {gone:?}");
    }
}
