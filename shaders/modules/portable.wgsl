// Elementary functions from `+ - * /` and bit casts alone, so that every device that rounds those correctly and fuses
// nothing computes the same bits. Vulkan and WebGPU promise neither; Mesa's software driver does both.

/// Sine and cosine of `2 pi turns`, for `turns` in `[0, 1]`. Absolute error below 4e-7.
fn portable_sin_cos_turns(turns: f32) -> vec2<f32> {
    let quarters = floor(4.0 * turns + 0.5);
    let a = (4.0 * turns - quarters) * 1.5707964;
    let a2 = a * a;
    let s = a * (1.0 + a2 * (-0.16666667 + a2 * (0.008333333 + a2 * -0.0001984127)));
    let c = 1.0 + a2 * (-0.5 + a2 * (0.041666668 + a2 * (-0.0013888889 + a2 * 0.000024801588)));
    switch u32(quarters) & 3u {
        case 0u: { return vec2<f32>(s, c); }
        case 1u: { return vec2<f32>(c, -s); }
        case 2u: { return vec2<f32>(-s, -c); }
        default: { return vec2<f32>(-c, s); }
    }
}

/// Binary logarithm of a positive normal number. Absolute error below 1e-6 for results below 8.
fn portable_log2(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    var exponent = f32(bits >> 23u) - 127.0;
    var mantissa = bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
    if mantissa > 1.4142135 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let series = 1.0 + t2 * (0.33333334 + t2 * (0.2 + t2 * (0.14285715 + t2 * 0.11111111)));
    // 2 / ln 2, from ln m = 2 artanh t.
    return exponent + (2.88539 * t) * series;
}
