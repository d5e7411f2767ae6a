//! Finding a backend.
use gibs_graph::{Backend, BackendError, DeviceInfo};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Which backend to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Choice {
    /// The fastest that the machine offers.
    #[default]
    Auto,
    /// The processor.
    Cpu,
    /// wgpu.
    Wgpu,
    /// Vulkan through ash.
    Vulkan,
}

/// A backend of which there are no figures.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotRun {
    /// Its name.
    pub backend: String,
    /// Why, and what to do.
    pub reason: String,
}

/// Not the name of a backend.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("there is no backend `{0}`; choose auto, cpu, wgpu or vulkan")]
pub struct UnknownBackend(pub String);

impl FromStr for Choice {
    type Err = UnknownBackend;

    fn from_str(name: &str) -> Result<Self, UnknownBackend> {
        match name {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "wgpu" => Ok(Self::Wgpu),
            "vulkan" => Ok(Self::Vulkan),
            _ => Err(UnknownBackend(name.into())),
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Wgpu => "wgpu",
            Self::Vulkan => "vulkan",
        })
    }
}

/// The backends that this build has, in the order in which `auto` prefers equals.
pub const BUILT: &[Choice] = &[
    #[cfg(feature = "vulkan")]
    Choice::Vulkan,
    #[cfg(feature = "wgpu")]
    Choice::Wgpu,
    #[cfg(feature = "cpu")]
    Choice::Cpu,
];

/// Opens a backend on its best device.
///
/// # Errors
/// [`BackendError::Unavailable`] where the backend is not built in or the machine lacks what it needs.
pub fn open(choice: Choice) -> Result<Box<dyn Backend>, BackendError> {
    match choice {
        Choice::Auto => auto(),
        #[cfg(feature = "cpu")]
        Choice::Cpu => Ok(Box::new(gibs_backend_cpu::CpuBackend::new(
            gibs_backend_cpu::Options::default(),
        )?)),
        #[cfg(feature = "wgpu")]
        Choice::Wgpu => Ok(Box::new(gibs_backend_wgpu::WgpuBackend::new(
            gibs_backend_wgpu::Options::default(),
        )?)),
        #[cfg(feature = "vulkan")]
        Choice::Vulkan => Ok(Box::new(gibs_backend_vulkan::VulkanBackend::new(
            gibs_backend_vulkan::Options::default(),
        )?)),
        #[allow(unreachable_patterns, reason = "reached where a feature is off")]
        missing => Err(BackendError::Unavailable {
            backend: missing.to_string(),
            reason: "this program was built without it".into(),
            remedy: format!("build with `--features {missing}`"),
        }),
    }
}

/// A GPU before the processor, the processor before a driver that only imitates a GPU on it.
fn auto() -> Result<Box<dyn Backend>, BackendError> {
    let mut best: Option<Box<dyn Backend>> = None;
    let mut last = None;
    for &choice in BUILT {
        match open(choice) {
            Ok(found)
                if best
                    .as_ref()
                    .is_none_or(|b| rank(found.device()) > rank(b.device())) =>
            {
                best = Some(found)
            }
            Ok(_) => {}
            Err(error) => last = Some(error),
        }
    }
    best.ok_or_else(|| {
        last.unwrap_or_else(|| BackendError::Unavailable {
            backend: "auto".into(),
            reason: "this program was built without any backend".into(),
            remedy: "build with `--features cpu`".into(),
        })
    })
}

fn rank(device: &DeviceInfo) -> u32 {
    match device.kind.as_str() {
        "discrete" => 4,
        "integrated" => 3,
        "virtual" => 2,
        "cpu" => 1,
        _ => 0,
    }
}
