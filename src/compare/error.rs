//! Why two pictures cannot be compared.
use crate::picture::PictureError;

/// An error about a comparison.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// Our picture lacks what is compared.
    #[error("our picture: {0}")]
    Ours(#[source] PictureError),
    /// The truth lacks what is compared.
    #[error("the truth: {0}")]
    Truth(#[source] PictureError),
    /// The sizes do not fit.
    #[error(
        "our picture has {ours_width}x{ours_height} pixels, the truth \
         {truth_width}x{truth_height}; render at the truth's size or \
         at one whole multiple of it in both directions"
    )]
    Size {
        /// Our width in pixels.
        ours_width: u32,
        /// Our height in pixels.
        ours_height: u32,
        /// The truth's width in pixels.
        truth_width: u32,
        /// The truth's height in pixels.
        truth_height: u32,
    },
    /// Cells of an even size have no middle.
    #[error(
        "our picture is {factor} times as large as the truth, and only an odd multiple has pixels whose centres are \
         the truth's; render at such a size, or compare without --centers"
    )]
    NoCenters {
        /// Our pixels in a row for each one of the truth's.
        factor: usize,
    },
    /// No pixel is left to compare.
    #[error(
        "none of the truth's {pixels} pixels is left to compare ({missed} hit nothing, \
         {blended} lie behind a blended surface, {fireflies} are fireflies); \
         choose another view or truth"
    )]
    EmptyMask {
        /// Pixels of the truth.
        pixels: usize,
        /// Pixels without `mask.A` = 1.
        missed: usize,
        /// Pixels left out for `blend.A`.
        blended: usize,
        /// Pixels left out for `firefly.A`.
        fireflies: usize,
    },
    /// The relative errors have no scale.
    #[error(
        "the truth's mean luminance over its mask is {mean}, which gives relative errors no scale; \
         choose a layer or a view with light in it"
    )]
    BlackTruth {
        /// The mean, in the layer's units.
        mean: f64,
    },
    /// The truth itself is spoiled.
    #[error(
        "the truth has {count} pixels within its mask that are not finite, the first at \
         ({x}, {y}); render it again or mark them in firefly.A"
    )]
    TruthNotFinite {
        /// How many.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
    },
    /// An exposure that cannot be used.
    #[error("the exposure is {exposure}; use a positive number, such as 1")]
    Exposure {
        /// The factor asked for.
        exposure: f64,
    },
}
