//! Light stays where it is: a sealed dark room beside a bright one.
mod common;

use common::{cpu, mean, settings};
use gibs::{Renderer, builtin};

/// Surfels fill the bright room first, then the camera moves into the dark one, so that bright surfels lie on the other
/// side of a wall 10 cm thick. At this size their radius, 8 pixels, is about 20 cm; a surfel several times as large as the
/// wall is thick does leak, which is why the test has a size.
#[test]
fn a_sealed_room_stays_dark() {
    let (scene, bright, dark) = builtin::sealed_rooms(builtin::SEALED_ROOMS_WALL);
    let backend = cpu();
    let mut renderer = Renderer::new(
        backend.as_ref(),
        &scene,
        &bright,
        [256, 144],
        &settings(50_000),
        0,
    )
    .expect("renders");
    for _ in 0..48 {
        renderer.frame().expect("renders");
    }
    let lit = mean(&renderer.picture().expect("a picture"), "E");
    renderer.set_camera(dark.camera);
    for _ in 0..48 {
        renderer.frame().expect("renders");
    }
    let unlit = mean(&renderer.picture().expect("a picture"), "E");
    println!(
        "bright room {lit:.4} W/m^2, sealed room {unlit:.6} W/m^2: {:.4} %",
        unlit / lit * 100.0
    );
    assert!(lit > 0.1, "the bright room is lit by {lit}");
    assert!(
        unlit <= 0.005 * lit,
        "the sealed room gets {unlit} of {lit}"
    );
}
