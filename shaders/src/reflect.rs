//! What a kernel binds, and how it uses that.
use crate::compiler::Inner;
use crate::compose::Place;
use crate::layout;
use gibs_graph::{ImageFormat, Layout};
use naga::valid::GlobalUse;
use naga::{
    AddressSpace, ArraySize, ImageClass, ImageDimension, ScalarKind, StorageAccess, StorageFormat,
    TypeInner,
};

/// A resource that a kernel declares.
#[derive(Debug)]
pub(crate) struct Global {
    pub name: String,
    pub place: Place,
    pub group: u32,
    pub binding: u32,
    pub space: Space,
    pub shape: Shape,
    pub used: Used,
}

/// How a resource is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`.
    ReadWrite,
    /// An image of this format.
    Image(ImageFormat),
    /// What rays are traced in.
    Acceleration,
    /// Anything that no port can be.
    Other,
}

impl Space {
    pub fn wgsl(self) -> &'static str {
        match self {
            Space::Image(ImageFormat::Float) => "var _: texture_2d<f32>",
            Space::Image(ImageFormat::Uint) => "var _: texture_2d<u32>",
            Space::Image(ImageFormat::Rgba16Float) => {
                "var _: texture_storage_2d<rgba16float, write>"
            }
            Space::Image(ImageFormat::Rgba32Float) => {
                "var _: texture_storage_2d<rgba32float, write>"
            }
            Space::Image(ImageFormat::Rgba8Unorm) => "var _: texture_storage_2d<rgba8unorm, write>",
            Space::Image(_) => "var _: texture",
            Space::Uniform => "var<uniform>",
            Space::Read => "var<storage, read>",
            Space::ReadWrite => "var<storage, read_write>",
            Space::Acceleration => "var _: acceleration_structure",
            Space::Other => "var",
        }
    }
}

/// What a resource holds. An element that no port can have comes with the reason.
#[derive(Debug)]
pub(crate) enum Shape {
    /// One value.
    One(Result<Layout, String>),
    /// As many as the buffer is long, `stride` bytes apart.
    Many {
        element: Result<Layout, String>,
        stride: u32,
        atomic: bool,
    },
}

/// How the entry point and all that it calls use a resource.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Used {
    /// At all, if only for its length.
    pub any: bool,
    /// Its contents are loaded. A read-modify-write atomic counts, too.
    pub read: bool,
    /// Its contents are stored. A read-modify-write atomic counts, too.
    pub write: bool,
}

/// All resources, in the order of their bindings.
pub(crate) fn globals(kernel: &Inner) -> Vec<Global> {
    let module = &kernel.module;
    let uses = kernel.info.get_entry_point(0);
    let mut globals: Vec<Global> = module
        .global_variables
        .iter()
        .filter_map(|(handle, global)| {
            let slot = global.binding?;
            let used = uses[handle];
            let space = match global.space {
                AddressSpace::Uniform => Space::Uniform,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                    Space::ReadWrite
                }
                AddressSpace::Storage { .. } => Space::Read,
                _ => match module.types[global.ty].inner {
                    TypeInner::AccelerationStructure { .. } => Space::Acceleration,
                    _ => image(module, global.ty).map_or(Space::Other, Space::Image),
                },
            };
            Some(Global {
                name: global.name.clone().unwrap_or_default(),
                place: kernel.place(handle),
                group: slot.group,
                binding: slot.binding,
                space,
                shape: shape(module, global.ty),
                // naga reports an atomic on a buffer as what it does, so as both; `ATOMIC` is for images.
                used: Used {
                    any: !used.is_empty(),
                    // A query of an acceleration structure is what reading is of a buffer.
                    read: used.contains(GlobalUse::READ)
                        || matches!(
                            module.types[global.ty].inner,
                            TypeInner::AccelerationStructure { .. }
                        ) && !used.is_empty(),
                    write: used.contains(GlobalUse::WRITE),
                },
            })
        })
        .collect();
    globals.sort_by_key(|g| (g.group, g.binding));
    globals
}

/// The format of an image that a port can have.
fn image(module: &naga::Module, ty: naga::Handle<naga::Type>) -> Option<ImageFormat> {
    let TypeInner::Image {
        dim: ImageDimension::D2,
        arrayed: false,
        class,
    } = module.types[ty].inner
    else {
        return None;
    };
    match class {
        ImageClass::Sampled {
            kind: ScalarKind::Float,
            multi: false,
        } => Some(ImageFormat::Float),
        ImageClass::Sampled {
            kind: ScalarKind::Uint,
            multi: false,
        } => Some(ImageFormat::Uint),
        ImageClass::Storage { format, access } if access == StorageAccess::STORE => match format {
            StorageFormat::Rgba16Float => Some(ImageFormat::Rgba16Float),
            StorageFormat::Rgba32Float => Some(ImageFormat::Rgba32Float),
            StorageFormat::Rgba8Unorm => Some(ImageFormat::Rgba8Unorm),
            _ => None,
        },
        _ => None,
    }
}

fn shape(module: &naga::Module, ty: naga::Handle<naga::Type>) -> Shape {
    let TypeInner::Array {
        base,
        size: ArraySize::Dynamic,
        stride,
    } = module.types[ty].inner
    else {
        return Shape::One(layout::reflect(module, ty));
    };
    match module.types[base].inner {
        TypeInner::Atomic(number) => Shape::Many {
            element: layout::scalar(number).map(Layout::Scalar),
            stride,
            atomic: true,
        },
        _ => Shape::Many {
            element: layout::reflect(module, base),
            stride,
            atomic: false,
        },
    }
}

/// Bytes of workgroup memory that the entry point and all that it calls use.
pub(crate) fn workgroup_memory(kernel: &Inner) -> u64 {
    let module = &kernel.module;
    let uses = kernel.info.get_entry_point(0);
    let shared = module.global_variables.iter().filter(|(handle, global)| {
        global.space == AddressSpace::WorkGroup && !uses[*handle].is_empty()
    });
    // WebGPU rounds every variable up to 16 bytes.
    let size = |ty| {
        u64::from(
            module.types[ty]
                .inner
                .try_size(module.to_ctx())
                .unwrap_or(u32::MAX),
        )
    };
    shared
        .map(|(_, global)| size(global.ty).next_multiple_of(16))
        .sum()
}
