//! Pictures of named float channels: in memory, as OpenEXR files, and as PNG previews for people.
//!
//! A picture is what renders, references and comparisons exchange. Its channels carry the names
//! that OpenEXR shows, a layer name and a suffix: `E.R`, `normal.X`, `mask.A`; the final image is
//! plain `R`, `G`, `B`.

mod color;
mod error;
mod file;
mod openexr;
mod preview;
mod ramp;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

pub use color::{linear_to_srgb, luminance, srgb_to_linear};
pub use error::PictureError;
pub use file::{WriteError, ensure_writable, replace_file};
pub use preview::{NON_FINITE_COLOR, OUTSIDE_COLOR, heat_map, tone_map, write_png};
pub use ramp::{cool_warm, inferno, name_color};

/// The layer name of the final image, whose channels are plain `R`, `G` and `B`.
pub const FINAL_IMAGE: &str = "";

/// Float channels of one size. Every channel holds `width * height` values, row by row from the
/// top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Values by full channel name (`E.R`), linear, in the units of the quantity.
    pub channels: BTreeMap<String, Vec<f32>>,
}

/// What a file's extension says it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// OpenEXR, every channel, 32-bit float.
    Exr,
    /// An 8-bit sRGB preview of one layer.
    Png,
}

impl Format {
    /// The format that `path` asks for by its extension, in any case.
    ///
    /// # Errors
    /// [`PictureError::UnknownExtension`] for anything but `.exr` and `.png`.
    pub fn of(path: &Path) -> Result<Self, PictureError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(PictureError::UnknownExtension {
                path: path.to_owned(),
                extension: extension.unwrap_or_default(),
            }),
        }
    }
}

/// The full name of a channel: `layer.suffix`, or the suffix alone for [`FINAL_IMAGE`].
pub fn channel_name(layer: &str, suffix: &str) -> String {
    if layer == FINAL_IMAGE {
        suffix.to_owned()
    } else {
        format!("{layer}.{suffix}")
    }
}

impl Picture {
    /// A picture of this size without channels.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            channels: BTreeMap::new(),
        }
    }

    /// Pixels in the picture, the length of every channel.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether a channel of this full name exists.
    pub fn has(&self, name: &str) -> bool {
        self.channels.contains_key(name)
    }

    /// One channel by its full name, such as `mask.A`.
    ///
    /// # Errors
    /// [`PictureError::MissingChannel`], which lists the channels present, or
    /// [`PictureError::ChannelLength`] if the channel was set to a length other than
    /// [`Picture::pixels`].
    pub fn scalar(&self, name: &str) -> Result<&[f32], PictureError> {
        let values = self
            .channels
            .get(name)
            .ok_or_else(|| PictureError::MissingChannel {
                wanted: name.to_owned(),
                present: self.channel_list(),
            })?;
        self.check_length(name, values.len())?;
        Ok(values)
    }

    /// The channels `layer.R`, `layer.G` and `layer.B`, or plain `R`, `G` and `B` for
    /// [`FINAL_IMAGE`].
    ///
    /// # Errors
    /// As [`Picture::scalar`].
    pub fn rgb(&self, layer: &str) -> Result<[&[f32]; 3], PictureError> {
        self.triple(layer, ["R", "G", "B"])
    }

    /// The channels `layer.X`, `layer.Y` and `layer.Z`, for positions and normals.
    ///
    /// # Errors
    /// As [`Picture::scalar`].
    pub fn xyz(&self, layer: &str) -> Result<[&[f32]; 3], PictureError> {
        self.triple(layer, ["X", "Y", "Z"])
    }

    /// Adds or replaces one channel.
    ///
    /// # Errors
    /// [`PictureError::ChannelLength`] unless there is one value for each pixel.
    pub fn set_scalar(&mut self, name: &str, values: Vec<f32>) -> Result<(), PictureError> {
        self.check_length(name, values.len())?;
        self.channels.insert(name.to_owned(), values);
        Ok(())
    }

    /// Adds or replaces `layer.R`, `layer.G` and `layer.B`.
    ///
    /// # Errors
    /// As [`Picture::set_scalar`]; the picture is unchanged then.
    pub fn set_rgb(&mut self, layer: &str, values: [Vec<f32>; 3]) -> Result<(), PictureError> {
        self.set_triple(layer, ["R", "G", "B"], values)
    }

    /// Adds or replaces `layer.X`, `layer.Y` and `layer.Z`.
    ///
    /// # Errors
    /// As [`Picture::set_scalar`]; the picture is unchanged then.
    pub fn set_xyz(&mut self, layer: &str, values: [Vec<f32>; 3]) -> Result<(), PictureError> {
        self.set_triple(layer, ["X", "Y", "Z"], values)
    }

    /// The layers that have all of `R`, `G` and `B`, in order of name; [`FINAL_IMAGE`] first if
    /// present.
    pub fn rgb_layers(&self) -> Vec<&str> {
        let complete = |layer: &str| {
            ["R", "G", "B"]
                .iter()
                .all(|s| self.has(&channel_name(layer, s)))
        };
        let named = self
            .channels
            .keys()
            .filter_map(|name| name.strip_suffix(".R"));
        std::iter::once(FINAL_IMAGE)
            .chain(named)
            .filter(|layer| complete(layer))
            .collect()
    }

    /// The names of the channels, comma-separated, for messages.
    pub fn channel_list(&self) -> String {
        let names: Vec<&str> = self.channels.keys().map(String::as_str).collect();
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    }

    /// Writes the picture as its extension says: `.exr` with every channel, `.png` as a preview of
    /// the final image, or of the first RGB layer where there is none. `exposure` is a factor on
    /// the preview only.
    ///
    /// # Errors
    /// [`PictureError`] for an unknown extension, a preview without an RGB layer, or a file that
    /// cannot be written.
    pub fn write(&self, path: &Path, exposure: f32) -> Result<(), PictureError> {
        match Format::of(path)? {
            Format::Exr => self.write_exr(path),
            Format::Png => {
                let layers = self.rgb_layers();
                let layer = layers.first().copied().unwrap_or(FINAL_IMAGE);
                self.write_preview(path, layer, exposure)
            }
        }
    }

    /// Writes one RGB layer as an sRGB PNG, multiplied by `exposure` and clamped to 0..1.
    ///
    /// # Errors
    /// As [`Picture::rgb`], or a file that cannot be written.
    pub fn write_preview(
        &self,
        path: &Path,
        layer: &str,
        exposure: f32,
    ) -> Result<(), PictureError> {
        let image = tone_map(self.width, self.height, self.rgb(layer)?, exposure);
        write_png(path, &image)
    }

    fn triple(&self, layer: &str, suffixes: [&str; 3]) -> Result<[&[f32]; 3], PictureError> {
        let [a, b, c] = suffixes.map(|suffix| self.scalar(&channel_name(layer, suffix)));
        Ok([a?, b?, c?])
    }

    fn set_triple(
        &mut self,
        layer: &str,
        suffixes: [&str; 3],
        values: [Vec<f32>; 3],
    ) -> Result<(), PictureError> {
        let names = suffixes.map(|suffix| channel_name(layer, suffix));
        for (name, values) in names.iter().zip(&values) {
            self.check_length(name, values.len())?;
        }
        self.channels.extend(names.into_iter().zip(values));
        Ok(())
    }

    fn check_length(&self, name: &str, found: usize) -> Result<(), PictureError> {
        if found == self.pixels() {
            return Ok(());
        }
        Err(PictureError::ChannelLength {
            channel: name.to_owned(),
            found,
            width: self.width,
            height: self.height,
            expected: self.pixels(),
        })
    }
}
