// Numbers of the debug views, and their pixels.
import package::types::DebugPixel;
import package::vector::{vector_dot, vector_length};

const DEBUG_VIEW_SURFELS: u32 = 1u;
const DEBUG_VIEW_COVERAGE: u32 = 2u;
const DEBUG_VIEW_RADIUS: u32 = 3u;
const DEBUG_VIEW_VARIANCE: u32 = 4u;
const DEBUG_VIEW_RAY_COUNT: u32 = 5u;
const DEBUG_VIEW_LIFE: u32 = 6u;
const DEBUG_VIEW_UNSEEN: u32 = 7u;
const DEBUG_VIEW_TRANSFORM_ID: u32 = 8u;
const DEBUG_VIEW_GRID: u32 = 9u;
const DEBUG_VIEW_CELL_HEAT: u32 = 10u;
const DEBUG_VIEW_DEPTH_FUNCTION: u32 = 11u;
const DEBUG_VIEW_GUIDE: u32 = 12u;

/// There is nothing to show.
fn debug_nothing() -> DebugPixel {
    return DebugPixel(-1.0, 0.0);
}

/// Brightness of a surface that is lit from the eye, so that shapes can be told in pictures of flat colours.
fn debug_headlight(to_eye: vec3<f32>, normal: vec3<f32>) -> f32 {
    let cosine = max(vector_dot(to_eye, normal), 0.0) / max(vector_length(to_eye), 1e-20);
    return 0.4 + 0.6 * cosine;
}
