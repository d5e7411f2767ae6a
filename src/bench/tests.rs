use super::*;
use crate::compare::Metrics;
use equal::{Curve, Need, Point, rays, search};
use gibs_passes::frame::{ELEMENTS, Settings};

#[test]
fn every_element_is_switched_once() {
    let settings = Settings::default();
    let all = configurations(&settings, &Configuration::elements());
    assert_eq!(all.len(), ELEMENTS.len() + 3);
    assert_eq!(all[0].name, "defaults");
    for (element, configuration) in ELEMENTS.iter().zip(&all[1..]) {
        let own = &configuration.settings;
        assert_ne!(element.is_on(own), element.is_on(&settings), "{element:?}");
        let back = element.switched(own, element.is_on(&settings));
        assert_eq!(back, settings, "{element:?} changes something else");
        let word = if element.is_on(own) {
            "with"
        } else {
            "without"
        };
        assert_eq!(configuration.name, format!("{word} {}", element.name));
    }
    let rays: Vec<u32> = all[ELEMENTS.len() + 1..]
        .iter()
        .map(|c| c.settings.rays)
        .collect();
    assert_eq!(rays, [25_000, 400_000]);
    let info = Settings::all().into_iter().find(|info| info.name == "rays");
    let most = info.expect("a setting").most as u32;
    for (rays, name) in [
        (most / 4, Some("4 x the rays")),
        (most / 2, Some("the most rays")),
        (most, None),
    ] {
        let settings = Settings {
            rays,
            ..Settings::default()
        };
        let all = configurations(&settings, &[]);
        assert_eq!(all.get(2).map(|c| c.name.as_str()), name);
        for configuration in all {
            configuration.settings.check().expect("within the range");
        }
    }
}

#[test]
fn powers_of_two_are_measured_on_the_way() {
    assert_eq!(checkpoints(&[1]), [(1, true)]);
    assert_eq!(
        checkpoints(&[12, 4]),
        [(1, false), (2, false), (4, true), (8, false), (12, true)]
    );
}

#[test]
fn means_and_spreads_are_those_of_the_values() {
    let one = Mean::of([3.0].into_iter());
    assert_eq!(
        (one.mean, one.standard_error, one.interval),
        (3.0, None, None)
    );
    // Variance 8/3, of four values.
    let four = Mean::of([1.0, 5.0, 3.0, 3.0].into_iter());
    assert_eq!(four.mean, 3.0);
    let error = four.standard_error.expect("of four");
    assert!((error - (8.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
    // Student's t of three degrees of freedom.
    let interval = four.interval.expect("of four");
    assert!((interval / error - 3.182).abs() < 1e-3);
    assert_eq!(four.ends(), [3.0 - interval, 3.0 + interval]);
    let spread = Spread::of((0..=10).rev().map(f64::from));
    assert_eq!((spread.low, spread.median, spread.high), (1.0, 5.0, 9.0));
    let two = Spread::of([4.0, 2.0].into_iter());
    assert_eq!((two.low, two.median, two.high), (2.2, 3.0, 3.8));
    assert!(Spread::of([].into_iter()).median.is_nan());
}

/// Metrics with this MAPE, and its square as relMSE.
fn metrics(mape: f64) -> Metrics {
    Metrics {
        rel_mse: mape * mape,
        rmse: 0.0,
        mape,
        bias: 0.0,
        p99: 0.0,
        block_error: 0.0,
        blocks: 1,
        flip: 0.0,
    }
}

/// Searches where the MAPE is `law` of the samples and a sample takes a millisecond; returns what was found and rendered.
fn searched(law: impl Fn(f64) -> f64, goal: f64, limit: f64) -> (Need, Vec<u32>) {
    let mut rendered = Vec::new();
    let mut curve = Curve::default();
    let need = search(
        &mut curve,
        |m| m.mape,
        0.5,
        goal,
        limit,
        |samples| {
            rendered.push(samples);
            let point = Point {
                samples,
                errors: metrics(law(f64::from(samples))),
                rays: f64::from(samples) * 3.0,
            };
            Ok::<_, ()>((point, f64::from(samples) * 1e-3))
        },
    );
    (need.expect("nothing fails"), rendered)
}

#[test]
fn the_samples_for_an_error_are_found_and_rendered_nearby() {
    let root = |samples: f64| 2.0 / samples.sqrt();
    let floor = |samples: f64| (4.0 / samples + 1e-4).sqrt();
    let heavy = |samples: f64| 2.0 / samples.powf(0.3);
    for (law, goal, samples) in [
        (&root as &dyn Fn(f64) -> f64, 0.02, 1e4),
        (&root, 0.5, 16.0),
        (&floor, 0.02, 4.0 / 3e-4),
        (&heavy, 0.2, 10f64.powf(1.0 / 0.3)),
    ] {
        let (need, rendered) = searched(law, goal, 1e6);
        assert!(need.reached, "{need:?}");
        assert!(
            (need.samples / samples - 1.0).abs() < 0.02,
            "{need:?}, not {samples}"
        );
        let near = |n: &u32| (law(f64::from(*n)) / goal - 1.0).abs() < 0.06;
        assert!(rendered.iter().any(near), "{rendered:?} for {samples}");
        assert!(rendered.len() <= 10, "{rendered:?}");
    }
    // One sample is enough, and where it is better than sought by more than the search minds, fewer would be.
    for (goal, fewer) in [(3.0, true), (2.0, false)] {
        let (need, _) = searched(root, goal, 1.0);
        assert_eq!((need.samples, need.fewer), (1.0, fewer), "{need:?}");
    }
}

#[test]
fn a_search_that_takes_too_long_says_how_far_it_came() {
    // Of a thousand samples a second, twenty seconds: far from the million that it takes.
    let (need, rendered) = searched(|n| 2.0 / n.sqrt(), 0.002, 20.0);
    assert!(
        !need.reached && (18_000.0..=20_000.0).contains(&need.samples),
        "{need:?}"
    );
    assert_eq!(rendered.last().map(|n| f64::from(*n)), Some(need.samples));
    // An error that never falls.
    let (need, _) = searched(|_| 1.0, 0.5, 2.0);
    assert!(!need.reached && need.samples <= 2000.0, "{need:?}");
}

/// Rays of the truth's pixels stand for those of all pixels; each seed is held against its own time; what was not reached or not needed is
/// counted.
#[test]
fn what_is_needed_is_of_whole_pictures_and_over_seeds() {
    let need = |samples, reached, fewer| Need {
        samples,
        reached,
        fewer,
    };
    // Ten samples of three rays per sample and pixel for 100 pixels, each of which stands for 25.
    assert_eq!(rays(&need(10.0, true, false), 300.0, 5), 75_000.0);
    assert_eq!(rays(&need(10.0, true, false), 300.0, 1), 3_000.0);
    let seed = |seconds: f64, need: Need, sought: f64| {
        let budget = Budget {
            frames: 16,
            asked: true,
            rays: 1e6,
            seconds,
        };
        vec![Needed::of(&budget, ("mape", sought), need, 4e6, 1e-6)]
    };
    let all = over_seeds(
        "path tracing",
        &[
            seed(2.0, need(8.0, true, false), 0.1),
            seed(1.0, need(16.0, false, false), 0.3),
            seed(0.5, need(1.0, true, true), 0.2),
        ],
    );
    let [found] = all.as_slice() else {
        panic!("{all:?}");
    };
    assert_eq!((found.frames, found.metric), (16, "mape"));
    assert_eq!((found.unreached, found.fewer), (1, 1));
    assert!(found.error.interval.is_some(), "it was measured");
    for bound in [found.samples, found.rays, found.seconds, found.times] {
        assert_eq!((bound.interval, bound.standard_error), (None, None));
    }
    assert!((found.error.mean - 0.2).abs() < 1e-12);
    assert!((found.samples.mean - 25.0 / 3.0).abs() < 1e-12);
    assert_eq!((found.rays.mean, found.seconds.mean), (4e6, 4.0));
    // 4 s over 2, 1 and 0.5 s.
    assert!((found.times.mean - 14.0 / 3.0).abs() < 1e-12);
    assert!(over_seeds("path tracing", &[]).is_empty());
}

#[test]
fn the_front_is_what_nothing_is_better_than() {
    let after = |seconds: f64, mape: f64| After {
        frames: 1,
        asked: true,
        errors: Errors::of([metrics(mape)].into_iter()),
        mape_ratio: Mean::of([1.0].into_iter()),
        rays: 1.0,
        total_rays: 1.0,
        milliseconds: 1.0,
        seconds: Mean::of([seconds].into_iter()),
        ratio: Spread::of([1.0].into_iter()),
        taken: None,
        pareto: false,
    };
    let row = |after: Vec<After>| Row {
        name: "any".into(),
        about: String::new(),
        kind: Kind::Settings,
        after,
    };
    let mut rows = [
        row(vec![after(1.0, 0.5), after(4.0, 0.1), after(9.0, f64::NAN)]),
        row(vec![after(2.0, 0.5), after(3.0, 0.3), after(4.0, 0.2)]),
        row(vec![after(5.0, 0.1), after(8.0, 0.05), after(8.0, 0.05)]),
    ];
    pareto::mark(&mut rows);
    let marked = rows.each_ref().map(|row| {
        let after = row.after.iter();
        after.map(|after| after.pareto).collect::<Vec<_>>()
    });
    assert_eq!(marked[0], [true, true, false]);
    assert_eq!(
        marked[1],
        [false, true, false],
        "no less error, or no less time"
    );
    assert_eq!(marked[2], [false, true, true], "equals");
}
