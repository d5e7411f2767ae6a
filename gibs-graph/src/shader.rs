//! What a graph asks of a shader compiler.
use crate::{GraphError, KernelSource, Port};

/// Composes, validates and reflects device kernels. `gibs-shaders` has one made with naga.
pub trait ShaderCompiler {
    /// Holds the kernel of `stage` against its ports: every global has a port and the reverse, access, layouts and
    /// workgroup size agree.
    ///
    /// # Errors
    /// Every mismatch, as [`GraphError::Shader`].
    fn check(
        &self,
        stage: &str,
        kernel: &KernelSource,
        ports: &[Port],
    ) -> Result<(), Vec<GraphError>>;
}
