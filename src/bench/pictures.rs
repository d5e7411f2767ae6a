//! Pictures of what was measured.
use super::{Look, Truth};
use crate::picture::{Picture, PictureError};
use image::RgbImage;
use std::path::{Path, PathBuf};

/// A picture of the first seed after frames that were asked for.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The configuration or the baseline.
    pub name: String,
    /// Frames of the surfels.
    pub frames: u32,
    /// The picture with all its channels.
    pub picture: Picture,
    /// Its relative error at the truth's pixels, as of [`crate::compare::Report::heat_map`].
    pub heat: RgbImage,
    /// Its mean relative error.
    pub mape: f64,
}

/// Pictures of one scene.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The truth, whole, to look at.
    pub look: Option<Look>,
    /// The first configuration and path tracing in its time.
    pub shots: Vec<Shot>,
}

impl Pictures {
    /// Writes all as OpenEXR, with names that begin with `stem`, and returns these: the truth that errors are against as
    /// `STEM-truth.exr`, and the one to look at as `STEM-truth-whole.exr`, where that is another one.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn write(
        &self,
        folder: &Path,
        stem: &str,
        truth: &Truth,
    ) -> Result<Vec<PathBuf>, PictureError> {
        let look = self.look.iter().map(|look| &look.picture);
        let look = look.filter(|whole| *whole != truth.picture());
        let look = look.map(|whole| (format!("{stem}-truth-whole.exr"), whole));
        let truth = [(format!("{stem}-truth.exr"), truth.picture())];
        let shots = self.shots.iter().map(|shot| {
            let name = shot.name.to_lowercase();
            let plain: Vec<&str> = name
                .split(|c: char| !c.is_ascii_alphanumeric())
                .filter(|part| !part.is_empty())
                .collect();
            let file = format!("{stem}-{}-{}.exr", plain.join("-"), shot.frames);
            (file, &shot.picture)
        });
        let mut files = Vec::new();
        for (name, picture) in truth.into_iter().chain(look).chain(shots) {
            let path = folder.join(name);
            picture.write_exr(&path)?;
            files.push(path);
        }
        Ok(files)
    }
}
