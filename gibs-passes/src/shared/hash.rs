//! Integer hashes: the only source of randomness. Inputs are stable identities, never slots.

/// PCG output function as a hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
#[inline]
pub fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Hash of two numbers; the order matters.
#[inline]
pub fn hash2(a: u32, b: u32) -> u32 {
    pcg(a.wrapping_add(pcg(b)))
}

/// Hash of three numbers; the order matters.
#[inline]
pub fn hash3(a: u32, b: u32, c: u32) -> u32 {
    hash2(a, hash2(b, c))
}

/// The largest number below one.
pub const ALMOST_ONE: f32 = 1.0 - 1.0 / 16_777_216.0;

/// The upper 24 bits as a number in `[0, 1)`.
#[inline]
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}
