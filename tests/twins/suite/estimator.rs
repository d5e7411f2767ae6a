//! What surfels know of their light: the estimator, sharing and requests.
use super::declare::{DIVIDED, EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::{Vec2, Vec3};
use gibs_passes::data::{ClampedLight, Drift, Neighbours, SurfelIrradiance, SurfelLight};
use gibs_passes::shared::estimator::{self, Drifting};
use gibs_passes::shared::requests;
use gibs_passes::shared::sharing::{self, Said};

/// Counts of rays, those at which something changes among them.
fn samples(d: &mut Draw) -> u32 {
    match d.below(3) {
        0 => d.one_of(&[
            0, 1, 23, 24, 25, 63, 64, 65, 127, 128, 129, 255, 256, 511, 512, 131_071, 131_072,
        ]),
        1 => d.below(300),
        _ => d.below(131_073),
    }
}

/// The state of a surfel in a frame.
fn state(d: &mut Draw, frame: u32) -> SurfelIrradiance {
    let level = d.below(40) as i32 - 20;
    let samples = samples(d);
    let mean = d.light(level - 3, level + 3);
    let short_mean = match d.below(4) {
        0 => mean,
        1 => mean * d.between(0.8, 1.3),
        _ => d.light(level - 3, level + 3),
    };
    let age = match d.below(3) {
        0 => d.one_of(&[0, 1, 7, 8, 15, 16, 31, 32, 33, 127, 128, 129]),
        _ => d.bits() >> d.below(32),
    };
    let further = d.below(3) * d.below(1000);
    SurfelIrradiance {
        mean,
        samples,
        short_mean,
        since: frame.wrapping_sub(age),
        variance: d.number(2 * level - 10, 2 * level + 10).abs(),
        short_noise: d.number(2 * level - 20, 2 * level).abs(),
        drawn: (samples + further).min(131_071),
        pad: 0,
    }
}

/// A sample of a surfel, sometimes far brighter than what it knows.
fn sample(d: &mut Draw, state: &SurfelIrradiance) -> Vec3 {
    match d.below(4) {
        0 => Vec3::ZERO,
        1 => state.short_mean * d.between(0.0, 3.0),
        2 => state.short_mean * d.magnitude(0, 12),
        _ => d.light(-20, 20),
    }
}

fn drift(d: &mut Draw) -> Drift {
    let level = d.number(-20, 20).abs();
    let noise = match d.below(3) {
        0 => 0.0,
        _ => level * level * d.magnitude(-20, 2),
    };
    // About as many standard deviations as matter, on either side.
    let deviations = d.one_of(&[-6.0, -5.0, -3.0, -0.5, 0.0, 1.0, 3.0, 5.0]) + d.between(-0.5, 0.5);
    let sum = deviations * (noise + 0.0004 * level * level).sqrt();
    Drift {
        sum,
        noise,
        level,
        pad: 0,
    }
}

twin! {
    unless_faint ["estimator::estimator_unless_faint"], (sample: Vec3, faintest: f32) -> Vec3,
    wgsl "estimator_unless_faint(sample, faintest)",
    rust estimator::unless_faint(sample, faintest),
    draw |d| { let sample = d.light(-30, 10); (sample, d.one_of(&[0.0, 1e-6, 1.0])) },
    bound ROUNDED,
}
twin! {
    luminance ["estimator::estimator_luminance"], (c: Vec3) -> f32,
    wgsl "estimator_luminance(c)",
    rust estimator::luminance(c),
    draw |d| (d.light(-60, 60),),
    bound ROUNDED,
}
twin! {
    with_drift ["estimator::estimator_with_drift"], (drift: Drift, state: SurfelIrradiance) -> Drift,
    wgsl "estimator_with_drift(drift, state)",
    rust drift.with(&state),
    draw |d| (super::drift(d), super::state(d, 9)),
    bound ROUNDED,
}
twin! {
    plus_drift ["estimator::estimator_plus_drift"], (a: Drift, b: Drift) -> Drift,
    wgsl "estimator_plus_drift(a, b)",
    rust a.plus(&b),
    draw |d| (super::drift(d), super::drift(d)),
    bound EXACT,
}
twin! {
    relative_drift ["estimator::estimator_relative_drift"], (drift: Drift) -> f32,
    wgsl "estimator_relative_drift(drift)",
    rust drift.relative(),
    draw |d| (super::drift(d),),
    bound ROUNDED,
}
twin! {
    change ["estimator::estimator_change"], (drift: Drift) -> f32,
    wgsl "estimator_change(drift)",
    rust drift.change(),
    draw |d| (super::drift(d),),
    bound DIVIDED,
}
twin! {
    to_forget ["estimator::estimator_to_forget"], (cell: Drift, everywhere: Drift) -> Vec2,
    wgsl "estimator_to_forget(cell, everywhere)",
    rust estimator::to_forget(&cell, &everywhere),
    draw |d| (super::drift(d), super::drift(d)),
    bound ROUNDED,
}
twin! {
    forget ["estimator::estimator_forget"],
    (state: SurfelIrradiance, share: f32, change: f32, frame: u32) -> SurfelIrradiance,
    wgsl "estimator_forget(state, share, change, frame)",
    rust estimator::forget(&state, share, change, frame),
    draw |d| {
        let frame = d.word();
        let share = d.unit();
        (super::state(d, frame), d.one_of(&[0.0, 1.0, share, share]), d.number(-20, 3).abs(), frame)
    },
    bound ROUNDED,
}
twin! {
    clamped ["estimator::estimator_clamped"], (state: SurfelIrradiance, sample: Vec3, rays: u32) -> Vec3,
    wgsl "estimator_clamped(state, sample, rays)",
    rust estimator::clamped(&state, sample, rays),
    draw |d| { let s = super::state(d, 9); (s, super::sample(d, &s), 1 + d.below(64)) },
    bound ROUNDED,
}
twin! {
    taken ["estimator::estimator_taken"], (state: SurfelIrradiance, sample: Vec3, rays: u32) -> ClampedLight,
    wgsl "estimator_taken(state, sample, rays)",
    rust estimator::taken(&state, sample, rays),
    draw |d| { let s = super::state(d, 9); (s, super::sample(d, &s), 1 + d.below(64)) },
    bound ROUNDED,
}
twin! {
    update ["estimator::estimator_update"],
    (state: SurfelIrradiance, sample: Vec3, rays: u32, frame: u32, cut: u32) -> SurfelIrradiance,
    wgsl "estimator_update(state, sample, rays, frame, cut != 0u)",
    rust estimator::update(&state, sample, rays, frame, cut != 0),
    draw |d| {
        let frame = d.word();
        let s = super::state(d, frame);
        (s, super::sample(d, &s), 1 + d.below(64), frame, d.flag())
    },
    bound ROUNDED,
}

fn said(d: &mut Draw) -> Said {
    let trust = d.unit();
    let rays = d.number(-10, 20).abs();
    let variance = d.number(-10, 20).abs();
    let ray_variance = d.one_of(&[0.0, 1_048_576.0, f32::MIN_POSITIVE, variance, variance]);
    Said {
        mean: d.light(-20, 20),
        trust: d.one_of(&[0.0, 1.0, 1.0 / 255.0, trust, trust]),
        rays: d.one_of(&[rays, 1_048_576.0]),
        ray_variance,
    }
}
twin! {
    said_pack ["sharing::sharing_pack"], (mean: Vec3, trust: f32, rays: f32, ray_variance: f32) -> Neighbours,
    wgsl "sharing_pack(SharingSaid(mean, trust, rays, ray_variance))",
    rust Said { mean, trust, rays, ray_variance }.pack(),
    draw |d| { let s = super::said(d); (s.mean, s.trust, s.rays, s.ray_variance) },
    bound EXACT,
    uses ["sharing::SharingSaid"],
}
twin! {
    said_unpack ["sharing::sharing_unpack"], (packed: Neighbours) -> [f32; 6],
    wgsl "let s = sharing_unpack(packed);
        return array<f32, 6>(s.mean.x, s.mean.y, s.mean.z, s.trust, s.rays, s.ray_variance);",
    rust { let s = Said::unpack(&packed); [s.mean.x, s.mean.y, s.mean.z, s.trust, s.rays, s.ray_variance] },
    draw |d| { let s = super::said(d); (s.pack(),) },
    bound DIVIDED,
}
twin! {
    is_due ["sharing::sharing_is_due"], (surfel: u32, state: SurfelIrradiance, forget: f32, frame: u32) -> u32,
    wgsl "u32(sharing_is_due(surfel, state, forget, frame))",
    rust u32::from(sharing::is_due(surfel, &state, forget, frame)),
    draw |d| { let f = d.word(); (d.word(), super::state(d, f), d.one_of(&[0.0, 0.0, 0.0, 0.5]), f) },
    bound EXACT,
}
twin! {
    mean_variance ["sharing::sharing_mean_variance"], (state: SurfelIrradiance) -> f32,
    wgsl "sharing_mean_variance(state)",
    rust sharing::mean_variance(&state),
    draw |d| (super::state(d, 9),),
    bound DIVIDED,
}
twin! {
    asks ["sharing::sharing_asks"], (state: SurfelIrradiance) -> u32,
    wgsl "u32(sharing_asks(state))",
    rust u32::from(sharing::asks(&state)),
    // A third of the variances lie about the threshold.
    draw |d| {
        let mut s = super::state(d, 9);
        let level = estimator::luminance(s.mean);
        if d.once_in(3) {
            s.variance = d.around(0.015 * 0.015 * level * level * s.samples as f32).abs();
        }
        (s,)
    },
    bound ROUNDED,
}
twin! {
    light_said ["sharing::sharing_light"],
    (state: SurfelIrradiance, age: u32, mean: Vec3, trust: f32, rays: f32) -> SurfelLight,
    wgsl "sharing_light(state, age, SharingSaid(mean, trust, rays, 0.0))",
    rust sharing::light(&state, age, &Said { mean, trust, rays, ray_variance: 0.0 }),
    draw |d| {
        let (state, s) = (super::state(d, 9), super::said(d));
        (state, d.word(), s.mean, s.trust, s.rays.max(1.0))
    },
    bound ROUNDED,
    uses ["sharing::SharingSaid"],
}
twin! {
    request ["requests::requests_request"], (state: SurfelIrradiance, said: f32, unseen: u32, steered: u32) -> u32,
    wgsl "requests_request(state, said, unseen, steered != 0u)",
    rust requests::request(&state, said, unseen, steered != 0),
    draw |d| (super::state(d, 9), super::said(d).ray_variance, d.below(10), u32::from(!d.once_in(8))),
    bound ROUNDED,
}

twins!(
    unless_faint,
    luminance,
    with_drift,
    plus_drift,
    relative_drift,
    change,
    to_forget,
    forget,
    clamped,
    taken,
    update,
    said_pack,
    said_unpack,
    is_due,
    mean_variance,
    asks,
    light_said,
    request,
);
