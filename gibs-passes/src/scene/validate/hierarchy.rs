//! Checks of nodes, skins and cameras.
use super::{SceneDataError, Tally, bad_value, check_finite, check_index, label};
use crate::scene::{Camera, LocalTransform, Mesh, Node, NodeId, Skin};
use glam::{DAffine3, DQuat};
use std::f64::consts::PI;

/// Parents before children, references that exist, transforms that are finite.
pub(super) fn nodes(
    nodes: &mut [Node],
    meshes: &[Mesh],
    skins: &[Skin],
    warnings: &mut Vec<String>,
) -> Result<(), SceneDataError> {
    let highest: Vec<Option<(u16, usize)>> = meshes.iter().map(highest_joint).collect();
    let mut unturned = Tally::default();
    for (i, node) in nodes.iter_mut().enumerate() {
        let name = node.name.clone();
        let element = || label("node", i, &name);
        if let Some(parent) = node.parent
            && parent as usize >= i
        {
            return Err(SceneDataError::Hierarchy {
                element: element(),
                parent,
            });
        }
        for &mesh in &node.meshes {
            check_index(element, "mesh", mesh, meshes.len())?;
        }
        if let Some(skin) = node.skin {
            check_index(element, "skin", skin, skins.len())?;
            let joints = skins[skin as usize].joints.len();
            for &mesh in &node.meshes {
                if let Some((joint, vertex)) = highest[mesh as usize] {
                    let place = || {
                        let mesh = label("mesh", mesh as usize, &meshes[mesh as usize].name);
                        format!(
                            "{mesh}, vertex {vertex}, drawn with skin {skin} by {},",
                            element()
                        )
                    };
                    check_index(place, "joint", joint.into(), joints)?;
                }
            }
        }
        match &mut node.local {
            LocalTransform::Parts {
                translation,
                rotation,
                scale,
            } => {
                check_finite(element, "translation", *translation)?;
                check_finite(element, "scale", *scale)?;
                unturned.add(usize::from(!unit_rotation(element, rotation)?), element);
            }
            LocalTransform::Affine(affine) => check_affine(element, "transform", affine)?,
        }
    }
    unturned.report(
        "node",
        "nodes",
        "had a rotation of no length, now none",
        warnings,
    );
    Ok(())
}

/// Highest joint index a mesh's vertices use, and the first vertex that uses it.
fn highest_joint(mesh: &Mesh) -> Option<(u16, usize)> {
    let mut highest: Option<(u16, usize)> = None;
    for (vertex, skin) in mesh.skin.iter().enumerate() {
        for &(joint, _) in &skin.weights {
            if highest.is_none_or(|(other, _)| joint > other) {
                highest = Some((joint, vertex));
            }
        }
    }
    highest
}

/// Makes a rotation unit; one of no length becomes no rotation, and `false` is returned.
pub(super) fn unit_rotation(
    element: impl FnOnce() -> String,
    rotation: &mut DQuat,
) -> Result<bool, SceneDataError> {
    if !rotation.is_finite() {
        return Err(bad_value(element(), "rotation", *rotation, "finite"));
    }
    let length = rotation.length();
    // Shorter than any rounding of a unit quaternion, and safe to divide by above it.
    if !(length.is_finite() && length > 1e-30) {
        *rotation = DQuat::IDENTITY;
        return Ok(false);
    }
    if (length - 1.0).abs() > 1e-12 {
        *rotation /= length;
    }
    Ok(true)
}

fn check_affine(
    element: impl FnOnce() -> String,
    what: &str,
    affine: &DAffine3,
) -> Result<(), SceneDataError> {
    if affine.is_finite() {
        return Ok(());
    }
    Err(bad_value(element(), what, affine, "finite"))
}

/// Joints that exist, each with its bind matrix.
pub(super) fn skins(skins: &[Skin], node_count: usize) -> Result<(), SceneDataError> {
    for (i, skin) in skins.iter().enumerate() {
        let element = || label("skin", i, "");
        if skin.inverse_bind.len() != skin.joints.len() {
            return Err(SceneDataError::Length {
                element: element(),
                what: "inverse bind matrices",
                found: skin.inverse_bind.len(),
                expected: format!("{}, one per joint,", skin.joints.len()),
            });
        }
        for &joint in &skin.joints {
            check_index(element, "joint node", joint, node_count)?;
        }
        for (joint, matrix) in skin.inverse_bind.iter().enumerate() {
            check_affine(element, &format!("inverse bind matrix {joint}"), matrix)?;
        }
    }
    Ok(())
}

/// Cameras in nodes that exist, with a field of view that shows something.
pub(super) fn cameras(
    cameras: &[(NodeId, Camera)],
    node_count: usize,
) -> Result<(), SceneDataError> {
    for (i, (node, camera)) in cameras.iter().enumerate() {
        let element = || label("camera", i, "");
        check_index(element, "node", *node, node_count)?;
        check_finite(element, "position", camera.position)?;
        check_finite(element, "target", camera.target)?;
        check_finite(element, "up direction", camera.up)?;
        if !(camera.vfov > 0.0 && camera.vfov < PI) {
            return Err(bad_value(
                element(),
                "vertical field of view",
                camera.vfov,
                "between 0 and pi radians",
            ));
        }
    }
    Ok(())
}
