//! Ports: how a stage touches a resource.
use crate::{Comparator, ImageFormat, Layout};
use serde::{Deserialize, Serialize};

/// One port of a stage. Everything else about the binding follows from it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Port {
    /// Name, also that of the WGSL global.
    pub name: &'static str,
    /// How it is touched.
    pub access: Access,
    /// Type of one element; of an image, of one value.
    pub element: Layout,
    /// What an image's texels are; `None` for a buffer.
    pub image: Option<ImageFormat>,
    /// Only some frames bind it; where one does, its name is a feature of the device kernel.
    pub optional: bool,
    /// How what the stage writes is compared between backends.
    pub comparator: Comparator,
}

/// How a stage touches a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Access {
    /// First element, through `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`, only written. Elements that the stage leaves out keep what they held, so a write
    /// goes after the writes before it and needs them.
    Write,
    /// `var<storage, read_write>`, read and written.
    ReadWrite,
    /// `var<storage, read_write>` of atomics, which workgroups may contend for.
    Atomic,
    /// The value of the frame before, `var<storage, read>`.
    Previous,
    /// Seen by the wide CPU kernel only; no device binding exists.
    HostOnly,
    /// What rays are traced in, `acceleration_structure`.
    Acceleration,
    /// An image that is read, `texture_2d`.
    Sampled,
    /// An image that is written, `texture_storage_2d<_, write>`. As for [`Access::Write`], what is left out stays.
    Stored,
    /// Sizes of an indirect dispatch; not a binding.
    Indirect,
}

impl Port {
    /// A port; [`stage!`](crate::stage!) makes them.
    pub fn new(
        name: &'static str,
        access: Access,
        element: Layout,
        image: Option<ImageFormat>,
        optional: bool,
    ) -> Self {
        Self {
            name,
            access,
            element,
            image,
            optional,
            comparator: Comparator::ROUNDING,
        }
    }

    /// The same, compared in another way.
    pub fn compared(self, comparator: Comparator) -> Self {
        Self { comparator, ..self }
    }
}

impl Access {
    /// The stage makes a new version of the resource.
    pub fn writes(self) -> bool {
        matches!(
            self,
            Access::Write | Access::ReadWrite | Access::Atomic | Access::Stored
        )
    }

    /// The stage depends on what is there.
    pub fn reads(self) -> bool {
        !matches!(self, Access::Write | Access::Stored)
    }

    /// It is an image.
    pub fn is_image(self) -> bool {
        matches!(self, Access::Sampled | Access::Stored)
    }

    /// The stage's device kernel has a global for it.
    pub fn is_bound(self) -> bool {
        !matches!(self, Access::HostOnly | Access::Indirect)
    }
}
