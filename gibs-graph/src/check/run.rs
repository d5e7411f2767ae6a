//! What the kit does with cases: compare backends on them, or record what one makes of them.
use super::case::distinct;
use super::lockstep::Lockstep;
use super::report::{Lane, Report};
use super::{Capture, Case, CheckError, Participant};
use crate::DispatchStep;

/// What is checked how.
#[derive(Clone, Debug, Default)]
pub struct CheckOptions {
    /// Report only steps and stages of which the name contains this.
    pub stage: Option<String>,
    /// Pairs of participants that have to be equal to the bit wherever elements have an order.
    pub exact: Vec<(String, String)>,
    /// Most captures of differences to keep.
    pub captures: usize,
}

/// What a check gives.
#[derive(Debug)]
pub struct Checked {
    /// What was found.
    pub report: Report,
    /// The first difference of each step that has one, as far as was asked for.
    pub captures: Vec<Capture>,
}

/// Runs the frames of each case on all participants and holds every pair of them against each other after every step. The first one is
/// the oracle: all go on from its values, and it tells what a rounding decides. `progress` hears of finished frames of a
/// case.
///
/// # Errors
/// [`CheckError::TooFew`], [`CheckError::Same`], [`CheckError::Mislabelled`]; [`CheckError::Shared`];
/// [`CheckError::NoStage`]; [`CheckError::Backend`] and [`CheckError::Feed`] of what failed on the way. A difference is none.
pub fn check(
    cases: &mut [Case<'_>],
    participants: &[Participant<'_>],
    options: &CheckOptions,
    mut progress: impl FnMut(&str, u32, u32),
) -> Result<Checked, CheckError> {
    distinct(participants)?;
    let lanes = participants.iter().map(|p| Lane {
        name: p.name.into(),
        device: p.backend.device().clone(),
    });
    let mut checked = Checked {
        report: Report {
            version: env!("CARGO_PKG_VERSION"),
            lanes: lanes.collect(),
            cases: Vec::new(),
        },
        captures: Vec::new(),
    };
    for case in cases.iter_mut() {
        case.keeps_transients()?;
        let mut run = Lockstep::new(case, participants, options)?;
        let frames = case.frames.clone();
        for (done, &frame) in (1..).zip(&frames) {
            run.skip_to(case, frame)?;
            run.frame(case, frame, &mut checked.captures, &mut |_, _| false)?;
            progress(&case.name, done, frames.len() as u32);
        }
        checked.report.cases.push(run.report);
    }
    if let Some(stage) = &options.stage
        && checked
            .report
            .cases
            .iter()
            .all(|case| case.steps.is_empty())
    {
        let names: Vec<_> = cases.iter().map(|case| case.name.as_str()).collect();
        return Err(CheckError::NoStage {
            case: names.join("`, `"),
            stage: stage.clone(),
        });
    }
    Ok(checked)
}

/// Runs a case up to a frame on one backend, and captures the steps of that frame that are `wanted`, by their names, with
/// what it made of them.
///
/// # Errors
/// As [`check`].
pub fn record(
    case: &mut Case<'_>,
    participant: Participant<'_>,
    frame: u32,
    mut wanted: impl FnMut(&str, &DispatchStep) -> bool,
) -> Result<Vec<Capture>, CheckError> {
    case.keeps_transients()?;
    let (participants, options) = ([participant], CheckOptions::default());
    let mut run = Lockstep::new(case, &participants, &options)?;
    let mut captures = Vec::new();
    run.skip_to(case, frame)?;
    run.frame(case, frame, &mut captures, &mut wanted)?;
    Ok(captures)
}
