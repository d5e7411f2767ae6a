//! What CPU kernels see of images: values by coordinates, row by row from the top left.
use crate::{RawView, ReadView, Sampled, Stored, WriteView};

/// Texels that a stage only reads.
pub struct ImageView<'a, T: Sampled> {
    texels: ReadView<'a, T::Value>,
    size: [u32; 2],
}

/// Texels that a stage writes, each from one workgroup only.
pub struct ImageStore<'a, T: Stored> {
    texels: WriteView<'a, T::Value>,
    size: [u32; 2],
}

impl<'a, T: Sampled> ImageView<'a, T> {
    /// A view of the whole image.
    pub fn of(raw: RawView<'a>) -> Self {
        Self {
            size: raw.size(),
            texels: ReadView::of(raw),
        }
    }

    /// A view of texels, row by row, for tests and for calls outside a graph.
    pub fn of_slice(texels: &'a [T::Value], size: [u32; 2]) -> Self {
        Self {
            texels: ReadView::of_slice(texels),
            size,
        }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The texel at column `x` of row `y`.
    ///
    /// # Panics
    /// Outside the image: a bug in the kernel.
    #[inline]
    #[track_caller]
    pub fn load(&self, x: u32, y: u32) -> T::Value {
        self.texels[index(self.size, x, y)]
    }
}

impl<'a, T: Stored> ImageStore<'a, T> {
    /// A view of the whole image, as [`WriteView::of`].
    pub fn of(raw: RawView<'a>, group: u32) -> Self {
        Self {
            size: raw.size(),
            texels: WriteView::of(raw, group),
        }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Replaces the texel at column `x` of row `y`, rounded as the format has it.
    ///
    /// # Panics
    /// Outside the image: a bug in the kernel.
    #[inline]
    #[track_caller]
    pub fn store(&self, x: u32, y: u32, value: T::Value) {
        self.texels.set(index(self.size, x, y), T::rounded(value));
    }
}

#[inline]
#[track_caller]
fn index([width, height]: [u32; 2], x: u32, y: u32) -> usize {
    assert!(
        x < width && y < height,
        "texel ({x}, {y}) of an image of {width}x{height}"
    );
    y as usize * width as usize + x as usize
}
