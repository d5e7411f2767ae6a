//! From the outputs of a schedule to the channels of a picture.
use crate::picture::{Picture, PictureError};
use crate::renderer::RenderError;
use crate::view::View;
use gibs_graph::{BackendError, Element, Executable, ResourceId, Schedule};
use gibs_passes::data::SurfacePoint;
use gibs_passes::shared::{octahedral, surface};
use glam::{DVec3, Vec3};

/// An output of a schedule, which has elements of this type.
///
/// # Errors
/// [`BackendError::Refused`] if there is no such output, or it has elements of another type.
pub(crate) fn find_output<T: Element>(
    schedule: &Schedule,
    name: &str,
) -> Result<ResourceId, BackendError> {
    let refuse = |reason: String, remedy: String| BackendError::Refused {
        what: format!("output `{name}`"),
        reason,
        remedy,
    };
    let Some(resource) = schedule.output(name) else {
        let names: Vec<&str> = schedule.outputs.iter().map(|o| o.name.as_str()).collect();
        let reason = "the frame has none of this name".into();
        return Err(refuse(reason, format!("it has {}", names.join(", "))));
    };
    let (has, wants) = (&schedule.resources[resource as usize].element, T::layout());
    if *has != wants {
        let reason = format!("its elements are `{has}`, not `{wants}`");
        return Err(refuse(reason, "read it as what it is".into()));
    }
    Ok(resource)
}

/// The elements of an output of a schedule.
///
/// # Errors
/// As [`find_output`], and what the executable says.
pub(crate) fn read_output<T: Element>(
    exec: &mut dyn Executable,
    name: &str,
) -> Result<Vec<T>, RenderError> {
    let resource = find_output::<T>(exec.schedule(), name)?;
    let bytes = exec.read(resource)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

pub(crate) fn set(
    picture: &mut Picture,
    layer: &str,
    values: impl Iterator<Item = Vec3>,
) -> Result<(), PictureError> {
    let mut planes = [const { Vec::new() }; 3];
    for v in values {
        for (plane, x) in planes.iter_mut().zip(v.to_array()) {
            plane.push(x);
        }
    }
    picture.set_rgb(layer, planes)
}

/// The channels of a truth that do not depend on light.
pub(crate) fn surface_channels(
    points: &[SurfacePoint],
    [width, height]: [u32; 2],
    view: &View,
    origin: DVec3,
) -> Result<Picture, PictureError> {
    let mut picture = Picture::new(width, height);
    let seen = |p: &SurfacePoint| surface::is_surface(p);
    let eye = (view.camera.position - origin).as_vec3();
    let forward = view.camera.axes()[2].as_vec3();
    let world = |p: &SurfacePoint| {
        if seen(p) {
            (p.position.as_dvec3() + origin).as_vec3()
        } else {
            Vec3::ZERO
        }
    };
    let normal = |p: &SurfacePoint| {
        if seen(p) {
            octahedral::unpack(p.shading_normal)
        } else {
            Vec3::ZERO
        }
    };
    let depth = |p: &SurfacePoint| {
        if seen(p) {
            (p.position - eye).dot(forward)
        } else {
            0.0
        }
    };
    set(&mut picture, "albedo", points.iter().map(surface::albedo))?;
    set(&mut picture, "emission", points.iter().map(|p| p.emission))?;
    let xyz = |f: &dyn Fn(&SurfacePoint) -> Vec3| {
        let mut planes = [const { Vec::new() }; 3];
        for p in points {
            for (plane, x) in planes.iter_mut().zip(f(p).to_array()) {
                plane.push(x);
            }
        }
        planes
    };
    picture.set_xyz("normal", xyz(&normal))?;
    picture.set_xyz("position", xyz(&world))?;
    picture.set_scalar("depth.Z", points.iter().map(depth).collect())?;
    picture.set_scalar(
        "mask.A",
        points
            .iter()
            .map(|p| f32::from(u8::from(seen(p))))
            .collect(),
    )?;
    Ok(picture)
}
