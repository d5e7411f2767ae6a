//! Holds a kernel against the ports of its stage.
use crate::reflect::{self, Global, Shape, Space, Used};
use crate::{CompiledKernel, Compiler, layout, names};
use gibs_graph::{Access, GraphError, KernelSource, Layout, Port, Scalar, ShaderCompiler};

/// What WebGPU guarantees.
const MAX_STORAGE_BUFFERS: usize = 8;
const MAX_UNIFORM_BUFFERS: usize = 12;
const MAX_SAMPLED_TEXTURES: usize = 16;
const MAX_STORAGE_TEXTURES: usize = 4;
const MAX_INVOCATIONS: u64 = 256;
const MAX_DEPTH: u32 = 64;
const MAX_WORKGROUP_MEMORY: u64 = 16384;

impl ShaderCompiler for Compiler {
    fn check(
        &self,
        stage: &str,
        kernel: &KernelSource,
        ports: &[Port],
        absent: &[Port],
    ) -> Result<(), Vec<GraphError>> {
        let mut report = Report {
            stage,
            errors: Vec::new(),
        };
        match self.compile(&kernel.wgsl, ports) {
            Ok(compiled) => report.kernel(&compiled, kernel.workgroup, ports, absent),
            Err(error) => report.add(None, error.to_string()),
        }
        if report.errors.is_empty() {
            Ok(())
        } else {
            Err(report.errors)
        }
    }
}

struct Report<'a> {
    stage: &'a str,
    errors: Vec<GraphError>,
}

impl Report<'_> {
    fn add(&mut self, port: Option<&str>, message: String) {
        self.errors.push(GraphError::Shader {
            stage: self.stage.into(),
            port: port.map(Into::into),
            message,
        });
    }

    fn at(&mut self, global: &Global, port: Option<&str>, message: impl AsRef<str>) {
        self.add(port, format!("{}: {}", global.place, message.as_ref()));
    }

    fn kernel(
        &mut self,
        kernel: &CompiledKernel,
        workgroup: [u32; 3],
        ports: &[Port],
        absent: &[Port],
    ) {
        let globals = reflect::globals(&kernel.inner);
        let mut claimed = vec![false; globals.len()];
        for port in ports.iter().filter(|p| p.access.is_bound()) {
            let name = names::global(port.name);
            match globals.iter().position(|g| g.name == name) {
                Some(index) => {
                    claimed[index] = true;
                    self.port(port, &globals[index]);
                }
                None => self.add(
                    Some(port.name),
                    format!(
                        "{}.wgsl: there is no global `{name}`; declare it, or remove the port",
                        kernel.inner.name
                    ),
                ),
            }
        }
        for (global, _) in globals
            .iter()
            .zip(&claimed)
            .filter(|(_, claimed)| !**claimed)
        {
            let hidden = ports
                .iter()
                .chain(absent)
                .find(|p| names::global(p.name) == global.name);
            self.at(
                global,
                None,
                match hidden {
                    Some(port) if port.optional => format!(
                        "port `{0}` is not bound here; put `@if({0})` before the global and what uses it",
                        port.name
                    ),
                    Some(port) => format!(
                        "port `{}` is not seen by devices, so no global may have its name",
                        port.name
                    ),
                    None => format!(
                        "no port is called `{}`; add one, or remove the global",
                        global.name
                    ),
                },
            );
        }
        self.bindings(&globals, absent);
        self.limits(kernel, workgroup, &globals);
    }

    fn port(&mut self, port: &Port, global: &Global) {
        let name = Some(port.name);
        let want = match port.access {
            Access::Sampled | Access::Stored => match port.image {
                Some(format) => Space::Image(format),
                None => Space::Other,
            },
            Access::Uniform => Space::Uniform,
            Access::Acceleration => Space::Acceleration,
            Access::Read | Access::Previous => Space::Read,
            _ => Space::ReadWrite,
        };
        let fits = want == global.space;
        if !fits {
            let message = match global.space {
                Space::Other => format!("no port can be this; the port needs `{}`", want.wgsl()),
                space => format!(
                    "declared `{}`, but the port needs `{}`",
                    space.wgsl(),
                    want.wgsl()
                ),
            };
            self.at(global, name, message);
        }
        if !global.used.any {
            self.at(
                global,
                name,
                "declared but not used by `main`; use it, or remove it and the port",
            );
        } else if fits && let Some(message) = unfit(port.access, global.used) {
            self.at(global, name, message);
        }
        let has_elements = |s| !matches!(s, Space::Other | Space::Image(_) | Space::Acceleration);
        if has_elements(global.space) && has_elements(want) {
            self.element(port, global);
        }
    }

    fn element(&mut self, port: &Port, global: &Global) {
        let name = Some(port.name);
        let element = match (&global.shape, port.access == Access::Uniform) {
            (Shape::One(element), true) => element,
            (
                Shape::Many {
                    element,
                    stride,
                    atomic,
                },
                false,
            ) => {
                self.atomic(port, global, *atomic);
                if matches!(element, Ok(layout) if layout.size() == port.element.size())
                    && *stride != port.element.size()
                {
                    let size = port.element.size();
                    let what = format!("elements are {size} bytes apart in Rust, {stride} in WGSL");
                    self.at(
                        global,
                        name,
                        format!("{what}; pad `{}` to {stride} bytes", port.element),
                    );
                }
                element
            }
            (Shape::One(_), false) => {
                return self.at(
                    global,
                    name,
                    format!("needs the type `array<{}>`", port.element),
                );
            }
            (Shape::Many { .. }, true) => {
                return self.at(global, name, format!("needs the type `{}`", port.element));
            }
        };
        match element {
            Ok(wgsl) => {
                for difference in layout::differences(&port.element, wgsl) {
                    self.at(global, name, difference);
                }
            }
            Err(reason) => self.at(global, name, reason),
        }
    }

    fn atomic(&mut self, port: &Port, global: &Global, atomic: bool) {
        let name = Some(port.name);
        match (port.access == Access::Atomic, atomic) {
            (true, false) => self.at(
                global,
                name,
                "the port is atomic; needs the type `array<atomic<u32>>`",
            ),
            (false, true) => self.at(
                global,
                name,
                "holds atomics; declare the port `atomic`, or use plain numbers",
            ),
            (true, true) if port.element != Layout::Scalar(Scalar::U32) => {
                self.at(
                    global,
                    name,
                    format!("atomics are of `u32`, not of `{}`", port.element),
                );
            }
            _ => {}
        }
    }

    /// Bindings are dense, but for the optional ports that are not bound.
    fn bindings(&mut self, globals: &[Global], absent: &[Port]) {
        let mut gaps = absent.iter().filter(|p| p.access.is_bound()).count() as u32;
        let mut next = 0;
        for global in globals {
            if global.group != 0 {
                self.at(
                    global,
                    None,
                    format!(
                        "`{}` is in group {}; use group 0",
                        global.name, global.group
                    ),
                );
                continue;
            }
            let skipped = global.binding.checked_sub(next);
            if let Some(skipped) = skipped.filter(|skipped| *skipped <= gaps) {
                gaps -= skipped;
            } else {
                let Global { name, binding, .. } = global;
                self.at(
                    global,
                    None,
                    format!("`{name}` has binding {binding}, but {next} comes next; leave no gaps"),
                );
            }
            next = global.binding.saturating_add(1);
        }
    }

    fn limits(&mut self, kernel: &CompiledKernel, want: [u32; 3], globals: &[Global]) {
        let file = format!("{}.wgsl", kernel.inner.name);
        let size = kernel.workgroup_size();
        if size != want {
            self.add(
                None,
                format!("{file}: `@workgroup_size` is {size:?}, but the stage declares {want:?}"),
            );
        }
        let invocations: u64 = size.iter().map(|n| u64::from(*n)).product();
        if invocations > MAX_INVOCATIONS || size[2] > MAX_DEPTH {
            let limit = format!("at most {MAX_INVOCATIONS} invocations, {MAX_DEPTH} along z");
            self.add(
                None,
                format!("{file}: a workgroup of {size:?} is too large; {limit}"),
            );
        }
        let memory = reflect::workgroup_memory(&kernel.inner);
        if memory > MAX_WORKGROUP_MEMORY {
            self.add(
                None,
                format!(
                    "{file}: {memory} bytes of workgroup memory; at most {MAX_WORKGROUP_MEMORY}"
                ),
            );
        }
        let count = |test: fn(Space) -> bool| globals.iter().filter(|g| test(g.space)).count();
        let storage = count(|s| matches!(s, Space::Read | Space::ReadWrite));
        if storage > MAX_STORAGE_BUFFERS {
            let remedy = "split the stage, or pack what is read together";
            self.add(
                None,
                format!(
                    "{file}: {storage} storage buffers; at most {MAX_STORAGE_BUFFERS}; {remedy}"
                ),
            );
        }
        let images = |stored: bool| {
            let is = |g: &&Global| matches!(g.space, Space::Image(f) if f.is_stored() == stored);
            globals.iter().filter(is).count()
        };
        for (what, count, most) in [
            ("sampled textures", images(false), MAX_SAMPLED_TEXTURES),
            ("storage textures", images(true), MAX_STORAGE_TEXTURES),
        ] {
            if count > most {
                self.add(
                    None,
                    format!("{file}: {count} {what}; at most {most}; split the stage"),
                );
            }
        }
        let uniforms = count(|s| s == Space::Uniform);
        if uniforms > MAX_UNIFORM_BUFFERS {
            self.add(
                None,
                format!("{file}: {uniforms} uniforms; at most {MAX_UNIFORM_BUFFERS}; join some"),
            );
        }
    }
}

/// Why a use does not fit the declared access. A port that declares more than is used makes false barriers.
fn unfit(access: Access, used: Used) -> Option<&'static str> {
    match (access, used.read, used.write) {
        (_, false, false) => {
            Some("only its length is used; pass that in a uniform and remove the port")
        }
        (Access::Write, true, _) => {
            Some("declared `write`, but also read; declare the port `read_write`")
        }
        (Access::ReadWrite, false, true) => {
            Some("over-declared: never read; declare the port `write`")
        }
        (Access::ReadWrite, true, false) => {
            Some("over-declared: never written; declare the port `read`")
        }
        (Access::Atomic, true, false) => {
            Some("over-declared: never written; declare the port `read`, of plain numbers")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
