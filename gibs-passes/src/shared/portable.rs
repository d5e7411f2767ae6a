//! Elementary functions from `+ - * /` and bit casts alone, so that every backend computes the same bits.

/// Sine and cosine of `2 pi turns`, for `turns` in `[0, 1]`. Absolute error below 4e-7.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let quarters = (4.0 * turns + 0.5).floor();
    let a = (4.0 * turns - quarters) * std::f32::consts::FRAC_PI_2;
    let a2 = a * a;
    let sin = a * (1.0 + a2 * (-0.166_666_67 + a2 * (0.008_333_333 + a2 * -0.000_198_412_7)));
    let cos =
        1.0 + a2 * (-0.5 + a2 * (0.041_666_668 + a2 * (-0.001_388_888_9 + a2 * 0.000_024_801_588)));
    match quarters as u32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Binary logarithm of a positive normal number. Absolute error below 1e-6 for results below 8.
#[inline]
pub fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let mut exponent = (bits >> 23) as f32 - 127.0;
    let mut mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    if mantissa > std::f32::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let series = 1.0 + t2 * (0.333_333_34 + t2 * (0.2 + t2 * (0.142_857_15 + t2 * 0.111_111_11)));
    // 2 / ln 2, from ln m = 2 artanh t.
    exponent + (2.885_39 * t) * series
}

#[cfg(test)]
mod tests {
    #[test]
    fn sine_and_cosine_stay_within_their_bound() {
        for i in 0..=100_000 {
            let turns = i as f32 / 100_000.0;
            let (sin, cos) = super::sin_cos_turns(turns);
            let angle = f64::from(turns) * std::f64::consts::TAU;
            assert!(
                (f64::from(sin) - angle.sin()).abs() < 4e-7,
                "sin of {turns} turns"
            );
            assert!(
                (f64::from(cos) - angle.cos()).abs() < 4e-7,
                "cos of {turns} turns"
            );
        }
    }

    #[test]
    fn logarithm_stays_within_its_bound() {
        for i in 1..200_000 {
            let x = i as f32 * 0.001;
            assert!(
                (f64::from(super::log2(x)) - f64::from(x).log2()).abs()
                    < 1e-6 * (1.0 + f64::from(x).log2().abs())
            );
        }
    }
}
