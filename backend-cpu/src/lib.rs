//! Runs gibs schedules on the processor: the CPU kernel of every stage, workgroups in parallel.
//!
//! The scalar kernels are the oracle that devices are compared with; where a stage has a wide kernel with the same
//! result, that one runs unless [`Options::scalar`] asks for the oracle.
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]
mod dispatch;
mod executable;
mod memory;
mod order;
mod shares;
mod system;

pub use dispatch::in_kernel;

use gibs_graph::{
    Backend, BackendError, Capabilities, DeviceInfo, Executable, MAX_GROUPS, Schedule,
};
use std::sync::Arc;

/// How the backend runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Threads; `None` for all that rayon finds.
    pub threads: Option<usize>,
    /// Run the scalar kernels even where a wide one exists.
    pub scalar: bool,
    /// Check that no two workgroups write one element, nor one workgroup an element of what a stage only writes twice, and run
    /// workgroups in a shuffled order.
    pub checked: bool,
}

/// The processor as a backend.
///
/// Of its [`Capabilities`], `memory` is what the system had available when it was made, or the limit of the process's
/// control group where that is less.
#[derive(Debug)]
pub struct CpuBackend {
    shared: Arc<Shared>,
}

/// What a backend and its executables have in common.
#[derive(Debug)]
struct Shared {
    options: Options,
    pool: rayon::ThreadPool,
    device: DeviceInfo,
    capabilities: Capabilities,
}

impl CpuBackend {
    /// Starts the threads.
    ///
    /// # Errors
    /// [`BackendError::Unavailable`] if threads cannot be started.
    pub fn new(options: Options) -> Result<Self, BackendError> {
        let threads = options.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("gibs-cpu-{i}"))
            .build()
            .map_err(|error| BackendError::Unavailable {
                backend: "cpu".into(),
                reason: format!("{threads} threads could not be started: {error}"),
                remedy: "ask for fewer threads".into(),
            })?;
        let device = DeviceInfo {
            name: processor_name(),
            driver: format!("gibs {}", env!("CARGO_PKG_VERSION")),
            kind: "cpu".into(),
            timestamps: true,
            ray_query: false,
            notes: vec![
                format!("{} threads", pool.current_num_threads()),
                simd(options).into(),
            ],
        };
        let mut capabilities = Capabilities::unlimited();
        capabilities.workgroups = [MAX_GROUPS; 3];
        capabilities.memory = system::memory();
        capabilities.host_data = true;
        Ok(Self {
            shared: Arc::new(Shared {
                options,
                pool,
                device,
                capabilities,
            }),
        })
    }
}

impl Backend for CpuBackend {
    fn name(&self) -> &str {
        "cpu"
    }

    fn device(&self) -> &DeviceInfo {
        &self.shared.device
    }

    fn capabilities(&self) -> &Capabilities {
        &self.shared.capabilities
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        Ok(Box::new(executable::CpuExecutable::new(
            schedule,
            Arc::clone(&self.shared),
        )?))
    }
}

fn processor_name() -> String {
    std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_string())
        })
        .unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH))
}

/// Which kernels run. Stages decide by themselves, with the features that go together since 2013, and those of AVX-512 that do
/// since 2019.
fn simd(options: Options) -> &'static str {
    if options.scalar {
        return "scalar kernels";
    }
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2")
        && std::arch::is_x86_feature_detected!("fma")
        && std::arch::is_x86_feature_detected!("bmi1")
        && std::arch::is_x86_feature_detected!("bmi2")
        && std::arch::is_x86_feature_detected!("lzcnt")
        && std::arch::is_x86_feature_detected!("popcnt")
    {
        let sixteen = std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512bw")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512vnni");
        return match sixteen {
            true => "8-wide kernels (AVX2), 16-wide lists (AVX-512)",
            false => "8-wide kernels (AVX2)",
        };
    }
    "portable kernels"
}
