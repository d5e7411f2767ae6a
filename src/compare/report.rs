//! What a comparison found, as a table, as JSON and as pictures.
use std::fmt;

use image::RgbImage;
use serde::Serialize;

use crate::picture::{FINAL_IMAGE, Picture, PictureError, heat_map};

use super::metrics::Metrics;
use super::pair::MaskCounts;

/// The relative error at which a heat map reaches its brightest colour: half of the truth.
pub const HEAT_FULL_SCALE: f32 = 0.5;

/// The result of [`compare`](super::compare).
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The layer compared; empty for the final image.
    pub layer: String,
    /// The truth's width in pixels.
    pub width: u32,
    /// The truth's height in pixels.
    pub height: u32,
    /// Our pixels in a row for one of the truth's; 1 where the sizes agree.
    pub averaged: u32,
    /// Whether their middle stands for them, in place of their mean.
    pub centers: bool,
    /// The pixels compared and left out.
    pub mask: MaskCounts,
    /// How many of the pixels compared show another surface in ours, whose depth is more than 5 % off the truth's; `None` where one
    /// of the two has no depth.
    pub elsewhere: Option<usize>,
    /// m: the truth's mean luminance over the mask, in the layer's units.
    pub mean: f64,
    /// The factor on both pictures before FLIP.
    pub exposure: f64,
    /// The errors; NaN (null in JSON) throughout if a pixel within the mask is not finite.
    pub metrics: Metrics,
    /// The errors of the remaining pixels, if some within the mask are not finite.
    pub finite_only: Option<Metrics>,
    /// Our values that are NaN or infinite.
    pub non_finite: NonFinite,
    /// What a perfect picture would show, where halves of the truth were given.
    pub noise: Option<Metrics>,
    /// Errors per pixel.
    #[serde(skip)]
    pub maps: Maps,
}

/// Our pixels with a value that is NaN or infinite, counted at our size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct NonFinite {
    /// In the whole picture.
    pub anywhere: usize,
    /// Within the mask.
    pub in_mask: usize,
    /// Column and row of the first one, at our size; one within the mask if there is any.
    pub first: Option<[u32; 2]>,
}

/// Errors per pixel at the truth's size, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// (o - t) / max(t, 0.01 m) of the luminance, signed; NaN outside the mask and where ours is
    /// not finite.
    pub relative: Vec<f32>,
    /// The FLIP difference, 0 to 1; near 0 outside the mask, where both pictures take the truth's
    /// value.
    pub flip: Vec<f32>,
    /// Whether the pixel was compared.
    pub mask: Vec<bool>,
}

impl Report {
    /// Whether all our values are finite, so that the comparison says something about all of them.
    /// No statement about the size of the errors.
    pub fn passed(&self) -> bool {
        self.non_finite.anywhere == 0
    }

    /// Pixels that show another surface, and how many are compared, where those make the pictures [of other
    /// views](super::is_other_view).
    pub fn other_view(&self) -> Option<[usize; 2]> {
        super::many(self.elsewhere?, self.mask.valid)
    }

    /// The size of the relative error per pixel, black for none to pale yellow for `full_scale`
    /// (such as [`HEAT_FULL_SCALE`]) and beyond; grey outside the mask, magenta where ours is not
    /// finite.
    pub fn heat_map(&self, full_scale: f32) -> RgbImage {
        let Maps { relative, mask, .. } = &self.maps;
        heat_map(self.width, self.height, relative, full_scale, |i| mask[i])
    }

    /// The errors per pixel as channels `error.Y` (relative, signed), `flip.Y` and `mask.A`.
    ///
    /// # Errors
    /// [`PictureError::ChannelLength`] if the maps were changed to other lengths.
    pub fn error_picture(&self) -> Result<Picture, PictureError> {
        let mut picture = Picture::new(self.width, self.height);
        let mask = self
            .maps
            .mask
            .iter()
            .map(|&inside| f32::from(u8::from(inside)));
        picture.set_scalar("mask.A", mask.collect())?;
        picture.set_scalar("error.Y", self.maps.relative.clone())?;
        picture.set_scalar("flip.Y", self.maps.flip.clone())?;
        Ok(picture)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let layer = if self.layer == FINAL_IMAGE {
            "RGB"
        } else {
            &self.layer
        };
        let mask = &self.mask;
        writeln!(
            f,
            "channel {layer}, {}x{}: {} of {} pixels compared",
            self.width, self.height, mask.valid, mask.pixels
        )?;
        if let Some(elsewhere) = self.elsewhere.filter(|count| *count > 0) {
            writeln!(
                f,
                "  {elsewhere} of those compared show another surface in our picture"
            )?;
        }
        for (count, reason) in [
            (mask.missed, "hit nothing"),
            (mask.blended, "lie behind a blended surface"),
            (mask.fireflies, "are fireflies of the truth"),
        ] {
            if count > 0 {
                writeln!(f, "  {count} {reason}")?;
            }
        }
        if self.averaged > 1 {
            let how = match self.centers {
                true => "thinned out",
                false => "averaged down",
            };
            writeln!(f, "  our picture {how} {0}x{0}", self.averaged)?;
        }
        writeln!(
            f,
            "mean of the truth {}, exposure for FLIP {}",
            significant(self.mean),
            significant(self.exposure)
        )?;
        if self.non_finite.anywhere > 0 {
            let NonFinite {
                anywhere,
                in_mask,
                first,
            } = self.non_finite;
            write!(
                f,
                "NOT FINITE: {anywhere} of our pixels, {in_mask} of them compared"
            )?;
            match first {
                Some([x, y]) => writeln!(f, ", the first at ({x}, {y})")?,
                None => writeln!(f)?,
            }
        }
        self.write_table(f)
    }
}

impl Report {
    fn write_table(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns: Vec<(&str, &Metrics)> = [
            ("value", Some(&self.metrics)),
            ("finite pixels", self.finite_only.as_ref()),
            ("noise of truth", self.noise.as_ref()),
        ]
        .into_iter()
        .filter_map(|(name, metrics)| Some((name, metrics?)))
        .collect();
        write!(f, "\n{:<12}", "metric")?;
        for (name, _) in &columns {
            write!(f, " {name:>14}")?;
        }
        type Row = (&'static str, fn(&Metrics) -> f64);
        let rows: [Row; 7] = [
            ("relMSE", |m| m.rel_mse),
            ("RMSE", |m| m.rmse),
            ("MAPE", |m| m.mape),
            ("bias", |m| m.bias),
            ("p99", |m| m.p99),
            ("block error", |m| m.block_error),
            ("FLIP", |m| m.flip),
        ];
        for (name, value) in rows {
            write!(f, "\n{name:<12}")?;
            for (_, metrics) in &columns {
                write!(f, " {:>14}", significant(value(metrics)))?;
            }
        }
        writeln!(f)
    }
}

/// Four significant digits, plain where that is short.
fn significant(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() {
        format!("{value}")
    } else if (1e-3..1e6).contains(&magnitude) {
        let decimals = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}
