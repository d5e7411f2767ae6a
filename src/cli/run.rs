//! What the commands share that run many frames.
use super::CommandError;
use super::output::warning;
use super::scene::Loaded;
use crate::bench::Spread;
use crate::compare::{CompareOptions, is_other_view};
use crate::measure::FrameRow;
use crate::picture::Picture;
use crate::reference::{ReferenceOptions, reference};
use crate::{Counters, Renderer};
use gibs_graph::Backend;
use gibs_passes::frame::Settings;
use serde::Serialize;
use std::path::Path;

/// The settings with the check of slots.
pub(super) fn checked(settings: &Settings) -> Settings {
    Settings {
        check_slots: true,
        ..settings.clone()
    }
}

/// A scene that is ready to run, from an empty cache but warm.
pub(super) fn prepare(
    backend: &dyn Backend,
    loaded: &Loaded,
    settings: &Settings,
    seed: u32,
) -> Result<Renderer, CommandError> {
    let mut renderer = Renderer::new(
        backend,
        &loaded.scene,
        &loaded.view,
        loaded.size,
        settings,
        seed,
    )?;
    warn_at_start(&renderer, settings);
    renderer.warm_up()?;
    Ok(renderer)
}

/// Says what the scene has that is left out, and what settings leave no light of.
pub(super) fn warn_at_start(renderer: &Renderer, settings: &Settings) {
    for warning in renderer.warnings() {
        warning!("{warning}");
    }
    warn_of_no_light(settings);
}

/// Says what settings leave no light of.
pub(super) fn warn_of_no_light(settings: &Settings) {
    if settings.surfels == 0 {
        warning!("without surfels there is direct light only");
    } else if settings.rays == 0 {
        warning!("without rays no surfel learns of any light: indirect light is zero");
    }
}

/// What happened to the surfels over a run.
#[derive(Debug, Default, Serialize)]
pub(super) struct Totals {
    pub surfels: u32,
    pub most_live: u32,
    pub births: u64,
    pub recycled: u64,
    pub starved: u64,
    /// Holes in crowded cells, in the frame that had most.
    pub crowded: u64,
    pub grid_overflow: u64,
    /// Over all frames, so that one that lasts counts in each.
    pub slot_errors: u64,
    /// Rays of all frames from surfels, and beyond hits.
    pub rays: u64,
    pub continued_rays: u64,
}

impl Totals {
    pub fn of<'a>(surfels: u32, rows: impl Iterator<Item = &'a FrameRow>) -> Self {
        let mut totals = Self {
            surfels,
            ..Self::default()
        };
        for row in rows {
            totals.most_live = totals.most_live.max(row.live);
            totals.births += u64::from(row.births);
            totals.recycled += u64::from(row.recycled);
            totals.starved += u64::from(row.starved);
            totals.crowded = totals.crowded.max(row.crowded.into());
            totals.grid_overflow += u64::from(row.grid_overflow);
            totals.slot_errors += u64::from(row.slot_errors.unwrap_or_default());
            totals.rays += u64::from(row.rays);
            totals.continued_rays += u64::from(row.continued);
        }
        totals
    }

    /// Says what ran out, and fails where slots are wrong.
    pub fn judge(&self) -> Result<(), CommandError> {
        warn_shortage(self.surfels, self.starved, self.crowded, self.grid_overflow);
        warn_of_few_rays(self.births, self.rays);
        match self.slot_errors {
            0 => Ok(()),
            errors => Err(CommandError::Slots { errors }),
        }
    }
}

/// Warns of what ran out, with the setting to raise.
pub(super) fn warn_shortage(surfels: u32, starved: u64, crowded: u64, overflow: u64) {
    // Who asked for none wants none.
    if starved > 0 && surfels > 0 {
        warning!("{starved} births found no free surfel; raise `surfels`");
    }
    if crowded > 0 {
        warning!(
            "{crowded} holes get no surfel: their cells' lists are as long as a lookup; raise `lookup`"
        );
    }
    if overflow > 0 {
        warning!("{overflow} entries did not fit the grid; raise `grid_lists`");
    }
}

/// Warns where surfels have had less than a ray each.
pub(super) fn warn_of_few_rays(surfels: u64, rays: u64) {
    if rays > 0 && rays < surfels {
        warning!(
            "{surfels} surfels have had {rays} rays in all, less than one each; raise `rays`, or render more frames"
        );
    }
}

/// How many pixels of a truth show another surface than the scene does, by the reference's picture of its size: a warning where those are more than a
/// tenth, an error where they are more than half. Of a truth that does not fit, or a backend that fails, nothing is known; that is left to
/// who measures.
pub(super) fn elsewhere(
    backend: &dyn Backend,
    loaded: &Loaded,
    truth: &Picture,
    path: &Path,
) -> Result<Option<usize>, CommandError> {
    let size = [truth.width, truth.height];
    let fits = |(of, whole): (&u32, &u32)| *of > 0 && whole.is_multiple_of(*of);
    if !size.iter().zip(&loaded.size).all(fits) {
        return Ok(None);
    }
    let options = ReferenceOptions {
        size,
        samples: 1,
        seed: 0,
        emitters: false,
    };
    let ours = reference(backend, &loaded.scene, &loaded.view, &options, |_, _| ());
    let counts = ours
        .ok()
        .and_then(|(ours, _)| crate::compare::elsewhere(&ours, truth, &CompareOptions::default()));
    let Some([elsewhere, of]) = counts else {
        return Ok(None);
    };
    if elsewhere > of / 2 {
        return Err(CommandError::OtherTruth {
            truth: path.to_owned(),
            elsewhere,
            of,
        });
    }
    if is_other_view([elsewhere, of]) {
        warning!(
            "--truth {}: {elsewhere} of {of} pixels show another surface than the scene does; is it of this scene and view?",
            path.display()
        );
    }
    Ok(Some(elsewhere))
}

/// The median of some numbers as text with so many decimals; a dash of none.
pub(super) fn median(values: impl Iterator<Item = f64>, decimals: usize) -> String {
    match Spread::of(values).median {
        none if none.is_nan() => "-".into(),
        median => format!("{median:.decimals$}"),
    }
}

/// As [`warn_shortage`], of the counters of a renderer.
pub(super) fn warn_of(surfels: u32, counters: &Counters) {
    let [starved, crowded, overflow] =
        [counters.starved, counters.crowded, counters.overflow].map(u64::from);
    warn_shortage(surfels, starved, crowded, overflow);
}
