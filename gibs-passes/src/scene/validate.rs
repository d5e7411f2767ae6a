//! The gate that every scene passes before use: whatever comes after may index without checking.
//!
//! What breaks a promise of the scene types is an error; what has an obvious repair is repaired with one warning.
mod hierarchy;
mod mesh;
mod motion;
mod surface;

use super::{MOST_RADIANCE, Material, Scene};
use glam::{DVec3, Vec3};

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

impl Scene {
    /// Checks every promise of the scene's types and repairs what has an obvious repair; returns one warning per kind
    /// of repair. A second call on the result changes nothing and returns no warning.
    ///
    /// Repairs: without materials a white one is added; triangles without area are dropped; missing normals, rotations
    /// and skin weights are filled in; factors and cone angles are clamped to their range; normals, rotations and
    /// weights are made unit (silently, since rounding alone needs that).
    ///
    /// # Errors
    /// An index out of range, arrays whose lengths disagree, a number that is not finite or has no meaning (a negative
    /// light, say), a parent after its child. The scene may then be repaired in part.
    pub fn validate(&mut self) -> Result<Vec<String>, SceneDataError> {
        let mut warnings = Vec::new();
        if self.materials.is_empty() {
            self.materials.push(Material::default());
        }
        surface::textures(&self.textures)?;
        surface::materials(&mut self.materials, self.textures.len(), &mut warnings)?;
        mesh::meshes(&mut self.meshes, self.materials.len(), &mut warnings)?;
        hierarchy::nodes(&mut self.nodes, &self.meshes, &self.skins, &mut warnings)?;
        hierarchy::skins(&self.skins, self.nodes.len())?;
        motion::animations(&mut self.animations, self.nodes.len(), &mut warnings)?;
        surface::lights(&mut self.lights, self.nodes.len(), &mut warnings)?;
        hierarchy::cameras(&self.cameras, self.nodes.len())?;
        Ok(warnings)
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
