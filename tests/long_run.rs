//! Long runs: energy neither grows nor fades.
mod common;

use common::{cpu, mean, settings};
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};

/// Ten thousand frames of a closed white box of albedo 0.95, where every error of a bounce comes back nineteen times over.
/// Radiance comes from below, because walls that no pixel sees have no surfels and paths there end after 16 segments: it comes
/// to 90 % of the closed form e / (1 - a) at frame 1000, where 88 % are asked, and goes on rising; no frame is more than 2 % above.
#[test]
fn energy_does_not_grow_over_ten_thousand_frames() {
    let (scene, view) = builtin::furnace(0.95, 1.0);
    let closed_form = 1.0 / (1.0 - 0.95);
    let settings = Settings {
        surfels: 256,
        continuations: 16,
        sorting: false,
        half_resolution: false,
        ..settings(400)
    };
    let backend = cpu();
    let mut renderer =
        Renderer::new(backend.as_ref(), &scene, &view, [16, 16], &settings, 1).expect("prepares");
    let mut shares = Vec::new();
    for frame in 1..=10_000 {
        renderer.frame().expect("renders");
        if frame % 100 == 0 {
            let share = mean(&renderer.picture().expect("a picture"), "") / closed_form;
            assert!(share < 1.02, "frame {frame}: {share} of the closed form");
            assert!(
                frame < 1000 || share > 0.88,
                "frame {frame}: {share} of the closed form"
            );
            shares.push(share);
        }
    }
    println!("over the closed form, every 100 frames: {shares:.3?}");
}
