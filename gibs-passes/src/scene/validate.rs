//! The gate that every scene passes before use: whatever comes after may index without checking.
//!
//! What breaks a promise of the scene types is an error; what has an obvious repair is repaired with one warning.
//! [`Scene::validate`] repairs a scene in place, for loaders. [`Scene::sound`] looks at a scene that it may not change,
//! and copies what it has to repair: every [`crate::device::DeviceScene`] is made from what it returns.
mod hierarchy;
mod mesh;
mod motion;
mod outside;
mod surface;

pub(crate) use outside::{environment, sun};

use super::{Light, MOST_RADIANCE, Material, Mesh, Node, Scene, Skin, Texture};
use glam::{DVec3, Vec3};
use mesh::Blemishes;
use std::borrow::Cow;

/// What is wrong with a scene. The text names the element, the value and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneDataError {
    /// An index points past the end of its list.
    #[error(
        "{element} refers to {what} {index}, but there are {count}; correct the index or add what it refers to"
    )]
    Index {
        /// Who refers.
        element: String,
        /// Kind of thing referred to.
        what: &'static str,
        /// The index.
        index: u64,
        /// Length of the list.
        count: usize,
    },
    /// An array's length does not match the one beside it.
    #[error("{element} has {found} {what} where {expected} are needed; give exactly as many")]
    Length {
        /// Whose array.
        element: String,
        /// Content of the array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Length that fits.
        expected: String,
    },
    /// A number is outside what it may be.
    #[error("{element}: {what} is {value}; it must be {expected}")]
    Value {
        /// Whose number.
        element: String,
        /// Which number.
        what: String,
        /// The number as found.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A node stands before its parent, or is its own ancestor.
    #[error(
        "{element} has node {parent} as parent, which does not stand before it; put every parent before its children"
    )]
    Hierarchy {
        /// The child.
        element: String,
        /// Its parent.
        parent: u32,
    },
}

/// A scene that has passed the gate, with copies of what had to be repaired.
pub(crate) struct Sound<'a> {
    pub nodes: &'a [Node],
    pub skins: &'a [Skin],
    pub textures: &'a [Texture],
    pub materials: Cow<'a, [Material]>,
    pub meshes: Vec<Cow<'a, Mesh>>,
    pub lighting: Lighting<'a>,
    /// What was repaired, but for the lights.
    pub warnings: Vec<String>,
}

/// Lights that have passed the gate.
pub(crate) struct Lighting<'a> {
    pub lights: Cow<'a, [Light]>,
    /// What was repaired in them.
    pub warnings: Vec<String>,
}

/// What there is to repair, with what goes in place of it, and a warning for each kind of repair.
struct Findings {
    materials: Vec<(usize, Material)>,
    meshes: Vec<(usize, Blemishes)>,
    lights: Vec<(usize, Light)>,
    warnings: Vec<String>,
    light_warnings: Vec<String>,
}

impl Scene {
    /// Checks every promise of the scene's types and repairs what has an obvious repair; returns one warning per kind
    /// of repair. A second call on the result changes nothing and returns no warning.
    ///
    /// Repairs: without materials a white one is added (silently); triangles without area are dropped; missing normals,
    /// rotations and skin weights are filled in; texture coordinates that are not finite become zero; factors and cone
    /// angles are clamped to their range; normals, rotations and weights are made unit (silently, since rounding alone
    /// needs that).
    ///
    /// A scene that was built in memory need not be validated: the gate to the device does the same to a copy of what
    /// needs it, each time. To call this once saves those copies.
    ///
    /// # Errors
    /// An index out of range, arrays whose lengths disagree, a number that is not finite or has no meaning (a negative
    /// light, say), a parent after its child. The scene then is as it was.
    pub fn validate(&mut self) -> Result<Vec<String>, SceneDataError> {
        let found = self.check()?;
        if self.materials.is_empty() {
            self.materials.push(Material::default());
        }
        put(&mut self.materials, found.materials);
        put(&mut self.lights, found.lights);
        for (i, blemishes) in found.meshes {
            mesh::repair(&mut self.meshes[i], blemishes);
        }
        mesh::make_unit(&mut self.meshes);
        hierarchy::make_unit(&mut self.nodes);
        motion::make_unit(&mut self.animations);
        let mut warnings = found.warnings;
        warnings.extend(found.light_warnings);
        Ok(warnings)
    }

    /// The scene as [`Scene::validate`] would leave it, but for what is made unit in silence: all users of normals,
    /// rotations and weights take them at any length.
    ///
    /// # Errors
    /// As [`Scene::validate`].
    pub(crate) fn sound(&self) -> Result<Sound<'_>, SceneDataError> {
        let found = self.check()?;
        let mut materials = Cow::Borrowed(&self.materials[..]);
        if materials.is_empty() {
            materials.to_mut().push(Material::default());
        }
        replace(&mut materials, found.materials);
        let mut lights = Cow::Borrowed(&self.lights[..]);
        replace(&mut lights, found.lights);
        let mut meshes: Vec<_> = self.meshes.iter().map(Cow::Borrowed).collect();
        for (i, blemishes) in found.meshes {
            mesh::repair(meshes[i].to_mut(), blemishes);
        }
        Ok(Sound {
            nodes: &self.nodes,
            skins: &self.skins,
            textures: &self.textures,
            materials,
            meshes,
            lighting: Lighting {
                lights,
                warnings: found.light_warnings,
            },
            warnings: found.warnings,
        })
    }

    /// The lights alone, with the nodes and clips that place them and the emission of what the nodes draw. Vertices are
    /// not looked at, so that this takes no time worth speaking of.
    ///
    /// # Errors
    /// As [`Scene::validate`].
    pub(crate) fn sound_lighting(&self) -> Result<Lighting<'_>, SceneDataError> {
        let mut unused = Vec::new();
        self.check_materials(&mut unused)?;
        mesh::materials_exist(&self.meshes, self.material_count())?;
        hierarchy::nodes(
            &self.nodes,
            self.meshes.len(),
            self.skins.len(),
            &mut unused,
        )?;
        motion::animations(&self.animations, self.nodes.len(), &mut unused)?;
        let mut warnings = Vec::new();
        let repaired = surface::lights(&self.lights, self.nodes.len(), &mut warnings)?;
        let mut lights = Cow::Borrowed(&self.lights[..]);
        replace(&mut lights, repaired);
        Ok(Lighting { lights, warnings })
    }

    fn check(&self) -> Result<Findings, SceneDataError> {
        let (mut warnings, mut light_warnings) = (Vec::new(), Vec::new());
        surface::textures(&self.textures)?;
        let materials = self.check_materials(&mut warnings)?;
        let meshes = mesh::meshes(&self.meshes, self.material_count(), &mut warnings)?;
        hierarchy::nodes(
            &self.nodes,
            self.meshes.len(),
            self.skins.len(),
            &mut warnings,
        )?;
        hierarchy::joints(&self.nodes, &self.meshes, &self.skins)?;
        hierarchy::skins(&self.skins, self.nodes.len())?;
        motion::animations(&self.animations, self.nodes.len(), &mut warnings)?;
        let lights = surface::lights(&self.lights, self.nodes.len(), &mut light_warnings)?;
        hierarchy::cameras(&self.cameras, self.nodes.len())?;
        Ok(Findings {
            materials,
            meshes,
            lights,
            warnings,
            light_warnings,
        })
    }

    fn check_materials(
        &self,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<(usize, Material)>, SceneDataError> {
        surface::materials(&self.materials, self.textures.len(), warnings)
    }

    /// With the white one that a scene without materials gets.
    fn material_count(&self) -> usize {
        self.materials.len().max(1)
    }
}

fn put<T>(list: &mut [T], repaired: Vec<(usize, T)>) {
    for (i, value) in repaired {
        list[i] = value;
    }
}

/// As [`put`], without a copy where there is nothing to put.
fn replace<T: Clone>(list: &mut Cow<'_, [T]>, repaired: Vec<(usize, T)>) {
    if !repaired.is_empty() {
        put(list.to_mut(), repaired);
    }
}

/// `mesh 3 "wall"`, or `mesh 3` without a name.
pub(crate) fn label(kind: &str, index: usize, name: &str) -> String {
    if name.is_empty() {
        format!("{kind} {index}")
    } else {
        format!("{kind} {index} {name:?}")
    }
}

/// An index checked against the length of its list; the element is named only where the check fails.
fn check_index(
    element: impl FnOnce() -> String,
    what: &'static str,
    index: u32,
    count: usize,
) -> Result<(), SceneDataError> {
    if (index as usize) < count {
        return Ok(());
    }
    Err(SceneDataError::Index {
        element: element(),
        what,
        index: index.into(),
        count,
    })
}

/// An error for a number that cannot be repaired.
fn bad_value(
    element: String,
    what: impl Into<String>,
    value: impl ToString,
    expected: &'static str,
) -> SceneDataError {
    SceneDataError::Value {
        element,
        what: what.into(),
        value: value.to_string(),
        expected,
    }
}

/// Light must be finite and not negative, and leave room for sums.
fn check_radiance(
    element: impl FnOnce() -> String,
    what: &str,
    v: Vec3,
) -> Result<(), SceneDataError> {
    if v.is_finite() && v.min_element() >= 0.0 && v.max_element() <= MOST_RADIANCE {
        return Ok(());
    }
    Err(bad_value(
        element(),
        what,
        v,
        "finite, not negative and at most 1e13",
    ))
}

/// A point or extent must be finite.
fn check_finite(
    element: impl FnOnce() -> String,
    what: &str,
    v: DVec3,
) -> Result<(), SceneDataError> {
    if v.is_finite() {
        return Ok(());
    }
    Err(bad_value(element(), what, v, "finite"))
}

/// How often one kind of repair happened, and where first.
#[derive(Default)]
struct Tally {
    count: usize,
    first: Option<String>,
}

impl Tally {
    fn add(&mut self, count: usize, place: impl FnOnce() -> String) {
        if count > 0 {
            self.count += count;
            self.first.get_or_insert_with(place);
        }
    }

    /// One warning, if anything was counted: `3 triangles without area were dropped (first in mesh 0)`.
    fn report(self, one: &str, many: &str, repair: &str, warnings: &mut Vec<String>) {
        if let Some(first) = self.first {
            let what = if self.count == 1 { one } else { many };
            warnings.push(format!("{} {what} {repair} (first in {first})", self.count));
        }
    }
}
