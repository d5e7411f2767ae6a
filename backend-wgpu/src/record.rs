//! Steps as commands.
use crate::buffers::Parity;
use crate::steps::{Dispatch, Step};
use crate::stores::Stores;
use crate::timing::Timer;
use gibs_graph::DispatchSize;

/// What commands are made from: bound steps, and the memory as one frame sees it.
pub(crate) struct Recorder<'a> {
    pub stores: &'a Stores,
    pub parity: Parity,
    /// Times the steps, if there is one.
    pub timer: Option<&'a Timer>,
}

impl Recorder<'_> {
    /// Records steps in order.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, steps: &[Step]) {
        let apart = self.timer.is_some_and(Timer::splits_passes);
        let together =
            |a: &Step, b: &Step| !apart && matches!((a, b), (Step::Dispatch(_), Step::Dispatch(_)));
        if let Some((queries, query)) = self.timer.and_then(Timer::start) {
            encoder.write_timestamp(queries, query);
        }
        for run in steps.chunk_by(together) {
            self.run(encoder, run);
        }
    }

    /// Records either one clear, or dispatches in one pass.
    fn run(&self, encoder: &mut wgpu::CommandEncoder, run: &[Step]) {
        match run {
            [] => {}
            [
                Step::Clear {
                    step,
                    resource,
                    bytes,
                },
                ..,
            ] => {
                if let Some(buffer) = self.stores.current(*resource, self.parity) {
                    encoder.clear_buffer(buffer, 0, Some(bytes.next_multiple_of(4)));
                }
                if let Some((queries, query)) = self.end(*step) {
                    encoder.write_timestamp(queries, query);
                }
            }
            [Step::Dispatch(first), ..] => {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(&first.label),
                    timestamp_writes: self.timer.and_then(|timer| timer.writes(first.step)),
                });
                for step in run {
                    if let Step::Dispatch(dispatch) = step {
                        self.dispatch(&mut pass, dispatch);
                        if let Some((queries, query)) = self.end(dispatch.step) {
                            pass.write_timestamp(queries, query);
                        }
                    }
                }
            }
        }
    }

    /// The query that the end of a step is written to.
    fn end(&self, step: usize) -> Option<(&wgpu::QuerySet, u32)> {
        self.timer?.end(step)
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, dispatch: &Dispatch) {
        if matches!(dispatch.size, DispatchSize::Groups(groups) if groups.contains(&0)) {
            return;
        }
        let Some(group) = dispatch.group(self.parity) else {
            return;
        };
        pass.set_pipeline(&dispatch.kernel.pipeline);
        pass.set_bind_group(0, group, &[]);
        match dispatch.size {
            DispatchSize::Groups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            DispatchSize::Indirect(args) => {
                if let Some(args) = self.stores.current(args, self.parity) {
                    pass.dispatch_workgroups_indirect(args, 0);
                }
            }
            // Refused when the steps were built.
            _ => {}
        }
    }
}
