//! Surfels, the grid that they stand in, and their settings.
use gibs_graph::element;
use glam::Vec3;

element! {
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
        /// Irradiance below which what rays bring counts as none, W/m^2.
        faintest: f32,
    }

    /// A surfel where it is now (GIBS, "Surfel = Surface Element").
    pub struct SurfelPose {
        /// Position.
        position: Vec3,
        /// Radius; zero for a free slot.
        radius: f32,
        /// Unit normal that its light comes over.
        normal: Vec3,
        /// Its identity, the plane that it lies in, and whether lookups need its depth function, see
        /// [`mark`](crate::shared::mark).
        mark: u32,
    }

    /// A surfel as it was born: fixed to its node.
    pub struct SurfelBirth {
        /// Position in the node's space.
        position: Vec3,
        /// Node.
        transform_id: u32,
        /// Packed normal in the node's space, that of shading unless `geometric_normals` is set.
        normal: u32,
        /// Packed normal of its plane in the node's space.
        plane: u32,
        /// Frame of birth; an earlier one where the surfel has grown too fast to learn from its depth function.
        frame: u32,
        /// [`lengths`](crate::shared::lengths), metres. Rounded up, the distance by which rays start off the surface. Rounded down,
        /// its clearance, the most radius that its surroundings leave it: the distance to the nearest surface that the picture
        /// showed at its birth, or half of the radius at which its rays found walls since; it never becomes larger.
        lengths: u32,
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
        /// Slots that have ever been in use: those below this. The stack gives out no other while one of them is free.
        used: u32,
    }
}
