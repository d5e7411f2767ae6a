//! Decodes the images that surfaces use.
use super::source::Source;
use super::uri::{self, Target};
use gibs_passes::scene::Texture;
use gltf::json;
use image::{ImageFormat, ImageReader};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Cursor;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Most texels of all images together, as many as a scene can have.
const MOST_TEXELS: u64 = i32::MAX as u64;

/// Decodes the given images in parallel; the result is in their order. An error is a warning for the user.
pub(super) fn decode(
    source: &Source,
    images: &[json::Index<json::Image>],
) -> Vec<Result<Texture, String>> {
    let texels = AtomicU64::new(0);
    images
        .par_iter()
        .map(|&index| {
            let name = || format!("images[{}]", index.value());
            let image = source
                .root
                .images
                .get(index.value())
                .ok_or_else(|| format!("{} does not exist", name()))?;
            read(source, index, image, &texels).map_err(|problem| {
                format!(
                    "{}: {}: {problem}; surfaces keep their plain factor",
                    source.file.display(),
                    name()
                )
            })
        })
        .collect()
}

fn read(
    source: &Source,
    index: json::Index<json::Image>,
    image: &json::Image,
    texels: &AtomicU64,
) -> Result<Texture, String> {
    let (bytes, place): (Cow<[u8]>, String) = match (image.buffer_view, &image.uri) {
        (Some(view), _) => {
            let view = source.view(view, || format!("images[{}]", index.value()));
            (view.map_err(|e| e.to_string())?.0.into(), String::new())
        }
        (None, Some(uri)) => match uri::resolve(&source.file, uri)? {
            Target::Data(bytes) => (bytes.into(), String::new()),
            Target::File(path) => {
                let bytes = uri::read(&path)
                    .map_err(|e| format!("cannot read {}: {e}; add the file", path.display()))?;
                (bytes.into(), format!("{}: ", path.display()))
            }
        },
        (None, None) => return Err("has neither a uri nor a bufferView; add one".to_owned()),
    };
    let format = format(&bytes).map_err(|problem| format!("{place}{problem}"))?;
    let size = ImageReader::with_format(Cursor::new(bytes.as_ref()), format).into_dimensions();
    let [width, height] = match size {
        Ok((width, height)) => [width, height].map(u64::from),
        Err(e) => return Err(format!("{place}cannot be decoded: {e}; save it again")),
    };
    let own = width.saturating_mul(height);
    if texels.fetch_add(own, Relaxed).saturating_add(own) > MOST_TEXELS {
        return Err(format!(
            "{place}has {width}x{height} texels, with which all images have more than {MOST_TEXELS}; make some smaller"
        ));
    }
    // The reader's default limits refuse images of more than 512 MiB.
    let decoded = ImageReader::with_format(Cursor::new(bytes), format).decode();
    let rgba = decoded
        .map_err(|e| format!("{place}cannot be decoded: {e}; save it again"))?
        .into_rgba8();
    Ok(Texture {
        name: image
            .name
            .clone()
            .or_else(|| image.uri.clone().filter(|uri| !uri.starts_with("data:")))
            .unwrap_or_else(|| format!("images[{}]", index.value())),
        width: rgba.width(),
        height: rgba.height(),
        texels: rgba.pixels().map(|texel| texel.0).collect(),
    })
}

/// The format by the first bytes, since `mimeType` and file names are often wrong.
fn format(bytes: &[u8]) -> Result<ImageFormat, String> {
    let other = match bytes {
        [0x89, b'P', b'N', b'G', ..] => return Ok(ImageFormat::Png),
        [0xff, 0xd8, 0xff, ..] => return Ok(ImageFormat::Jpeg),
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => "WebP",
        [0xab, b'K', b'T', b'X', ..] => "KTX",
        [b'D', b'D', b'S', b' ', ..] => "DDS",
        _ => "of an unknown format",
    };
    Err(format!(
        "is {other}; only PNG and JPEG are read, so convert it"
    ))
}
