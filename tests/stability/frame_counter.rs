//! The frame number passes 2^32, after two years at 60 frames a second. Ages are its differences.
use super::build::room;
use super::common::all_backends;
use super::measure::{
    FRAMES, Noise, SIZE, U, assert_same_light, go_on, levels, mean, relative, settings,
};
use super::pictures;
use gibs::passes::data::{SurfelBirth, SurfelIrradiance, SurfelPose};
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};
use std::f64::consts::PI;

fn state<T: bytemuck::Pod>(renderer: &mut Renderer, key: &str) -> Vec<T> {
    let exec = renderer.executable();
    let id = exec.schedule().resource(key).expect("a state");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

/// A run that starts half its frames before the number wraps has the light of one that starts at 0, but for chance, [`Noise`]:
/// other numbers draw other rays. No surfel's age or time since its mean began is more than the frames that have run.
#[test]
fn light_goes_on_past_the_last_frame_number() {
    let noise = Noise::of_room();
    let (scene, view) = room();
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings(), 0).expect("prepares");
        let early = go_on(&mut renderer, FRAMES, name);
        renderer.start_at(u32::MAX - FRAMES / 2).expect("resets");
        let late = go_on(&mut renderer, FRAMES, name);
        let number = renderer.gi().frames();
        assert!(number < FRAMES, "{name}: the number has wrapped: {number}");
        assert_same_light(&early, &late, &noise, &format!("{name}: past 2^32 frames"));
        let poses: Vec<SurfelPose> = state(&mut renderer, "surfel_poses");
        let births: Vec<SurfelBirth> = state(&mut renderer, "surfel_births");
        let kept: Vec<SurfelIrradiance> = state(&mut renderer, "surfel_irradiance");
        let mut ages = (0, 0);
        for i in (0..poses.len()).filter(|&i| poses[i].radius > 0.0) {
            let age = |frame: u32| number.wrapping_sub(frame);
            assert!(age(births[i].frame) <= FRAMES, "{name}: {:?}", births[i]);
            let known = kept[i].samples == 0 || age(kept[i].since) <= FRAMES;
            assert!(known, "{name}: {:?}", kept[i]);
            match births[i].frame > FRAMES {
                true => ages.0 += 1,
                false => ages.1 += 1,
            }
        }
        println!(
            "{name}: {} surfels from before the wrap, {} from after it",
            ages.0, ages.1
        );
        assert!(
            ages.0 > 0 && ages.1 > 0,
            "{name}: born on both sides of the wrap"
        );
        pictures::errors("frame-counter", name, &early, &relative(&early, &late), 0.5);
    }
}

/// In a furnace of albedo 0 there is no chance: E is `pi e` in every frame around the wrap, within the roundings of
/// `white_walls`.
#[test]
fn no_frame_around_the_wrap_shows_it() {
    let settings = Settings {
        emitters: false,
        ..settings()
    };
    let (scene, view) = builtin::furnace(0.0, 1.0);
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings, 0).expect("prepares");
        renderer.start_at(u32::MAX - 20).expect("resets");
        go_on(&mut renderer, 16, name);
        let mut worst = 0f64;
        for _ in 0..10 {
            let picture = go_on(&mut renderer, 1, name);
            let off = mean(&levels(&picture, "E")) / PI - 1.0;
            worst = worst.max(off.abs());
        }
        let bound = 2.0 * (26.0 + 1024.0) * U;
        println!("{name}: E around the wrap is off by {worst:.2e} (bound {bound:.2e})");
        assert!(worst <= bound, "{name}: {worst}");
    }
}
