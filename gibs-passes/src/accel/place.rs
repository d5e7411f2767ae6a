//! Placing an instance in the world: its transforms and its padded box.
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};

use super::error::LeftOut;
use super::intersect::pad;
use super::level::Bounds;
use super::types::{BvhNode, Instance};

/// World coordinates beyond this take an instance out of the scene.
pub const MAX_WORLD_COORDINATE: f64 = 1e18;

/// Writes the transform of an instance and returns its padded world box.
pub(super) fn place_instance(
    instance: &mut Instance,
    root: Option<&BvhNode>,
    transform: &DAffine3,
) -> Result<Bounds, LeftOut> {
    let root = root.ok_or(LeftOut::Empty)?;
    if !transform.is_finite() {
        return Err(LeftOut::OutOfRange);
    }
    // The device sees the rounded transform, so its inverse is what rays need.
    let rounded = transform.as_affine3().as_daffine3();
    let matrix: DMat3 = rounded.matrix3;
    let volume = matrix.x_axis.length() * matrix.y_axis.length() * matrix.z_axis.length();
    let determinant = matrix.determinant();
    // Below this share of its axes' volume a transform is flat within f32. Both are finite here.
    if determinant.abs() <= 1e-12 * volume {
        return Err(LeftOut::Singular);
    }
    let inverse = rounded.inverse();
    let (forward, backward) = (rows(&rounded), rows(&inverse));
    if !forward.iter().chain(&backward).all(|row| row.is_finite()) {
        return Err(LeftOut::OutOfRange);
    }
    let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
    for corner in 0..8 {
        let pick = |bit: usize, low: f32, high: f32| if corner & bit == 0 { low } else { high };
        let local = Vec3::new(
            pick(1, root.min.x, root.max.x),
            pick(2, root.min.y, root.max.y),
            pick(4, root.min.z, root.max.z),
        );
        let world = rounded.transform_point3(local.as_dvec3());
        low = low.min(world);
        high = high.max(world);
    }
    if !low
        .abs()
        .max(high.abs())
        .cmplt(DVec3::splat(MAX_WORLD_COORDINATE))
        .all()
    {
        return Err(LeftOut::OutOfRange);
    }
    instance.object_to_world = forward;
    instance.world_to_object = backward;
    instance.flags = if determinant < 0.0 {
        Instance::MIRRORED
    } else {
        0
    };
    Ok(pad(low.as_vec3(), high.as_vec3()))
}

/// Rows of an affine map, rounded.
fn rows(map: &DAffine3) -> [Vec4; 3] {
    let linear = map.matrix3.transpose();
    let t = map.translation;
    [
        linear.x_axis.extend(t.x).as_vec4(),
        linear.y_axis.extend(t.y).as_vec4(),
        linear.z_axis.extend(t.z).as_vec4(),
    ]
}
