//! Emissive triangles for emitter sampling: drawn with probability proportional to area times luminance.
use crate::accel::TwoLevel;
use crate::data::{Emitter, Instance, Material};
use crate::shared::estimator::luminance;
use crate::shared::texture;
use crate::stages::resolve_hits::map_point;

/// Table of the emitters that sampling covers: those without an emission texture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmitterTable {
    /// Triangles in the world; at least one, which is degenerate where there are none.
    pub emitters: Vec<Emitter>,
    /// Sum over all emitters of area times luminance, W/sr; zero where there are none.
    pub power: f32,
}

impl EmitterTable {
    /// Collects the emitters of all instances.
    pub(super) fn build(tree: &TwoLevel, materials: &[Material]) -> Self {
        let mut emitters = Vec::new();
        let mut power = 0.0f64;
        let shines: Vec<bool> = materials
            .iter()
            .map(|m| texture::is_sampled_emitter(m) && luminance(m.emission) > 0.0)
            .collect();
        if shines.contains(&true) {
            for (i, instance) in tree.instances.iter().enumerate() {
                if instance.flags & Instance::LEFT_OUT != 0 {
                    continue;
                }
                for triangle in tree.triangles_of(i as u32) {
                    let material = &materials[triangle.material() as usize];
                    if !shines[triangle.material() as usize] {
                        continue;
                    }
                    let v0 = map_point(&instance.object_to_world, triangle.v0);
                    let e1 = map_point(&instance.object_to_world, triangle.v0 + triangle.e1) - v0;
                    let e2 = map_point(&instance.object_to_world, triangle.v0 + triangle.e2) - v0;
                    let normal = e1.as_dvec3().cross(e2.as_dvec3());
                    let area = 0.5 * normal.length();
                    if area <= 0.0 {
                        continue;
                    }
                    power += area * f64::from(luminance(material.emission));
                    let double_sided = u32::from(material.flags & texture::DOUBLE_SIDED != 0);
                    let mirrored = instance.flags & Instance::MIRRORED;
                    emitters.push(Emitter {
                        v0,
                        cumulative: power as f32,
                        e1,
                        flags: double_sided | (mirrored << 1),
                        e2,
                        pad: 0,
                        radiance: material.emission,
                        pad1: 0,
                    });
                }
            }
        }
        for emitter in &mut emitters {
            emitter.cumulative = (f64::from(emitter.cumulative) / power) as f32;
        }
        if emitters.is_empty() {
            emitters.push(Emitter::default());
        }
        Self {
            emitters,
            power: power as f32,
        }
    }
}
