//! The shared scalar formulas: ray against box, ray against triangle, ray into an instance's space.
//!
//! Plain `f32` in a fixed order of operations, never fused: SIMD code and shaders can follow them to the bit.
use glam::{Vec3, Vec4};

use super::types::{Instance, Ray, Triangle};

/// Smallest magnitude of a direction component that is inverted as it stands; a smaller one counts as this, so that
/// reciprocals stay finite and no `0 * infinity` can occur.
const SMALLEST_DIRECTION: f32 = 1e-18;

/// Largest magnitude of a ray's origin, in world and in object space.
pub const FARTHEST_ORIGIN: f32 = 1e18;

/// `1 + 2 gamma(3)` with `gamma(n) = n e / (1 - n e)`, e = 2^-24, rounded up.
///
/// Scaling the far distance by it makes the slab test conservative: T. Ize, "Robust BVH Ray Traversal", Journal of
/// Computer Graphics Techniques 2(2), 2013.
pub const FAR_SCALE: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Padding of boxes relative to their largest coordinate.
const BOX_PADDING: f32 = 1.0 / (1 << 18) as f32;

/// Pads a box by 2^-18 of its largest coordinate.
#[inline(always)]
pub fn pad(min: Vec3, max: Vec3) -> (Vec3, Vec3) {
    let largest = min.abs().max(max.abs());
    let padding = Vec3::splat(largest.x.max(largest.y).max(largest.z) * BOX_PADDING);
    (min - padding, max + padding)
}

/// A ray prepared for box tests, in world or object space.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// Start.
    pub origin: Vec3,
    /// Direction, any length.
    pub direction: Vec3,
    /// Component-wise reciprocal of the direction, finite.
    pub inverse: Vec3,
}

impl BoxRay {
    /// Prepares a ray; `None` for one that hits nothing by definition, because it starts beyond [`FARTHEST_ORIGIN`] or
    /// is not finite. No product of what remains overflows into something that is not a number.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3) -> Option<Self> {
        // Not `>`: the comparison must also fail for NaN.
        let near = origin.abs().cmple(Vec3::splat(FARTHEST_ORIGIN)).all();
        if !(near && direction.is_finite()) {
            return None;
        }
        let invert = |d: f32| {
            let safe = if d.abs() < SMALLEST_DIRECTION {
                SMALLEST_DIRECTION.copysign(d)
            } else {
                d
            };
            1.0 / safe
        };
        Some(BoxRay {
            origin,
            direction,
            inverse: Vec3::new(
                invert(direction.x),
                invert(direction.y),
                invert(direction.z),
            ),
        })
    }

    /// Distance at which the ray enters a box, at least `t_min`; `None` if it misses the box.
    ///
    /// Slab test (Kay and Kajiya 1986) with Ize's scaling of the far distance. Each rounded operation is monotone in the
    /// planes: a box inside another one is never entered earlier, and never hit alone. Planes are told apart by the
    /// direction, not by their order, so that an inverted box (the root of an empty tree) is always missed.
    #[inline(always)]
    pub fn enter(&self, min: Vec3, max: Vec3, t_min: f32) -> Option<f32> {
        let a = (min - self.origin) * self.inverse;
        let b = (max - self.origin) * self.inverse;
        let backward = self.inverse.cmplt(Vec3::ZERO);
        let (near, far) = (Vec3::select(backward, b, a), Vec3::select(backward, a, b));
        let near = near.x.max(near.y).max(near.z).max(t_min);
        let far = far.x.min(far.y).min(far.z) * FAR_SCALE;
        (near <= far).then_some(near)
    }
}

/// Distance and weights of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
}

#[inline(always)]
fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )
}

#[inline(always)]
fn dot(a: Vec3, b: Vec3) -> f32 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

/// Two-sided intersection of a ray's whole line with a triangle; `None` beside it, parallel to it or where it has no
/// area.
///
/// T. Moeller and B. Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", Journal of Graphics Tools 2(1),
/// 1997, with the determinants expanded about the triangle's normal: with `n = e1 x e2`, `c = v0 - o`, `r = c x d`,
/// `det = d . n`: `t = c . n / det`, `u = e2 . r / det`, `v = -(e1 . r) / det`.
#[inline(always)]
pub fn intersect_triangle(
    origin: Vec3,
    direction: Vec3,
    triangle: &Triangle,
) -> Option<TriangleHit> {
    let n = cross(triangle.e1, triangle.e2);
    let c = triangle.v0 - origin;
    let r = cross(c, direction);
    let det = dot(direction, n);
    let sign = if det.is_sign_negative() { -1.0 } else { 1.0 };
    let size = det.abs();
    let u = dot(triangle.e2, r) * sign;
    let v = -(dot(triangle.e1, r) * sign);
    if u >= 0.0 && v >= 0.0 && u + v <= size && size > 0.0 {
        let t = dot(c, n) * sign;
        Some(TriangleHit {
            t: t / size,
            u: u / size,
            v: v / size,
        })
    } else {
        None
    }
}

/// A ray in the space of an instance that it enters.
#[derive(Clone, Copy, Debug)]
pub struct InstanceRay {
    /// The ray in object space; its direction is not normalised, so that `t` is that of the world.
    pub ray: BoxRay,
    /// Lower end of the world ray's interval.
    pub t_min: f32,
    /// Distance at which the world ray enters the instance's box.
    pub near: f32,
}

impl InstanceRay {
    /// Moves a world ray into an instance whose box it enters at `near`; `None` as in [`BoxRay::new`].
    #[inline(always)]
    pub fn new(ray: &Ray, instance: &Instance, near: f32) -> Option<Self> {
        let rows = &instance.world_to_object;
        let origin = transform_point(rows, ray.origin);
        let direction = transform_vector(rows, ray.direction);
        Some(InstanceRay {
            ray: BoxRay::new(origin, direction)?,
            t_min: ray.t_min,
            near,
        })
    }

    /// The definition of a hit: the triangle is hit beyond `t_min`, and so is its padded box.
    ///
    /// The distance is never below the entry into either box. That changes a distance only where rounding made it worse
    /// than the padding, and it makes culling by boxes exact.
    #[inline(always)]
    pub fn hit(&self, triangle: &Triangle) -> Option<TriangleHit> {
        let hit = intersect_triangle(self.ray.origin, self.ray.direction, triangle)?;
        if !(hit.t > self.t_min && hit.t < f32::INFINITY) {
            return None;
        }
        let (min, max) = triangle.bounds();
        let near = self.ray.enter(min, max, self.t_min)?;
        Some(TriangleHit {
            t: hit.t.max(near).max(self.near),
            ..hit
        })
    }
}

/// Applies the rows of an affine map to a point.
#[inline(always)]
pub fn transform_point(rows: &[Vec4; 3], p: Vec3) -> Vec3 {
    let row = |r: &Vec4| ((r.x * p.x + r.y * p.y) + r.z * p.z) + r.w;
    Vec3::new(row(&rows[0]), row(&rows[1]), row(&rows[2]))
}

/// Applies the linear part of an affine map to a vector.
#[inline(always)]
pub fn transform_vector(rows: &[Vec4; 3], v: Vec3) -> Vec3 {
    let row = |r: &Vec4| (r.x * v.x + r.y * v.y) + r.z * v.z;
    Vec3::new(row(&rows[0]), row(&rows[1]), row(&rows[2]))
}
