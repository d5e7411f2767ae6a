//! The element types of the frame's edges. Lengths are metres relative to the floating origin.
pub use crate::accel::{BvhNode, Hit, Instance, NONE, Ray, Triangle, WideNode, WidePacket};
use gibs_graph::{element, element_layout};
use glam::{Vec2, Vec3, Vec4};

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

    /// Conventions of an engine's G-buffer, and what the engine wants back. The depth is `depth_offset + depth_scale /
    /// distance along the viewing axis`; normals are in the world's axes; albedo is linear; ids are those of scene nodes.
    pub struct HostGbuffer {
        /// See above.
        depth_scale: f32,
        /// See above.
        depth_offset: f32,
        /// Depth where nothing was drawn.
        depth_clear: f32,
        /// Distance between the values of a fixed-point depth buffer; 0 for floats.
        depth_step: f32,
        /// How far the picture was moved, pixels to the right and down.
        jitter: Vec2,
        /// Encoding of normals, see `shared::gbuffer`.
        normals: u32,
        /// 1 to get radiance, 0 to get irradiance.
        radiance: u32,
        /// Factor on what the engine gets.
        exposure: f32,
        /// Number of scene nodes, which `gibs::Gi` fills in: no surface has an id from here on.
        nodes: u32,
        /// Zero.
        pad1: u32,
        /// Zero.
        pad2: u32,
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

    /// The non-linear grid (GIBS, "Acceleration Structure"): a cube of uniform cells around the eye, and one
    /// trapezoidal grid along each of the six half-axes whose slices thicken with distance.
    pub struct GridShape {
        /// Centre of the cube.
        centre: Vec3,
        /// Half the side of the cube.
        half: f32,
        /// Cells along each side of the cube, and across each slice.
        side: u32,
        /// Slices per half-axis.
        slices: u32,
        /// Ratio of the distances of successive slices.
        growth: f32,
        /// `1 / log2(growth)`.
        per_octave: f32,
    }

    /// Settings of the surfels.
    pub struct SurfelSettings {
        /// Surfels that exist, live or free.
        capacity: u32,
        /// Rays per frame.
        ray_budget: u32,
        /// Target radius on screen, pixels.
        radius_pixels: f32,
        /// Summed weight at which spawning stops.
        coverage: f32,
        /// Most surfels that a lookup visits in a cell.
        lookup: u32,
        /// Blend of a depth sample into the depth function, per ray.
        depth_blend: f32,
        /// 1 where the firefly clamp of the estimator is on.
        clamp: u32,
        /// 1 where the variance of surfels decides about their rays.
        steered: u32,
        /// Pixels along each side of a texel of gap filling, 1 or 2.
        stride: u32,
        /// Most surfels that are proposed at hits in a frame, on average.
        hit_births: u32,
        /// Number of the debug view; 0 for none.
        debug: u32,
        /// 1 where new surfels take the geometric normal.
        geometric_normals: u32,
        /// Texels along each side of a depth function.
        depth_side: u32,
        /// 1 where the average of the cell makes up for what surfels do not cover.
        fallback: u32,
        /// Texels along each side of a guide.
        guide_side: u32,
        /// Padding.
        pad: u32,
    }

    /// Normals and texture coordinates of a triangle's vertices.
    pub struct Corners {
        /// Packed vertex normals, in the bottom level's space.
        normals: [u32; 3],
        /// 1 where there are vertex normals.
        smooth: u32,
        /// Texture coordinates.
        uvs: [Vec2; 3],
    }

    /// A Lambertian material.
    pub struct Material {
        /// Linear base colour factor.
        base_color: Vec3,
        /// Alpha factor, times one minus transmission.
        alpha: f32,
        /// Emitted radiance, W/(m^2 sr).
        emission: Vec3,
        /// See `shared::texture`: alpha mode, two-sidedness.
        flags: u32,
        /// Map of the texture coordinates to the base colour texture's u.
        base_u: Vec3,
        /// First word of the base colour texture; `u32::MAX` for none.
        base_texels: u32,
        /// Map of the texture coordinates to the base colour texture's v.
        base_v: Vec3,
        /// Width and, from bit 16, height of the base colour texture.
        base_size: u32,
        /// Map of the texture coordinates to the emission texture's u.
        emission_u: Vec3,
        /// First word of the emission texture; `u32::MAX` for none.
        emission_texels: u32,
        /// Map of the texture coordinates to the emission texture's v.
        emission_v: Vec3,
        /// Width and, from bit 16, height of the emission texture.
        emission_size: u32,
        /// Cut-out threshold.
        cutoff: f32,
        /// Sampler bits of the base colour texture.
        base_sampler: u32,
        /// Sampler bits of the emission texture.
        emission_sampler: u32,
        /// Zero.
        pad: u32,
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

    /// A light that is not a surface.
    pub struct Light {
        /// Position of a point or spot light.
        position: Vec3,
        /// 0 directional, 1 point, 2 spot.
        kind: u32,
        /// Radiant intensity, W/sr; irradiance, W/m^2, of a directional light.
        intensity: Vec3,
        /// Cosine of the outer half angle of a spot.
        cos_outer: f32,
        /// Direction in which it shines.
        direction: Vec3,
        /// Cosine of the inner half angle of a spot.
        cos_inner: f32,
    }

    /// An emissive triangle in the world.
    pub struct Emitter {
        /// First vertex.
        v0: Vec3,
        /// Probability that emitter sampling draws this one or one before it.
        cumulative: f32,
        /// Second vertex minus first.
        e1: Vec3,
        /// Bit 0: shines on both sides. Bit 1: its instance mirrors, so that the front is the clockwise side.
        flags: u32,
        /// Third vertex minus first.
        e2: Vec3,
        /// Zero.
        pad: u32,
        /// Emitted radiance, W/(m^2 sr).
        radiance: Vec3,
        /// Zero.
        pad1: u32,
    }

    /// One light chosen for a point: what it adds if nothing stands between.
    pub struct LightSample {
        /// Irradiance divided by the probability of the choice, W/m^2.
        irradiance: Vec3,
        /// Zero.
        pad: u32,
    }

    /// Affine map of a node to the world, and back.
    pub struct Transform {
        /// Rows of the map to the world.
        to_world: [Vec4; 3],
        /// Rows of the map from the world.
        to_local: [Vec4; 3],
    }

    /// A surfel where it is now (GIBS, "Surfel = Surface Element").
    pub struct SurfelPose {
        /// Position.
        position: Vec3,
        /// Radius; zero for a free slot.
        radius: f32,
        /// Unit geometric normal.
        normal: Vec3,
        /// Its identity, and whether lookups need its depth function, see [`mark`](crate::shared::mark).
        mark: u32,
    }

    /// A surfel as it was born: fixed to its node.
    pub struct SurfelBirth {
        /// Position in the node's space.
        position: Vec3,
        /// Node.
        transform_id: u32,
        /// Packed normal in the node's space.
        normal: u32,
        /// Frame of birth; an earlier one where the surfel has grown too fast to learn from its depth function.
        frame: u32,
        /// Distance by which rays start off the surface.
        offset: f32,
        /// Most radius that its surroundings leave it: the distance to the nearest surface that the picture showed at its birth,
        /// or half of the radius at which its rays found walls since. It never becomes larger. Metres.
        clearance: f32,
    }

    /// Irradiance of a surfel as the multiscale mean estimator holds it, W/m^2.
    pub struct SurfelIrradiance {
        /// Long mean.
        mean: Vec3,
        /// Rays that the long mean counts, at most `estimator::MOST_SAMPLES`.
        samples: u32,
        /// Short-term mean.
        short_mean: Vec3,
        /// Frame in which it began, or began anew.
        since: u32,
        /// Variance of the luminance that one ray brings, W^2/m^4.
        variance: f32,
        /// Variance of the short-term mean's luminance, W^2/m^4.
        short_noise: f32,
        /// Rays drawn so far, which number the sequence of directions; falls back by half at `estimator::MOST_SAMPLES`.
        drawn: u32,
        /// Zero.
        pad: u32,
    }

    /// What a surfel says to those who look it up: its irradiance, improved by its neighbours' while it is uncertain.
    pub struct SurfelLight {
        /// Irradiance, W/m^2.
        irradiance: Vec3,
        /// How far to trust it as the light of further bounces, in `(0, 1]`; 0 where neither it nor a neighbour has had a ray.
        trust: f32,
    }

    /// What a surfel and its neighbours say about its irradiance, see [`Said`](crate::shared::sharing::Said).
    pub struct Neighbours {
        /// Weighted mean of their irradiance, W/m^2.
        mean: Vec3,
        /// Trust, rays and the variance of a ray, packed; 0 where there are no neighbours.
        packed: u32,
    }

    /// How far the short means of surfels have left their long ones, as luminances.
    pub struct Drift {
        /// Sum of short means less long ones, W/m^2.
        sum: f32,
        /// Variance of that by chance, W^2/m^4.
        noise: f32,
        /// Sum of the larger of the two, W/m^2.
        level: f32,
        /// Zero.
        pad: u32,
    }

    /// What the firefly clamp took from rays.
    pub struct ClampedLight {
        /// Luminance of irradiance times rays that it took, W/m^2.
        taken: f32,
        /// Luminance of irradiance times rays that they brought, W/m^2.
        brought: f32,
        /// How many times it took some from a surfel.
        samples: u32,
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

    /// Slots of the surfel buffers that are in use, and what happened to them.
    pub struct SurfelCounters {
        /// Slots in use: free ones are on the stack from this index on, so that it grows at its end.
        live: u32,
        /// Surfels that found no free slot, since the start, wrapping.
        starved: u32,
        /// Surfels born since the start, wrapping.
        born: u32,
        /// Surfels that gave up their slots since the start, wrapping.
        recycled: u32,
    }
}

/// What cannot be said of an engine's G-buffer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HostGbufferError {
    /// There is no such near plane.
    #[error("the near plane is at {near} m; give a finite distance above zero")]
    Near {
        /// Its distance, metres.
        near: f64,
    },
    /// There is no such far plane.
    #[error(
        "the far plane is at {far} m and the near plane at {near} m; give a far plane beyond the near one, or `None` where there is none"
    )]
    Far {
        /// Distance of the near plane, metres.
        near: f64,
        /// Distance of the far plane, metres.
        far: f64,
    },
    /// A field has a value that means nothing.
    #[error("`{field}` of the G-buffer's description is {value}; it must be {expected}")]
    Field {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
}

impl HostGbuffer {
    /// Depths of a perspective projection onto `[0, 1]` with these planes, metres: `far` is `None` or infinite for one
    /// without end, `reversed` if near things have the larger depths. Plain normals, no jitter, irradiance at exposure 1.
    ///
    /// # Errors
    /// [`HostGbufferError`] for a near plane that is not at a finite distance above zero, and for a far plane that is
    /// not beyond it: planes are told apart by `f32` numbers in the end.
    pub fn perspective(
        near: f64,
        far: Option<f64>,
        reversed: bool,
    ) -> Result<Self, HostGbufferError> {
        // Below this, and above the other, the device's numbers are none.
        if !(near >= f64::from(f32::MIN_POSITIVE) && near <= f64::from(f32::MAX)) {
            return Err(HostGbufferError::Near { near });
        }
        let far = far.filter(|&far| far != f64::INFINITY);
        if let Some(far) = far.filter(|&far| far.is_nan() || far <= near) {
            return Err(HostGbufferError::Far { near, far });
        }
        let (scale, offset) = match (far, reversed) {
            (None, true) => (near, 0.0),
            (None, false) => (-near, 1.0),
            // Divided through by `far`, which may be large.
            (Some(far), true) => (near / (1.0 - near / far), -near / (far - near)),
            (Some(far), false) => (-near / (1.0 - near / far), far / (far - near)),
        };
        let host = Self {
            depth_scale: scale as f32,
            depth_offset: offset as f32,
            depth_clear: if reversed { 0.0 } else { 1.0 },
            exposure: 1.0,
            ..Self::default()
        };
        match (host.check(), far) {
            (Err(_), Some(far)) => Err(HostGbufferError::Far { near, far }),
            (checked, _) => checked.map(|()| host),
        }
    }

    /// Whether a frame can be read by this description: numbers that are finite, a depth that changes with distance, an
    /// encoding of normals that there is.
    ///
    /// # Errors
    /// [`HostGbufferError::Field`] names the field, its value and what would be right.
    pub fn check(&self) -> Result<(), HostGbufferError> {
        use crate::shared::gbuffer::{NORMALS_OCTAHEDRAL, NORMALS_SIGNED, NORMALS_UNSIGNED};
        let field = |field, value: String, expected| {
            Err(HostGbufferError::Field {
                field,
                value,
                expected,
            })
        };
        let scale = self.depth_scale;
        if !(scale.is_finite() && scale != 0.0) {
            let expected = "finite and not zero; `HostGbuffer::perspective` makes it of the planes";
            return field("depth_scale", scale.to_string(), expected);
        }
        for (name, value) in [
            ("depth_offset", self.depth_offset),
            ("depth_clear", self.depth_clear),
            ("jitter.x", self.jitter.x),
            ("jitter.y", self.jitter.y),
        ] {
            if !value.is_finite() {
                return field(name, value.to_string(), "finite");
            }
        }
        for (name, value) in [("depth_step", self.depth_step), ("exposure", self.exposure)] {
            if !(value.is_finite() && value >= 0.0) {
                return field(name, value.to_string(), "finite and not negative");
            }
        }
        if ![NORMALS_SIGNED, NORMALS_UNSIGNED, NORMALS_OCTAHEDRAL].contains(&self.normals) {
            let expected = "one of `NORMALS_SIGNED` (0), `NORMALS_UNSIGNED` (1) and `NORMALS_OCTAHEDRAL` (2) of `shared::gbuffer`";
            return field("normals", self.normals.to_string(), expected);
        }
        if self.radiance > 1 {
            let expected = "1 to get radiance or 0 to get irradiance";
            return field("radiance", self.radiance.to_string(), expected);
        }
        Ok(())
    }
}
