//! What views of surfels show.
use super::*;

/// Shares of all surfels sum to the budget, which the frame spends to the ray; each pixel shows a mean of some of them.
#[test]
fn ray_counts_sum_to_the_budget() {
    for budget in [0, 7, 20_000] {
        let mut settings = with_view(DebugView::RayCount);
        settings.rays = budget;
        let mut renderer = renderer(cpu().as_ref(), "atrium", &settings);
        for _ in 0..4 {
            renderer.frame().expect("renders");
        }
        let spent: DispatchArgs = buffer(&mut renderer, "ray_batch")[0];
        let counts: Vec<f32> = renderer.output("debug_surfels").expect("an output");
        let sum: f32 = counts.iter().filter(|n| **n > 0.0).sum();
        assert_eq!((sum, spent.count), (budget as f32, budget));
        let most = counts.iter().copied().fold(0.0, f32::max);
        let values = values(&mut renderer);
        // A weighted mean of numbers up to `most`, rounded once per surfel: 1e-4 is a thousand roundings.
        assert!(values.iter().all(|v| (-1.0..=most * 1.0001).contains(v)));
    }
}

/// Of a surfel that the grid does not limit, the radius is the wanted one; no radius is above it.
#[test]
fn radii_are_at_most_the_wanted_one() {
    let mut renderer = rendered(DebugView::Radius, 5);
    let wanted = with_view(DebugView::Radius).radius_in(SIZE);
    let values: Vec<f32> = values(&mut renderer)
        .into_iter()
        .filter(|v| *v >= 0.0)
        .collect();
    // The same product and quotient in two orders: a few roundings.
    let is_wanted = |v: f32| (v / wanted - 1.0).abs() < 1e-5;
    assert!(
        values
            .iter()
            .all(|&v| v > 0.0 && (v < wanted || is_wanted(v)))
    );
    assert!(values.iter().filter(|v| is_wanted(**v)).count() > values.len() / 2);
}

#[test]
fn variances_are_those_of_the_estimator() {
    let slots = slots(6);
    let mut renderer = rendered(DebugView::Variance, 6);
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let luminance = |c: Vec3| c.as_dvec3().dot(glam::DVec3::new(0.2126, 0.7152, 0.0722));
    let mut met = 0;
    for (value, slot) in values(&mut renderer).into_iter().zip(slots) {
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let state = &states[slot as usize];
        let level = luminance(state.mean).max(luminance(state.short_mean));
        let expected = match level > 0.0 {
            true => (f64::from(state.variance) / 4.0).sqrt() / level,
            false => 0.0,
        };
        // Half a dozen roundings to 24 bits.
        assert!(
            (f64::from(value) - expected).abs() <= 1e-6 * expected,
            "{value} for {expected}"
        );
        met += 1;
    }
    assert!(met > 2000, "{met}");
}

/// No surfel is older than the first frame; those of this frame are of age 0.
#[test]
fn surfels_age_by_a_frame_at_a_time() {
    for frames in [2, 9] {
        let values = values(&mut rendered(DebugView::Life, frames));
        let oldest = values.iter().copied().fold(0.0, f32::max);
        assert_eq!(oldest, frames as f32 - 1.0);
        assert!(values.iter().all(|v| *v == -1.0 || *v >= 0.0));
    }
}

/// The camera looks away for five frames: what it sees again has not been seen for six, this one included.
#[test]
fn frames_unseen_are_counted_until_seen_again() {
    let mut renderer = renderer(cpu().as_ref(), "cornell", &with_view(DebugView::Unseen));
    let (_, view) = builtin::by_name("cornell").expect("built in");
    for _ in 0..8 {
        renderer.frame().expect("renders");
    }
    assert!(values(&mut renderer).contains(&1.0));
    let mut away = view.camera;
    away.target = 2.0 * away.position - away.target;
    renderer.set_camera(away);
    for _ in 0..5 {
        renderer.frame().expect("renders");
    }
    renderer.set_camera(view.camera);
    renderer.frame().expect("renders");
    let values = values(&mut renderer);
    let shown = values.iter().filter(|v| **v >= 0.0).count();
    let six = values.iter().filter(|v| **v == 6.0).count();
    assert!(shown > 1000 && six * 10 > shown * 9, "{six} of {shown}");
}

/// What is drawn is the mean distance that a lookup at the pixel compares with, and some of it is nearer than the
/// diameter.
#[test]
fn depth_functions_are_looked_up_towards_the_pixel() {
    let slots = slots(12);
    let mut renderer = rendered(DebugView::DepthFunction, 12);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let depths: Vec<u32> = buffer(&mut renderer, "surfel_depths");
    let depths = Depths::new(&depths, Settings::default().depth_side);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let mut nearer = 0;
    for ((value, slot), point) in values(&mut renderer).into_iter().zip(slots).zip(&points) {
        // Where the nearest one has no ray yet, another one is drawn.
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let pose = &poses[slot as usize];
        let d = point.position - pose.position;
        let toward = match d.length() < 0.02 * pose.radius {
            true => pose.normal,
            false => d.normalize(),
        };
        let local = sampling::to_local(toward, pose.normal).max(Vec3::new(-1.0, -1.0, 0.0));
        let expected = depth::depth_moments(depths.get(slot as usize).expect("there"), local).x;
        assert!((value - expected).abs() < 1e-5, "{value} for {expected}");
        nearer += usize::from(value < 0.7);
    }
    assert!(nearer > 50, "{nearer}");
}

/// A pixel shows a texel of its surfel's guide, over the brightest one; at a centre, one of the four in the middle.
#[test]
fn guides_are_drawn_on_discs() {
    let slots = slots(12);
    let mut renderer = rendered(DebugView::Guide, 12);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let guides: Vec<u32> = buffer(&mut renderer, "surfel_guides");
    let guides = Guides::new(&guides, Settings::default().guide_side);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let (mut met, mut bright) = (0, 0);
    for ((value, slot), point) in values(&mut renderer).into_iter().zip(slots).zip(&points) {
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let pose = &poses[slot as usize];
        let guide = guides.get(slot as usize).expect("there");
        let has = |i: u32| guide.texel(i) as f32 / 255.0 == value;
        assert!(
            (0..guide.texels()).any(has),
            "{value} is no texel of surfel {slot}"
        );
        if (point.position - pose.position).length() < 0.1 * pose.radius {
            assert!(
                [14, 15, 20, 21].into_iter().any(has),
                "{value} in the middle"
            );
            met += 1;
        }
        bright += usize::from(value == 1.0);
    }
    assert!(met > 20 && bright > 20, "{met}, {bright}");
}
