//! Colour ramps for magnitudes, and colours for names.
use super::color::linear_to_srgb;

/// Nine even samples of the "inferno" map of Smith and van der Walt (matplotlib, CC0), as sRGB code
/// values. Its lightness rises evenly from black, so that it reads in grey and to colour-blind
/// people.
const INFERNO: [[u8; 3]; 9] = [
    [0, 0, 4],
    [33, 12, 74],
    [87, 16, 110],
    [138, 34, 106],
    [188, 55, 84],
    [228, 90, 49],
    [249, 142, 9],
    [249, 203, 53],
    [252, 255, 164],
];

/// The sRGB colour of `t` in 0..1 (clamped; NaN counts as 0): black through purple and orange to
/// pale yellow.
pub fn inferno(t: f32) -> [u8; 3] {
    along(&INFERNO, t)
}

/// Nine even samples of the "cool to warm" map of Moreland 2009 ("Diverging Color Maps for Scientific Visualization"),
/// from sRGB (59, 76, 192) over (221, 221, 221) to (180, 4, 38), interpolated in his Msh space, as sRGB code values.
const COOL_WARM: [[u8; 3]; 9] = [
    [59, 76, 192],
    [98, 130, 234],
    [141, 176, 254],
    [184, 208, 249],
    [221, 221, 221],
    [245, 196, 173],
    [244, 154, 123],
    [222, 97, 76],
    [180, 4, 38],
];

/// The sRGB colour of `t` in 0..1 (clamped; NaN counts as 0): blue, grey at 0.5, red. Lightness rises to the middle and
/// falls beyond, so that both sides of it are told apart.
pub fn cool_warm(t: f32) -> [u8; 3] {
    along(&COOL_WARM, t)
}

/// An sRGB colour for a name: its hue by golden ratio steps, so that names in a row differ most, and three lightnesses, all
/// in Oklab (Ottosson 2020), which keeps any two hues about equally bright.
pub fn name_color(name: u32) -> [u8; 3] {
    let turns = f64::from(name) * 0.618_033_988_749_894_9;
    let hue = turns.fract() * std::f64::consts::TAU;
    let lightness = [0.74, 0.62, 0.86][(turns as u64 % 3) as usize];
    let (a, b) = (0.11 * hue.cos(), 0.11 * hue.sin());
    let cubed = |x: f64| x * x * x;
    let l = cubed(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cubed(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cubed(lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    linear.map(|c| (linear_to_srgb(c as f32) * 255.0).round() as u8)
}

fn along(ramp: &[[u8; 3]; 9], t: f32) -> [u8; 3] {
    let last = ramp.len() - 1;
    let position = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * last as f32;
    let left = (position as usize).min(last - 1);
    let fraction = position - left as f32;
    std::array::from_fn(|c| {
        let [a, b] = [ramp[left][c], ramp[left + 1][c]].map(f32::from);
        (a + (b - a) * fraction).round() as u8
    })
}
