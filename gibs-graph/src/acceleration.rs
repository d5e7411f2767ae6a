//! Acceleration structures: what a host says of one, and what backends make of that.
//!
//! A structure is an input of [`AccelerationInstance`]s over another one of triangles, so that it is uploaded, adopted
//! and captured like any other. A backend whose device traces rays builds it from the two whenever one was written; the
//! CPU kernels of a stage see the instances, and trace rays without it.
use crate::{BackendError, Resource, ResourceId, Schedule};
use glam::Vec4;

/// The three corners of a triangle: x, y and z of each.
pub type AccelerationTriangle = [f32; 9];

crate::element! {
    /// Triangles placed in the world, 64 bytes.
    pub struct AccelerationInstance {
        /// Rows of the affine map from the space of the triangles to that of rays; `w` is the translation.
        to_world: [Vec4; 3],
        /// First triangle. Instances of the same triangles share a bottom level.
        first: u32,
        /// Number of triangles; an instance without is left out.
        count: u32,
        /// What rays find as the instance's custom index; 24 bits.
        custom: u32,
        /// [`AccelerationInstance::ASKS`].
        flags: u32,
    }
}

impl AccelerationInstance {
    /// Flag: rays ask the kernel about each hit with one of the triangles (they are not opaque).
    pub const ASKS: u32 = 1;
    /// Largest [`AccelerationInstance::custom`].
    pub const MOST_CUSTOM: u32 = (1 << 24) - 1;
}

/// Triangles that make up a bottom level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BottomLevel {
    /// First triangle.
    pub first: u32,
    /// Number of triangles, at least one.
    pub count: u32,
    /// Rays need not ask the kernel about hits.
    pub opaque: bool,
}

/// What a structure is to be built from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AccelerationPlan {
    /// Each bottom level once.
    pub bottoms: Vec<BottomLevel>,
    /// The instances that are not left out, each with the index of its bottom level.
    pub instances: Vec<(AccelerationInstance, usize)>,
}

/// A structure as a backend keeps it on the host: its instances, and whether it has to be built anew.
#[derive(Clone, Debug)]
pub struct AccelerationSource {
    /// Resource of the structure.
    pub resource: ResourceId,
    /// Resource of its triangles.
    pub triangles: ResourceId,
    /// Something was written since it was built, or it never was.
    pub stale: bool,
    key: String,
    /// Number of triangles.
    room: u64,
    instances: Vec<AccelerationInstance>,
}

impl AccelerationSource {
    /// Those of a schedule, without triangles.
    pub fn all(schedule: &Schedule) -> Vec<Self> {
        let of = |(resource, found): (ResourceId, &Resource)| {
            let triangles = found.triangles?;
            Some(Self {
                resource,
                triangles,
                stale: true,
                key: found.key.clone(),
                room: schedule.resources[triangles as usize].len,
                instances: vec![AccelerationInstance::default(); found.len as usize],
            })
        };
        (0..).zip(&schedule.resources).filter_map(of).collect()
    }

    /// Takes over the instances of one with the same length.
    pub fn adopt(&mut self, old: &Self) {
        self.instances.clone_from(&old.instances);
        self.stale = true;
    }

    /// Takes notice of bytes that are uploaded to a resource from `offset` on, which are within it: keeps those of instances,
    /// and says whether they are.
    pub fn uploaded(&mut self, resource: ResourceId, offset: u64, bytes: &[u8]) -> bool {
        let is_own = resource == self.resource;
        if is_own {
            self.write(offset, bytes);
        }
        self.stale |= resource == self.triangles;
        is_own
    }

    /// Whether the structure is built from a resource.
    pub fn is_of(&self, resource: ResourceId) -> bool {
        resource == self.resource || resource == self.triangles
    }

    fn write(&mut self, offset: u64, bytes: &[u8]) {
        let held: &mut [u8] = bytemuck::cast_slice_mut(&mut self.instances);
        let start = offset as usize;
        if let Some(place) = held.get_mut(start..start.saturating_add(bytes.len())) {
            place.copy_from_slice(bytes);
        }
        self.stale = true;
    }

    /// The bytes of the instances.
    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.instances)
    }

    /// Number of instances, of which some may be left out.
    pub fn len(&self) -> usize {
        self.instances.len()
    }

    /// There are no instances.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// What to build, and in which order.
    ///
    /// # Errors
    /// [`BackendError::Refused`] for an instance of triangles that are not there, with a custom index of more than 24 bits, or
    /// with a transform that is not finite.
    pub fn plan(&self) -> Result<AccelerationPlan, BackendError> {
        let mut plan = AccelerationPlan::default();
        let mut known = std::collections::HashMap::new();
        for (i, instance) in self.instances.iter().enumerate() {
            if instance.count == 0 {
                continue;
            }
            self.check(i, instance)?;
            let bottom = BottomLevel {
                first: instance.first,
                count: instance.count,
                opaque: instance.flags & AccelerationInstance::ASKS == 0,
            };
            let key = (bottom.first, bottom.count, bottom.opaque);
            let index = *known.entry(key).or_insert_with(|| {
                plan.bottoms.push(bottom);
                plan.bottoms.len() - 1
            });
            plan.instances.push((*instance, index));
        }
        Ok(plan)
    }

    fn check(&self, i: usize, instance: &AccelerationInstance) -> Result<(), BackendError> {
        let refuse = |reason: String, remedy: &str| {
            Err(BackendError::Refused {
                what: format!("instance {i} of `{}`", self.key),
                reason,
                remedy: remedy.into(),
            })
        };
        let end = u64::from(instance.first) + u64::from(instance.count);
        if end > self.room {
            return refuse(
                format!("its triangles end at {end}, there are {}", self.room),
                "name triangles that are there",
            );
        }
        if instance.custom > AccelerationInstance::MOST_CUSTOM {
            return refuse(
                format!("its custom index is {}", instance.custom),
                "use at most 24 bits",
            );
        }
        if !instance.to_world.iter().all(|row| row.is_finite()) {
            return refuse(
                "its transform is not finite".into(),
                "leave it out with a count of 0",
            );
        }
        Ok(())
    }

    /// The rows of an instance's transform, one after the other.
    pub fn rows(instance: &AccelerationInstance) -> [f32; 12] {
        bytemuck::cast(instance.to_world)
    }
}
