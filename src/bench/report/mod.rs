//! What was measured: tables, CSV, plots, and one page with all of it.
mod csv;
mod html;
mod plots;
mod sections;
mod table;
#[cfg(test)]
mod tests;

pub use csv::{csv, equal_error_csv};
pub use html::html;
pub use plots::plots;
pub use table::{equal_error_table, table};

use super::{EqualError, Pictures, Row};
use crate::backends::NotRun;
use crate::compare::{MaskCounts, Metrics, is_other_view};
use crate::words::counted;
use serde::Serialize;
use std::collections::BTreeMap;
use table::rounded;

/// Everything that a run of the command measured.
#[derive(Clone, Debug, Serialize)]
pub struct BenchReport {
    /// The command line.
    pub command: String,
    /// What it ran on.
    pub machine: Machine,
    /// Backends that were to be measured and are not there.
    pub not_run: Vec<NotRun>,
    /// Scenes that were to be measured and were not, on one backend or any.
    pub failed: Vec<Failed>,
    /// What was measured, by scene and backend.
    pub measured: Vec<Measured>,
}

/// A machine.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Operating system and architecture.
    pub system: String,
    /// Threads that can run at once.
    pub threads: usize,
    /// Version of the program.
    pub gibs: String,
}

/// A scene that could not be measured.
#[derive(Clone, Debug, Serialize)]
pub struct Failed {
    /// The scene, as it was asked for.
    pub scene: String,
    /// The backend on which it was not; `None` of one that is measured on none, for want of a truth.
    pub backend: Option<String>,
    /// Why, and what to do.
    pub reason: String,
}

/// What was measured of one scene on one backend.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The scene, as it was asked for.
    pub scene: String,
    /// Backend.
    pub backend: String,
    /// Its device.
    pub device: String,
    /// The device's driver.
    pub driver: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// How the scene is seen, as in a view file.
    pub view: serde_json::Value,
    /// Every setting of the first configuration.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Ray budget of a frame of the first configuration.
    pub rays: u32,
    /// Repetitions.
    pub seeds: u32,
    /// What errors are against.
    pub truth: AboutTruth,
    /// A row for each configuration and baseline.
    pub rows: Vec<Row>,
    /// What path tracing needs for equal error.
    pub equal_error: Vec<EqualError>,
    /// Baselines that are no other than path tracing in this scene, and have no rows.
    pub same_as_path_tracing: Vec<String>,
    /// Factor on pictures for display.
    #[serde(skip)]
    pub exposure: f32,
    /// Pictures of the first seed.
    #[serde(skip)]
    pub pictures: Pictures,
}

/// A truth.
#[derive(Clone, Debug, Serialize)]
pub struct AboutTruth {
    /// The file that was given; `None` of one that was path-traced here.
    pub file: Option<String>,
    /// Of every how many pixels of a row and column there is a truth.
    pub step: u32,
    /// Samples per pixel, where known.
    pub samples: Option<u32>,
    /// Standard error per pixel over the mean, where known.
    pub standard_error: Option<f64>,
    /// The errors of a picture without any, where halves of the truth tell: its own noise.
    pub noise: Option<Metrics>,
    /// Its pixels: those that errors are of, and those left out.
    pub mask: MaskCounts,
    /// How many of those that errors are of show another surface than the scene does; `None` where that is not known, as of a truth without
    /// depths, and of one that was path-traced here.
    pub elsewhere: Option<usize>,
}

impl Machine {
    /// The one that this runs on.
    pub fn here() -> Self {
        Self {
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            gibs: env!("CARGO_PKG_VERSION").into(),
        }
    }
}

/// A line about the measurement.
pub fn heading(measured: &Measured) -> String {
    let [width, height] = measured.size;
    format!(
        "{} on {} ({}): {width}x{height}, {} rays a frame, {}; {}{}",
        measured.scene,
        measured.backend,
        measured.device,
        measured.rays,
        counted(measured.seeds, "seed"),
        measured.truth.in_words(),
        match measured.same_as_path_tracing.as_slice() {
            [] => String::new(),
            same => format!(
                "; {} is path tracing here, where nothing emits that a ray could be sent to",
                same.join(", ")
            ),
        }
    )
}

impl AboutTruth {
    /// What errors are against, how many pixels of it, and what makes it doubtful.
    fn in_words(&self) -> String {
        let Self { mask, .. } = self;
        let mut text = match &self.file {
            Some(file) => format!("truth {file} of "),
            None => "truth of ".into(),
        };
        text += &match self.step {
            1 => "every pixel".to_string(),
            step => format!("one of {} pixels", u64::from(step).pow(2)),
        };
        if let Some(samples) = self.samples {
            text += &format!(", {samples} samples");
        }
        if let Some(error) = self.standard_error {
            text += &format!(", standard error {:.1} % per pixel", error * 100.0);
        }
        text += &match (&self.noise, self.standard_error) {
            (Some(noise), _) => format!(
                ", of whose noise alone a picture without errors has relMSE {}, MAPE {} %",
                rounded(noise.rel_mse, 2, false),
                rounded(noise.mape * 100.0, 2, false)
            ),
            (None, None) => "; its noise is not known".into(),
            (None, Some(_)) => String::new(),
        };
        text += &format!("; errors are of {}", counted(mask.valid as u64, "pixel"));
        let left_out = [(mask.fireflies, "fireflies"), (mask.blended, "blended")];
        for (count, what) in left_out.into_iter().filter(|(count, _)| *count > 0) {
            text += &format!(", {count} left out ({what})");
        }
        if let Some(elsewhere) = self.elsewhere.filter(|count| *count > 0) {
            text += &format!("; {elsewhere} show another surface in the truth");
            if is_other_view([elsewhere, mask.valid]) {
                text += ": is it of this scene and view?";
            }
        }
        text
    }
}
