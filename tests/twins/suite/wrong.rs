//! Twins that are not: what the comparison must find.
use super::declare::{EXACT, ROUNDED};

// Off by the last place for one input in about a hundred.
twin! {
    last_place [], (a: f32, b: f32) -> f32,
    wgsl "a + b",
    rust { let sum = a + b; if sum.to_bits() % 100 == 7 { sum.next_up() } else { sum } },
    draw |d| (d.number(-20, 20), d.number(-20, 20)),
    bound ROUNDED,
}
// Differs at a threshold alone: on one side a number from 1 on is large, on the other one above 1.
twin! {
    threshold [], (x: f32) -> u32,
    wgsl "u32(x >= 1.0)",
    rust u32::from(x > 1.0),
    draw |d| (d.around(1.0),),
    bound EXACT,
}
// Not a number, where the other side has one.
twin! {
    no_number [], (x: f32) -> f32,
    wgsl "bitcast<f32>(select(0x7fc00000u, 0x3f800000u, x > -0.5))",
    rust if x > 0.5 { 1.0 } else { f32::NAN },
    draw |d| (d.around(1.0),),
    bound EXACT,
}

twins!(last_place, threshold, no_number);
