//! What pictures are held against.
use super::{BenchError, TruthCache};
use crate::RenderError;
use crate::compare::{CompareOptions, MaskCounts, Report, compare};
use crate::picture::{FINAL_IMAGE, Picture, luminance};
use crate::reference::{ReferenceOptions, reference};
use crate::view::View;
use gibs_graph::Backend;
use gibs_passes::scene::Scene;
use std::path::{Path, PathBuf};

/// A truth for a picture of a size.
#[derive(Clone, Debug)]
pub struct Truth {
    picture: Picture,
    /// Where it was read from; `None` of one that was path-traced.
    file: Option<PathBuf>,
    /// Pixels of the picture in a row for one of the truth's.
    step: u32,
    /// Samples per pixel, where that is known.
    pub samples: Option<u32>,
    /// What was wrong with a file of the cache.
    pub warning: Option<String>,
    /// Root mean square over pixels of the standard error of luminance, over the mean luminance, where that is known.
    pub standard_error: Option<f64>,
}

/// Of every how many pixels of a row and column a truth is rendered, by preference: odd, so that its pixels' centres are
/// centres of the picture's.
pub const TRUTH_STEPS: [u32; 3] = [5, 3, 1];

/// The seed of truths, which no frame has.
const SEED: u32 = 0x7472_7574;

/// Samples per pixel of a picture to look at: least, and most, beyond which nobody sees a difference.
const LOOK: [u32; 2] = [16, 512];

/// What there is a truth of.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// What path traces it.
    pub backend: &'a dyn Backend,
    /// The scene.
    pub scene: &'a Scene,
    /// How it is seen.
    pub view: &'a View,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
}

/// A picture of the truth to look at.
#[derive(Clone, Debug)]
pub struct Look {
    /// The picture.
    pub picture: Picture,
    /// Samples per pixel, where known.
    pub samples: Option<u32>,
    /// What was wrong with a file of the cache.
    pub warning: Option<String>,
}

impl Target<'_> {
    fn reference(
        &self,
        size: [u32; 2],
        samples: u32,
        cache: Option<&TruthCache>,
        progress: impl FnMut(u32, u32),
    ) -> Result<(Picture, Option<String>), RenderError> {
        let options = ReferenceOptions {
            size,
            samples,
            seed: SEED,
            emitters: true,
        };
        let (backend, scene, view) = (self.backend, self.scene, self.view);
        match cache {
            Some(cache) => {
                let cached = cache.reference(backend, scene, view, &options, progress)?;
                Ok((cached.picture, cached.warning))
            }
            None => {
                let (picture, _) = reference(backend, scene, view, &options, progress)?;
                Ok((picture, None))
            }
        }
    }
}

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
            file: Some(path.to_owned()),
            step,
            samples: None,
            warning: None,
            standard_error,
        })
    }

    /// A truth by the reference: the pixels in the middle of squares of as many pixels of the picture as
    /// [`TRUTH_STEPS`] and the picture's size allow. It is taken from `cache` where it is there. `progress` is that of
    /// [`reference()`].
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn render(
        target: &Target<'_>,
        samples: u32,
        cache: Option<&TruthCache>,
        progress: impl FnMut(u32, u32),
    ) -> Result<Self, RenderError> {
        let fits = |step: &u32| target.size.iter().all(|side| side.is_multiple_of(*step));
        let step = TRUTH_STEPS.into_iter().find(fits).unwrap_or(1);
        let size = target.size.map(|side| side / step);
        let (picture, warning) = target.reference(size, samples, cache, progress)?;
        Ok(Self {
            standard_error: standard_error(&picture),
            picture,
            file: None,
            step,
            samples: Some(samples),
            warning,
        })
    }

    /// The whole picture for people to look at, with as many paths in all as a truth of every few pixels has with `samples`
    /// of each, but 16 to 512 samples per pixel; the truth itself where it has every pixel and the final image.
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn look(
        &self,
        target: &Target<'_>,
        samples: u32,
        cache: Option<&TruthCache>,
        progress: impl FnMut(u32, u32),
    ) -> Result<Look, RenderError> {
        if self.step == 1 && self.picture.rgb(FINAL_IMAGE).is_ok() {
            return Ok(Look {
                picture: self.picture.clone(),
                samples: self.samples,
                warning: None,
            });
        }
        let samples = (u64::from(samples) / u64::from(self.step).pow(2))
            .clamp(LOOK[0].into(), LOOK[1].into()) as u32;
        let (picture, warning) = target.reference(target.size, samples, cache, progress)?;
        Ok(Look {
            picture,
            samples: Some(samples),
            warning,
        })
    }

    /// Refuses one that nothing can be held against, such as a black one, before anything is; counts the pixels of any other.
    ///
    /// # Errors
    /// [`BenchError::Truth`], with the name of the file, or of the scene where it was path-traced.
    pub fn check(&self, scene: &str) -> Result<MaskCounts, BenchError> {
        let itself = compare(&self.picture, &self.picture, &CompareOptions::default());
        let wrong = |source| BenchError::Truth {
            of: match &self.file {
                Some(file) => format!("the truth {}", file.display()),
                None => scene.to_owned(),
            },
            source,
        };
        itself.map(|report| report.mask).map_err(wrong)
    }

    /// The picture itself.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Pixels of the picture in a row for one of the truth's.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// Width and height of the truth, pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.picture.width, self.picture.height]
    }

    /// The errors of a picture's indirect irradiance, of the size that the truth is for or of its own.
    ///
    /// # Errors
    /// [`BenchError::Compare`], [`BenchError::NotFinite`], with the name of the configuration and the frames.
    pub(super) fn errors(
        &self,
        picture: &Picture,
        configuration: &str,
        frames: u32,
    ) -> Result<Report, BenchError> {
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
            0 => Ok(report),
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
    // As in comparisons, fireflies and what is blended do not count.
    let is_set = |name: &str, i: usize| truth.scalar(name).is_ok_and(|plane| plane[i] != 0.0);
    let counts = |i: &usize| mask[*i] == 1.0 && !is_set("firefly.A", *i) && !is_set("blend.A", *i);
    let (mut squares, mut mean, mut count) = (0.0, 0.0, 0.0);
    for i in (0..mask.len()).filter(counts) {
        squares += f64::from(errors[i]).powi(2);
        mean += luminance(light.map(|plane| plane[i]));
        count += 1.0;
    }
    (mean > 0.0).then(|| (squares / count).sqrt() / (mean / count))
}
