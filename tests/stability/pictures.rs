//! Pictures of error, for people: only where `GIBS_STABILITY_PICTURES` names a folder.
use gibs::picture::{Picture, heat_map, write_png};
use std::path::PathBuf;

/// Writes the magnitudes of `errors`, one a pixel, as a heat map that is pale yellow at `full_scale`. Pixels without a surface
/// are grey.
pub fn errors(case: &str, backend: &str, picture: &Picture, errors: &[f64], full_scale: f64) {
    let Some(path) = path(case, backend) else {
        return;
    };
    let mask = picture.scalar("mask.A").expect("a mask");
    let values: Vec<f32> = errors.iter().map(|&e| e as f32).collect();
    let (width, height) = (picture.width, picture.height);
    let image = heat_map(width, height, &values, full_scale as f32, |i| mask[i] > 0.0);
    write_png(&path, &image).unwrap_or_else(|e| panic!("{e}"));
}

/// Writes E, as a heat map up to its own largest value: for cases whose error is one number.
pub fn irradiance(case: &str, backend: &str, picture: &Picture) {
    let levels = super::measure::levels(picture, "E");
    let most = levels.iter().fold(f64::MIN_POSITIVE, |a, &b| a.max(b));
    errors(case, backend, picture, &levels, most);
}

fn path(case: &str, backend: &str) -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("GIBS_STABILITY_PICTURES")?);
    std::fs::create_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    Some(folder.join(format!("{case}-{backend}.png")))
}
