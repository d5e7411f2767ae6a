//! OpenEXR files: every channel, 32-bit float, without loss.
use std::collections::BTreeMap;
use std::io::{Cursor, ErrorKind};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image,
    Layer, LayerAttributes, LineOrder, MetaData, ReadChannels, ReadLayers, Text, WritableImage,
    read,
};

use super::{Picture, PictureError};

/// The first four bytes of every OpenEXR file.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The most values (pixels times channels) read from one file, 4 GiB of memory: a damaged header
/// must not make the program ask for more.
const MAX_VALUES: usize = 1 << 30;

/// Most values that one byte of a file can stand for: zlib, the best of the codings, has about five hundred halves of one
/// value.
const MAX_VALUES_PER_BYTE: usize = 4096;

impl Picture {
    /// Reads every channel of an OpenEXR file. Half and integer channels become float. The channels
    /// of a file with several parts get the part's name in front; the largest level of a tiled file
    /// is taken.
    ///
    /// # Errors
    /// [`PictureError`] for a missing, unreadable, foreign, damaged or too large file; for deep
    /// data, subsampled channels, a data window other than the display window, or parts of
    /// different sizes.
    pub fn read_exr(path: &Path) -> Result<Self, PictureError> {
        Ok(Self::read_exr_with_notes(path)?.0)
    }

    /// As [`Picture::read_exr`], with the file's attributes that are text and not among OpenEXR's standard ones.
    ///
    /// # Errors
    /// As [`Picture::read_exr`].
    pub fn read_exr_with_notes(
        path: &Path,
    ) -> Result<(Self, BTreeMap<String, String>), PictureError> {
        let bytes = crate::files::read(path).map_err(|source| match source.kind() {
            ErrorKind::NotFound => PictureError::Missing {
                path: path.to_owned(),
            },
            _ => PictureError::Unreadable {
                path: path.to_owned(),
                source,
            },
        })?;
        if !bytes.starts_with(&MAGIC) {
            return Err(PictureError::NotExr {
                path: path.to_owned(),
                start: start_of(&bytes),
            });
        }
        let meta = MetaData::read_from_buffered(bytes.as_slice(), false)
            .map_err(|e| decode_error(path, e))?;
        check_headers(path, &meta, bytes.len())?;
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(|e| decode_error(path, e))?;

        let several = image.layer_data.len() > 1;
        let mut picture = Self::default();
        let mut notes = BTreeMap::new();
        for layer in image.layer_data {
            let others = layer.attributes.other.iter();
            notes.extend(others.filter_map(|(name, value)| match value {
                AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
                _ => None,
            }));
            picture.width = layer.size.width() as u32;
            picture.height = layer.size.height() as u32;
            let part = layer
                .attributes
                .layer_name
                .filter(|_| several)
                .map(|name| name.to_string());
            for channel in layer.channel_data.list {
                let name = match &part {
                    Some(part) => format!("{part}.{}", channel.name),
                    None => channel.name.to_string(),
                };
                picture.set_scalar(&name, floats(channel.sample_data))?;
            }
        }
        Ok((picture, notes))
    }

    /// Writes every channel as 32-bit float, losslessly compressed, under a temporary name that is
    /// then renamed.
    ///
    /// # Errors
    /// [`PictureError`] for a picture without pixels or channels, a channel of the wrong length or
    /// with a name that OpenEXR cannot hold, or a file that cannot be written.
    pub fn write_exr(&self, path: &Path) -> Result<(), PictureError> {
        self.write_exr_with_notes(path, &BTreeMap::new())
    }

    /// As [`Picture::write_exr`], with attributes of text.
    ///
    /// # Errors
    /// As [`Picture::write_exr`]; notes whose name or text OpenEXR cannot hold are left out.
    pub fn write_exr_with_notes(
        &self,
        path: &Path,
        notes: &BTreeMap<String, String>,
    ) -> Result<(), PictureError> {
        if self.pixels() == 0 || self.channels.is_empty() {
            return Err(PictureError::Empty {
                path: path.to_owned(),
                width: self.width,
                height: self.height,
                channels: self.channels.len(),
            });
        }
        let channels = self
            .channels
            .keys()
            .map(|name| {
                let values = self.scalar(name)?.to_vec();
                Ok(AnyChannel::new(text(path, name)?, FlatSamples::F32(values)))
            })
            .collect::<Result<_, PictureError>>()?;
        let attributes = LayerAttributes {
            software_name: Text::new_or_none(concat!("gibs ", env!("CARGO_PKG_VERSION"))),
            other: notes
                .iter()
                .filter_map(|(name, text)| {
                    let text = AttributeValue::Text(Text::new_or_none(text)?);
                    Some((Text::new_or_none(name)?, text))
                })
                .collect(),
            ..LayerAttributes::default()
        };
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let size = (self.width as usize, self.height as usize);
        let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .map_err(|error| PictureError::Encode {
                path: path.to_owned(),
                reason: error.to_string(),
            })?;
        Ok(super::replace_file(path, bytes.get_ref())?)
    }
}

/// Refuses what the decoder would misread or what would not fit in memory, before any pixel is
/// decoded. `bytes` is the length of the file.
fn check_headers(path: &Path, meta: &MetaData, bytes: usize) -> Result<(), PictureError> {
    let unsupported = |what: String, remedy| {
        Err(PictureError::Unsupported {
            path: path.to_owned(),
            what,
            remedy,
        })
    };
    let mut values = 0_usize;
    let channels = meta
        .headers
        .iter()
        .map(|header| header.channels.list.len())
        .sum();
    let first = meta.headers.first().map(|header| header.layer_size);
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        if header.deep {
            return unsupported(
                "it holds deep data".to_owned(),
                "flatten it to one value per pixel",
            );
        }
        if let Some(channel) = header
            .channels
            .list
            .iter()
            .find(|c| (c.sampling.x(), c.sampling.y()) != (1, 1))
        {
            return unsupported(
                format!("channel {} is subsampled", channel.name),
                "write every channel at full resolution",
            );
        }
        if first != Some(header.layer_size) {
            return unsupported(
                "its parts differ in size".to_owned(),
                "write one part, or parts of one size",
            );
        }
        // A shifted data window would lay pixels of different places over one another.
        if header.data_window() != header.shared_attributes.display_window {
            return unsupported(
                "its data window differs from its display window".to_owned(),
                "crop or pad it to the display window",
            );
        }
        let area = width.checked_mul(height);
        let size = area.and_then(|area| area.checked_mul(header.channels.list.len()));
        values = size
            .and_then(|size| size.checked_add(values))
            .unwrap_or(usize::MAX);
        if values > MAX_VALUES {
            return Err(PictureError::TooLarge {
                path: path.to_owned(),
                width,
                height,
                channels,
                limit: MAX_VALUES,
            });
        }
        if values > bytes.saturating_mul(MAX_VALUES_PER_BYTE) {
            return Err(PictureError::Damaged {
                path: path.to_owned(),
                reason: format!(
                    "{width}x{height} pixels with {channels} channels in a file of only {bytes} bytes"
                ),
            });
        }
    }
    Ok(())
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        other => other.values_as_f32().collect(),
    }
}

fn text(path: &Path, name: &str) -> Result<Text, PictureError> {
    // OpenEXR ends a list of channels with an empty name, and holds at most 255 bytes.
    let fits = name.is_ascii() && !name.contains('\0') && (1..=255).contains(&name.len());
    let text = if fits { Text::new_or_none(name) } else { None };
    text.ok_or_else(|| PictureError::ChannelName {
        path: path.to_owned(),
        name: name.to_owned(),
    })
}

fn start_of(bytes: &[u8]) -> String {
    let shown: Vec<String> = bytes
        .iter()
        .take(8)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    if shown.is_empty() {
        "nothing: it is empty".to_owned()
    } else {
        shown.join(" ")
    }
}

fn decode_error(path: &Path, error: exr::error::Error) -> PictureError {
    match error {
        exr::error::Error::NotSupported(what) => PictureError::Unsupported {
            path: path.to_owned(),
            what: format!("it uses a feature that is not supported ({what})"),
            remedy: "write it as scan lines with ZIP compression",
        },
        other => PictureError::Damaged {
            path: path.to_owned(),
            reason: other.to_string(),
        },
    }
}
