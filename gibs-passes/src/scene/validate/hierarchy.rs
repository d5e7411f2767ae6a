//! Checks of nodes, skins and cameras.
use super::{SceneDataError, Tally, bad_value, check_finite, check_index, label};
use crate::scene::{Camera, LocalTransform, Mesh, Node, NodeId, Skin, has_length, unit_rotation};
use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::PI;

/// Parents before children, references that exist, transforms that are finite.
pub(super) fn nodes(
    nodes: &[Node],
    mesh_count: usize,
    skin_count: usize,
    warnings: &mut Vec<String>,
) -> Result<(), SceneDataError> {
    let mut unturned = Tally::default();
    for (i, node) in nodes.iter().enumerate() {
        let element = || label("node", i, &node.name);
        if let Some(parent) = node.parent
            && parent as usize >= i
        {
            return Err(SceneDataError::Hierarchy {
                element: element(),
                parent,
            });
        }
        for &mesh in &node.meshes {
            check_index(element, "mesh", mesh, mesh_count)?;
        }
        if let Some(skin) = node.skin {
            check_index(element, "skin", skin, skin_count)?;
        }
        match &node.local {
            LocalTransform::Parts {
                translation,
                rotation,
                scale,
            } => {
                check_finite(element, "translation", *translation)?;
                check_finite(element, "scale", *scale)?;
                unturned.add(usize::from(!check_rotation(element, *rotation)?), element);
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

/// Vertices follow joints that the skins they are drawn with have. Nodes, meshes and skins have been checked alone.
pub(super) fn joints(
    nodes: &[Node],
    meshes: &[Mesh],
    skins: &[Skin],
) -> Result<(), SceneDataError> {
    let highest: Vec<Option<(u16, usize)>> = meshes.iter().map(highest_joint).collect();
    for (i, node) in nodes.iter().enumerate() {
        let Some(skin) = node.skin else {
            continue;
        };
        let joints = skins[skin as usize].joints.len();
        for &mesh in &node.meshes {
            if let Some((joint, vertex)) = highest[mesh as usize] {
                let place = || {
                    let mesh = label("mesh", mesh as usize, &meshes[mesh as usize].name);
                    let node = label("node", i, &node.name);
                    format!("{mesh}, vertex {vertex}, drawn with skin {skin} by {node},")
                };
                check_index(place, "joint", joint.into(), joints)?;
            }
        }
    }
    Ok(())
}

/// Highest joint index that a mesh's vertices follow, and the first vertex that does. Joints of weight zero do not
/// count, and a vertex without others follows the first.
fn highest_joint(mesh: &Mesh) -> Option<(u16, usize)> {
    let mut highest: Option<(u16, usize)> = None;
    for (vertex, skin) in mesh.skin.iter().enumerate() {
        let followed = skin.weights.iter().filter(|(_, weight)| *weight > 0.0);
        let joint = followed.map(|&(joint, _)| joint).max().unwrap_or(0);
        if highest.is_none_or(|(other, _)| joint > other) {
            highest = Some((joint, vertex));
        }
    }
    highest
}

/// Makes all rotations unit; those of no length become none.
pub(super) fn make_unit(nodes: &mut [Node]) {
    for node in nodes {
        if let LocalTransform::Parts { rotation, .. } = &mut node.local {
            *rotation = unit_rotation(*rotation);
        }
    }
}

/// A rotation must be finite; returns whether it has a length.
pub(super) fn check_rotation(
    element: impl FnOnce() -> String,
    rotation: DQuat,
) -> Result<bool, SceneDataError> {
    if rotation.is_finite() {
        Ok(has_length(rotation))
    } else {
        Err(bad_value(element(), "rotation", rotation, "finite"))
    }
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
            if !matrix.is_finite() {
                check_affine(element, &format!("inverse bind matrix {joint}"), matrix)?;
            }
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
        check_vfov(element, camera.vfov)?;
    }
    Ok(())
}

/// A field of view must show something.
fn check_vfov(element: impl FnOnce() -> String, vfov: f64) -> Result<(), SceneDataError> {
    if vfov > 0.0 && vfov < PI {
        return Ok(());
    }
    Err(bad_value(
        element(),
        "vertical field of view",
        vfov,
        "between 0 and pi radians",
    ))
}

/// Farthest place of a view's camera, metres. Far beyond any scene, and what is a metre ahead still is another point.
const FARTHEST_CAMERA: f64 = 1e15;

impl Camera {
    /// Whether there is a picture from here: places that are finite and at most 1e15 m away, a target other than the
    /// position, a finite up direction, a field of view between 0 and pi. An up direction along the line of sight is
    /// allowed, see [`Camera::axes`].
    ///
    /// # Errors
    /// [`SceneDataError::Value`] names what is wrong.
    pub fn check(&self) -> Result<(), SceneDataError> {
        let element = || "the view's camera".to_owned();
        for (what, place) in [("position", self.position), ("target", self.target)] {
            // Not `>`: the comparison must also fail for NaN.
            if !(place.abs().cmple(DVec3::splat(FARTHEST_CAMERA)).all()) {
                let expected = "finite and at most 1e15 in magnitude";
                return Err(bad_value(element(), what, place, expected));
            }
        }
        if (self.target - self.position).try_normalize().is_none() {
            let expected =
                "another point than the position, so that there is a direction to look in";
            return Err(bad_value(element(), "target", self.target, expected));
        }
        check_finite(element, "up direction", self.up)?;
        check_vfov(element, self.vfov)
    }
}
