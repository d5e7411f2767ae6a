//! Emissive triangles for emitter sampling: drawn with probability proportional to area times luminance.
use crate::accel::TwoLevel;
use crate::data::{Emitter, Instance, Material};
use crate::shared::estimator::luminance;
use crate::shared::texture;
use crate::stages::resolve_hits::map_point;
use glam::Vec3;

/// Table of the emitters that sampling covers: those without an emission texture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmitterTable {
    /// Triangles in the world; at least one, which is degenerate where there are none.
    pub emitters: Vec<Emitter>,
    /// Sum over all emitters of area times luminance, W/sr; zero where there are none.
    pub power: f32,
}

impl EmitterTable {
    /// Collects the emitters of all instances. Of triangles that coincide the first stays, which is the one that rays hit: were
    /// the others in the table, points there would be drawn more often than by power, and count too much.
    pub(super) fn build(tree: &TwoLevel, materials: &[Material]) -> Self {
        let mut emitters = collected(tree, materials);
        drop_twins(&mut emitters);
        let mut power = 0.0f64;
        let sums: Vec<f64> = emitters
            .iter()
            .map(|emitter| {
                power += area(emitter) * f64::from(luminance(emitter.radiance));
                power
            })
            .collect();
        for (emitter, sum) in emitters.iter_mut().zip(sums) {
            emitter.cumulative = (sum / power) as f32;
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

fn area(emitter: &Emitter) -> f64 {
    0.5 * emitter.e1.as_dvec3().cross(emitter.e2.as_dvec3()).length()
}

/// All emissive triangles that have an area, in the order of instances and triangles.
fn collected(tree: &TwoLevel, materials: &[Material]) -> Vec<Emitter> {
    let mut emitters = Vec::new();
    let shines: Vec<bool> = materials
        .iter()
        .map(|m| texture::is_sampled_emitter(m) && luminance(m.emission) > 0.0)
        .collect();
    if !shines.contains(&true) {
        return emitters;
    }
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
            let double_sided = u32::from(material.flags & texture::DOUBLE_SIDED != 0);
            let mirrored = instance.flags & Instance::MIRRORED;
            let emitter = Emitter {
                v0,
                e1,
                flags: double_sided | (mirrored << 1),
                e2,
                radiance: material.emission,
                ..Emitter::default()
            };
            if area(&emitter) > 0.0 {
                emitters.push(emitter);
            }
        }
    }
    emitters
}

/// Corners that are closer than this share of the largest coordinate are one: four roundings of it.
const SAME_PLACE: f32 = 1.0 / 4_194_304.0;

/// Most triangles about as far along that turn out to lie elsewhere before the search for a twin is given up: more than there are where
/// coordinates have a few digits left, and few enough where they have none.
const MOST_OTHERS: usize = 256;

/// Takes out every triangle that has the same corners as one before it, in whatever order and up to rounding.
fn drop_twins(emitters: &mut Vec<Emitter>) {
    let corners: Vec<[Vec3; 3]> = emitters
        .iter()
        .map(|e| [e.v0, e.v0 + e.e1, e.v0 + e.e2])
        .collect();
    // Along a direction in which hardly any two scenes line up, so that few are compared.
    let place = |i: usize| {
        corners[i]
            .iter()
            .sum::<Vec3>()
            .dot(Vec3::new(0.61, 0.37, 0.7))
    };
    let mut along: Vec<(f32, usize)> = (0..corners.len()).map(|i| (place(i), i)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut twins = vec![false; corners.len()];
    for (k, &(at, i)) in along.iter().enumerate() {
        // Its own twins are those of the one that it is a twin of.
        if twins[i] {
            continue;
        }
        let largest = corners[i]
            .iter()
            .fold(0.0f32, |m, c| m.max(c.abs().max_element()));
        let slack = largest * SAME_PLACE;
        // Three corners, each off by as much along each axis.
        let near = along[k + 1..]
            .iter()
            .take_while(|(other, _)| other - at <= 8.0 * slack);
        let mut others = 0;
        for &(_, j) in near {
            if twins[j] {
                continue;
            }
            if coincide(&corners[i], &corners[j], slack) {
                twins[i.max(j)] = true;
                continue;
            }
            others += 1;
            if others == MOST_OTHERS {
                break;
            }
        }
    }
    let mut twins = twins.into_iter();
    emitters.retain(|_| !twins.next().unwrap_or(false));
}

/// Whether two triangles have the same corners in one of the six orders.
fn coincide(a: &[Vec3; 3], b: &[Vec3; 3], slack: f32) -> bool {
    let same = |p: Vec3, q: Vec3| (p - q).abs().max_element() <= slack;
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    ORDERS
        .iter()
        .any(|order| (0..3).all(|k| same(a[k], b[order[k]])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [Vec3; 3]) -> Emitter {
        Emitter {
            v0: corners[0],
            e1: corners[1] - corners[0],
            e2: corners[2] - corners[0],
            ..Emitter::default()
        }
    }

    /// Of a triangle in all six orders one is left, and what only shares an edge, lies beside or is a little smaller stays.
    #[test]
    fn only_twins_are_dropped() {
        let [a, b, c, d] = [
            [0.1, 2.3, 4.5],
            [1.7, 2.1, 4.4],
            [0.3, 3.9, 4.6],
            [1.9, 3.7, 4.5],
        ]
        .map(Vec3::from_array);
        let orders = [
            [a, b, c],
            [b, c, a],
            [c, a, b],
            [a, c, b],
            [c, b, a],
            [b, a, c],
        ];
        let mut emitters: Vec<Emitter> = orders.map(triangle).to_vec();
        drop_twins(&mut emitters);
        assert_eq!(emitters, [triangle(orders[0])]);
        let shifted = [a, b, c].map(|p| p + Vec3::new(1e-4, 0.0, 0.0));
        let smaller = [a, b, c + (a - c) * 1e-5];
        let apart = [[a, b, c], [b, d, c], shifted, smaller].map(triangle);
        let mut emitters = apart.to_vec();
        drop_twins(&mut emitters);
        assert_eq!(emitters, apart);
        // Many copies of a few, in turns; and so far away that all lie in one place.
        let mut many: Vec<Emitter> = (0..40_000).map(|i| apart[i % 4]).collect();
        drop_twins(&mut many);
        assert_eq!(many, apart);
        let far = |i: usize| {
            Vec3::splat(1e9) + Vec3::new(0.0, 64.0 * (i % 200) as f32, 64.0 * (i / 200) as f32)
        };
        let far = |i: usize| [far(i), far(i) + 128.0 * Vec3::X, far(i) + 128.0 * Vec3::Y];
        let mut all: Vec<Emitter> = (0..40_000).map(|i| triangle(far(i))).collect();
        drop_twins(&mut all);
        assert!(!all.is_empty());
    }
}
