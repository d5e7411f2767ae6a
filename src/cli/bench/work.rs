//! Measuring every scene on every backend.
use super::truth::Held;
use super::{Args, files, json};
use crate::bench::{
    self, BenchReport, Failed, Measured, Options, Pictures, Target, Truth, TruthCache,
};
use crate::cli::CommandError;
use crate::cli::error::Failures;
use crate::cli::output::{progress, say, warning};
use crate::cli::scene::Loaded;
use crate::conditions::{settings_map, view_value};
use gibs_graph::Backend;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What is to be measured.
pub struct Work<'a> {
    pub args: &'a Args,
    pub options: &'a Options,
    pub scenes: &'a [Loaded],
    pub backends: &'a [Box<dyn Backend>],
    /// The truth that was given.
    pub truth: Option<&'a Truth>,
    pub cache: Option<&'a TruthCache>,
}

impl Work<'_> {
    /// Measures every scene on every backend, those after one that cannot be measured too. The files are written anew after
    /// each, with all that is there by then; `written` hears of plots and pictures.
    ///
    /// # Errors
    /// The first of those for which a scene could not be measured.
    pub fn measure(
        &self,
        report: &mut BenchReport,
        written: &mut BTreeSet<PathBuf>,
    ) -> Result<(), CommandError> {
        let Some(first) = self.backends.first() else {
            return Ok(());
        };
        let mut failures = Failures::default();
        for (index, scene) in self.args.scenes.iter().enumerate() {
            let held = match Held::of(self, index, first.as_ref()) {
                Ok(held) => held,
                Err(error) => {
                    report.failed.push(failed(scene, None, &error));
                    failures.add(error);
                    if let Err(error) = self.write(report) {
                        failures.add(error);
                    }
                    continue;
                }
            };
            for backend in self.backends {
                match self.on(index, backend.as_ref(), &held) {
                    Ok(measured) => {
                        report.measured.push(measured);
                        // What cannot be written was measured all the same.
                        for error in self.draw(index, report, &held, written) {
                            failures.add(error);
                        }
                    }
                    Err(error) => {
                        let on = Some(backend.name().to_owned());
                        report.failed.push(failed(scene, on, &error));
                        failures.add(error);
                    }
                }
                if let Err(error) = self.write(report) {
                    failures.add(error);
                }
            }
        }
        failures.first()
    }

    /// Writes the files of the report, with all that was measured so far.
    fn write(&self, report: &BenchReport) -> Result<(), CommandError> {
        match &self.args.report {
            Some(folder) if !report.measured.is_empty() => {
                files::write(folder, report, &json(report))
            }
            _ => Ok(()),
        }
    }

    pub fn target<'a>(&'a self, index: usize, backend: &'a dyn Backend) -> Target<'a> {
        let loaded = &self.scenes[index];
        Target {
            backend,
            scene: &loaded.scene,
            view: &loaded.view,
            size: self.args.size,
        }
    }

    /// Measures a scene on one backend.
    fn on(
        &self,
        index: usize,
        backend: &dyn Backend,
        held: &Held,
    ) -> Result<Measured, CommandError> {
        let target = self.target(index, backend);
        let mut measured = measure(&target, held, self.options, &self.args.scenes[index])?;
        measured.exposure = target.view.exposure;
        measured.pictures.look = held.look.clone();
        if !self.args.json {
            let tables = bench::table(&measured.rows);
            let equal = bench::equal_error_table(&measured.equal_error);
            say!("{}\n\n{tables}\n{equal}", bench::heading(&measured));
        }
        Ok(measured)
    }

    /// Writes the plots and pictures of what was measured last; gives what failed.
    fn draw(
        &self,
        index: usize,
        report: &BenchReport,
        held: &Held,
        written: &mut BTreeSet<PathBuf>,
    ) -> Vec<CommandError> {
        let (Some(folder), Some(measured)) = (&self.args.report, report.measured.last()) else {
            return Vec::new();
        };
        let stem = files::stem(&self.args.scenes, index, &measured.backend);
        let mut all = vec![files::write_plots(folder, &stem, measured)];
        if self.args.pictures {
            let pictures = measured.pictures.write(folder, &stem, &held.truth);
            all.push(pictures.map_err(CommandError::from));
        }
        let mut errors = Vec::new();
        for done in all {
            match done {
                Ok(paths) => written.extend(paths),
                Err(error) => errors.push(error),
            }
        }
        errors
    }
}

fn failed(scene: &str, backend: Option<String>, error: &CommandError) -> Failed {
    Failed {
        scene: scene.to_owned(),
        backend,
        reason: error.to_string(),
    }
}

fn measure(
    target: &Target<'_>,
    held: &Held,
    options: &Options,
    scene: &str,
) -> Result<Measured, CommandError> {
    let bar = progress(bench::work(options), "measuring");
    let done = bench::measure(target, &held.truth, options, || bar.inc(1));
    bar.finish_and_clear();
    let done = done?;
    for warning in &done.warnings {
        warning!("{scene}: {warning}");
    }
    let backend: &dyn Backend = target.backend;
    let device = backend.device();
    let first = options.configurations.first().map(|first| &first.settings);
    Ok(Measured {
        scene: scene.into(),
        backend: backend.name().into(),
        device: device.name.clone(),
        driver: device.driver.clone(),
        size: options.size,
        view: view_value(target.view),
        settings: first.map(settings_map).unwrap_or_default(),
        rays: first.map_or(0, |settings| settings.rays),
        seeds: options.seeds,
        truth: held.about.clone(),
        rows: done.rows,
        equal_error: done.equal_error,
        same_as_path_tracing: done.same,
        exposure: 1.0,
        pictures: Pictures {
            look: None,
            shots: done.shots,
        },
    })
}
