//! What pictures are held against: a truth of a file, of the cache, or path-traced with a bar.
use super::work::Work;
use crate::bench::{AboutTruth, Look, Target, Truth, TruthCache};
use crate::cli::CommandError;
use crate::cli::compare::noise_of;
use crate::cli::output::{progress, warning};
use crate::cli::run::elsewhere;
use crate::compare::CompareOptions;
use gibs_graph::Backend;

/// What the pictures of a scene are held against.
pub struct Held {
    pub truth: Truth,
    pub about: AboutTruth,
    /// A picture to look at, where there is a report.
    pub look: Option<Look>,
}

impl Held {
    /// Of a scene: one for all backends, so that its noise is the same for all. The first one path-traces it.
    pub fn of(work: &Work<'_>, scene: usize, first: &dyn Backend) -> Result<Self, CommandError> {
        let Work { args, cache, .. } = *work;
        let (name, loaded) = (&args.scenes[scene], &work.scenes[scene]);
        let of_first = work.target(scene, first);
        let truth = match work.truth {
            Some(truth) => truth.clone(),
            None => path_trace(&of_first, args.spp, cache)?,
        };
        let mask = truth.check(name)?;
        let mut about = AboutTruth {
            file: args.truth.as_ref().map(|path| path.display().to_string()),
            step: truth.step(),
            samples: truth.samples,
            standard_error: truth.standard_error,
            noise: None,
            mask,
            elsewhere: None,
        };
        if let Some(path) = &args.truth {
            about.elsewhere = elsewhere(first, loaded, truth.picture(), path)?;
            if let Some([half_a, half_b]) = args.halves.as_deref() {
                let options = CompareOptions::default();
                let noise = noise_of([half_a, half_b], truth.picture(), path, &options)?;
                // Of halves that are none it is nothing.
                about.noise = (!noise.doubted).then_some(noise.errors);
            }
        }
        let look = match args.report {
            Some(_) => Some(look(&truth, &of_first, args.spp, cache)?),
            None => None,
        };
        Ok(Self { truth, about, look })
    }
}

/// The truth of a target, path-traced or of the cache.
fn path_trace(
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
fn look(
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
