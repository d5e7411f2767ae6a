// Products of vectors with their operations in a fixed order, which the built-in functions leave to the device.

/// Sum of products, from x to z.
fn vector_dot(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

/// Cross product.
fn vector_cross(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// Euclidean length.
fn vector_length(v: vec3<f32>) -> f32 {
    return sqrt(vector_dot(v, v));
}

/// A vector times the reciprocal of its length.
fn vector_normalize(v: vec3<f32>) -> vec3<f32> {
    return v * (1.0 / vector_length(v));
}

/// The largest component.
fn vector_max_element(v: vec3<f32>) -> f32 {
    return max(max(v.x, v.y), v.z);
}

/// A vector times the power of two that brings its largest component to between 1 and 2: its direction to the same digits, of a
/// length whose square is a number.
fn vector_leveled(v: vec3<f32>) -> vec3<f32> {
    let exponent = min(bitcast<u32>(vector_max_element(abs(v))) >> 23u, 253u);
    return v * bitcast<f32>((254u - exponent) << 23u);
}
