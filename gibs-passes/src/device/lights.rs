//! Sun and punctual lights.
use crate::data::Light;
use crate::scene::{LightKind, Pose, Scene, Sun};
use glam::{DVec3, Vec3};

/// The sun, then the scene's lights that shine at all.
pub(super) fn pack(scene: &Scene, pose: &Pose, origin: DVec3, sun: Option<&Sun>) -> Vec<Light> {
    let sun = sun
        .filter(|sun| sun.irradiance != Vec3::ZERO)
        .map(|sun| Light {
            intensity: sun.irradiance,
            direction: sun.direction.as_vec3(),
            ..Light::default()
        });
    let lights = scene
        .lights
        .iter()
        .filter(|light| light.intensity != Vec3::ZERO)
        .map(|light| {
            let world = &pose.world[light.node as usize];
            let direction = world
                .transform_vector3(DVec3::NEG_Z)
                .try_normalize()
                .unwrap_or(DVec3::NEG_Z);
            let (kind, cos_inner, cos_outer) = match light.kind {
                LightKind::Directional => (0, 0.0, 0.0),
                LightKind::Point => (1, 0.0, 0.0),
                LightKind::Spot { inner, outer } => (2, inner.cos(), outer.cos()),
            };
            Light {
                position: (world.translation - origin).as_vec3(),
                kind,
                intensity: light.intensity,
                cos_outer,
                direction: direction.as_vec3(),
                cos_inner,
            }
        });
    sun.into_iter().chain(lights).collect()
}
