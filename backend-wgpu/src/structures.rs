//! Acceleration structures, built from the triangles and the instances that the host uploads.
//!
//! Top levels stay for as long as the executable, so that bind groups hold. A bottom level that was built again is a new
//! object; wgpu keeps an old one for as long as work that was submitted needs it.
use crate::buffers::Parity;
use crate::context::{Context, said};
use crate::stores::Stores;
use gibs_graph::{
    AccelerationSource, AccelerationTriangle, BackendError, BottomLevel, ResourceId, Schedule,
};
use wgpu::AccelerationStructureFlags as Flags;
use wgpu::AccelerationStructureGeometryFlags as GeometryFlags;

/// Corners of a triangle.
const CORNERS: u32 = 3;
/// Bytes between corners.
const STRIDE: u64 = (size_of::<AccelerationTriangle>() / CORNERS as usize) as u64;

/// Those of a schedule.
#[derive(Default)]
pub(crate) struct Structures(Vec<Structure>);

struct Structure {
    source: AccelerationSource,
    top: wgpu::Tlas,
    /// Bottom levels that are to be built with it.
    waiting: Vec<(
        wgpu::Blas,
        wgpu::BlasTriangleGeometrySizeDescriptor,
        BottomLevel,
    )>,
}

impl Structures {
    /// Makes those of `schedule`, which the device allows, with the instances of `old` that it adopts.
    pub fn new(
        context: &Context,
        schedule: &Schedule,
        old: Option<(&Self, &Schedule)>,
    ) -> Result<Self, BackendError> {
        let make = |mut source: AccelerationSource| {
            if let Some((old, before)) = old {
                for (from, to) in schedule.adoptions(before) {
                    let adopted = old.find(from).filter(|_| to == source.resource);
                    if let Some(adopted) = adopted {
                        source.adopt(&adopted.source);
                    }
                }
            }
            let resource = &schedule.resources[source.resource as usize];
            let descriptor = wgpu::CreateTlasDescriptor {
                label: Some(&resource.key),
                max_instances: source.len() as u32,
                flags: Flags::PREFER_FAST_TRACE,
                update_mode: wgpu::AccelerationStructureUpdateMode::Build,
            };
            let top = context.guard(|| context.device.create_tlas(&descriptor))?;
            Ok(Structure {
                source,
                top,
                waiting: Vec::new(),
            })
        };
        let sources = AccelerationSource::all(schedule);
        sources
            .into_iter()
            .map(make)
            .collect::<Result<_, _>>()
            .map(Self)
    }

    fn find(&self, resource: ResourceId) -> Option<&Structure> {
        self.0.iter().find(|s| s.source.resource == resource)
    }

    /// What stages bind.
    pub fn top(&self, resource: ResourceId) -> Option<&wgpu::Tlas> {
        self.find(resource).map(|structure| &structure.top)
    }

    /// The instances that were uploaded; `None` for any other resource.
    pub fn read(&self, resource: ResourceId) -> Option<Vec<u8>> {
        let found = self.find(resource)?;
        Some(found.source.bytes().to_vec())
    }

    /// Takes notice of an upload, and keeps it where it is one of instances: whether it is.
    pub fn write(&mut self, resource: ResourceId, offset: u64, bytes: &[u8]) -> bool {
        let mut taken = false;
        for Structure { source, .. } in &mut self.0 {
            taken |= source.uploaded(resource, offset, bytes);
        }
        taken
    }

    /// Whether structures are built from the memory of a resource.
    pub fn uses(&self, resource: ResourceId) -> bool {
        self.0.iter().any(|s| s.source.is_of(resource))
    }

    /// Makes the bottom levels of what has to be built anew, and fills the top levels in. What cannot be built fails
    /// here, before anything is recorded.
    pub fn prepare(&mut self, context: &Context) -> Result<(), BackendError> {
        let stale = self.0.iter_mut().filter(|structure| structure.source.stale);
        for structure in stale {
            let plan = structure.source.plan()?;
            let made = context.guard_as(
                || {
                    let bottoms = plan.bottoms.iter().map(|b| bottom(context, b));
                    bottoms.collect::<Vec<_>>()
                },
                |error| out_of_memory(context, plan.bottoms.len(), &error),
            )?;
            let len = structure.source.len();
            let places = structure.top.get_mut_slice(0..len).unwrap_or_default();
            places.fill(None);
            for (place, (instance, bottom)) in places.iter_mut().zip(&plan.instances) {
                let rows = AccelerationSource::rows(instance);
                let (blas, ..) = &made[*bottom];
                *place = Some(wgpu::TlasInstance::new(blas, rows, instance.custom, 0xff));
            }
            structure.waiting = made;
        }
        Ok(())
    }

    /// Records the builds that [`Structures::prepare`] made ready. Within [`Context::guard`].
    pub fn record(&mut self, stores: &Stores, encoder: &mut wgpu::CommandEncoder) {
        for Structure {
            source,
            top,
            waiting,
        } in &mut self.0
        {
            let Some(corners) = stores.current(source.triangles, Parity::default()) else {
                continue;
            };
            if !source.stale {
                continue;
            }
            let entries: Vec<_> = waiting
                .iter()
                .map(|(blas, size, bottom)| wgpu::BlasBuildEntry {
                    blas,
                    geometry: wgpu::BlasGeometries::TriangleGeometries(vec![
                        wgpu::BlasTriangleGeometry {
                            size,
                            vertex_buffer: corners,
                            first_vertex: CORNERS * bottom.first,
                            vertex_stride: STRIDE,
                            index_buffer: None,
                            first_index: None,
                            transform_buffer: None,
                            transform_buffer_offset: None,
                        },
                    ]),
                })
                .collect();
            encoder.build_acceleration_structures(&entries, [&*top]);
            drop(entries);
            waiting.clear();
            source.stale = false;
        }
    }
}

fn bottom(
    context: &Context,
    bottom: &BottomLevel,
) -> (
    wgpu::Blas,
    wgpu::BlasTriangleGeometrySizeDescriptor,
    BottomLevel,
) {
    let size = wgpu::BlasTriangleGeometrySizeDescriptor {
        vertex_format: wgpu::VertexFormat::Float32x3,
        vertex_count: CORNERS * bottom.count,
        index_format: None,
        index_count: None,
        flags: match bottom.opaque {
            true => GeometryFlags::OPAQUE,
            // The kernel counts what it is asked about as hits, and twice is as good as once.
            false => GeometryFlags::empty(),
        },
    };
    let descriptor = wgpu::CreateBlasDescriptor {
        label: Some("bottom level"),
        flags: Flags::PREFER_FAST_TRACE,
        update_mode: wgpu::AccelerationStructureUpdateMode::Build,
    };
    let sizes = wgpu::BlasGeometrySizeDescriptors::Triangles {
        descriptors: vec![size.clone()],
    };
    let made = context.device.create_blas(&descriptor, sizes);
    (made, size, *bottom)
}

fn out_of_memory(context: &Context, bottoms: usize, error: &wgpu::Error) -> BackendError {
    match error {
        wgpu::Error::OutOfMemory { .. } => BackendError::Refused {
            what: format!("building an acceleration structure of {bottoms} bottom levels"),
            reason: format!("the device `{}` is out of memory", context.info.name),
            remedy: "trace without ray queries, or use a smaller scene".into(),
        },
        other => context.failed(&said(other)),
    }
}
