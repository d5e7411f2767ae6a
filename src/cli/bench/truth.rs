//! Path tracing truths, with a bar.
use crate::bench::{Look, Target, Truth, TruthCache};
use crate::cli::CommandError;
use crate::cli::output::{progress, warning};

/// The truth of a target, path-traced or of the cache.
pub fn path_trace(
    target: &Target<'_>,
    samples: u32,
    cache: Option<&TruthCache>,
) -> Result<Truth, CommandError> {
    let (bar, heard) = tracing(samples, "path tracing the truth");
    let truth = Truth::render(target, samples, cache, heard);
    bar.finish_and_clear();
    let truth = truth?;
    if let Some(warning) = &truth.warning {
        warning!("{warning}");
    }
    Ok(truth)
}

/// Its picture to look at.
pub fn look(
    truth: &Truth,
    target: &Target<'_>,
    samples: u32,
    cache: Option<&TruthCache>,
) -> Result<Look, CommandError> {
    let (bar, heard) = tracing(samples, "path tracing its picture");
    let look = truth.look(target, samples, cache, heard);
    bar.finish_and_clear();
    let look = look?;
    if let Some(warning) = &look.warning {
        warning!("{warning}");
    }
    Ok(look)
}

/// A bar for path tracing, and what moves it.
fn tracing(samples: u32, what: &'static str) -> (indicatif::ProgressBar, impl FnMut(u32, u32)) {
    // How many segments paths have is not known before; three per sample is usual.
    let bar = progress(u64::from(samples) * 3, what);
    let own = bar.clone();
    (bar, move |frames, _| {
        own.set_length(own.length().unwrap_or(0).max(u64::from(frames)));
        own.set_position(u64::from(frames));
    })
}
