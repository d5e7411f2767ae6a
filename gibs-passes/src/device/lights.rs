//! Sun and punctual lights.
use crate::accel::MAX_WORLD_COORDINATE;
use crate::data::Light;
use crate::scene::{self, LightKind, Node, Pose, Sun, label};
use glam::{DVec3, Vec3};

/// The sun, then the scene's lights that shine at all. Those without a place or a direction are left out and named in
/// `warnings`.
pub(super) fn pack(
    lights: &[scene::Light],
    nodes: &[Node],
    pose: &Pose,
    origin: DVec3,
    sun: Option<&Sun>,
    warnings: &mut Vec<String>,
) -> Vec<Light> {
    let sun = sun
        .filter(|sun| sun.irradiance != Vec3::ZERO)
        .map(|sun| Light {
            intensity: sun.irradiance,
            direction: sun.direction.as_vec3(),
            ..Light::default()
        });
    let lights = lights
        .iter()
        .enumerate()
        .filter(|(_, light)| light.intensity != Vec3::ZERO)
        .filter_map(|(i, light)| {
            let world = &pose.world[light.node as usize];
            let position = world.translation - origin;
            let direction = world.transform_vector3(DVec3::NEG_Z).try_normalize();
            let is_far = !(position.abs())
                .cmplt(DVec3::splat(MAX_WORLD_COORDINATE))
                .all();
            let problem = match light.kind {
                LightKind::Point | LightKind::Spot { .. } if is_far => {
                    "its node is out of range; bring it closer to the origin"
                }
                LightKind::Directional | LightKind::Spot { .. } if direction.is_none() => {
                    "its node has no direction; give every axis a scale other than zero"
                }
                _ => "",
            };
            if !problem.is_empty() {
                let name = &nodes[light.node as usize].name;
                let node = label("node", light.node as usize, name);
                warnings.push(format!("light {i} in {node} is left out: {problem}"));
                return None;
            }
            let (kind, cos_inner, cos_outer) = match light.kind {
                LightKind::Directional => (0, 0.0, 0.0),
                LightKind::Point => (1, 0.0, 0.0),
                LightKind::Spot { inner, outer } => (2, inner.cos(), outer.cos()),
            };
            Some(Light {
                position: position.as_vec3(),
                kind,
                intensity: light.intensity,
                cos_outer,
                direction: direction.unwrap_or(DVec3::NEG_Z).as_vec3(),
                cos_inner,
            })
        });
    sun.into_iter().chain(lights).collect()
}
