//! What nodes carry beside meshes: skins, lights, cameras.
use super::error::ImportError;
use super::hierarchy::{Tree, affine};
use super::source::Source;
use super::warnings::Warnings;
use gibs_passes::scene::{Camera, Light, LightKind, NodeId, Scene, Skin};
use glam::{DAffine3, DVec3, Vec3};
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::extensions::scene::khr_lights_punctual::Type as PunctualType;
use gltf::json::validation::Checked;
use std::collections::BTreeMap;

/// Adds the skins, lights and cameras of the scene's nodes.
pub(super) fn attach(
    source: &Source,
    tree: &Tree,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(), ImportError> {
    let world = scene.pose(&[]).world;
    let mut skins = BTreeMap::new();
    for (id, index, node) in tree.nodes(source) {
        if let (Some(skin), Some(_)) = (node.skin, node.mesh) {
            let slot = match skins.get(&skin.value()) {
                Some(&slot) => slot,
                None => {
                    let slot = read_skin(source, tree, skin, index, warnings)?.map(|skin| {
                        scene.skins.push(skin);
                        scene.skins.len() as u32 - 1
                    });
                    skins.insert(skin.value(), slot);
                    slot
                }
            };
            scene.nodes[id as usize].skin = slot;
        }
        let punctual = node
            .extensions
            .as_ref()
            .and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(punctual) = punctual {
            scene.lights.push(light(source, id, index, punctual.light)?);
        }
        if let Some(index_of_camera) = node.camera {
            let owner = || format!("nodes[{index}]");
            let camera = source.get(&source.root.cameras, "camera", index_of_camera, owner)?;
            if let Some(camera) = perspective(
                camera,
                index_of_camera.value(),
                world[id as usize],
                warnings,
            ) {
                scene.cameras.push((id, camera));
            }
        }
    }
    Ok(())
}

/// A skin; `None` where the scene does not have all of its joints.
fn read_skin(
    source: &Source,
    tree: &Tree,
    index: json::Index<json::Skin>,
    node: usize,
    warnings: &mut Warnings,
) -> Result<Option<Skin>, ImportError> {
    let skin = source.get(&source.root.skins, "skin", index, || {
        format!("nodes[{node}]")
    })?;
    let element = || format!("skins[{}]", index.value());
    let mut joints: Vec<NodeId> = Vec::with_capacity(skin.joints.len());
    for &joint in &skin.joints {
        source.get(&source.root.nodes, "node", joint, element)?;
        let Some(id) = tree.id(joint) else {
            warnings.push(format!(
                "{} has joint node {}, which is not in the scene; what it should move stays rigid",
                element(),
                joint.value()
            ));
            return Ok(None);
        };
        joints.push(id);
    }
    let inverse_bind = match skin.inverse_bind_matrices {
        None => vec![DAffine3::IDENTITY; joints.len()],
        Some(accessor) => {
            let matrices = source.reals(accessor, &[Type::Mat4], &element)?;
            if matrices.count < joints.len() {
                let problem = format!(
                    "has {} joints, but {} inverse bind matrices; give one for each joint",
                    joints.len(),
                    matrices.count
                );
                return Err(source.error(element(), problem));
            }
            (0..joints.len())
                .map(|i| affine(&matrices.real(i)))
                .collect()
        }
    };
    Ok(Some(Skin {
        joints,
        inverse_bind,
    }))
}

fn light(
    source: &Source,
    id: NodeId,
    node: usize,
    index: json::Index<json::extensions::scene::khr_lights_punctual::Light>,
) -> Result<Light, ImportError> {
    let lights: &[json::extensions::scene::khr_lights_punctual::Light] = source.root.as_ref();
    let light = source.get(lights, "light", index, || format!("nodes[{node}]"))?;
    let kind = match light.type_ {
        Checked::Valid(PunctualType::Directional) => LightKind::Directional,
        Checked::Valid(PunctualType::Point) => LightKind::Point,
        Checked::Valid(PunctualType::Spot) => {
            let cone = light.spot.as_ref();
            LightKind::Spot {
                inner: cone.map_or(0.0, |cone| cone.inner_cone_angle),
                outer: cone.map_or(std::f32::consts::FRAC_PI_4, |cone| cone.outer_cone_angle),
            }
        }
        Checked::Invalid => {
            let i = index.value();
            let found = source.stated(&format!("/extensions/KHR_lights_punctual/lights/{i}/type"));
            let problem = format!("has type {found}; it must be directional, point or spot");
            return Err(source.error(format!("KHR_lights_punctual.lights[{i}]"), problem));
        }
    };
    Ok(Light {
        node: id,
        kind,
        intensity: Vec3::from(light.color) * light.intensity,
    })
}

/// A camera at its node's place at rest. Cameras look along -z with y up (glTF 2.0, 3.10).
fn perspective(
    camera: &json::Camera,
    index: usize,
    world: DAffine3,
    warnings: &mut Warnings,
) -> Option<Camera> {
    let Some(perspective) = &camera.perspective else {
        warnings.once("orthographic camera", || {
            format!("cameras[{index}] is not a perspective camera; such cameras are not supported and left out")
        });
        return None;
    };
    let position = world.translation;
    let forward = world.transform_vector3(DVec3::NEG_Z).try_normalize();
    let up = world.transform_vector3(DVec3::Y).try_normalize();
    let vfov = f64::from(perspective.yfov);
    let sees = vfov > 0.0 && vfov < std::f64::consts::PI;
    let (Some(forward), Some(up), true) = (forward, up, sees) else {
        warnings.push(format!(
            "cameras[{index}] has no picture (yfov {vfov}, or a flat node) and is left out"
        ));
        return None;
    };
    Some(Camera {
        position,
        target: position + forward,
        up,
        vfov,
    })
}
