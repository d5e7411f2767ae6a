//! `gibs replay --reduce`: a smaller capture on which two backends still differ.
use super::Args;
use crate::check::{
    Capture, CaptureError, Comparison, Participant, Reduced, reduce, replay, verify,
};
use crate::cli::CommandError;
use crate::cli::output::progress;
use gibs_graph::{Backend, StageInfo};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A capture that has become smaller.
#[derive(Serialize)]
pub struct Shrunk {
    pub file: PathBuf,
    pub nonzero_bytes_before: u64,
    pub nonzero_bytes_after: u64,
    pub tried: u32,
}

/// Shrinks the capture as long as the backend differs from the other one.
pub fn shrink(
    args: &Args,
    file: &Path,
    capture: &Capture,
    stages: &[StageInfo],
    backend: &dyn Backend,
) -> Result<Shrunk, CommandError> {
    let other = args.against.open(false)?;
    let differ = |candidate: &Capture| -> Result<bool, CaptureError> {
        let expected = replay(candidate, stages, other.as_ref(), 1)?;
        let found = replay(candidate, stages, backend, 1)?;
        let ports = verify(
            candidate,
            &expected.schedule,
            &expected.outputs,
            &found.outputs,
        );
        Ok(ports
            .iter()
            .any(|(_, found): &(String, Comparison)| !found.refused.is_empty()))
    };
    if !differ(capture)? {
        return Err(CommandError::NothingToReduce {
            capture: args.capture.clone(),
            a: args.against.name(),
            b: args.backend.name(),
        });
    }
    let bar = progress(u64::from(args.tries), "candidates");
    let Reduced {
        mut capture,
        nonzero,
        tried,
    } = reduce(capture, args.tries, |candidate| {
        bar.inc(1);
        // A stage may be unable to run on zeros in place of, say, a tree; that is no smaller case of the difference.
        Ok::<_, CaptureError>(differ(candidate).unwrap_or(false))
    })?;
    bar.finish_and_clear();
    for (name, backend) in [
        (args.against.name(), other.as_ref()),
        (args.backend.name(), backend),
    ] {
        let outputs = replay(&capture, stages, backend, 1)?.outputs;
        capture.add_results(Participant::named(name, backend), outputs);
    }
    capture.write(file)?;
    Ok(Shrunk {
        file: file.into(),
        nonzero_bytes_before: nonzero[0],
        nonzero_bytes_after: nonzero[1],
        tried,
    })
}
