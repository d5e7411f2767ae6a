//! An origin that moves takes the surfels with it.
use crate::common::{all_backends, mean};
use crate::harness::{box_with_surfels, state, states};
use gibs::graph::Executable;
use gibs::passes::data::{SurfelBirth, SurfelPose};
use gibs::passes::shared::mark;
use glam::{DVec3, Vec3};

/// How many surfels live on in their slots; each of them is where it was in the world.
fn followed(
    exec: &mut dyn Executable,
    poses: &[SurfelPose],
    births: &[SurfelBirth],
    shift: Vec3,
) -> u32 {
    let moved: Vec<SurfelPose> = state(exec, "surfel_poses");
    let after: Vec<SurfelBirth> = state(exec, "surfel_births");
    let mut followed = 0;
    for slot in 0..poses.len() {
        let same = mark::identity(moved[slot].mark) == mark::identity(poses[slot].mark);
        if !same || poses[slot].radius <= 0.0 {
            continue;
        }
        assert_eq!(births[slot].position, after[slot].position);
        let off = moved[slot].position + shift - poses[slot].position;
        // A coordinate of up to 128 m is rounded to 2^-18 m twice.
        assert!(off.abs().max_element() < 1e-5, "{off} of slot {slot}");
        followed += 1;
    }
    followed
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
        let followed = followed(renderer.executable(), &poses, &births, shift);
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

        let followed = followed(renderer.executable(), &poses, &births, shift);
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
