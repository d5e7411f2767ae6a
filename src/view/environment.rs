//! Reading of environment maps.
use super::ViewError;
use exr::prelude::{ReadChannels, ReadLayers, read};
use gibs_passes::scene::{EnvironmentMap, clamp_radiance};
use glam::Vec3;
use image::{DynamicImage, ImageDecoder, codecs::hdr::HdrDecoder};
use std::{fs::File, io::BufReader, path::Path};

/// Largest number of texels that is read: a map of 16384 x 8192, 1.5 GiB as it is held.
const MAX_TEXELS: u64 = 1 << 27;

/// Most texels that one byte of a file can stand for. zlib, the best of OpenEXR's codings, has fewer than two hundred of one
/// value, and Radiance's run lengths sixty-four.
const MAX_TEXELS_PER_BYTE: u64 = 4096;

/// Width, height and texels as the file has them.
type Raw = (u32, u32, Vec<Vec3>);

/// Reads the map, applies `scale` and clamps bad texels, which are counted in one of the `warnings`.
pub(crate) fn load(
    file: &Path,
    scale: f32,
    warnings: &mut Vec<String>,
) -> Result<EnvironmentMap, ViewError> {
    let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
    let (width, height, mut texels) = match extension.as_deref() {
        Some("hdr" | "pic" | "rgbe") => read_hdr(file)?,
        Some("exr") => read_exr(file)?,
        _ => {
            let problem = "its name ends neither in .hdr nor in .exr".to_owned();
            return Err(wrong(file, problem, "give a Radiance or an OpenEXR image"));
        }
    };
    let mut clamped = 0_usize;
    for texel in &mut texels {
        let wanted = *texel * scale;
        *texel = clamp_radiance(wanted);
        // NaN differs from everything, so it counts too.
        clamped += usize::from(*texel != wanted);
    }
    if clamped > 0 {
        warnings.push(format!(
            "environment map {}: {clamped} of {} texels were negative, not finite or above 1e13 and were clamped",
            file.display(),
            texels.len()
        ));
    }
    Ok(EnvironmentMap {
        width,
        height,
        texels,
        rotation_y: 0.0,
    })
}

fn wrong(file: &Path, problem: String, remedy: &'static str) -> ViewError {
    ViewError::Environment {
        file: file.to_owned(),
        problem,
        remedy,
    }
}

/// Refuses a size before anything of that size is allocated: one that is too large, and one that the file's length does not
/// bear out.
fn check_size(file: &Path, width: u64, height: u64) -> Result<(), ViewError> {
    let problem = format!("it is {width} x {height}");
    if width == 0 || height == 0 {
        return Err(wrong(file, problem, "give an image with texels"));
    }
    if width.saturating_mul(height) > MAX_TEXELS {
        return Err(wrong(
            file,
            problem,
            "scale it down to at most 16384 x 8192",
        ));
    }
    // What is no regular file says no length, and is read as far as it goes.
    let metadata = std::fs::metadata(file)
        .ok()
        .filter(std::fs::Metadata::is_file);
    if let Some(bytes) = metadata.map(|metadata| metadata.len())
        && width * height > bytes.saturating_mul(MAX_TEXELS_PER_BYTE)
    {
        let problem = format!("{problem}, but the file has only {bytes} bytes");
        return Err(wrong(file, problem, "copy or save it again"));
    }
    Ok(())
}

fn read_hdr(file: &Path) -> Result<Raw, ViewError> {
    let bad = |e: image::ImageError| {
        wrong(
            file,
            e.to_string(),
            "save it again as a Radiance .hdr image",
        )
    };
    let opened = File::open(file).map_err(|source| ViewError::Read {
        file: file.to_owned(),
        source,
    })?;
    let decoder = HdrDecoder::new(BufReader::new(opened)).map_err(bad)?;
    let (width, height) = decoder.dimensions();
    check_size(file, u64::from(width), u64::from(height))?;
    let image = DynamicImage::from_decoder(decoder)
        .map_err(bad)?
        .into_rgb32f();
    Ok((
        width,
        height,
        image.pixels().map(|p| Vec3::from_array(p.0)).collect(),
    ))
}

fn read_exr(file: &Path) -> Result<Raw, ViewError> {
    let bad = |e: exr::error::Error| match e {
        exr::error::Error::Io(source) => ViewError::Read {
            file: file.to_owned(),
            source,
        },
        e => wrong(
            file,
            e.to_string(),
            "save it again as an OpenEXR image with channels R, G and B",
        ),
    };
    let meta = exr::meta::MetaData::read_from_file(file, false).map_err(bad)?;
    for header in &meta.headers {
        check_size(
            file,
            header.layer_size.x() as u64,
            header.layer_size.y() as u64,
        )?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![Vec3::ZERO; size.area()]),
            |(width, texels): &mut (usize, Vec<Vec3>), at, (r, g, b): (f32, f32, f32)| {
                texels[at.y() * *width + at.x()] = Vec3::new(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(file)
        .map_err(bad)?;
    let layer = image.layer_data;
    Ok((
        layer.size.width() as u32,
        layer.size.height() as u32,
        layer.channel_data.pixels.1,
    ))
}
