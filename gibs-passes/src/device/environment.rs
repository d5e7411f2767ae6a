//! The environment as an octahedral map with a table for importance sampling.
use crate::scene::{Environment, EnvironmentMap};
use crate::shared::environment::{direction, solid_angle_per_area};
use crate::shared::estimator::luminance;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Side of the octahedral map that a latitude-longitude map becomes, texels.
const SIDE: u32 = 512;

/// Samples along each side of a texel when a map is converted.
const TAPS: u32 = 3;

/// An environment map on the device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvironmentTable {
    /// Side of the map; 1 for a constant sky.
    pub side: u32,
    /// `rgb` radiance, W/(m^2 sr); `a` density of emitter sampling per area of the square `[-1, 1]^2`.
    pub texels: Vec<Vec4>,
    /// Cumulative probability of the texels, for emitter sampling; one element for a constant sky.
    pub cumulative: Vec<f32>,
    /// Emitter sampling covers the environment.
    pub sampled: bool,
    /// Luminance from all directions together, W/m^2.
    pub power: f32,
}

impl EnvironmentTable {
    /// No light comes from anywhere.
    pub fn is_black(&self) -> bool {
        self.texels
            .iter()
            .all(|texel| texel.truncate() == Vec3::ZERO)
    }

    /// Converts an environment. A constant one is left to cosine sampling.
    pub fn build(environment: &Environment) -> Self {
        match environment {
            Environment::Constant(radiance) => Self {
                side: 1,
                texels: vec![radiance.extend(0.0)],
                cumulative: vec![1.0],
                sampled: false,
                power: luminance(*radiance) * 4.0 * PI,
            },
            Environment::Map(map) => Self::from_map(map),
        }
    }

    fn from_map(map: &EnvironmentMap) -> Self {
        let radiances: Vec<Vec3> = (0..SIDE * SIDE)
            .into_par_iter()
            .map(|i| resample(map, i % SIDE, i / SIDE))
            .collect();
        let power = |i: usize| {
            let middle = direction(SIDE, i as u32 % SIDE, i as u32 / SIDE, 0.5, 0.5);
            f64::from(luminance(radiances[i]) * solid_angle_per_area(middle))
        };
        let total: f64 = (0..radiances.len()).map(power).sum();
        if total <= 0.0 {
            return Self {
                side: 1,
                texels: vec![Vec4::ZERO],
                cumulative: vec![1.0],
                sampled: false,
                power: 0.0,
            };
        }
        let area = 4.0 / f64::from(SIDE * SIDE);
        let mut sum = 0.0;
        let mut cumulative = Vec::with_capacity(radiances.len());
        let mut texels = Vec::with_capacity(radiances.len());
        for (i, radiance) in radiances.iter().enumerate() {
            let share = power(i) / total;
            sum += share;
            cumulative.push(sum as f32);
            texels.push(radiance.extend((share / area) as f32));
        }
        Self {
            side: SIDE,
            texels,
            cumulative,
            sampled: true,
            power: total as f32,
        }
    }
}

/// Mean radiance of a texel of the octahedral map.
fn resample(map: &EnvironmentMap, x: u32, y: u32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for tap in 0..TAPS * TAPS {
        let at = |i: u32| (i as f32 + 0.5) / TAPS as f32;
        sum += look_up(
            map,
            direction(SIDE, x, y, at(tap % TAPS), at(tap / TAPS)).as_dvec3(),
        );
    }
    sum / (TAPS * TAPS) as f32
}

/// Bilinear radiance of a latitude-longitude map.
fn look_up(map: &EnvironmentMap, d: DVec3) -> Vec3 {
    use std::f64::consts::{PI, TAU};
    let turned = glam::DQuat::from_rotation_y(-map.rotation_y) * d;
    let u = (turned.x.atan2(-turned.z) / TAU).rem_euclid(1.0);
    let v = turned.y.clamp(-1.0, 1.0).acos() / PI;
    let (x, y) = (
        u * f64::from(map.width) - 0.5,
        v * f64::from(map.height) - 0.5,
    );
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
    let texel = |dx: f64, dy: f64| {
        let column = (x0 + dx).rem_euclid(f64::from(map.width)) as usize;
        let row = (y0 + dy).clamp(0.0, f64::from(map.height) - 1.0) as usize;
        map.texels[row * map.width as usize + column]
    };
    texel(0.0, 0.0)
        .lerp(texel(1.0, 0.0), fx)
        .lerp(texel(0.0, 1.0).lerp(texel(1.0, 1.0), fx), fy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map that is 1 in the upper half: irradiance on a surface facing up is pi, and the densities sum to one.
    #[test]
    fn conversion_keeps_energy_and_orientation() {
        let (width, height) = (64, 32);
        let texels = (0..width * height)
            .map(|i| {
                if i / width < height / 2 {
                    Vec3::ONE
                } else {
                    Vec3::ZERO
                }
            })
            .collect();
        let map = EnvironmentMap {
            width,
            height,
            texels,
            rotation_y: 0.0,
        };
        let table = EnvironmentTable::build(&Environment::Map(map));
        let area = 4.0 / (table.side * table.side) as f32;
        let (mut irradiance, mut density) = (0.0f64, 0.0f64);
        for (i, texel) in table.texels.iter().enumerate() {
            let d = direction(
                table.side,
                i as u32 % table.side,
                i as u32 / table.side,
                0.5,
                0.5,
            );
            irradiance += f64::from(texel.x * d.y.max(0.0) * solid_angle_per_area(d) * area);
            density += f64::from(texel.w * area);
        }
        assert!(
            (irradiance - std::f64::consts::PI).abs() < 0.01,
            "{irradiance}"
        );
        assert!((density - 1.0).abs() < 1e-4, "{density}");
    }
}
