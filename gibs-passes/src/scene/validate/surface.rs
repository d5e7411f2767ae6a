//! Checks of what surfaces are made of, and of the lights.
use super::{SceneDataError, Tally, bad_value, check_index, check_radiance, label};
use crate::scene::{AlphaMode, Light, LightKind, Material, Texture};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// Longest side of a texture: both sides share a word on the device, and texel indices stay within 31 bits.
const MOST_TEXELS_ACROSS: u32 = 32_768;

/// Texel arrays match their sizes.
pub(super) fn textures(textures: &[Texture]) -> Result<(), SceneDataError> {
    for (i, texture) in textures.iter().enumerate() {
        if texture.width.max(texture.height) > MOST_TEXELS_ACROSS {
            return Err(SceneDataError::Value {
                element: label("texture", i, &texture.name),
                what: "size".into(),
                value: format!("{}x{}", texture.width, texture.height),
                expected: "at most 32768 texels along each side; scale the image down",
            });
        }
        let texels = u64::from(texture.width) * u64::from(texture.height);
        if texels == 0 || texels != texture.texels.len() as u64 {
            let expected = format!(
                "width {} x height {}, at least one,",
                texture.width, texture.height
            );
            return Err(SceneDataError::Length {
                element: label("texture", i, &texture.name),
                what: "texels",
                found: texture.texels.len(),
                expected,
            });
        }
    }
    Ok(())
}

/// Factors in range, textures there. Returns the materials that had to be clamped.
pub(super) fn materials(
    materials: &[Material],
    texture_count: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<(usize, Material)>, SceneDataError> {
    let mut clamped = Tally::default();
    let mut repaired = Vec::new();
    for (i, material) in materials.iter().enumerate() {
        let element = || label("material", i, &material.name);
        for (what, value) in [
            ("alpha", material.alpha),
            ("transmission", material.transmission),
        ] {
            if !value.is_finite() {
                return Err(bad_value(element(), what, value, "finite"));
            }
        }
        if let AlphaMode::Mask(cutoff) = material.alpha_mode
            && !cutoff.is_finite()
        {
            return Err(bad_value(element(), "alpha cutoff", cutoff, "finite"));
        }
        if !material.base_color.is_finite() {
            return Err(bad_value(
                element(),
                "base colour",
                material.base_color,
                "finite",
            ));
        }
        check_radiance(element, "emission", material.emission)?;
        for texture in [material.base_color_texture, material.emission_texture]
            .into_iter()
            .flatten()
        {
            check_index(element, "texture", texture.texture, texture_count)?;
            if !texture.transform.is_finite() {
                return Err(bad_value(
                    element(),
                    "texture transform",
                    texture.transform,
                    "finite",
                ));
            }
        }
        let factors = (
            material.base_color.clamp(Vec3::ZERO, Vec3::ONE),
            material.alpha.clamp(0.0, 1.0),
            material.transmission.clamp(0.0, 1.0),
        );
        if factors != (material.base_color, material.alpha, material.transmission) {
            let (base_color, alpha, transmission) = factors;
            let within = Material {
                base_color,
                alpha,
                transmission,
                ..material.clone()
            };
            repaired.push((i, within));
            clamped.add(1, element);
        }
    }
    clamped.report(
        "material",
        "materials",
        "had a factor outside 0..1, which was clamped",
        warnings,
    );
    Ok(repaired)
}

/// Lights that shine, from nodes that exist, through cones that open. Returns the lights that had to be clamped.
pub(super) fn lights(
    lights: &[Light],
    node_count: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<(usize, Light)>, SceneDataError> {
    let mut clamped = Tally::default();
    let mut repaired = Vec::new();
    for (i, light) in lights.iter().enumerate() {
        let element = || label("light", i, "");
        check_index(element, "node", light.node, node_count)?;
        check_radiance(element, "intensity", light.intensity)?;
        if let LightKind::Spot { inner, outer } = light.kind {
            if !(inner.is_finite() && outer.is_finite() && outer > 0.0) {
                let angles = format!("{inner} (inner) and {outer} (outer) radians");
                return Err(bad_value(
                    element(),
                    "cone",
                    angles,
                    "finite, and the outer angle above zero",
                ));
            }
            let wide = outer.min(FRAC_PI_2);
            // The falloff divides by the difference of the two, so equal angles become a very narrow rim.
            let narrow = inner.clamp(0.0, wide * 0.999);
            if (narrow, wide) != (inner, outer) {
                let kind = LightKind::Spot {
                    inner: narrow,
                    outer: wide,
                };
                repaired.push((
                    i,
                    Light {
                        kind,
                        ..light.clone()
                    },
                ));
                clamped.add(1, element);
            }
        }
    }
    clamped.report(
        "spot light",
        "spot lights",
        "had angles outside 0 <= inner < outer <= 90 degrees, which were clamped",
        warnings,
    );
    Ok(repaired)
}
