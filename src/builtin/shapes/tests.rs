use super::sweep::triangulate;
use super::*;
use std::collections::HashMap;

/// Fails unless the shape is watertight and faces outwards.
pub(crate) fn assert_closed(name: &str, shape: &Shape) {
    let key = |i: u32| {
        shape.positions[i as usize]
            .to_array()
            .map(|c| (c + 0.0).to_bits())
    };
    let mut edges: HashMap<_, i32> = HashMap::new();
    let mut volume = 0.0_f64;
    for &[a, b, c] in &shape.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((key(from), key(to))).or_default() += 1;
        }
        let [a, b, c] = [a, b, c].map(|i| shape.positions[i as usize].as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
    }
    let single = edges
        .iter()
        .filter(|((a, b), n)| edges.get(&(*b, *a)) != Some(n))
        .count();
    assert_eq!(single, 0, "{name}: edges without their opposite");
    assert!(
        edges.values().all(|&n| n == 1),
        "{name}: an edge belongs to more than two triangles"
    );
    assert!(volume > 0.0, "{name}: it is inside out, volume {volume}");
}

/// Fails unless there is a unit normal per vertex, on the front of each triangle, and every triangle has an area.
pub(crate) fn assert_normals(
    name: &str,
    positions: &[Vec3],
    normals: &[Vec3],
    triangles: &[[u32; 3]],
) {
    assert_eq!(positions.len(), normals.len(), "{name}");
    for n in normals {
        // Rounding of a normalised f32 vector is below 4 ULP.
        assert!(
            (n.length() - 1.0).abs() < 1e-6,
            "{name}: normal {n} has length {}",
            n.length()
        );
    }
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
        let face = (b - a).cross(c - a);
        assert!(face.length() > 1e-12, "{name}: triangle {t:?} has no area");
        for &i in t {
            let front = face.normalize().dot(normals[i as usize].as_dvec3());
            // Smooth normals lean by half the angle between faces at most.
            assert!(
                front > 0.5,
                "{name}: normal of triangle {t:?} leans away, {front}"
            );
        }
    }
}

fn solids() -> Vec<(&'static str, Shape)> {
    let arch: Vec<[f32; 2]> = [[-2.0, 0.0], [-1.0, 0.0]]
        .into_iter()
        .chain(arc([0.0, 0.0], 0.9, 180.0, 0.0, 12))
        .chain([[1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [-2.0, 2.0]])
        .collect();
    let wave = |s: f32, t: f32| Vec3::new(s, -t, 0.1 * (s * 9.0).sin() * t);
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 2.0, 0.5));
    vec![
        ("cuboid", cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0))),
        (
            "bevelled",
            bevelled(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 0.1),
        ),
        (
            "mirrored",
            bevelled(Vec3::ZERO, Vec3::ONE, 0.1).transformed(mirror),
        ),
        ("extruded arch", extrude(&arch, -0.2, 0.2)),
        (
            "ring",
            ring(
                [3.0, 2.0],
                &[[-0.5, 0.0], [0.5, 0.0], [0.5, 0.2], [-0.5, 0.4]],
            ),
        ),
        (
            "lathe",
            lathe(&[[0.0, 0.0], [0.5, 0.0], [0.4, 1.0], [0.0, 1.2]], 12, false),
        ),
        (
            "faceted",
            lathe(&[[0.0, 0.0], [0.5, 0.0], [0.4, 1.0], [0.0, 1.2]], 8, true),
        ),
        (
            "torus",
            lathe(&[[1.0, 0.0], [1.2, 0.1], [1.0, 0.2], [0.8, 0.1]], 12, false),
        ),
        (
            "cylinder",
            cylinder(Vec3::ONE, Vec3::new(2.0, 3.0, -1.0), 0.1, 8),
        ),
        ("sphere", sphere(0.5, 12)),
        ("sheet", sheet(10, 6, 0.01, wave)),
    ]
}

#[test]
fn solids_are_closed_and_their_normals_are_in_front() {
    for (name, shape) in solids() {
        assert_closed(name, &shape);
        assert_normals(name, &shape.positions, &shape.normals, &shape.triangles);
        assert_eq!(shape.positions.len(), shape.uvs.len(), "{name}");
    }
}

#[test]
fn rooms_are_closed_with_and_without_a_window() {
    let inner = [Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0)];
    let outer = [Vec3::splat(-0.3), Vec3::new(4.3, 3.3, 4.3)];
    for opening in [None, Some([[1.0, 2.0], [1.0, 2.5]])] {
        let (mut whole, inside) = shell(inner, outer, opening);
        for face in &inside {
            whole.append(face);
        }
        assert_closed("shell", &whole);
        assert_normals("shell", &whole.positions, &whole.normals, &whole.triangles);
    }
}

#[test]
#[should_panic(expected = "edges without their opposite")]
fn a_hole_is_noticed() {
    let mut shape = cuboid(Vec3::ZERO, Vec3::ONE);
    shape.triangles.pop();
    assert_closed("open", &shape);
}

#[test]
fn polygons_with_dents_keep_their_area() {
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
    let triangles = triangulate(&outline);
    assert_eq!(triangles.len(), 3);
    let area: f32 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| Vec2::from(outline[i as usize]));
            let twice = (b - a).perp_dot(c - a);
            assert!(twice > 0.0, "{t:?} is turned over");
            twice / 2.0
        })
        .sum();
    // Shoelace formula by hand: 4 x 3 less the notch of 4 x 2 / 2.
    assert_eq!(area, 8.0);
}

#[test]
fn textures_lie_in_metres() {
    let shape = cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0));
    for t in &shape.triangles {
        let p = t.map(|i| shape.positions[i as usize]);
        let uv = t.map(|i| shape.uvs[i as usize]);
        assert_eq!((p[1] - p[0]).length(), (uv[1] - uv[0]).length());
        assert_eq!((p[2] - p[1]).length(), (uv[2] - uv[1]).length());
    }
}
