// Two lengths in a word, eight bits of each mantissa.

/// One that is rounded up and one that is rounded down, neither negative.
fn lengths_pack(up: f32, down: f32) -> u32 {
    return ((bitcast<u32>(up) + 0xffffu) & 0xffff0000u) | (bitcast<u32>(down) >> 16u);
}

/// The one that was rounded up.
fn lengths_up(word: u32) -> f32 {
    return bitcast<f32>(word & 0xffff0000u);
}

/// The one that was rounded down.
fn lengths_down(word: u32) -> f32 {
    return bitcast<f32>(word << 16u);
}
