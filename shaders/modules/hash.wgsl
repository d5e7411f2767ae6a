// Integer hashes: the only source of randomness.

/// PCG output function as a hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
fn hash_pcg(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// Hash of two numbers; the order matters.
fn hash_hash2(a: u32, b: u32) -> u32 {
    return hash_pcg(a + hash_pcg(b));
}

/// Hash of three numbers; the order matters.
fn hash_hash3(a: u32, b: u32, c: u32) -> u32 {
    return hash_hash2(a, hash_hash2(b, c));
}

/// The largest number below one.
const HASH_ALMOST_ONE: f32 = 1.0 - 1.0 / 16777216.0;

/// The upper 24 bits as a number in `[0, 1)`.
fn hash_unit(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}
