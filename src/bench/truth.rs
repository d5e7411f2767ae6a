//! What pictures are held against.
use super::BenchError;
use crate::RenderError;
use crate::compare::{CompareOptions, Metrics, compare};
use crate::picture::{Picture, luminance};
use crate::reference::{ReferenceOptions, reference};
use crate::view::View;
use gibs_graph::Backend;
use gibs_passes::scene::Scene;
use std::path::Path;

/// A truth for a picture of a size.
#[derive(Clone, Debug)]
pub struct Truth {
    picture: Picture,
    /// Pixels of the picture in a row for one of the truth's.
    step: u32,
    /// Samples per pixel, where that is known.
    pub samples: Option<u32>,
    /// Root mean square over pixels of the standard error of luminance, over the mean luminance, where that is known.
    pub standard_error: Option<f64>,
}

/// Of every how many pixels of a row and column a truth is rendered, by preference: odd, so that its pixels' centres are
/// centres of the picture's.
pub const TRUTH_STEPS: [u32; 3] = [5, 3, 1];

/// The seed of truths, which no frame has.
const SEED: u32 = 0x7472_7574;

impl Truth {
    /// A truth in a file, for a picture of this size.
    ///
    /// # Errors
    /// [`BenchError::Picture`], [`BenchError::TruthSize`].
    pub fn read(path: &Path, size: [u32; 2]) -> Result<Self, BenchError> {
        let picture = Picture::read_exr(path)?;
        let own = [picture.width, picture.height];
        let step = size[0].checked_div(own[0]).unwrap_or(0);
        if step.is_multiple_of(2) || own.map(|side| side.checked_mul(step)) != size.map(Some) {
            return Err(BenchError::TruthSize {
                path: path.to_owned(),
                truth: own,
                size,
            });
        }
        let standard_error = standard_error(&picture);
        Ok(Self {
            picture,
            step,
            samples: None,
            standard_error,
        })
    }

    /// Renders a truth by the reference: the pixels in the middle of squares of as many pixels of the picture as
    /// [`TRUTH_STEPS`] and the picture's size allow. `progress` is that of [`reference()`].
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn render(
        backend: &dyn Backend,
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        samples: u32,
        progress: impl FnMut(u32, u32),
    ) -> Result<Self, RenderError> {
        let fits = |step: &u32| size.iter().all(|side| side.is_multiple_of(*step));
        let step = TRUTH_STEPS.into_iter().find(fits).unwrap_or(1);
        let options = ReferenceOptions {
            size: size.map(|side| side / step),
            samples,
            seed: SEED,
            emitters: true,
        };
        let (picture, certainty) = reference(backend, scene, view, &options, progress)?;
        Ok(Self {
            picture,
            step,
            samples: Some(samples),
            standard_error: Some(certainty.standard_error),
        })
    }

    /// Pixels of the picture in a row for one of the truth's.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// The errors of a picture's indirect irradiance.
    ///
    /// # Errors
    /// [`BenchError::Compare`], [`BenchError::NotFinite`], with the name of the configuration and the frames.
    pub(super) fn errors(
        &self,
        picture: &Picture,
        configuration: &str,
        frames: u32,
    ) -> Result<Metrics, BenchError> {
        let options = CompareOptions {
            centers: true,
            ..CompareOptions::default()
        };
        let report =
            compare(picture, &self.picture, &options).map_err(|source| BenchError::Compare {
                configuration: configuration.into(),
                frames,
                source,
            })?;
        match report.non_finite.anywhere {
            0 => Ok(report.metrics),
            count => Err(BenchError::NotFinite {
                configuration: configuration.into(),
                frames,
                count,
            }),
        }
    }
}

/// What [`crate::reference::Certainty::standard_error`] was, from the channels; `None` of a truth without them.
fn standard_error(truth: &Picture) -> Option<f64> {
    let errors = truth.scalar("standard_error.Y").ok()?;
    let light = truth.rgb("E").ok()?;
    let mask = truth.scalar("mask.A").ok()?;
    let (mut squares, mut mean, mut count) = (0.0, 0.0, 0.0);
    for i in (0..mask.len()).filter(|&i| mask[i] == 1.0) {
        squares += f64::from(errors[i]).powi(2);
        mean += luminance(light.map(|plane| plane[i]));
        count += 1.0;
    }
    (mean > 0.0).then(|| (squares / count).sqrt() / (mean / count))
}
