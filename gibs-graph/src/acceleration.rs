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

    /// Replaces bytes of the instances from `offset` on, which are within them.
    pub fn write(&mut self, offset: u64, bytes: &[u8]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dispatch, Graph, WgslSource, Workgroup, stage};

    stage! {
        /// Traces.
        pub stage Trace {
            wgsl: WgslSource { name: "trace", text: "", modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: { optional_acceleration structure: AccelerationInstance, write hits: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: Workgroup) {}

    fn source() -> (Schedule, AccelerationSource) {
        let mut g = Graph::new("traced");
        let structure = g.acceleration("scene", 10, 3);
        let inputs = Inputs {
            structure: Some(&structure),
            hits: g.transient("hits", 64),
        };
        let out = g.add::<Trace>("trace", inputs, Dispatch::Elements(64));
        g.output("hits", &out.hits);
        let schedule = g.compile(None).unwrap();
        let source = AccelerationSource::all(&schedule).remove(0);
        (schedule, source)
    }

    fn instance(first: u32, count: u32) -> AccelerationInstance {
        AccelerationInstance {
            first,
            count,
            ..AccelerationInstance::default()
        }
    }

    #[test]
    fn a_structure_brings_its_triangles_into_the_schedule() {
        let (schedule, source) = source();
        let [structure, triangles] =
            [source.resource, source.triangles].map(|id| &schedule.resources[id as usize]);
        assert_eq!(
            (&*structure.key, &*triangles.key),
            ("scene", "scene_triangles")
        );
        assert!(structure.usage.acceleration && triangles.usage.triangles);
        assert_eq!((structure.len, triangles.len), (3, 10));
        assert!(
            schedule.to_text().contains("q:scene"),
            "{}",
            schedule.to_text()
        );
        let features = schedule.dispatches().next().unwrap().2.features();
        assert_eq!(features, ["structure", "RAY_QUERY"]);
    }

    #[test]
    fn instances_of_the_same_triangles_share_a_bottom_level() {
        let (_, mut source) = source();
        let given = [instance(4, 6), instance(0, 0), instance(4, 6)];
        source.write(0, bytemuck::cast_slice(&given));
        let plan = source.plan().unwrap();
        let bottom = BottomLevel {
            first: 4,
            count: 6,
            opaque: true,
        };
        assert_eq!(plan.bottoms, [bottom]);
        assert_eq!(plan.instances, [(given[0], 0), (given[2], 0)]);
        assert_eq!(source.bytes(), bytemuck::cast_slice::<_, u8>(&given));
    }

    #[test]
    fn what_cannot_be_built_is_refused() {
        let (_, mut source) = source();
        let wide = AccelerationInstance {
            custom: 1 << 24,
            ..instance(0, 1)
        };
        let mut endless = instance(0, 1);
        endless.to_world[1].w = f32::INFINITY;
        for (given, says) in [
            (instance(9, 2), "end at 11, there are 10"),
            (wide, "24 bits"),
            (endless, "not finite"),
        ] {
            source.write(64, bytemuck::bytes_of(&given));
            let error = source.plan().unwrap_err().to_string();
            assert!(
                error.contains("instance 1") && error.contains(says),
                "{error}"
            );
        }
    }

    #[test]
    fn a_device_without_ray_queries_refuses_it_and_says_what_to_do() {
        let (schedule, _) = source();
        let error = crate::Capabilities::webgpu().check("GPU", &schedule);
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains("stage `trace`") && error.contains("ray_queries=off"),
            "{error}"
        );
        assert!(
            crate::Capabilities::unlimited()
                .check("CPU", &schedule)
                .is_ok()
        );
    }
}
