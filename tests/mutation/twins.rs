//! Mutants against the twin tests: a change in a shared function, made in the small stages that run it beside its Rust twin.
use crate::generate::Kernel;
use crate::suite::declare::Twin;
use crate::suite::{families, run};
use gibs::graph::{Action, Backend, BackendError, Schedule, WgslSource, bytemuck};
use gibs_shaders::Compiler;
use std::sync::Arc;

/// The twins, with what the Rust functions make of their cases.
pub struct Twins(Vec<Entry>);

struct Entry {
    twin: Twin,
    /// The stage whose kernel is changed: the first.
    stage: &'static str,
    kernel: Kernel,
    schedule: Schedule,
    cases: Vec<u32>,
    expected: Vec<u32>,
}

impl Twins {
    /// All twins, run on the oracle.
    pub fn new(oracle: &dyn Backend) -> Result<Self, Box<dyn std::error::Error>> {
        let compiler = Compiler::new();
        let mut entries = Vec::new();
        for twin in families().into_iter().flat_map(|(_, twins)| twins) {
            let schedule = (twin.graph)(twin.cases).compile(None)?;
            let Some((_, _, dispatch)) = schedule.dispatches().next() else {
                continue;
            };
            let compiled = compiler.compile(&dispatch.kernel.wgsl, &dispatch.ports)?;
            let kernel = Kernel::new(compiled.wgsl())?;
            let cases = run::cases(&twin);
            entries.push(Entry {
                expected: run::run(&twin, oracle, &cases),
                stage: dispatch.kernel.wgsl.name,
                kernel,
                schedule,
                cases,
                twin,
            });
        }
        Ok(Self(entries))
    }

    /// Whether a twin test fails when the n-th change of a function of a kernel is made. What a stage does itself is tried where
    /// the twin test runs that very stage.
    pub fn catch(&self, of: &Kernel, function: &str, ordinal: usize, device: &dyn Backend) -> bool {
        let concerned = self.0.iter().filter_map(|entry| {
            if function == "main" && entry.kernel.source() != of.source() {
                return None;
            }
            let index = entry.kernel.index_of(function, ordinal)?;
            Some((entry, entry.kernel.mutant(index).ok()?))
        });
        let mut concerned = concerned;
        concerned.any(|(entry, mutant)| match entry.run(&mutant.text, device) {
            Ok(got) => {
                let found = run::compare(&entry.twin, &entry.cases, &entry.expected, &got);
                !found.fits(&entry.twin.bound, true)
            }
            Err(_) => true,
        })
    }
}

impl Entry {
    /// What the device makes of the cases with another kernel.
    fn run(&self, text: &str, device: &dyn Backend) -> Result<Vec<u32>, BackendError> {
        let mut schedule = self.schedule.clone();
        for step in &mut schedule.steps {
            if let Action::Dispatch(dispatch) = &mut step.action
                && dispatch.kernel.wgsl.name == self.stage
            {
                dispatch.kernel.wgsl = WgslSource {
                    name: self.stage,
                    // As for mutants of stages: a tool that ends.
                    text: String::leak(text.to_owned()),
                    modules: &[],
                    features: &[],
                };
            }
        }
        let (source, target) = (schedule.resource("source"), schedule.output("target"));
        let globals: Vec<_> = self
            .twin
            .globals
            .iter()
            .map(|(key, bytes)| (schedule.resource(key), bytes))
            .collect();
        let mut exec = device.prepare(Arc::new(schedule))?;
        if let Some(source) = source {
            exec.upload(source, 0, bytemuck::cast_slice(&self.cases))?;
        }
        for (id, bytes) in globals {
            if let Some(id) = id {
                exec.upload(id, 0, bytes)?;
            }
        }
        exec.run()?;
        match target {
            Some(target) => Ok(bytemuck::pod_collect_to_vec(&exec.read(target)?)),
            None => Ok(Vec::new()),
        }
    }
}
