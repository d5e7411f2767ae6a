//! What takes part in a check.
use super::Args;
use crate::backends::{self, Choice};
use crate::check::NotRun;
use crate::cli::CommandError;
use gibs_graph::{Backend, BackendError};

/// A way to run a backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The processor's scalar kernels, one by one the oracle.
    Scalar,
    /// The processor's kernels as they are used.
    Cpu,
    /// The same, with workgroups in another order and a map of who writes what.
    Checked,
    /// Vulkan through ash.
    Vulkan,
    /// wgpu.
    Wgpu,
}

pub const WAYS: [(&str, Way); 5] = [
    ("cpu-scalar", Way::Scalar),
    ("cpu", Way::Cpu),
    ("cpu-checked", Way::Checked),
    ("vulkan", Way::Vulkan),
    ("wgpu", Way::Wgpu),
];

impl std::str::FromStr for Way {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = WAYS.iter().find(|(known, _)| *known == name);
        found.map(|(_, way)| *way).ok_or_else(|| {
            let names: Vec<_> = WAYS.iter().map(|(name, _)| *name).collect();
            format!("choose of {}", names.join(", "))
        })
    }
}

impl Way {
    pub fn name(self) -> &'static str {
        let found = WAYS.iter().find(|(_, way)| *way == self);
        found.map_or("", |(name, _)| name)
    }

    /// Opens it; wgpu with the SPIR-V that Vulkan gets, where that is asked for.
    pub fn open(self, same_spirv: bool) -> Result<Box<dyn Backend>, BackendError> {
        match self {
            #[cfg(feature = "cpu")]
            Way::Scalar | Way::Checked => {
                let options = gibs_backend_cpu::Options {
                    threads: None,
                    scalar: self == Way::Scalar,
                    checked: self == Way::Checked,
                };
                Ok(Box::new(gibs_backend_cpu::CpuBackend::new(options)?))
            }
            #[cfg(not(feature = "cpu"))]
            Way::Scalar | Way::Checked => backends::open(Choice::Cpu),
            Way::Cpu => backends::open(Choice::Cpu),
            Way::Vulkan => backends::open(Choice::Vulkan),
            #[cfg(feature = "wgpu")]
            Way::Wgpu if same_spirv => {
                let options = gibs_backend_wgpu::Options {
                    same_spirv,
                    ..Default::default()
                };
                Ok(Box::new(gibs_backend_wgpu::WgpuBackend::new(options)?))
            }
            Way::Wgpu => {
                // Without the backend, what it would be given does not matter.
                let _ = same_spirv;
                backends::open(Choice::Wgpu)
            }
        }
    }
}

/// The participants, and what could not be had.
pub struct Opened {
    pub backends: Vec<(&'static str, Box<dyn Backend>)>,
    pub not_run: Vec<NotRun>,
    /// wgpu runs the SPIR-V that Vulkan gets.
    pub same_spirv: bool,
}

/// Opens the participants. One that was named has to be there; of those that nobody named, the others are left out.
pub fn open(args: &Args) -> Result<Opened, CommandError> {
    let named = |way| args.backends.is_empty() || args.backends.contains(&way);
    if args.same_spirv && !(named(Way::Vulkan) && named(Way::Wgpu)) {
        return Err(CommandError::SameWordsOfOne);
    }
    let usual = [Way::Scalar, Way::Cpu, Way::Vulkan, Way::Wgpu];
    let asked = match args.backends.is_empty() {
        true => &usual[..],
        false => &args.backends,
    };
    let mut opened = Opened {
        backends: Vec::new(),
        not_run: Vec::new(),
        same_spirv: args.same_spirv,
    };
    let missing = |name: &str, error: BackendError| NotRun {
        name: name.into(),
        reason: error.to_string(),
    };
    for &way in asked {
        let mut found = way.open(args.same_spirv);
        if let (Way::Wgpu, true, Err(_)) = (way, args.same_spirv, &found) {
            // Without that, it can still be compared as it usually runs.
            let plain = way.open(false);
            if let (Ok(_), Err(error)) = (&plain, found) {
                let name = "wgpu with the SPIR-V of vulkan";
                opened.not_run.push(missing(name, error));
                opened.same_spirv = false;
            }
            found = plain;
        }
        match found {
            Ok(backend) => opened.backends.push((way.name(), backend)),
            Err(error) if !args.backends.is_empty() => return Err(error.into()),
            Err(error) => opened.not_run.push(missing(way.name(), error)),
        }
    }
    let has = |name| opened.backends.iter().any(|(known, _)| *known == name);
    if opened.same_spirv && !(has("vulkan") && has("wgpu")) {
        opened.same_spirv = false;
        opened.not_run.push(NotRun {
            name: "wgpu with the SPIR-V of vulkan".into(),
            reason: "it takes both of them".into(),
        });
    }
    let device = |name| {
        let mut found = opened.backends.iter().filter(|(known, _)| *known == name);
        found.next().map(|(_, backend)| &backend.device().name)
    };
    if opened.same_spirv && device("vulkan") != device("wgpu") {
        let reason = "the two have chosen different devices".into();
        opened.same_spirv = false;
        opened.not_run.push(NotRun {
            name: "equal bits of vulkan and wgpu".into(),
            reason,
        });
    }
    Ok(opened)
}
