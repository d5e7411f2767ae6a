//! The element types of the frame's edges. Lengths are metres relative to the floating origin.
mod host;
mod scene;
mod surfels;

pub use crate::accel::{BvhNode, Hit, Instance, NONE, Ray, Triangle, WideNode, WidePacket};
use gibs_graph::{element, element_layout};
use glam::{Vec3, Vec4};
pub use host::{HostGbuffer, HostGbufferError};
pub use scene::{Corners, Emitter, Light, Material, Transform};
pub use surfels::{
    ClampedLight, Drift, GridShape, Neighbours, SurfelBirth, SurfelCounters, SurfelIrradiance,
    SurfelLight, SurfelPose, SurfelSettings,
};

element_layout!(BvhNode {
    min: Vec3,
    first: u32,
    max: Vec3,
    count: u32
});
element_layout!(Triangle {
    v0: Vec3,
    primitive: u32,
    e1: Vec3,
    material_flags: u32,
    e2: Vec3,
    transform_id: u32,
});
element_layout!(Instance {
    world_to_object: [Vec4; 3],
    object_to_world: [Vec4; 3],
    root: u32,
    first_triangle: u32,
    transform_id: u32,
    flags: u32,
});
element_layout!(Ray {
    origin: Vec3,
    t_min: f32,
    direction: Vec3,
    t_max: f32
});
element_layout!(Hit {
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    instance: u32
});
element_layout!(WideNode {
    planes: [[f32; 8]; 6],
    children: [u32; 8],
    sources: [u32; 8]
});
element_layout!(WidePacket {
    v0: [[f32; 8]; 3],
    e1: [[f32; 8]; 3],
    e2: [[f32; 8]; 3],
    first: u32,
    count: u32,
    alpha: u32,
    padding: [u32; 5],
});

element! {
    /// The camera, in the floating origin's frame.
    pub struct Camera {
        /// Eye.
        eye: Vec3,
        /// Width of the picture in pixels.
        width: u32,
        /// Right, as long as half the picture's width at distance one.
        right: Vec3,
        /// Height of the picture in pixels.
        height: u32,
        /// Up, as long as half the picture's height at distance one.
        up: Vec3,
        /// Angle that a pixel in the middle subtends, radians.
        pixel_angle: f32,
        /// Unit vector along the viewing axis.
        forward: Vec3,
        /// Zero.
        pad: u32,
    }

    /// What changes every frame.
    pub struct Frame {
        /// Frame number, wrapping.
        number: u32,
        /// Seed of the run.
        seed: u32,
        /// Number of lights.
        lights: u32,
        /// Lights that are sampled at each point.
        lights_per_point: u32,
        /// Side of the octahedral environment map, in texels.
        environment_side: u32,
        /// 1 where emitter sampling covers the sky.
        sky_sampled: u32,
        /// Sum over all sampled emitters of area times luminance, W/sr.
        emitter_power: f32,
        /// Samples per pixel of a reference.
        samples: u32,
    }

    /// A point on a surface: what a ray or a pixel sees.
    pub struct SurfacePoint {
        /// Position.
        position: Vec3,
        /// Distance by which rays start off the surface, along the geometric normal.
        offset: f32,
        /// Packed geometric normal, facing the viewer.
        geometric_normal: u32,
        /// Packed interpolated normal, facing the viewer.
        shading_normal: u32,
        /// Red and green of the albedo, 16 bits each.
        albedo_rg: u32,
        /// Blue of the albedo in the low 16 bits; flags above, see `shared::surface`.
        albedo_b_flags: u32,
        /// Emitted radiance towards the viewer, W/(m^2 sr).
        emission: Vec3,
        /// Node that the surface moves with; `u32::MAX` where the ray missed.
        transform_id: u32,
    }

    /// One light chosen for a point: what it adds if nothing stands between.
    pub struct LightSample {
        /// Irradiance divided by the probability of the choice, W/m^2.
        irradiance: Vec3,
        /// Zero.
        pad: u32,
    }

    /// What the surfels around a point say.
    pub struct Gathered {
        /// Sum of weight times irradiance, divided by the summed weight where that is above one, W/m^2.
        irradiance: Vec3,
        /// Summed weight, at most one.
        weight: f32,
        /// Average irradiance of the cell, with normal and depth weights only, W/m^2.
        average: Vec3,
        /// How far to trust the irradiance as the light of further bounces, 0 to 1: weighted mean of
        /// `lookup::trust` over the surfels.
        confidence: f32,
    }

    /// What a debug view shows at a pixel.
    pub struct DebugPixel {
        /// In the unit of the view, never negative; -1 where there is nothing to show.
        value: f32,
        /// Brightness of the colour that stands for the value in a picture, 0 to 1.
        shade: f32,
    }

    /// A path from a surfel: the ray with the same index is its next segment.
    pub struct Path {
        /// Product of albedos, over the probabilities of going on.
        throughput: Vec3,
        /// Index of the surfel's ray that it began with.
        root: u32,
        /// State of its random numbers.
        seed: u32,
        /// Surfel that it began at.
        surfel: u32,
        /// Cosine of the segment's ray with the normal where it begins.
        cosine: f32,
        /// Density of the ray over the lobe there, 1/sr; negative where the ray was sent to an emitter.
        density: f32,
    }

    /// A pixel of the reference: its path, and the sum of the finished ones.
    pub struct ReferencePath {
        /// Turns irradiance at the path's vertex into irradiance at the pixel.
        scale: Vec3,
        /// Segments that the path has, this one included; zero for none.
        segment: u32,
        /// Irradiance that the path has found so far, W/m^2.
        sample: Vec3,
        /// State of its random numbers.
        seed: u32,
        /// Sum of the finished samples, W/m^2.
        sum: Vec3,
        /// Finished samples.
        done: u32,
        /// Sum of the squared luminances of the finished samples.
        sum_squared: f32,
        /// Largest luminance of a finished sample.
        largest: f32,
        /// Segments traced, of all paths.
        segments: u32,
        /// Zero.
        pad: u32,
    }
}
