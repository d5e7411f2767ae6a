// 64-bit integers as a high and a low word, for products of 32-bit numbers.

/// `a * b`: the high word in `x`, the low word in `y`. Exact.
fn wide_integer_multiply(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    // Neither sum can overflow: 0xffff * 0xffff + 2 * 0xffff is the largest 32-bit number.
    let first = a_high * b_low + (low >> 16u);
    let second = a_low * b_high + (first & 0xffffu);
    let high = a_high * b_high + (first >> 16u) + (second >> 16u);
    return vec2<u32>(high, (second << 16u) | (low & 0xffffu));
}

/// `floor(n / c)` of a 64-bit number, for `n.x < c`, so that the result fits 32 bits. Long division, bit by bit.
fn wide_integer_divide(n: vec2<u32>, c: u32) -> u32 {
    if n.x == 0u {
        return n.y / c;
    }
    var rest = n.x;
    var low = n.y;
    var quotient = 0u;
    for (var i = 0u; i < 32u; i++) {
        // The rest is below `c`, so that doubled it may take 33 bits; the difference fits 32 again.
        let carry = rest >> 31u;
        rest = (rest << 1u) | (low >> 31u);
        low = low << 1u;
        quotient = quotient << 1u;
        if carry != 0u || rest >= c {
            rest -= c;
            quotient |= 1u;
        }
    }
    return quotient;
}

/// `floor((a * b + phase) / c)` without overflow, for `a <= c` and `phase < c`; 0 for `c = 0`.
fn wide_integer_share(a: u32, b: u32, phase: u32, c: u32) -> u32 {
    if c == 0u {
        return 0u;
    }
    if a == c {
        return b;
    }
    let product = wide_integer_multiply(a, b);
    let low = product.y + phase;
    let carry = select(0u, 1u, low < phase);
    return wide_integer_divide(vec2<u32>(product.x + carry, low), c);
}
