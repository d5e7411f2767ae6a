//! Decoding of an engine's G-buffer.
use super::{octahedral, surface};
use crate::data::{Camera, HostGbuffer};
use glam::{UVec2, Vec2, Vec3, Vec4};

/// [`HostGbuffer::normals`]: x, y and z as they are.
pub const NORMALS_SIGNED: u32 = 0;
/// [`HostGbuffer::normals`]: x, y and z from 0 to 1.
pub const NORMALS_UNSIGNED: u32 = 1;
/// [`HostGbuffer::normals`]: octahedral in x and y, from -1 to 1.
pub const NORMALS_OCTAHEDRAL: u32 = 2;

/// A normal from depths is believed where the cosine to the normal given is at least this: across an edge, depths say
/// nothing.
pub const AGREEMENT: f32 = 0.5;

/// Distance along the viewing axis of a depth in the buffer. Of any perspective projection, reversed or not, with a far
/// plane or without, the depth is `offset + scale / distance`.
#[inline]
pub fn view_depth(z: f32, host: &HostGbuffer) -> f32 {
    host.depth_scale / (z - host.depth_offset)
}

/// Where a pixel's surface is, relative to the floating origin.
#[inline]
pub fn position(at: UVec2, z: f32, camera: &Camera, host: &HostGbuffer) -> Vec3 {
    let x = at.x as f32 + 0.5 - host.jitter.x;
    let y = at.y as f32 + 0.5 - host.jitter.y;
    let across = x / camera.width as f32 * 2.0 - 1.0;
    let upwards = 1.0 - y / camera.height as f32 * 2.0;
    let ray = camera.forward + camera.right * across + camera.up * upwards;
    camera.eye + ray * view_depth(z, host)
}

/// Distance by which rays start off the surface: that of its coordinates, and how far the depth buffer's steps lie
/// apart there, as floats (half an ulp either way) and as the integers that they may have been made from.
#[inline]
pub fn offset(position: Vec3, z: f32, camera: &Camera, host: &HostGbuffer) -> f32 {
    let reach = position.abs().max(camera.eye.abs()).max_element();
    let d = view_depth(z, host);
    let step = host.depth_step + z.abs() * f32::EPSILON;
    reach * surface::OFFSET + 2.0 * (d * d / host.depth_scale.abs() * step)
}

/// The normal that the engine gives.
#[inline]
pub fn normal(texel: Vec4, host: &HostGbuffer) -> Vec3 {
    let v = match host.normals {
        NORMALS_UNSIGNED => Vec3::new(
            texel.x * 2.0 - 1.0,
            texel.y * 2.0 - 1.0,
            texel.z * 2.0 - 1.0,
        ),
        NORMALS_OCTAHEDRAL => return octahedral::decode(Vec2::new(texel.x, texel.y)),
        _ => texel.truncate(),
    };
    if v.dot(v) > 0.0 {
        v.normalize()
    } else {
        Vec3::Z
    }
}

/// A normal on the side that is seen; `seen` is the way from the eye.
#[inline]
pub fn facing(n: Vec3, seen: Vec3) -> Vec3 {
    if n.dot(seen) > 0.0 { -n } else { n }
}

/// Geometric and shading normal: `flat` is the normal of the depths (of any length, zero where there is none), `seen`
/// the way from the eye. Both are on the side that is seen.
#[inline]
pub fn sides(flat: Vec3, given: Vec3, seen: Vec3) -> (Vec3, Vec3) {
    let square = flat.dot(flat);
    if square > 0.0 {
        let geometric = facing(flat.normalize(), seen);
        let shading = if given.dot(geometric) < 0.0 {
            -given
        } else {
            given
        };
        if shading.dot(geometric) >= AGREEMENT {
            return (geometric, shading);
        }
    }
    let given = facing(given, seen);
    (given, given)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The projections that engines use, with near plane 0.1 and far plane 1000 where there is one: depth of a distance
    /// in f64, from the textbook matrix, decoded again.
    #[test]
    fn every_projection_is_undone() {
        let (n, f) = (0.1f64, 1000.0f64);
        /// Depth of a distance with a near and a far plane.
        type Project = fn(f64, f64, f64) -> f64;
        let cases: [(&str, Project, HostGbuffer); 4] = [
            (
                "finite",
                |d, n, f| f / (f - n) - n * f / (f - n) / d,
                HostGbuffer::perspective(n, Some(f), false).expect("planes"),
            ),
            (
                "finite, reversed",
                |d, n, f| -n / (f - n) + n * f / (f - n) / d,
                HostGbuffer::perspective(n, Some(f), true).expect("planes"),
            ),
            (
                "infinite",
                |d, n, _| 1.0 - n / d,
                HostGbuffer::perspective(n, None, false).expect("planes"),
            ),
            (
                "infinite, reversed",
                |d, n, _| n / d,
                HostGbuffer::perspective(n, None, true).expect("planes"),
            ),
        ];
        for (name, project, host) in cases {
            for d in [0.1, 0.5, 1.0, 10.0, 100.0, 900.0] {
                let z = project(d, n, f) as f32;
                let got = f64::from(view_depth(z, &host));
                // The depth's own rounding, half an ulp, taken through the inverse projection, and that of decoding.
                let slack = d * d / n * f64::from(z.abs()).max(1e-3) * 2e-7 + d * 1e-6;
                assert!((got - d).abs() <= slack, "{name}: {d} became {got}");
            }
            let reversed = name.contains("reversed");
            assert_eq!(host.depth_clear, if reversed { 0.0 } else { 1.0 });
        }
    }

    #[test]
    fn normals_decode_from_every_encoding() {
        let n = Vec3::new(0.36, -0.48, 0.8);
        let host = |normals| HostGbuffer {
            normals,
            ..HostGbuffer::perspective(0.1, None, true).expect("planes")
        };
        assert!(normal(n.extend(0.0) * 3.0, &host(NORMALS_SIGNED)).distance(n) < 1e-6);
        let unsigned = (n * 0.5 + 0.5).extend(1.0);
        assert!(normal(unsigned, &host(NORMALS_UNSIGNED)).distance(n) < 1e-6);
        let p = octahedral::encode(n);
        let octahedral = Vec4::new(p.x, p.y, 0.0, 0.0);
        assert!(normal(octahedral, &host(NORMALS_OCTAHEDRAL)).distance(n) < 1e-6);
        assert_eq!(normal(Vec4::ZERO, &host(NORMALS_SIGNED)), Vec3::Z);
    }

    #[test]
    fn normals_face_the_eye_and_depths_are_doubted_across_edges() {
        let seen = Vec3::NEG_Z;
        let tilted = Vec3::new(0.3, 0.0, 0.954).normalize();
        assert_eq!(sides(Vec3::Z * 4.0, tilted, seen), (Vec3::Z, tilted));
        assert_eq!(sides(Vec3::NEG_Z, -tilted, seen), (Vec3::Z, tilted));
        assert_eq!(sides(Vec3::ZERO, tilted, seen), (tilted, tilted));
        let edge = Vec3::new(0.99, 0.0, 0.1);
        assert_eq!(sides(edge, Vec3::Z, seen), (Vec3::Z, Vec3::Z));
    }
}
