//! Checks and repairs of geometry.
use super::{SceneDataError, Tally, bad_value, check_index, label};
use crate::accel::MAX_COORDINATE;
use crate::scene::{Mesh, SkinVertex};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// What has to be repaired in a mesh: how many of each.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Blemishes {
    flat: usize,
    normals: usize,
    uvs: usize,
    unbound: usize,
}

/// Every mesh whole: lengths agree, indices exist, numbers are finite. Returns the meshes to repair.
pub(super) fn meshes(
    meshes: &[Mesh],
    material_count: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<(usize, Blemishes)>, SceneDataError> {
    materials_exist(meshes, material_count)?;
    // All of them, so that of several errors it is always the first mesh's that is told.
    let checked: Vec<_> = meshes.par_iter().enumerate().map(check).collect();
    let mut found = Vec::new();
    for (i, blemishes) in checked.into_iter().enumerate() {
        let blemishes = blemishes?;
        if blemishes != Blemishes::default() {
            found.push((i, blemishes));
        }
    }
    type Count = fn(&Blemishes) -> usize;
    let kinds: [(Count, &str, &str, &str); 4] = [
        (
            |b| b.flat,
            "triangle without area",
            "triangles without area",
            "dropped",
        ),
        (
            |b| b.normals,
            "normal",
            "normals",
            "of no usable length (zero, next to it, beyond f32 or no number) replaced by the triangles' own",
        ),
        (
            |b| b.uvs,
            "texture coordinate",
            "texture coordinates",
            "not finite, set to zero",
        ),
        (
            |b| b.unbound,
            "vertex",
            "vertices",
            "without skin weights bound to the skin's first joint",
        ),
    ];
    for (count, one, many, repair) in kinds {
        let mut tally = Tally::default();
        for (i, blemishes) in &found {
            tally.add(count(blemishes), || label("mesh", *i, &meshes[*i].name));
        }
        tally.report(one, many, repair, warnings);
    }
    Ok(found)
}

/// Materials of all meshes exist.
pub(super) fn materials_exist(
    meshes: &[Mesh],
    material_count: usize,
) -> Result<(), SceneDataError> {
    for (i, mesh) in meshes.iter().enumerate() {
        let element = || label("mesh", i, &mesh.name);
        check_index(element, "material", mesh.material, material_count)?;
    }
    Ok(())
}

fn check((i, mesh): (usize, &Mesh)) -> Result<Blemishes, SceneDataError> {
    lengths(i, mesh)?;
    for (v, p) in mesh.positions.iter().enumerate() {
        // Not `>`: the comparison must also fail for NaN.
        if !p.abs().cmplt(Vec3::splat(MAX_COORDINATE)).all() {
            let expected = "finite and below 1e12 in magnitude";
            return Err(bad_value(vertex(i, mesh, v), "position", p, expected));
        }
    }
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for &corner in triangle {
            let element = || format!("{}, triangle {t},", label("mesh", i, &mesh.name));
            check_index(element, "vertex", corner, mesh.positions.len())?;
        }
    }
    let unbound = unbound(i, mesh)?;
    let flat = |&&t: &&[u32; 3]| !has_area(&mesh.positions, t);
    Ok(Blemishes {
        flat: mesh.triangles.iter().filter(flat).count(),
        normals: mesh.normals.iter().filter(|n| !has_direction(n)).count(),
        uvs: mesh.uvs.iter().filter(|uv| !uv.is_finite()).count(),
        unbound,
    })
}

/// Repairs what was found.
pub(super) fn repair(mesh: &mut Mesh, blemishes: Blemishes) {
    if blemishes.flat > 0 {
        let positions = &mesh.positions;
        mesh.triangles.retain(|&t| has_area(positions, t));
    }
    if blemishes.normals > 0 {
        fill_in_normals(mesh);
    }
    if blemishes.uvs > 0 {
        for uv in mesh.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
        }
    }
    if blemishes.unbound > 0 {
        for skin in mesh.skin.iter_mut().filter(|skin| !is_bound(skin)) {
            skin.weights = vec![(0, 1.0)];
        }
    }
}

/// Makes all normals unit and all weights sum to one.
pub(super) fn make_unit(meshes: &mut [Mesh]) {
    meshes.par_iter_mut().for_each(|mesh| {
        for normal in &mut mesh.normals {
            let length = normal.as_dvec3().length();
            if (length - 1.0).abs() > 1e-6 {
                *normal = (normal.as_dvec3() / length).as_vec3();
            }
        }
        share_weights(&mut mesh.skin);
    });
}

fn vertex(i: usize, mesh: &Mesh, v: usize) -> String {
    format!("{}, vertex {v}", label("mesh", i, &mesh.name))
}

fn lengths(i: usize, mesh: &Mesh) -> Result<(), SceneDataError> {
    let expected = mesh.positions.len();
    let arrays = [
        ("normals", mesh.normals.len()),
        ("texture coordinates", mesh.uvs.len()),
        ("skin vertices", mesh.skin.len()),
    ];
    for (what, found) in arrays {
        if found != 0 && found != expected {
            return Err(SceneDataError::Length {
                element: label("mesh", i, &mesh.name),
                what,
                found,
                expected: format!("none or {expected}, as positions,"),
            });
        }
    }
    Ok(())
}

/// Twice the area times the normal. The differences and products of f32 values are exact in f64 or nearly so, hence
/// zero where corners coincide or lie on an axis-parallel or otherwise exact line.
fn double_area(positions: &[Vec3], triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Whether a triangle has a normal that f32 can hold.
fn has_area(positions: &[Vec3], triangle: [u32; 3]) -> bool {
    double_area(positions, triangle).abs().max_element() >= f64::from(f32::MIN_POSITIVE)
}

/// Whether a normal points anywhere: at less than 1e-20 even the quotient of f32 components is noise.
fn has_direction(normal: &Vec3) -> bool {
    let square = normal.as_dvec3().length_squared();
    square.is_finite() && square > 1e-40
}

/// Normals without a direction become the area-weighted mean of their triangles' normals (+y where no triangle has the
/// vertex).
fn fill_in_normals(mesh: &mut Mesh) {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let normal = double_area(&mesh.positions, triangle);
        for v in triangle {
            sums[v as usize] += normal;
        }
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        if !has_direction(normal) {
            *normal = sum.try_normalize().map_or(Vec3::Y, |n| n.as_vec3());
        }
    }
}

fn is_bound(skin: &SkinVertex) -> bool {
    skin.weights.iter().any(|&(_, weight)| weight > 0.0)
}

/// How many vertices follow no joint at all; weights must be numbers.
fn unbound(i: usize, mesh: &Mesh) -> Result<usize, SceneDataError> {
    let mut count = 0;
    for (v, skin) in mesh.skin.iter().enumerate() {
        let bad = |(_, weight): &&(u16, f32)| !(weight.is_finite() && *weight >= 0.0);
        if let Some(&(joint, weight)) = skin.weights.iter().find(bad) {
            let what = format!("weight of joint {joint}");
            let expected = "finite and not negative";
            return Err(bad_value(vertex(i, mesh, v), what, weight, expected));
        }
        count += usize::from(!is_bound(skin));
    }
    Ok(count)
}

/// Makes weights sum to one and drops zero ones; each vertex has one above zero.
fn share_weights(skin: &mut [SkinVertex]) {
    for skin in skin {
        skin.weights.retain(|&(_, weight)| weight > 0.0);
        let sum: f64 = skin
            .weights
            .iter()
            .map(|&(_, weight)| f64::from(weight))
            .sum();
        if (sum - 1.0).abs() > 1e-6 {
            for (_, weight) in &mut skin.weights {
                *weight = (f64::from(*weight) / sum) as f32;
            }
            // A weight that vanishes beside the others would break the promise that all are above zero.
            skin.weights.retain(|&(_, weight)| weight > 0.0);
        }
    }
}
