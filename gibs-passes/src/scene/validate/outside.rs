//! Checks of what lights a scene from outside.
use super::{SceneDataError, bad_value, check_radiance};
use crate::scene::{Environment, EnvironmentMap, Sun, clamp_radiance};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// The sun with a direction of unit length. The length that it comes with means nothing, so there is no warning.
///
/// # Errors
/// A direction that is not finite or has no length; light that is not finite, negative or too much.
pub(crate) fn sun(sun: &Sun) -> Result<Sun, SceneDataError> {
    let element = || "the sun".to_owned();
    check_radiance(element, "irradiance", sun.irradiance)?;
    match unit(sun.direction) {
        Some(direction) => Ok(Sun { direction, ..*sun }),
        None => Err(bad_value(
            element(),
            "direction",
            sun.direction,
            "finite and have a length",
        )),
    }
}

/// `None` for a direction that is none. One that is unit within rounding stays as it is.
fn unit(direction: DVec3) -> Option<DVec3> {
    if (direction.length() - 1.0).abs() <= 1e-12 {
        return Some(direction);
    }
    if !direction.is_finite() {
        return None;
    }
    // Scaled first, because squares of large and of small numbers leave the range.
    (direction / direction.abs().max_element()).try_normalize()
}

/// Texels that one thread looks at together, so that the work outweighs handing it over.
const GRAIN: usize = 1 << 14;

/// The environment with texels that are light: bad ones of a map are clamped, as in a map that is read from a file, with
/// one warning.
///
/// # Errors
/// A constant sky that is not light; a map without texels or with another number of them than its size says; a rotation
/// that is not finite.
pub(crate) fn environment<'a>(
    environment: &'a Environment,
    warnings: &mut Vec<String>,
) -> Result<Cow<'a, Environment>, SceneDataError> {
    let map = match environment {
        Environment::Constant(radiance) => {
            check_radiance(|| "the sky".to_owned(), "radiance", *radiance)?;
            return Ok(Cow::Borrowed(environment));
        }
        Environment::Map(map) => map,
    };
    let element = || "the environment map".to_owned();
    let (width, height) = (map.width, map.height);
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 || texels != map.texels.len() as u64 {
        return Err(SceneDataError::Length {
            element: element(),
            what: "texels",
            found: map.texels.len(),
            expected: format!("width {width} x height {height}, at least one,"),
        });
    }
    if !map.rotation_y.is_finite() {
        return Err(bad_value(element(), "rotation", map.rotation_y, "finite"));
    }
    let parts = map.texels.par_iter().with_min_len(GRAIN);
    // NaN differs from everything, so it counts too.
    let bad = parts.filter(|&&t| clamp_radiance(t) != t).count();
    if bad == 0 {
        return Ok(Cow::Borrowed(environment));
    }
    warnings.push(format!(
        "environment map: {bad} of {texels} texels were negative, not finite or above 1e13 and were clamped"
    ));
    Ok(Cow::Owned(Environment::Map(EnvironmentMap {
        texels: map.texels.iter().copied().map(clamp_radiance).collect(),
        ..*map
    })))
}
