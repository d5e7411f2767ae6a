//! Room for surfels and lists.
use super::*;

/// With 16 slots for hundreds of births the stack runs empty; the rest is counted, and the picture stays finite.
#[test]
fn births_without_a_slot_are_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let settings = Settings {
            surfels: 16,
            ..settings(1_000)
        };
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [96, 96], &settings, 0)
            .expect("prepares");
        for _ in 0..6 {
            renderer.frame().expect("renders");
        }
        let counters = renderer.counters().expect("reads");
        assert_eq!(counters.live, 16, "{}", backend.name());
        assert!(counters.starved > 0, "{}", backend.name());
        let picture = renderer.picture().expect("a picture");
        assert!(
            picture.channels.values().flatten().all(|x| x.is_finite()),
            "{}",
            backend.name()
        );
    }
}

/// A surfel overlaps several cells; with room for one entry each, whole lists are dropped, the loss is counted, and
/// the bits are the same on every run.
#[test]
fn a_full_grid_is_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let settings = Settings {
            surfels: 64,
            grid_lists: 1,
            ..settings(1_000)
        };
        let run = || {
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [96, 96], &settings, 0)
                    .expect("prepares");
            for _ in 0..8 {
                renderer.frame().expect("renders");
            }
            (
                renderer.counters().expect("reads"),
                renderer.picture().expect("a picture"),
            )
        };
        let (counters, picture) = run();
        assert!(
            counters.overflow > 0,
            "{}: nothing overflowed",
            backend.name()
        );
        assert!(
            picture.channels.values().flatten().all(|x| x.is_finite()),
            "{}",
            backend.name()
        );
        let again = run();
        assert!(
            again.0 == counters && again.1 == picture,
            "{}: two runs differ",
            backend.name()
        );
    }
}

/// Without surfels the picture is direct light and what the lamp shows; births are counted as starved, and none happens.
/// Going back to some finds the frame as it was.
#[test]
fn no_surfels_is_direct_light_only() {
    let (scene, view) = builtin::by_name("atrium").expect("built in");
    for backend in all_backends() {
        for half_resolution in [true, false] {
            let none = Settings {
                surfels: 0,
                check_slots: true,
                guiding: true,
                half_resolution,
                hit_births: 16,
                ..settings(1_000)
            };
            let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [48, 32], &none, 0)
                .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
            for _ in 0..3 {
                renderer.frame().expect("renders");
            }
            let counters = renderer.counters().expect("reads");
            let name = backend.name();
            assert_eq!((counters.live, counters.born), (0, 0), "{name}");
            assert!(counters.starved > 0, "{name}");
            assert_eq!(
                (counters.rays, counters.slot_errors),
                (0, Some(0)),
                "{name}"
            );
            let picture = renderer.picture().expect("a picture");
            let irradiance = picture.rgb("E").expect("E");
            assert!(
                irradiance.iter().all(|c| c.iter().all(|x| *x == 0.0)),
                "{name}"
            );
            assert!(mean(&picture, "direct") > 0.1, "{name}: the sun shines");
            assert!(is_finite(&mut renderer), "{name}");
            let some = Settings {
                surfels: 256,
                ..none.clone()
            };
            for settings in [&some, &none] {
                renderer.set_settings(settings).expect("other settings");
                for _ in 0..2 {
                    renderer.frame().expect("renders");
                }
                let counters = renderer.counters().expect("reads");
                assert_eq!(
                    counters.live > 0,
                    settings.surfels > 0,
                    "{name}: {counters:?}"
                );
                assert_eq!(counters.slot_errors, Some(0), "{name}");
            }
        }
    }
}

/// What a surfel of capacity takes from frame to frame, with everything switched on: the budget of 256 bytes, where depth functions
/// and guides have the default sizes, and as many more as wider ones have texels. While a frame runs, there are lists of the grid,
/// and what stages hand on; a grid of fixed size and what belongs to rays do not grow with the capacity.
#[test]
fn a_surfel_takes_at_most_256_bytes_and_160_within_a_frame() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let states = |surfels: u32, guiding: bool, side: Option<u32>| -> (u64, u64) {
        let usual = Settings::default();
        let settings = Settings {
            surfels,
            guiding,
            depth_side: side.unwrap_or(usual.depth_side),
            guide_side: side.unwrap_or(usual.guide_side),
            rays: 1000,
            grid_side: 40,
            ..usual
        };
        let gi = Gi::new(&scene, &view, [64, 64], &settings, Screen::Traced).expect("compiles");
        let schedule = gi.schedule();
        let kept = schedule.resources.iter().filter(|r| r.kind.persists());
        let kept = kept.map(|r| r.bytes * r.kind.allocations()).sum();
        (kept, schedule.bytes(false))
    };
    // Inputs persist as well, but do not grow with the capacity.
    let wide = 256 + (8 * 8 - 4 * 4) * 4 + (8 * 8 - 6 * 6);
    for (guiding, side, expected) in [(true, None, 256), (false, None, 216), (true, Some(8), wide)]
    {
        const MORE: u64 = 65_536;
        let (few, many) = (
            states(65_536, guiding, side),
            states(131_072, guiding, side),
        );
        let kept = (many.0 - few.0) / MORE;
        assert_eq!(kept, expected, "guiding {guiding}");
        let within_a_frame = (many.1 - few.1) / MORE - kept;
        assert_eq!(within_a_frame, 160, "guiding {guiding}");
    }
}
