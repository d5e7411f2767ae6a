// Rounding to 16-bit floats, to the nearest and of two the even one. Stores into 16-bit images may round as the device
// likes; what is rounded before is kept by all.

fn half_float_one(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    let magnitude = bits & 0x7fffffffu;
    // Below 2^-14 halves lie 2^-24 apart.
    if magnitude < 0x38800000u {
        return round(x * 16777216.0) / 16777216.0;
    }
    // From 65520 on the nearest is infinity, which stays, as what is not a number does.
    if magnitude >= 0x477ff000u {
        return bitcast<f32>((bits & 0x80000000u) | max(0x7f800000u, magnitude));
    }
    return bitcast<f32>((bits + 0xfffu + ((bits >> 13u) & 1u)) & 0xffffe000u);
}

/// Each component as the nearest 16-bit float.
fn half_float_rounded(v: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(half_float_one(v.x), half_float_one(v.y), half_float_one(v.z), half_float_one(v.w));
}
