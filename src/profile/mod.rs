//! Time, work and memory of every stage of the frame.
mod against;
mod beside;
mod error;
mod measure;
mod memory;
mod savings;
mod statistics;
mod table;
#[cfg(test)]
mod tests;
mod trace;
mod work;

pub use against::{Change, Comparison, Verdict, compare};
pub use beside::beside;
pub use error::ProfileError;
pub use measure::{Options, Progress, measure};
pub use savings::{Saving, savings};
pub use statistics::{Figure, Interval};
pub(crate) use table::signed_bytes;
pub use table::{comparison_table, saving_table, table};
pub use trace::{TimedFrame, chrome_trace};

use crate::Counters;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Version of the file format; others are refused.
pub const FORMAT: u32 = 4;

/// What was measured on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Version of the program.
    pub version: String,
    /// The scene, as it was asked for.
    pub scene: String,
    /// How it is seen, as in a view file.
    pub view: serde_json::Value,
    /// Backend.
    pub backend: String,
    /// Device behind it.
    pub device: String,
    /// Its driver and version.
    pub driver: String,
    /// What else tells about the backend: threads, kernels.
    pub notes: Vec<String>,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Every setting.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Runs, each from an empty cache.
    pub runs: u32,
    /// Seed of the first run's random numbers.
    pub seed: u32,
    /// Measured frames of each run.
    pub frames: u32,
    /// Frames of each run before the measured ones.
    pub warm_up: u32,
    /// The frame as a whole.
    pub frame: FrameCost,
    /// Memory.
    pub memory: MemoryCost,
    /// Surfels and rays after the last frame.
    pub counters: Counters,
    /// The groups of the frame, in the order in which they first run.
    pub groups: Vec<Cost>,
    /// The stages of each group, as often as each runs in a frame taken together.
    pub stages: Vec<StageCost>,
    /// Every step of the frame, in order.
    pub steps: Vec<StageCost>,
}

/// What a frame takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameCost {
    /// From the first upload until the device is done, milliseconds on the host's clock, while steps are not timed.
    pub wall_ms: Figure,
    /// The same while steps are timed.
    pub timed_ms: Figure,
    /// Time of all steps together, milliseconds; `None` where the device measures none.
    pub steps_ms: Option<Figure>,
    /// Time of those steps that trace rays, milliseconds.
    pub tracing_ms: Option<Figure>,
    /// The steps' share of the frame that they are of, in the median over frames; the rest is uploads, submission and waiting.
    pub covered: Option<f64>,
    /// A frame over its steps that trace rays, in the median over frames.
    pub over_tracing: Option<f64>,
    /// Time of a frame whose steps are timed over that of one whose steps are not: frames took turns.
    pub overhead: Interval,
}

/// Time that something takes in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// What.
    pub name: String,
    /// Milliseconds; `None` where the device measures none.
    pub ms: Option<Figure>,
    /// Its share of all steps' time, of medians; 0 where there is none.
    pub share: f64,
}

/// A stage or a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageCost {
    /// Group of the frame, as the talk has them.
    pub group: String,
    /// Time; the name is that of the schedule, of a stage without the group and the number of the repetition.
    #[serde(flatten)]
    pub cost: Cost,
    /// How often it runs in a frame.
    pub times: u32,
    /// What it does in one frame, the last.
    #[serde(flatten)]
    pub work: Work,
}

/// What a step does in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Invocations that are dispatched: workgroups times their size.
    pub invocations: u64,
    /// Elements that the step is for, where a count on the device says so: invocations beyond do nothing.
    pub items: Option<u64>,
    /// Rays that it traces.
    pub rays: u64,
    /// Bytes of what it may read: all of every buffer and image that it binds for reading. What is read more than once
    /// counts once, and what the kernel skips counts too.
    pub bytes_read: u64,
    /// Bytes of what it may write, in the same sense.
    pub bytes_written: u64,
    /// Bytes of memory that are there because of it: of everything that it is the first to write, whether others share
    /// the memory or not.
    pub bytes_held: u64,
}

/// Memory of a frame, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryCost {
    /// All of it.
    pub total: u64,
    /// What the host writes: the scene, the camera.
    pub inputs: u64,
    /// What outlives the frame: surfels.
    pub kept: u64,
    /// What lives within a frame.
    pub transient: u64,
    /// What transients would take on top if none shared memory with another.
    pub saved_by_sharing: u64,
}

impl Profile {
    /// Reads profiles that `gibs profile --json` printed.
    ///
    /// # Errors
    /// [`ProfileError::Read`], [`ProfileError::Parse`], [`ProfileError::Other`], [`ProfileError::Format`], [`ProfileError::Empty`],
    /// [`ProfileError::Figure`].
    pub fn read(path: &Path) -> Result<Vec<Self>, ProfileError> {
        let text = crate::files::read_text(path).map_err(|source| ProfileError::Read {
            path: path.to_owned(),
            source,
        })?;
        let wrong = |source| ProfileError::Parse {
            path: path.to_owned(),
            source,
        };
        let mut all: serde_json::Value = serde_json::from_str(&text).map_err(wrong)?;
        let other = |found| ProfileError::Other {
            path: path.to_owned(),
            found,
        };
        match all.get("gibs_profile") {
            Some(format) if *format == FORMAT => {}
            Some(format) => {
                return Err(ProfileError::Format {
                    path: path.to_owned(),
                    found: format.to_string(),
                });
            }
            None => {
                return Err(other(match () {
                    () if all.get("traceEvents").is_some() => "a trace",
                    () if all.get("measured").is_some() => "a report of `gibs bench`",
                    () => "JSON of something else",
                }));
            }
        }
        let profiles: Vec<Self> = serde_json::from_value(all["profiles"].take()).map_err(wrong)?;
        if profiles.is_empty() {
            return Err(ProfileError::Empty {
                path: path.to_owned(),
            });
        }
        for profile in &profiles {
            if let Some((name, found)) = profile.broken() {
                return Err(ProfileError::Figure {
                    path: path.to_owned(),
                    name,
                    found,
                });
            }
        }
        Ok(profiles)
    }

    /// The first figure that cannot have been measured, and what is wrong with it.
    fn broken(&self) -> Option<(String, String)> {
        let frame = &self.frame;
        let of_frame = [
            ("frame", Some(&frame.wall_ms)),
            ("timed frame", Some(&frame.timed_ms)),
            ("steps of the frame", frame.steps_ms.as_ref()),
            ("tracing of the frame", frame.tracing_ms.as_ref()),
        ];
        let costs = self.groups.iter();
        let costs = costs.chain(self.stages.iter().chain(&self.steps).map(|row| &row.cost));
        let costs = costs.map(|cost| (cost.name.as_str(), cost.ms.as_ref()));
        of_frame
            .into_iter()
            .chain(costs)
            .find_map(|(name, figure)| {
                let figure = figure?;
                let runs = figure.of_runs.len();
                let is_time = |ms: &f64| ms.is_finite() && *ms >= 0.0;
                let of_runs = || figure.of_runs.iter();
                let strange = |ms: &f64| format!("{ms} milliseconds");
                let found = if runs != self.runs as usize || runs == 0 {
                    format!("medians of {runs} runs, where there were {}", self.runs)
                } else {
                    let mut all = of_runs().chain([&figure.median, &figure.p95]);
                    let found = all.find(|ms| !is_time(ms)).map(strange);
                    found.or_else(|| figure.outside_its_runs())?
                };
                Some((name.to_owned(), found))
            })
    }
}
