//! Numbers: the operations that everything is made of, elementary functions, hashes, half floats, wide integers, places in a
//! dispatch.
use super::declare::{DIVIDED, EXACT, ROOT, ROUNDED, Truth, Twin};
use gibs_graph::glam::{UVec2, UVec3, Vec2, Vec4};
use gibs_graph::{DispatchArgs, Rgba16Float, Stored};
use gibs_passes::shared::{batch, hash, portable};
use gibs_passes::stages::allocate_rays;
use std::f64::consts::FRAC_PI_2;

// What a device does with the operations themselves decides which bounds it is held to.
twin! {
    multiply_add [], (a: f32, b: f32, c: f32) -> f32,
    wgsl "a * b + c",
    rust a * b + c,
    draw |d| (d.number(-20, 20), d.number(-20, 20), d.number(-20, 20)),
    bound ROUNDED,
}
twin! {
    divide [], (a: f32, b: f32) -> f32,
    wgsl "a / b",
    rust a / b,
    draw |d| (d.number(-60, 60), d.signed(-60, 60)),
    bound DIVIDED,
}
twin! {
    square_root [], (a: f32) -> f32,
    wgsl "sqrt(a)",
    rust a.sqrt(),
    draw |d| (d.magnitude(-126, 128),),
    bound ROOT,
}
twin! {
    subnormal [], (a: f32, b: f32) -> f32,
    wgsl "a * b",
    rust a * b,
    draw |d| (d.number(-100, -40), d.number(-60, -30)),
    bound ROUNDED,
}

/// The angle within its quarter is exact in `f64`, so that the zeros of the truth are zeros.
fn sin_cos_of_turns(words: &[u32]) -> Vec<f64> {
    let turns = 4.0 * f64::from(f32::from_bits(words[0]));
    let quarters = turns.round();
    let (sin, cos) = ((turns - quarters) * FRAC_PI_2).sin_cos();
    match quarters as u32 & 3 {
        0 => vec![sin, cos],
        1 => vec![cos, -sin],
        2 => vec![-sin, -cos],
        _ => vec![-cos, sin],
    }
}
twin! {
    sin_cos_turns ["portable::portable_sin_cos_turns"], (turns: f32) -> Vec2,
    wgsl "portable_sin_cos_turns(turns)",
    rust { let (sin, cos) = portable::sin_cos_turns(turns); Vec2::new(sin, cos) },
    // Evenly over the circle, and then what lies about its eighths.
    draw |d| {
        let even = d.case() as f32 / (1 << 19) as f32;
        let eighth = (0.125 * d.below(9) as f32).max(0.0);
        let edge = d.around(eighth).clamp(0.0, 1.0);
        let small = d.unit();
        (if even <= 1.0 { even } else { d.one_of(&[edge, small, eighth]) },)
    },
    bound ROUNDED,
    truth Truth {
        what: &["sine, 524288 even steps of the circle and about its eighths", "cosine, over the same"],
        of: sin_cos_of_turns,
        most: 7.0,
        reason: "the first term left out of the sine is a^9/9!, at a = pi/4 5.3 ULP; the rest is rounding",
    },
    cases 1 << 20,
}
twin! {
    log2 ["portable::portable_log2"], (x: f32) -> f32,
    wgsl "portable_log2(x)",
    rust portable::log2(x),
    // Every 32nd number from 1/2 to 2, all exponents, and what lies about 1 and the root of 2, where the mantissa is halved.
    draw |d| {
        let even = f32::from_bits(0x3f00_0000 + d.case() * 32);
        let root = d.around(std::f32::consts::SQRT_2).abs().max(f32::MIN_POSITIVE);
        let one = d.around(1.0).abs().max(f32::MIN_POSITIVE);
        let any = d.magnitude(-126, 128);
        (if even < 2.0 { even } else { d.one_of(&[root, one, any, f32::MAX, f32::MIN_POSITIVE]) },)
    },
    bound ROUNDED,
    truth Truth {
        what: &["binary logarithm, every 32nd float from 1/2 to 2, and all exponents"],
        of: |words| vec![f64::from(f32::from_bits(words[0])).log2()],
        most: 4.0,
        reason: "the first term left out is t^10/11 of the result, t at most 0.172: nothing; the rest is the rounding of six \
                 operations",
    },
    cases 1 << 20,
}

twin! {
    hash_pcg ["hash::hash_pcg"], (value: u32) -> u32,
    wgsl "hash_pcg(value)",
    rust hash::pcg(value),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    hash2 ["hash::hash_hash2"], (a: u32, b: u32) -> u32,
    wgsl "hash_hash2(a, b)",
    rust hash::hash2(a, b),
    draw |d| (d.word(), d.word()),
    bound EXACT,
}
twin! {
    hash3 ["hash::hash_hash3"], (a: u32, b: u32, c: u32) -> u32,
    wgsl "hash_hash3(a, b, c)",
    rust hash::hash3(a, b, c),
    draw |d| (d.word(), d.word(), d.word()),
    bound EXACT,
}
twin! {
    hash_unit ["hash::hash_unit"], (bits: u32) -> f32,
    wgsl "hash_unit(bits)",
    rust hash::unit(bits),
    draw |d| (d.word(),),
    bound EXACT,
}

twin! {
    half_one ["half_float::half_float_one"], (x: f32) -> f32,
    wgsl "half_float_one(x)",
    rust Rgba16Float::rounded(Vec4::splat(x)).x,
    // Halves and the middles between them, with their neighbours, on either side of the least normal half and of infinity.
    draw |d| {
        let middle = f32::from_bits((d.word() << 12) & 0x47ff_f000 | 0x3000_0000);
        let near = d.around(middle);
        let edge = d.one_of(&[65_504.0, 65_519.996, 65_520.0, 6.103_515_6e-5, 2.980_232_2e-8]);
        let about = d.around(edge);
        let any = d.float();
        (d.one_of(&[near, about, any]),)
    },
    bound DIVIDED,
}
twin! {
    half_rounded ["half_float::half_float_rounded"], (v: Vec4) -> Vec4,
    wgsl "half_float_rounded(v)",
    rust Rgba16Float::rounded(v),
    draw |d| (Vec4::new(d.float(), d.number(-30, 17), d.number(-16, -12), d.unit()),),
    bound DIVIDED,
}

twin! {
    wide_multiply ["wide_integer::wide_integer_multiply"], (a: u32, b: u32) -> UVec2,
    wgsl "wide_integer_multiply(a, b)",
    rust { let p = u64::from(a) * u64::from(b); UVec2::new((p >> 32) as u32, p as u32) },
    draw |d| (d.word(), d.word()),
    bound EXACT,
}
twin! {
    wide_divide ["wide_integer::wide_integer_divide"], (n: UVec2, c: u32) -> u32,
    wgsl "wide_integer_divide(n, c)",
    rust ((u64::from(n.x) << 32 | u64::from(n.y)) / u64::from(c)) as u32,
    draw |d| {
        let c = d.word().max(1);
        let high = d.one_of(&[0, c - 1, c / 2]);
        let drawn = d.below(c);
        (UVec2::new(d.one_of(&[high, drawn]), d.word()), c)
    },
    bound EXACT,
}
twin! {
    wide_share ["wide_integer::wide_integer_share"], (a: u32, b: u32, phase: u32, c: u32) -> u32,
    wgsl "wide_integer_share(a, b, phase, c)",
    rust allocate_rays::share(a, b, phase, c),
    draw |d| {
        let c = d.word();
        let below = d.below(c.max(1));
        let a = d.one_of(&[below, c, c.saturating_sub(1), 0]);
        let phase = d.below(c.max(1));
        (a, d.word(), d.one_of(&[phase, 0, c.saturating_sub(1)]), c)
    },
    bound EXACT,
}

/// Sizes of dispatches that fit 32 bits.
fn workgroup(id: UVec3, count: UVec3) -> gibs_graph::Workgroup {
    gibs_graph::Workgroup {
        id: id.to_array(),
        count: count.to_array(),
        size: [64, 1, 1],
    }
}
twin! {
    group_number ["invocation::invocation_group"], (id: UVec3, count: UVec3) -> u32,
    wgsl "invocation_group(id, count)",
    rust workgroup(id, count).linear(),
    draw |d| {
        let count = UVec3::new(1 + d.below(65_535), 1 + d.below(60), 1 + d.below(4));
        (UVec3::new(d.below(count.x), d.below(count.y), d.below(count.z)), count)
    },
    bound EXACT,
}
twin! {
    lane_number ["invocation::invocation_index"], (id: UVec3, count: UVec3, lane: u32) -> u32,
    wgsl "invocation_index(id, count, 64u, lane)",
    rust workgroup(id, count).range(u32::MAX).start as u32 + lane,
    draw |d| {
        let count = UVec3::new(1 + d.below(65_535), 1 + d.below(60), 1 + d.below(4));
        let id = UVec3::new(d.below(count.x), d.below(count.y), d.below(count.z));
        (id, count, d.below(64))
    },
    bound EXACT,
}

twin! {
    div_ceil ["batch::batch_div_ceil"], (a: u32, b: u32) -> u32,
    wgsl "batch_div_ceil(a, b)",
    rust a.div_ceil(b),
    draw |d| (d.word(), d.word().max(1)),
    bound EXACT,
}
twin! {
    dispatch_args ["batch::batch_args"], (count: u32) -> DispatchArgs,
    wgsl "batch_args(count)",
    rust batch::args(count),
    draw |d| {
        let row = (64 * 65_535 * (1 + d.below(1000))).wrapping_add(d.below(3)).wrapping_sub(1);
        let any = d.word();
        (d.one_of(&[row, any]),)
    },
    bound EXACT,
}

/// The operations themselves.
pub fn operations() -> Vec<Twin> {
    vec![
        multiply_add::twin(),
        divide::twin(),
        square_root::twin(),
        subnormal::twin(),
    ]
}

twins!(
    multiply_add,
    divide,
    square_root,
    subnormal,
    sin_cos_turns,
    log2,
    hash_pcg,
    hash2,
    hash3,
    hash_unit,
    half_one,
    half_rounded,
    wide_multiply,
    wide_divide,
    wide_share,
    group_number,
    lane_number,
    div_ceil,
    dispatch_args,
);
