//! What surfels do in their first frames: they share at once, and shrink where their rays find walls.
mod common;

use common::{all_backends, settings};
use gibs::passes::data::{
    Camera, GridShape, SurfelBirth, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings,
};
use gibs::passes::frame::Settings;
use gibs::passes::shared::{depth, lengths, mark};
use gibs::passes::stages::positional_update::{LEARNS_FOR, LEARNS_UP_TO, SHRINKS_TO, radius_at};
use gibs::{Renderer, builtin};

fn left<T: bytemuck::Pod>(renderer: &mut Renderer, key: &str) -> Vec<T> {
    let exec = renderer.executable();
    let resource = exec.schedule().resource(key).expect("a resource");
    bytemuck::pod_collect_to_vec(&exec.read(resource).expect("read"))
}

/// After one frame, surfels that were born in it say what they all know, and without sharing what each one knows.
#[test]
fn surfels_that_are_born_together_share() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        for sharing in [true, false] {
            let settings = Settings {
                sharing,
                ..settings(8_000)
            };
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [64, 64], &settings, 0)
                    .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
            renderer.frame().expect("a frame");
            let own: Vec<SurfelIrradiance> = left(&mut renderer, "surfel_irradiance");
            let said: Vec<SurfelLight> = left(&mut renderer, "surfel_light");
            let with_rays = || own.iter().zip(&said).filter(|(own, _)| own.samples > 0);
            let changed = with_rays().filter(|(own, said)| own.mean != said.irradiance);
            let (live, changed) = (with_rays().count(), changed.count());
            println!(
                "{}: {changed} of {live} say more than they know",
                backend.name()
            );
            assert!(live > 50, "{live}");
            match sharing {
                // Each tile has one by then, and not all of them have a neighbour within reach.
                true => assert!(changed > live / 3, "{changed} of {live}"),
                false => assert_eq!(changed, 0),
            }
        }
    }
}

/// With a camera that stands still, a radius changes where a young surfel's depth function tells of walls, as the formula
/// says, and nowhere else.
#[test]
fn young_surfels_shrink_where_rays_find_walls() {
    let (scene, view) = builtin::by_name("atrium").expect("built in");
    let settings = settings(4_000);
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [96, 54], &settings, 0)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mut shrunk, mut old) = (0, 0);
        let (mut opened, mut hides) = (0, 0);
        renderer.frame().expect("a frame");
        for frame in 1..LEARNS_FOR + 8 {
            let before: Vec<SurfelPose> = left(&mut renderer, "surfel_poses");
            let births: Vec<SurfelBirth> = left(&mut renderer, "surfel_births");
            let depths: Vec<u32> = left(&mut renderer, "surfel_depths");
            renderer.frame().expect("a frame");
            let after: Vec<SurfelPose> = left(&mut renderer, "surfel_poses");
            let camera: Camera = left(&mut renderer, "camera")[0];
            let grid: GridShape = left(&mut renderer, "grid")[0];
            let on_device: SurfelSettings = left(&mut renderer, "settings")[0];
            for (i, (was, is)) in before.iter().zip(&after).enumerate() {
                if was.radius <= 0.0 || mark::identity(was.mark) != mark::identity(is.mark) {
                    // What is new has learned in this frame what hides, but has not looked at that yet.
                    assert!(
                        !mark::is_open(is.mark) || is.radius <= 0.0,
                        "{name}, surfel {i}"
                    );
                    continue;
                }
                let texels = depth::count(settings.depth_side);
                let texels = || depths[i * texels..][..texels].iter().copied();
                let crowded = depth::is_crowded(texels());
                if is.radius == was.radius {
                    let open = depth::is_open(texels());
                    assert_eq!(mark::is_open(is.mark), open, "{name}, surfel {i}");
                    (opened, hides) = (opened + u32::from(open), hides + u32::from(!open));
                }
                let had = lengths::down(births[i].lengths);
                let open = radius_at(is.position, had, &camera, &grid, &on_device);
                let grows = open > LEARNS_UP_TO * was.radius;
                let young = !grows && frame.wrapping_sub(births[i].frame) < LEARNS_FOR;
                let clearance = match crowded && young {
                    true => had.min(SHRINKS_TO * was.radius),
                    false => had,
                };
                let clearance = lengths::down(lengths::pack(0.0, clearance));
                let radius = radius_at(is.position, clearance, &camera, &grid, &on_device);
                assert!(
                    (is.radius / radius - 1.0).abs() < 1e-5,
                    "{name}, frame {frame}, surfel {i}: {} for {radius}",
                    is.radius
                );
                shrunk += u32::from(is.radius < 0.999 * was.radius);
                old += u32::from(crowded && !young);
            }
        }
        println!("{name}: {shrunk} times one shrank, {old} times one was too old to");
        assert!(shrunk > 50 && old > 0, "{name}: {shrunk}, {old}");
        assert!(opened > 50 && hides > 50, "{name}: {opened}, {hides}");
    }
}
