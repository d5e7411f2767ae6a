//! What a graph asks of a shader compiler.
use crate::{GraphError, KernelSource, Port};

/// Composes, validates and reflects device kernels. `gibs-shaders` has one made with naga.
pub trait ShaderCompiler {
    /// Holds the kernel of `stage` against the ports that are bound: every global has a port and the reverse, access,
    /// layouts and workgroup size agree. `absent` has the optional ports that are not bound.
    ///
    /// # Errors
    /// Every mismatch, as [`GraphError::Shader`].
    fn check(
        &self,
        stage: &str,
        kernel: &KernelSource,
        ports: &[Port],
        absent: &[Port],
    ) -> Result<(), Vec<GraphError>>;
}
