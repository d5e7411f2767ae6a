//! From a recorded graph to a schedule, as one numbered procedure.
mod dag;
mod hazards;
mod layout;
mod share;
mod validate;

use crate::schedule::Output;
use crate::{Graph, GraphError, GraphErrors, Schedule, ShaderCompiler};
use std::collections::HashSet;

impl Graph {
    /// Compiles the frame. With `shaders`, every live device kernel is held against its ports first; a program with
    /// the CPU backend alone may leave that out.
    ///
    /// # Errors
    /// Everything that is wrong, at once.
    pub fn compile(
        mut self,
        shaders: Option<&dyn ShaderCompiler>,
    ) -> Result<Schedule, GraphErrors> {
        // 1. Validate what was recorded.
        let mut errors = std::mem::take(&mut self.errors);
        validate::validate(&self, &mut errors);
        // 2. Make the DAG: a node per stage, an edge per dependency.
        let dag = dag::dependencies(&self.stages, self.resources.len());
        // 3. Traverse from the outputs; what is not reached is dead.
        let live = dag::live_stages(&self, &dag);
        // 4. Order: topological, ties by insertion.
        let order = dag::order(&self.stages, &dag, &live, &mut errors);
        // 5. Hold the live device kernels against their ports.
        if let Some(shaders) = shaders {
            check_shaders(&self, &order, shaders, &mut errors);
        }
        if !errors.is_empty() {
            return Err(GraphErrors {
                graph: self.name,
                errors,
            });
        }
        // 6. Place resources: the ones that live stages touch.
        let (mut resources, place) = layout::place_resources(&self, &order);
        // 7. Lay out steps, each clear right before the first use of its resource.
        let mut steps = layout::lay_out(&self, &order, &resources, &place);
        let outputs: Vec<Output> = self
            .outputs
            .iter()
            .filter_map(|o| {
                Some(Output {
                    name: o.name.clone(),
                    resource: *place.get(&o.resource)?,
                })
            })
            .collect();
        // 8. Find hazards; barriers only where one is.
        let mut edges = hazards::find_hazards(&mut steps, &resources);
        if self.shares {
            // 9. Let transients share memory where their lifetimes do not meet, and find the hazards of that.
            let mut outlives = vec![false; resources.len()];
            for output in &outputs {
                outlives[output.resource as usize] = true;
            }
            share::share(&steps, &mut resources, &outlives);
            edges = hazards::find_hazards(&mut steps, &resources);
        }
        let dead = self.stages.iter().zip(&live).filter(|(_, live)| !**live);
        let removed = dead.map(|(stage, _)| stage.label.clone()).collect();
        Ok(Schedule {
            name: self.name,
            resources,
            steps,
            outputs,
            removed,
            edges,
        })
    }
}

/// Stages of one type with the same ports have one kernel, so the first of each speaks for all.
fn check_shaders(
    graph: &Graph,
    order: &[usize],
    shaders: &dyn ShaderCompiler,
    errors: &mut Vec<GraphError>,
) {
    let mut seen = HashSet::new();
    for &i in order {
        let stage = &graph.stages[i];
        let absent: Vec<_> = stage.absent.iter().map(|(_, port)| port.clone()).collect();
        let names: Vec<_> = absent.iter().map(|port| port.name).collect();
        if seen.insert((stage.kernel.wgsl.name, stage.stage, names))
            && let Err(found) = shaders.check(&stage.label, &stage.kernel, &stage.ports, &absent)
        {
            errors.extend(found);
        }
    }
}
