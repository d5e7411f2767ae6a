//! 8-bit pictures for people: tone-mapped previews and heat maps.
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgb, RgbImage};

use super::color::linear_to_srgb;
use super::error::PictureError;
use super::file::replace_file;
use super::ramp::inferno;

/// The colour of pixels with a NaN or an infinity: magenta, which neither lit surfaces nor the ramp
/// show.
pub const NON_FINITE_COLOR: [u8; 3] = [255, 0, 255];

/// The colour of pixels outside a heat map's mask: a grey, which the ramp does not contain.
pub const OUTSIDE_COLOR: [u8; 3] = [72, 72, 72];

/// Linear RGB planes of `width * height` values, multiplied by `exposure`, clamped to 0..1 and put
/// through the sRGB curve. Pixels that are not finite become [`NON_FINITE_COLOR`]; values missing
/// from a plane count as such.
pub fn tone_map(width: u32, height: u32, rgb: [&[f32]; 3], exposure: f32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let i = y as usize * width as usize + x as usize;
        let pixel = rgb.map(|plane| plane.get(i).copied().unwrap_or(f32::NAN));
        Rgb(if pixel.iter().all(|v| v.is_finite()) {
            // A finite value times the exposure may overflow to an infinity, which the clamp takes.
            pixel.map(|v| (linear_to_srgb(v * exposure) * 255.0).round() as u8)
        } else {
            NON_FINITE_COLOR
        })
    })
}

/// The magnitudes of `values` (`width * height`) on the [`inferno`] ramp: black at 0, pale yellow
/// at `full_scale` and beyond. NaN and infinities are [`NON_FINITE_COLOR`]; where `inside` is false
/// the pixel is [`OUTSIDE_COLOR`].
pub fn heat_map(
    width: u32,
    height: u32,
    values: &[f32],
    full_scale: f32,
    inside: impl Fn(usize) -> bool,
) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let i = y as usize * width as usize + x as usize;
        Rgb(match values.get(i) {
            _ if !inside(i) => OUTSIDE_COLOR,
            Some(value) if value.is_finite() => inferno(value.abs() / full_scale),
            _ => NON_FINITE_COLOR,
        })
    })
}

/// Writes an 8-bit sRGB picture as PNG, under a temporary name that is then renamed.
///
/// # Errors
/// [`PictureError::Encode`] for a picture that PNG cannot hold, [`PictureError::Write`] for a file
/// that cannot be written.
pub fn write_png(path: &Path, image: &RgbImage) -> Result<(), PictureError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(
            image.as_raw(),
            image.width(),
            image.height(),
            ExtendedColorType::Rgb8,
        )
        .map_err(|error| PictureError::Encode {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
    Ok(replace_file(path, &bytes)?)
}
