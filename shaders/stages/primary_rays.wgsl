// Starts a ray at the eye through each pixel's centre. Blended surfaces are invisible to it.
import package::invocation::invocation_index;
import package::types::{Camera, F32_MAX, Ray};
import package::vector::vector_normalize;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read_write> rays: array<Ray>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(workgroup, groups, 64u, lane);
    if i >= camera.width * camera.height {
        return;
    }
    let x = f32(i % camera.width) + 0.5;
    let y = f32(i / camera.width) + 0.5;
    let across = x / f32(camera.width) * 2.0 - 1.0;
    let upwards = 1.0 - y / f32(camera.height) * 2.0;
    let direction = vector_normalize(camera.forward + camera.right * across + camera.up * upwards);
    rays[i] = Ray(camera.eye, -0.0, direction, F32_MAX);
}
