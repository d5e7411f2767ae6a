//! The wide tests as plain loops over eight lanes, which compilers turn into vector code.
use super::intersect::{BoxRay, FAR_SCALE};
use super::types::{PACKET, WideNode, WidePacket};
use super::wide::Kernel;

/// The kernel for any processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

/// A ray with, for each axis, the plane that it meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct PortableRay {
    ray: BoxRay,
    near: [usize; 3],
    t_min: f32,
}

type Lanes = [f32; PACKET];
type Lanes3 = [Lanes; 3];

#[inline(always)]
fn map(f: impl Fn(usize) -> f32) -> Lanes {
    std::array::from_fn(f)
}

#[inline(always)]
fn bits(f: impl Fn(usize) -> bool) -> u32 {
    (0..PACKET).fold(0, |mask, lane| mask | (u32::from(f(lane)) << lane))
}

#[inline(always)]
fn cross(a: &Lanes3, b: &Lanes3) -> Lanes3 {
    [
        map(|i| a[1][i] * b[2][i] - a[2][i] * b[1][i]),
        map(|i| a[2][i] * b[0][i] - a[0][i] * b[2][i]),
        map(|i| a[0][i] * b[1][i] - a[1][i] * b[0][i]),
    ]
}

#[inline(always)]
fn dot(a: &Lanes3, b: &Lanes3) -> Lanes {
    map(|i| (a[0][i] * b[0][i] + a[1][i] * b[1][i]) + a[2][i] * b[2][i])
}

impl Kernel for Portable {
    type Ray = PortableRay;

    #[inline(always)]
    fn prepare(self, ray: &BoxRay, t_min: f32) -> PortableRay {
        let near = |axis: usize| {
            if ray.inverse[axis] < 0.0 {
                axis + 3
            } else {
                axis
            }
        };
        PortableRay {
            ray: *ray,
            near: [near(0), near(1), near(2)],
            t_min,
        }
    }

    #[inline(always)]
    fn boxes(self, ray: &PortableRay, node: &WideNode, limit: f32) -> (u32, [f32; 8]) {
        let mut near = [ray.t_min; 8];
        let mut far = [f32::INFINITY; 8];
        for axis in 0..3 {
            let (origin, inverse) = (ray.ray.origin[axis], ray.ray.inverse[axis]);
            let entry = &node.planes[ray.near[axis]];
            let exit = &node.planes[(ray.near[axis] + 3) % 6];
            for lane in 0..8 {
                near[lane] = larger((entry[lane] - origin) * inverse, near[lane]);
                far[lane] = smaller((exit[lane] - origin) * inverse, far[lane]);
            }
        }
        let mask = bits(|i| near[i] <= smaller(far[i] * FAR_SCALE, limit));
        (mask, near)
    }

    #[inline(always)]
    fn triangles(self, ray: &PortableRay, packet: &WidePacket, limit: f32) -> u32 {
        let (o, d) = (ray.ray.origin, ray.ray.direction);
        let d = [[d.x; PACKET], [d.y; PACKET], [d.z; PACKET]];
        let n = cross(&packet.e1, &packet.e2);
        let c = [
            map(|i| packet.v0[0][i] - o.x),
            map(|i| packet.v0[1][i] - o.y),
            map(|i| packet.v0[2][i] - o.z),
        ];
        let r = cross(&c, &d);
        let det = dot(&d, &n);
        let sign = map(|i| if det[i].is_sign_negative() { -1.0 } else { 1.0 });
        let (u, v) = (dot(&packet.e2, &r), dot(&packet.e1, &r));
        let u = map(|i| u[i] * sign[i]);
        let v = map(|i| -(v[i] * sign[i]));
        let size = map(|i| det[i].abs());
        let inside =
            bits(|i| (u[i] >= 0.0) & (v[i] >= 0.0) & (u[i] + v[i] <= size[i]) & (size[i] > 0.0));
        if inside == 0 {
            return 0;
        }
        let t = dot(&c, &n);
        let t = map(|i| t[i] * sign[i] / size[i]);
        inside & bits(|i| (t[i] > ray.t_min) & (t[i] <= limit))
    }
}

/// The larger number, `b` if `a` is not one; one instruction, unlike `f32::max`.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller number, `b` if `a` is not one.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
