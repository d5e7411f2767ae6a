//! Device data of the acceleration structure: plain structs whose layout Rust and WGSL share.
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// Index that stands for nothing: the instance and triangle of a miss, an empty child of a wide node.
pub const NONE: u32 = u32::MAX;

/// Largest magnitude of an object-space coordinate. Products of three such numbers, which the triangle test forms,
/// still fit an `f32`.
pub const MAX_COORDINATE: f32 = 1e12;

/// Triangles in a [`WidePacket`].
pub const PACKET: usize = 8;

/// Node of a binary tree, 32 bytes.
///
/// All levels share one buffer. `count == 0`: an inner node, children at `first` and `first + 1`. `count > 0`: a
/// leaf. In the top level (root at 0) a leaf holds exactly one instance, `first`; in a bottom level it holds the
/// triangles `first .. first + count`. Indices are absolute. Siblings share a 64-byte line.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct BvhNode {
    /// Lower corner of the padded box.
    pub min: Vec3,
    /// First child or first primitive.
    pub first: u32,
    /// Upper corner of the padded box.
    pub max: Vec3,
    /// Number of primitives; zero for an inner node.
    pub count: u32,
}

/// Triangle in object space, 48 bytes, in leaf order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Triangle {
    /// First vertex.
    pub v0: Vec3,
    /// [`super::MeshPart::first_primitive`] plus the triangle's index in its part.
    pub primitive: u32,
    /// Second vertex minus the first.
    pub e1: Vec3,
    /// Material index; bit 31 ([`Triangle::ALPHA_TEST`]) asks for the alpha test.
    pub material_flags: u32,
    /// Third vertex minus the first.
    pub e2: Vec3,
    /// Transform that moves the triangle, as surfels remember it.
    pub transform_id: u32,
}

impl Triangle {
    /// Bit of [`Triangle::material_flags`]: the filter of a traversal decides whether a hit counts.
    pub const ALPHA_TEST: u32 = 1 << 31;

    /// Whether the alpha test decides about hits.
    #[inline(always)]
    pub fn needs_alpha_test(&self) -> bool {
        self.material_flags & Self::ALPHA_TEST != 0
    }

    /// Index of the material.
    #[inline(always)]
    pub fn material(&self) -> u32 {
        self.material_flags & !Self::ALPHA_TEST
    }

    /// Padded box of the triangle (lower, upper corner).
    ///
    /// The padding is 2^-18 of the largest coordinate, 38 um at 10 m: more than the triangle test's rounding for a
    /// triangle of ordinary shape, so that the box never takes a hit away. Builder and traversals must compute it
    /// alike, from the stored edges.
    #[inline(always)]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (v1, v2) = (self.v0 + self.e1, self.v0 + self.e2);
        let min = self.v0.min(v1).min(v2);
        let max = self.v0.max(v1).max(v2);
        super::intersect::pad(min, max)
    }
}

/// A bottom level placed in the world, 112 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Instance {
    /// Rows of the affine map from world to object space; `w` is the translation.
    pub world_to_object: [Vec4; 3],
    /// Rows of the affine map from object to world space.
    pub object_to_world: [Vec4; 3],
    /// Root of the bottom level in the node buffer.
    pub root: u32,
    /// First triangle of the bottom level.
    pub first_triangle: u32,
    /// Transform that moves the instance, as surfels remember it.
    pub transform_id: u32,
    /// [`Instance::MIRRORED`] and [`Instance::LEFT_OUT`].
    pub flags: u32,
}

impl Instance {
    /// Flag: the transform turns counter-clockwise triangles into clockwise ones.
    pub const MIRRORED: u32 = 1;
    /// Flag: no ray can hit the instance (see [`super::Stats::left_out`]).
    pub const LEFT_OUT: u32 = 2;
}

/// Ray, 32 bytes. Points `origin + t * direction` with `t_min < t <= t_max`; `direction` need not have unit length.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Ray {
    /// Start, in world space.
    pub origin: Vec3,
    /// Lower end of the interval, exclusive; at least zero.
    pub t_min: f32,
    /// Direction; `t` counts its lengths.
    pub direction: Vec3,
    /// Upper end of the interval, inclusive; may be infinite.
    pub t_max: f32,
}

/// Closest hit, 20 bytes. A miss has `instance == NONE` and the ray's `t_max` as `t`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Weight of the triangle's second vertex.
    pub u: f32,
    /// Weight of the triangle's third vertex.
    pub v: f32,
    /// Index into the triangles.
    pub triangle: u32,
    /// Index into the instances.
    pub instance: u32,
}

impl Default for Hit {
    fn default() -> Self {
        Self::miss(f32::INFINITY)
    }
}

impl Hit {
    /// The result of a ray that hits nothing up to `t_max`.
    #[inline(always)]
    pub fn miss(t_max: f32) -> Self {
        Hit {
            t: t_max,
            u: 0.0,
            v: 0.0,
            triangle: NONE,
            instance: NONE,
        }
    }

    /// Whether nothing was hit.
    #[inline(always)]
    pub fn is_miss(&self) -> bool {
        self.instance == NONE
    }

    /// Whether a hit at `t` wins against this one; of equal distances the smallest (instance, triangle).
    #[inline(always)]
    pub fn loses_to(&self, t: f32, instance: u32, triangle: u32) -> bool {
        t < self.t || (t == self.t && (instance, triangle) < (self.instance, self.triangle))
    }
}

/// The buffers of a two-level tree, as a traversal reads them.
#[derive(Clone, Copy, Debug)]
pub struct AccelView<'a> {
    /// Top level, then all bottom levels.
    pub nodes: &'a [BvhNode],
    /// Triangles in leaf order.
    pub triangles: &'a [Triangle],
    /// Instances, in the order in which they were given.
    pub instances: &'a [Instance],
}

/// Node with up to eight children, 256 bytes: boxes as arrays over the children.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WideNode {
    /// `[min x, min y, min z, max x, max y, max z]` of each child. An absent child has an inverted box.
    pub planes: [[f32; 8]; 6],
    /// Inner: index of the child. Leaf: [`WideNode::LEAF`] plus the packet (bottom level) or instance (top level).
    pub children: [u32; 8],
    /// Bottom level: node of the binary tree that the child stands for. Top level: child word that starts the
    /// instance's bottom level.
    pub sources: [u32; 8],
}

impl WideNode {
    /// Bit of a child word that marks a leaf.
    pub const LEAF: u32 = 1 << 31;

    /// A node without children.
    pub const EMPTY: WideNode = WideNode {
        planes: {
            let (low, high) = ([1e30; 8], [-1e30; 8]);
            [low, low, low, high, high, high]
        },
        children: [NONE; 8],
        sources: [NONE; 8],
    };
}

impl Default for WideNode {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// Up to eight triangles as arrays, 320 bytes. An absent triangle has zero edges, which no ray hits.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct WidePacket {
    /// First vertices, `[x, y, z]` of each triangle.
    pub v0: [[f32; PACKET]; 3],
    /// First edges.
    pub e1: [[f32; PACKET]; 3],
    /// Second edges.
    pub e2: [[f32; PACKET]; 3],
    /// First triangle of the packet; lane `i` is triangle `first + i`.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
    /// Bit mask of the triangles that need the alpha test.
    pub alpha: u32,
    /// Zero.
    pub padding: [u32; 5],
}

impl WidePacket {
    /// The triangle of a lane as far as rays are concerned, so that no other memory is touched to test it.
    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize) -> Triangle {
        let lane = lane % PACKET;
        let gather =
            |rows: &[[f32; PACKET]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
        Triangle {
            v0: gather(&self.v0),
            e1: gather(&self.e1),
            e2: gather(&self.e2),
            ..Triangle::default()
        }
    }
}

/// The buffers of a wide tree, as a traversal reads them.
#[derive(Clone, Copy, Debug)]
pub struct WideView<'a> {
    /// Top level (root at 0), then all bottom levels.
    pub nodes: &'a [WideNode],
    /// Leaves of the bottom levels.
    pub packets: &'a [WidePacket],
    /// Instances.
    pub instances: &'a [Instance],
}
