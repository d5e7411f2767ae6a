//! Kernels that are held against ports, and what is wrong with them.
use crate::Compiler;
use gibs_graph::{GraphError, KernelSource, Port, ShaderCompiler, Stage, WgslSource};

mod graph;
mod kernel;
mod ports;

gibs_graph::element! {
    /// Sixteen bytes.
    pub struct Ray {
        /// Start.
        origin: glam::Vec3,
        /// Least distance.
        t_min: f32,
    }
    /// A struct within a struct.
    pub struct Pair {
        /// One.
        ray: Ray,
        /// Four columns.
        frame: [glam::Vec4; 4],
        /// Numbers.
        list: [u32; 4],
    }
}

const GOOD: &str = "struct Ray { origin: vec3<f32>, t_min: f32 }
struct Pair { ray: Ray, frame: mat4x4<f32>, list: array<u32, 4> }
@group(0) @binding(0) var<uniform> view: Ray;
@group(0) @binding(1) var<storage, read> rays: array<Pair>;
@group(0) @binding(2) var<storage, read> before: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> target_: array<u32>;
@group(0) @binding(4) var<storage, read_write> both: array<f32>;
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
fn helper(i: u32) { both[i] += rays[i].ray.t_min * before[i].x; }
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    helper(id.x);
    target_[id.x] = atomicAdd(&counts[0], u32(view.t_min));
}
";

mod good {
    use super::{Pair, Ray};

    gibs_graph::stage! {
        /// Has a port of every kind.
        pub stage Good {
            wgsl: gibs_graph::WgslSource { name: "good", text: super::GOOD, modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: {
                uniform view: Ray,
                read rays: Pair,
                previous before: glam::Vec2,
                write target: u32,
                read_write both: f32,
                atomic counts: u32,
                host_only tree: u32,
            },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}
use good::Good;

fn check(text: String, ports: &[Port]) -> Vec<String> {
    let wgsl = WgslSource {
        text: text.leak(),
        ..Good::kernel().wgsl
    };
    let found = Compiler::new().check(
        "stage",
        &KernelSource {
            wgsl,
            ..Good::kernel()
        },
        ports,
        &[],
    );
    let describe = |error| match error {
        GraphError::Shader {
            stage,
            port,
            message,
        } => {
            assert_eq!(stage, "stage");
            format!("{}: {message}", port.unwrap_or_default())
        }
        other => panic!("{other}"),
    };
    found
        .err()
        .unwrap_or_default()
        .into_iter()
        .map(describe)
        .collect()
}
