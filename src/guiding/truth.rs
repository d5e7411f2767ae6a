//! Irradiance by numerical integration over the texels of a sky.
use gibs_passes::device::EnvironmentTable;
use gibs_passes::shared::estimator::luminance;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Points along each side of a texel: for the texels that the probe's horizon cuts.
const POINTS: u32 = 3;

/// Luminance of the irradiance on a surface with this unit normal, W/m^2, in double precision: the sum over the texels of
/// the octahedral map of radiance times cosine times solid angle. The radiance is that which rays get: one value for each
/// texel.
pub fn irradiance(sky: &EnvironmentTable, normal: Vec3) -> f64 {
    let side = sky.side;
    let normal = normal.as_dvec3();
    let step = 2.0 / f64::from(side * POINTS);
    let row = |y: u32| {
        let mut sum = 0.0;
        for x in 0..side {
            let texel = sky.texels[(y * side + x) as usize];
            let mut weight = 0.0;
            for point in 0..POINTS * POINTS {
                let at =
                    |texel: u32, point: u32| (f64::from(texel * POINTS + point) + 0.5) * step - 1.0;
                let d = decode(at(x, point % POINTS), at(y, point / POINTS));
                // The solid angle per area of the square, as in `shared::environment`.
                let s = d.x.abs() + d.y.abs() + d.z.abs();
                weight += normal.dot(d).max(0.0) * s * s * s;
            }
            sum += f64::from(luminance(texel.truncate())) * weight;
        }
        sum
    };
    let rows: Vec<f64> = (0..side).into_par_iter().map(row).collect();
    rows.iter().sum::<f64>() * step * step
}

/// The direction at a point of the octahedral square `[-1, 1]^2`.
fn decode(x: f64, y: f64) -> DVec3 {
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    DVec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
}
