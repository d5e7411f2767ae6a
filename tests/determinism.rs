//! The same inputs give the same bits, run to run, on any one backend.
mod common;

use common::{all_backends, render, settings};
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};
use gibs_backend_cpu::{CpuBackend, Options};

#[test]
fn two_runs_give_the_same_bits() {
    let scene = builtin::by_name("window-room").expect("built in");
    let settings = settings(8_000);
    for (backend, settings) in all_backends()
        .iter()
        .flat_map(|backend| [settings.clone(), pressed(8_000)].map(|settings| (backend, settings)))
    {
        let first = render(backend.as_ref(), &scene, [80, 45], 12, &settings, 7);
        let second = render(backend.as_ref(), &scene, [80, 45], 12, &settings, 7);
        assert!(first == second, "{}: two runs differ", backend.name());
        let other = render(backend.as_ref(), &scene, [80, 45], 12, &settings, 8);
        assert!(
            first != other,
            "{}: another seed gives the same picture",
            backend.name()
        );
    }
}

/// Frames after those that warm a renderer up are those of a new one.
#[test]
fn what_was_warmed_up_starts_from_nothing() {
    let (scene, view) = builtin::by_name("window-room").expect("built in");
    for backend in all_backends() {
        let pictures = [false, true].map(|warm| {
            let (backend, settings) = (backend.as_ref(), settings(8_000));
            let made = Renderer::new(backend, &scene, &view, [80, 45], &settings, 7);
            let mut renderer = made.expect("the frame compiles");
            if warm {
                renderer.warm_up().expect("frames run");
            }
            let mut frame = || {
                renderer.frame().expect("a frame runs");
                let counters = renderer.counters().expect("they are there");
                (renderer.picture().expect("a picture"), counters)
            };
            [frame(), frame(), frame()]
        });
        let [new, warm] = pictures;
        assert!(new == warm, "{}: it remembers", backend.name());
    }
}

/// Neither the number of threads nor the order of workgroups nor the width of the traversal shows; and in the
/// checking mode no two workgroups of any stage write one element.
#[test]
fn threads_and_order_do_not_show() {
    only_the_settings_show(&settings(4_000));
}

/// So it is where slots are short, rays are sorted, surfels are born at hits and lists do not fit.
#[test]
fn threads_and_order_do_not_show_under_pressure() {
    only_the_settings_show(&pressed(4_000));
}

/// Slots are short, rays are sorted, surfels are born at hits and lists do not fit.
fn pressed(rays: u32) -> Settings {
    Settings {
        surfels: 200,
        sorting: true,
        hit_births: 64,
        grid_lists: 2,
        ..settings(rays)
    }
}

/// The pressure is there: with more room, another settings would be tested.
#[test]
fn pressure_is_there() {
    let (scene, view) = builtin::by_name("window-room").expect("built in");
    let backend = common::cpu();
    let mut renderer = Renderer::new(
        backend.as_ref(),
        &scene,
        &view,
        [48, 27],
        &pressed(4_000),
        3,
    )
    .expect("a renderer");
    for _ in 0..6 {
        renderer.frame().expect("a frame");
    }
    let counters = renderer.counters().expect("counters");
    assert!(
        counters.starved > 0 && counters.overflow > 0,
        "{counters:?}"
    );
}

fn only_the_settings_show(settings: &Settings) {
    let scene = builtin::by_name("window-room").expect("built in");
    let with = |options: Options| {
        let backend = CpuBackend::new(options).expect("threads start");
        render(&backend, &scene, [48, 27], 6, settings, 3)
    };
    let one = with(Options {
        threads: Some(1),
        ..Options::default()
    });
    assert!(
        one == with(Options {
            threads: Some(3),
            ..Options::default()
        }),
        "the number of threads shows"
    );
    assert!(
        one == with(Options {
            scalar: true,
            ..Options::default()
        }),
        "the wide traversal shows"
    );
    assert!(
        one == with(Options {
            checked: true,
            ..Options::default()
        }),
        "the order of workgroups shows"
    );
}

/// Sorted rays are the same rays, and what they bring goes to the same surfels.
#[test]
fn sorting_changes_no_bit() {
    let scene = builtin::by_name("window-room").expect("built in");
    let backend = common::cpu();
    let [sorted, unsorted] = [true, false].map(|sorting| {
        let settings = Settings {
            sorting,
            ..settings(4_000)
        };
        render(backend.as_ref(), &scene, [48, 27], 6, &settings, 3)
    });
    assert!(sorted == unsorted);
}
