//! A colour ramp for magnitudes.

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
    let last = INFERNO.len() - 1;
    let position = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * last as f32;
    let left = (position as usize).min(last - 1);
    let fraction = position - left as f32;
    std::array::from_fn(|c| {
        let [a, b] = [INFERNO[left][c], INFERNO[left + 1][c]].map(f32::from);
        (a + (b - a) * fraction).round() as u8
    })
}
