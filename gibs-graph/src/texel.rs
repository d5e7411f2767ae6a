//! Images: what their texels are. Images exist only where a frame meets the outside; stages exchange buffers.
use crate::{Element, Layout};
use glam::{UVec4, Vec4};
use half::f16;
use serde::{Deserialize, Serialize};

/// The texels of an image, as a type. Kernels see [`Texel::Value`]s, whatever the format in memory is.
pub trait Texel: Send + Sync + 'static {
    /// What a load gives and a store takes: four numbers.
    type Value: Element;
    /// How devices see it.
    const FORMAT: ImageFormat;
}

/// Texels that stages read, by coordinates and without filtering.
pub trait Sampled: Texel {}

/// Texels that stages write.
pub trait Stored: Texel {
    /// The value that comes back from the format.
    fn rounded(value: Self::Value) -> Self::Value;
}

/// How devices see an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ImageFormat {
    /// `texture_2d<f32>`: any format of floats or normalized integers that can be sampled, depth included.
    Float,
    /// `texture_2d<u32>`: any format of unsigned integers.
    Uint,
    /// `texture_storage_2d<rgba16float, write>`.
    Rgba16Float,
    /// `texture_storage_2d<rgba32float, write>`.
    Rgba32Float,
    /// `texture_storage_2d<rgba8unorm, write>`.
    Rgba8Unorm,
}

/// Floats that stages read: colours, normals, depths. A depth is in the first component.
#[derive(Clone, Copy, Debug)]
pub struct Float;

/// Unsigned integers that stages read: ids.
#[derive(Clone, Copy, Debug)]
pub struct Uint;

/// Four 16-bit floats that a stage writes.
#[derive(Clone, Copy, Debug)]
pub struct Rgba16Float;

/// Four 32-bit floats that a stage writes.
#[derive(Clone, Copy, Debug)]
pub struct Rgba32Float;

/// Four bytes that a stage writes, 0 to 1 each.
#[derive(Clone, Copy, Debug)]
pub struct Rgba8Unorm;

impl Texel for Float {
    type Value = Vec4;
    const FORMAT: ImageFormat = ImageFormat::Float;
}

impl Sampled for Float {}

impl Texel for Uint {
    type Value = UVec4;
    const FORMAT: ImageFormat = ImageFormat::Uint;
}

impl Sampled for Uint {}

impl Texel for Rgba16Float {
    type Value = Vec4;
    const FORMAT: ImageFormat = ImageFormat::Rgba16Float;
}

impl Stored for Rgba16Float {
    fn rounded(value: Vec4) -> Vec4 {
        value.map(|x| f16::from_f32(x).to_f32())
    }
}

impl Texel for Rgba32Float {
    type Value = Vec4;
    const FORMAT: ImageFormat = ImageFormat::Rgba32Float;
}

impl Stored for Rgba32Float {
    fn rounded(value: Vec4) -> Vec4 {
        value
    }
}

impl Texel for Rgba8Unorm {
    type Value = Vec4;
    const FORMAT: ImageFormat = ImageFormat::Rgba8Unorm;
}

impl Stored for Rgba8Unorm {
    fn rounded(value: Vec4) -> Vec4 {
        value.map(|x| f32::from(unorm8(x)) / 255.0)
    }
}

fn unorm8(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0).round_ties_even() as u8
}

impl ImageFormat {
    /// Every format.
    pub const ALL: [ImageFormat; 5] = [
        ImageFormat::Float,
        ImageFormat::Uint,
        ImageFormat::Rgba16Float,
        ImageFormat::Rgba32Float,
        ImageFormat::Rgba8Unorm,
    ];

    /// Layout of a [`Texel::Value`].
    pub fn value(self) -> Layout {
        match self {
            ImageFormat::Uint => UVec4::layout(),
            _ => Vec4::layout(),
        }
    }

    /// Stages write it.
    pub fn is_stored(self) -> bool {
        !matches!(self, ImageFormat::Float | ImageFormat::Uint)
    }

    /// Bytes of a texel in an image of this format that a backend makes itself: of sampled ones, 32 bits a component.
    pub fn texel_bytes(self) -> u32 {
        match self {
            ImageFormat::Float | ImageFormat::Uint | ImageFormat::Rgba32Float => 16,
            ImageFormat::Rgba16Float => 8,
            ImageFormat::Rgba8Unorm => 4,
        }
    }

    /// Bytes of values as bytes of texels.
    pub fn encode(self, values: &[u8]) -> Vec<u8> {
        let numbers = values
            .as_chunks::<4>()
            .0
            .iter()
            .map(|b| f32::from_ne_bytes(*b));
        match self {
            ImageFormat::Rgba16Float => numbers
                .flat_map(|x| f16::from_f32(x).to_ne_bytes())
                .collect(),
            ImageFormat::Rgba8Unorm => numbers.map(unorm8).collect(),
            _ => values.to_vec(),
        }
    }

    /// Bytes of texels as bytes of values.
    pub fn decode(self, texels: &[u8]) -> Vec<u8> {
        match self {
            ImageFormat::Rgba16Float => {
                let halves = texels.as_chunks::<2>().0.iter();
                halves
                    .flat_map(|b| f16::from_ne_bytes(*b).to_f32().to_ne_bytes())
                    .collect()
            }
            ImageFormat::Rgba8Unorm => texels
                .iter()
                .flat_map(|b| (f32::from(*b) / 255.0).to_ne_bytes())
                .collect(),
            _ => texels.to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every 16-bit float survives, infinities and subnormals included; NaN stays NaN.
    #[test]
    fn halves_round_trip() {
        for bits in 0..=u16::MAX {
            let x = f16::from_bits(bits).to_f32();
            let y = Rgba16Float::rounded(Vec4::splat(x)).x;
            assert!(
                x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan()),
                "{bits:#x}"
            );
        }
        let beyond = Rgba16Float::rounded(Vec4::new(65_519.0, 65_520.0, 1e-9, -0.0));
        assert_eq!(beyond.x, 65_504.0);
        assert_eq!(beyond.y, f32::INFINITY);
        assert_eq!(beyond.z, 0.0);
        assert!(beyond.w.is_sign_negative());
    }

    #[test]
    fn bytes_clamp_and_round() {
        let got = Rgba8Unorm::rounded(Vec4::new(-1.0, 2.0, f32::NAN, 0.5));
        assert_eq!(got, Vec4::new(0.0, 1.0, 0.0, 128.0 / 255.0));
    }

    #[test]
    fn encoding_gives_rounded_values_back() {
        let values = [
            Vec4::new(0.1, 1.0, 0.0, 0.333),
            Vec4::new(2.0, -3.5, 1e6, 0.7),
        ];
        let bytes = bytemuck::cast_slice(&values);
        let back = |format: ImageFormat| -> Vec<Vec4> {
            let texels = format.encode(bytes);
            assert_eq!(texels.len(), values.len() * format.texel_bytes() as usize);
            let bytes = format.decode(&texels);
            let values = bytes.as_chunks::<16>().0.iter();
            values.map(|b| bytemuck::pod_read_unaligned(b)).collect()
        };
        assert_eq!(back(ImageFormat::Rgba32Float), values);
        assert_eq!(
            back(ImageFormat::Rgba16Float),
            values.map(Rgba16Float::rounded)
        );
        assert_eq!(
            back(ImageFormat::Rgba8Unorm),
            values.map(Rgba8Unorm::rounded)
        );
    }
}
