//! Checks and repairs of geometry.
use super::{SceneDataError, Tally, bad_value, check_index, label};
use crate::accel::MAX_COORDINATE;
use crate::scene::Mesh;
use glam::{DVec3, Vec2, Vec3};

/// What was repaired in all meshes together.
#[derive(Default)]
struct Repairs {
    flat: Tally,
    normals: Tally,
    uvs: Tally,
    weights: Tally,
}

/// Every mesh whole: lengths agree, indices exist, numbers are finite.
pub(super) fn meshes(
    meshes: &mut [Mesh],
    material_count: usize,
    warnings: &mut Vec<String>,
) -> Result<(), SceneDataError> {
    let mut repairs = Repairs::default();
    for (i, mesh) in meshes.iter_mut().enumerate() {
        check_index(
            || label("mesh", i, &mesh.name),
            "material",
            mesh.material,
            material_count,
        )?;
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
        repairs
            .flat
            .add(drop_flat(mesh), || label("mesh", i, &mesh.name));
        repairs
            .normals
            .add(fix_normals(mesh), || label("mesh", i, &mesh.name));
        repairs
            .uvs
            .add(fix_uvs(mesh), || label("mesh", i, &mesh.name));
        let unbound = fix_weights(i, mesh)?;
        repairs
            .weights
            .add(unbound, || label("mesh", i, &mesh.name));
    }
    repairs.flat.report(
        "triangle without area",
        "triangles without area",
        "dropped",
        warnings,
    );
    repairs.normals.report(
        "normal",
        "normals",
        "of no length replaced by the triangles' own",
        warnings,
    );
    repairs.uvs.report(
        "texture coordinate",
        "texture coordinates",
        "not finite, set to zero",
        warnings,
    );
    repairs.weights.report(
        "vertex",
        "vertices",
        "without skin weights bound to the skin's first joint",
        warnings,
    );
    Ok(())
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
fn double_area(mesh: &Mesh, triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Drops triangles without a normal that f32 can hold; returns how many.
fn drop_flat(mesh: &mut Mesh) -> usize {
    let area = |mesh: &Mesh, t: [u32; 3]| {
        double_area(mesh, t).abs().max_element() >= f64::from(f32::MIN_POSITIVE)
    };
    let before = mesh.triangles.len();
    let mut triangles = std::mem::take(&mut mesh.triangles);
    triangles.retain(|&t| area(mesh, t));
    mesh.triangles = triangles;
    before - mesh.triangles.len()
}

/// Makes normals unit; those without a direction become the area-weighted mean of their triangles' normals (+y where
/// no triangle has the vertex). Returns how many were replaced.
fn fix_normals(mesh: &mut Mesh) -> usize {
    let mut lost = Vec::new();
    for (v, normal) in mesh.normals.iter_mut().enumerate() {
        let length = normal.as_dvec3().length();
        // Below this even the quotient of f32 components is noise.
        if !(length.is_finite() && length > 1e-20) {
            lost.push(v);
            *normal = Vec3::ZERO;
        } else if (length - 1.0).abs() > 1e-6 {
            *normal = (normal.as_dvec3() / length).as_vec3();
        }
    }
    if lost.is_empty() {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let normal = double_area(mesh, triangle);
        for v in triangle {
            sums[v as usize] += normal;
        }
    }
    for &v in &lost {
        mesh.normals[v] = sums[v].try_normalize().map_or(Vec3::Y, |n| n.as_vec3());
    }
    lost.len()
}

fn fix_uvs(mesh: &mut Mesh) -> usize {
    let mut count = 0;
    for uv in mesh.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        count += 1;
    }
    count
}

/// Makes weights sum to one, drops zero ones, binds vertices without any to the first joint; returns how many.
fn fix_weights(i: usize, mesh: &mut Mesh) -> Result<usize, SceneDataError> {
    for (v, skin) in mesh.skin.iter().enumerate() {
        if let Some(&(joint, weight)) = skin
            .weights
            .iter()
            .find(|(_, w)| !(w.is_finite() && *w >= 0.0))
        {
            let what = format!("weight of joint {joint}");
            return Err(bad_value(
                vertex(i, mesh, v),
                what,
                weight,
                "finite and not negative",
            ));
        }
    }
    let mut unbound = 0;
    for skin in &mut mesh.skin {
        skin.weights.retain(|&(_, weight)| weight > 0.0);
        let sum: f64 = skin
            .weights
            .iter()
            .map(|&(_, weight)| f64::from(weight))
            .sum();
        if skin.weights.is_empty() {
            skin.weights.push((0, 1.0));
            unbound += 1;
        } else if (sum - 1.0).abs() > 1e-6 {
            for (_, weight) in &mut skin.weights {
                *weight = (f64::from(*weight) / sum) as f32;
            }
            // A weight that vanishes beside the others would break the promise that all are above zero.
            skin.weights.retain(|&(_, weight)| weight > 0.0);
        }
    }
    Ok(unbound)
}
