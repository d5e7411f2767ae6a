//! Environments made by code, so that the test bed needs nothing downloaded.
use gibs_passes::scene::EnvironmentMap;
use glam::Vec3;
use std::f32::consts::PI;

/// Width and height, texels.
const SIZE: [u32; 2] = [512, 256];

/// Name and radiance by elevation and azimuth, radians, the latter in `[0, 2 pi)`.
type Entry = (&'static str, fn(f32, f32) -> Vec3);

const ENVIRONMENTS: [Entry; 3] = [("windows", windows), ("sun", sun), ("overcast", overcast)];

/// What can be asked for.
pub fn names() -> impl Iterator<Item = &'static str> {
    ENVIRONMENTS.iter().map(|(name, _)| *name)
}

/// An environment by its name: `windows`, a dark hall with a bright band at the horizon; `sun`, a small low sun under a
/// clear sky; `overcast`, a sky that guides can gain nothing from.
pub fn built_in(name: &str) -> Option<EnvironmentMap> {
    let (_, radiance) = ENVIRONMENTS.iter().find(|(known, _)| *known == name)?;
    let [width, height] = SIZE;
    let texel = |i: u32| {
        let elevation = PI * (0.5 - ((i / width) as f32 + 0.5) / height as f32);
        let azimuth = 2.0 * PI * ((i % width) as f32 + 0.5) / width as f32;
        radiance(elevation, azimuth)
    };
    Some(EnvironmentMap {
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
        rotation_y: 0.0,
    })
}

/// Twelve panes of 20 by 12 degrees around the horizon, 100 times as bright as the hall.
fn windows(elevation: f32, azimuth: f32) -> Vec3 {
    let in_pane = (azimuth.to_degrees() % 30.0) < 20.0;
    let hall = Vec3::new(0.10, 0.09, 0.08);
    match in_pane && (0.0..12.0).contains(&elevation.to_degrees()) {
        true => Vec3::new(9.0, 10.0, 11.0),
        false => hall,
    }
}

/// A disc 6 degrees wide, 20 degrees above the horizon, which gives about as much light as sky and ground together.
fn sun(elevation: f32, azimuth: f32) -> Vec3 {
    let at = |elevation: f32, azimuth: f32| {
        let (sin, cos) = elevation.sin_cos();
        Vec3::new(cos * azimuth.cos(), sin, cos * azimuth.sin())
    };
    let towards = at(elevation, azimuth).dot(at(20f32.to_radians(), 1.0));
    if towards > 3f32.to_radians().cos() {
        Vec3::new(420.0, 360.0, 270.0)
    } else if elevation > 0.0 {
        Vec3::new(0.6, 0.9, 1.4)
    } else {
        Vec3::new(0.30, 0.27, 0.22)
    }
}

/// The sky of the standard of the International Commission on Illumination (CIE S 011, type 1): three times as bright at the
/// zenith as at the horizon; the ground reflects a fifth.
fn overcast(elevation: f32, _: f32) -> Vec3 {
    match elevation > 0.0 {
        true => Vec3::splat((1.0 + 2.0 * elevation.sin()) / 3.0),
        false => Vec3::splat(0.15),
    }
}
