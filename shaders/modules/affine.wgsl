// Affine maps given by three rows; `w` is the translation.
import package::vector::vector_dot;

/// A map applied to a point.
fn affine_map_point(rows: array<vec4<f32>, 3>, p: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        vector_dot(rows[0].xyz, p) + rows[0].w,
        vector_dot(rows[1].xyz, p) + rows[1].w,
        vector_dot(rows[2].xyz, p) + rows[2].w,
    );
}

/// The linear part of a map applied to a vector.
fn affine_map_vector(rows: array<vec4<f32>, 3>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(vector_dot(rows[0].xyz, v), vector_dot(rows[1].xyz, v), vector_dot(rows[2].xyz, v));
}

/// The transpose of the linear part applied to a vector. With the inverse map's rows, this maps normals.
fn affine_map_transposed(rows: array<vec4<f32>, 3>, v: vec3<f32>) -> vec3<f32> {
    return rows[0].xyz * v.x + rows[1].xyz * v.y + rows[2].xyz * v.z;
}
