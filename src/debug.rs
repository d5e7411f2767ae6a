//! Debug views as pictures: what each pixel shows, and the colours that stand for it.
use crate::picture::{
    OUTSIDE_COLOR, PictureError, cool_warm, inferno, linear_to_srgb, name_color, srgb_to_linear,
    write_png,
};
use gibs_passes::data::DebugPixel;
use gibs_passes::frame::{DebugScale, DebugView};
use image::{Rgb, RgbImage};
use std::path::Path;

/// The parts of the grid, as sRGB code values: grey, and six colours that colour-blind people tell apart as well (Okabe and
/// Ito 2008), the warm ones along x, the others along y and z.
const PARTS: [[u8; 3]; 7] = [
    [153, 153, 153],
    [213, 94, 0],
    [230, 159, 0],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [86, 180, 233],
];

/// What a frame drew as a [`DebugView`].
#[derive(Clone, Debug, PartialEq)]
pub struct DebugPicture {
    view: DebugView,
    size: [u32; 2],
    values: Vec<f32>,
    shades: Vec<f32>,
}

impl DebugPicture {
    /// From the pixels that a frame of this view and size has as its output `debug`, row by row from the top left. Those
    /// that are missing show nothing.
    pub fn new(view: DebugView, size: [u32; 2], pixels: &[DebugPixel]) -> Self {
        Self {
            view,
            size,
            values: pixels.iter().map(|p| p.value).collect(),
            shades: pixels.iter().map(|p| p.shade).collect(),
        }
    }

    /// What it shows.
    pub fn view(&self) -> DebugView {
        self.view
    }

    /// A value for each pixel, in [`DebugView::unit`]; -1 where there is nothing to show.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Least and largest value; `None` where no pixel shows anything.
    pub fn range(&self) -> Option<[f32; 2]> {
        let shown = self.values.iter().copied().filter(|&v| v >= 0.0);
        shown.fold(None, |range, v| match range {
            None => Some([v, v]),
            Some([least, most]) => Some([least.min(v), most.max(v)]),
        })
    }

    /// The values in the colours of [`DebugView::scale`], darker where the view draws shapes or lines;
    /// [`OUTSIDE_COLOR`] where there is nothing to show.
    pub fn image(&self) -> RgbImage {
        let [width, height] = self.size;
        RgbImage::from_fn(width, height, |x, y| {
            let i = y as usize * width as usize + x as usize;
            Rgb(match (self.values.get(i), self.shades.get(i)) {
                (Some(&value), Some(&shade)) if value >= 0.0 => {
                    shaded(color(self.view.scale(), value), shade)
                }
                _ => OUTSIDE_COLOR,
            })
        })
    }

    /// Writes [`DebugPicture::image`] as PNG.
    ///
    /// # Errors
    /// As [`write_png`].
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        write_png(path, &self.image())
    }
}

/// The sRGB colour of a value.
fn color(scale: DebugScale, value: f32) -> [u8; 3] {
    match scale {
        DebugScale::Names => name_color(value as u32),
        DebugScale::Parts => PARTS[(value as usize).min(PARTS.len() - 1)],
        DebugScale::Heat(most) => inferno(value / most),
        DebugScale::BlueToRed(most) => cool_warm(0.5 + 0.5 * value.ln() / most.ln()),
    }
}

/// A colour with its light scaled down.
fn shaded(color: [u8; 3], shade: f32) -> [u8; 3] {
    if shade >= 1.0 {
        return color;
    }
    let darken = |code: u8| linear_to_srgb(srgb_to_linear(f32::from(code) / 255.0) * shade);
    color.map(|code| (darken(code) * 255.0).round() as u8)
}
