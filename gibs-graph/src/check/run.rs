//! What the kit does with cases: compare backends on them, or record what one makes of them.
use super::case::distinct;
use super::lockstep::Lockstep;
use super::near::near;
use super::report::{Lane, Report};
use super::{Capture, Case, CheckError, Participant};
use crate::{Action, DispatchStep, Step};

/// What is checked how.
#[derive(Clone, Debug, Default)]
pub struct CheckOptions {
    /// Report only steps and stages of which the name contains this.
    pub stage: Option<String>,
    /// Pairs of participants that have to be equal to the bit wherever elements have an order.
    pub exact: Vec<(String, String)>,
    /// Most captures of differences to keep.
    pub captures: usize,
    /// Capture steps and stages of which the name contains this, also where all agree.
    pub capture: Option<String>,
    /// Most captures of those to keep.
    pub captured: usize,
}

/// What a check gives.
#[derive(Debug)]
pub struct Checked {
    /// What was found.
    pub report: Report,
    /// The first difference of each step that has one, as far as was asked for.
    pub captures: Vec<Capture>,
    /// The steps that [`CheckOptions::capture`] names, of the frames that were compared, case by case; with what all
    /// participants made of them.
    pub asked: Vec<Capture>,
    /// There would have been more of those.
    pub asked_more: bool,
}

/// Captures on the way.
#[derive(Default)]
pub(crate) struct Captures {
    /// Of differences.
    pub differing: Vec<Capture>,
    /// Of steps that were asked for.
    pub wanted: Vec<Capture>,
}

/// Whether a step of this name, of a stage of this type, is one that was asked for.
fn is_named(wanted: &str, label: &str, stage: &str) -> bool {
    label.contains(wanted) || stage.contains(wanted)
}

/// Name of a step and type of its stage, which a clear has none of.
fn names(step: &Step) -> [&str; 2] {
    match &step.action {
        Action::Dispatch(dispatch) => [&step.label, dispatch.stage],
        Action::Clear(_) => [&step.label, ""],
    }
}

/// Refuses a name that no step has, before anything has run. `clears` are steps too, but run no kernel.
fn expect_step(
    cases: &[Case<'_>],
    wanted: Option<&String>,
    clears: bool,
) -> Result<(), CheckError> {
    let Some(wanted) = wanted else {
        return Ok(());
    };
    let steps = || {
        cases
            .iter()
            .flat_map(|case| &case.schedule.steps)
            .map(names)
            .filter(|[_, stage]| clears || !stage.is_empty())
    };
    if steps().any(|[label, stage]| is_named(wanted, label, stage)) {
        return Ok(());
    }
    let known = steps().flatten();
    Err(CheckError::NoStage {
        near: near(wanted, known),
        stage: wanted.clone(),
    })
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
    expect_step(cases, options.stage.as_ref(), true)?;
    expect_step(cases, options.capture.as_ref(), false)?;
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
        asked: Vec::new(),
        asked_more: false,
    };
    let mut captures = Captures::default();
    let mut count = 0;
    let mut wanted = |label: &str, dispatch: &DispatchStep| {
        let named = options.capture.as_deref();
        let named = named.is_some_and(|wanted| is_named(wanted, label, dispatch.stage));
        count += usize::from(named);
        named && count <= options.captured
    };
    for case in cases.iter_mut() {
        case.keeps_transients()?;
        let mut run = Lockstep::new(case, participants, options)?;
        let frames = case.frames.clone();
        for (done, &frame) in (1..).zip(&frames) {
            run.skip_to(case, frame)?;
            run.frame(case, frame, &mut captures, &mut wanted)?;
            progress(&case.name, done, frames.len() as u32);
        }
        checked.report.cases.push(run.report);
    }
    checked.asked_more = count > options.captured;
    (checked.captures, checked.asked) = (captures.differing, captures.wanted);
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
    let mut captures = Captures::default();
    run.skip_to(case, frame)?;
    run.frame(case, frame, &mut captures, &mut wanted)?;
    Ok(captures.wanted)
}
