//! What can be wrong with a kernel.
use crate::compose::ComposeError;
use crate::validate::WgslError;
use thiserror::Error;

/// A kernel that cannot be compiled. Messages carry the original file, line and column.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShaderError {
    /// Imports, conditions or names.
    #[error(transparent)]
    Compose(#[from] ComposeError),
    /// naga rejects the composed text.
    #[error("{kernel}: {source}")]
    Wgsl {
        /// Name of the kernel.
        kernel: String,
        /// What naga says.
        source: WgslError,
    },
    /// An `override` has no value.
    #[error("{kernel}: {message}; give every `override` a default value")]
    Override {
        /// Name of the kernel.
        kernel: String,
        /// What naga says.
        message: String,
    },
    /// SPIR-V cannot be written.
    #[error("{kernel}: no SPIR-V {}.{}: {message}", version.0, version.1)]
    Spirv {
        /// Name of the kernel.
        kernel: String,
        /// Version that was asked for.
        version: (u8, u8),
        /// What naga says.
        message: String,
    },
}
