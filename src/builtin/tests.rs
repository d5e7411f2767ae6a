use super::shapes::tests::{assert_closed, assert_normals};
use super::shapes::{Shape, flat_uv};
use super::*;
use gibs_passes::scene::{Environment, Keyframes, LightKind};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::HashMap;

fn scene(name: &str) -> (Scene, View) {
    by_name(name).unwrap()
}

/// Every triangle as it is drawn, at rest.
fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    drawn(scene)
        .into_iter()
        .map(|(_, triangle)| triangle)
        .collect()
}

/// Every triangle with the node that draws it.
fn drawn(scene: &Scene) -> Vec<(&str, [DVec3; 3])> {
    let pose = scene.pose(&[]);
    let mut all = Vec::new();
    for (node, world) in scene.nodes.iter().zip(&pose.world) {
        for mesh in node.meshes.iter().map(|&i| &scene.meshes[i as usize]) {
            all.extend((mesh.triangles.iter()).map(|t| {
                let at = |i: u32| world.transform_point3(mesh.positions[i as usize].as_dvec3());
                (node.name.as_str(), t.map(at))
            }));
        }
    }
    all
}

/// Everything that is drawn as one shape.
fn whole(scene: &Scene) -> Shape {
    let mut shape = Shape::default();
    for [a, b, c] in triangles(scene) {
        shape.polygon(&[a, b, c].map(|p| p.as_vec3()));
    }
    shape
}

#[test]
fn every_name_builds_a_sound_scene() {
    for (name, description) in names() {
        assert!(!description.is_empty());
        let (mut scene, view) = scene(name);
        assert_eq!(scene.name, *name);
        let notes = scene.validate().unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(notes.is_empty(), "{name}: {notes:?}");
        for mesh in &scene.meshes {
            let label = format!("{name}, {}", mesh.name);
            assert_normals(&label, &mesh.positions, &mesh.normals, &mesh.triangles);
            assert_eq!(mesh.uvs.len(), mesh.positions.len(), "{label}");
        }
        let text = view.to_json().unwrap();
        let again = View::from_json(&text, "v.json".as_ref()).unwrap();
        assert_eq!(
            (again.resolution, again.environment),
            (view.resolution, view.environment),
            "{name}"
        );
        assert!(
            (again.camera.position - view.camera.position).length() < 1e-12,
            "{name}"
        );
    }
    assert!(by_name("no such scene").is_none());
}

#[test]
fn sizes_are_as_described() {
    for (name, expected) in [
        ("cornell", 32..=32),
        ("furnace", 12..=12),
        ("atrium", 50_000..=200_000),
        ("window-room", 100..=2_000),
        ("glass", 100..=5_000),
        ("moving", 100..=1_000),
        ("many-lights", 5_000..=200_000),
    ] {
        let count = triangles(&scene(name).0).len();
        assert!(expected.contains(&count), "{name} has {count} triangles");
    }
    let (street, _) = scene("many-lights");
    assert_eq!(street.lights.len(), 1400);
    assert!(
        street
            .lights
            .iter()
            .all(|light| light.kind == LightKind::Point)
    );
}

#[test]
fn scenes_are_the_same_every_time() {
    for name in ["atrium", "many-lights"] {
        assert_eq!(format!("{:?}", scene(name)), format!("{:?}", scene(name)));
    }
}

/// The front face that a camera ray through the picture's middle meets first, as a normal.
fn first_normal(scene: &Scene, from: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let hits = triangles(scene).into_iter().filter_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a - from) / normal.dot(direction);
        let p = from + direction * t;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(a, b)| (b - a).cross(p - a).dot(normal) >= 0.0);
        (t > 0.0 && inside).then(|| (t, normal.normalize()))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[test]
fn cameras_see_fronts() {
    for (name, _) in names() {
        let (scene, view) = scene(name);
        let [right, up, forward] = view.camera.axes();
        for i in 0..25 {
            let x = f64::from(i % 5 - 2) * 0.2 + 0.013;
            let y = f64::from(i / 5 - 2) * 0.2 + 0.017;
            let direction = forward + (right * x + up * y) * (view.camera.vfov / 2.0).tan() * 2.0;
            if let Some((_, normal)) = first_normal(&scene, view.camera.position, direction) {
                assert!(normal.dot(direction) < 0.0, "{name}: ray {i} meets a back");
            }
        }
    }
}

#[test]
fn rooms_without_openings_are_closed() {
    let mut furnace = whole(&furnace(0.5, 1.0).0);
    // Seen from inside; turned over it must be a solid.
    furnace.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_closed("furnace", &furnace);

    for wall in [0.001, SEALED_ROOMS_WALL, 0.5] {
        let (scene, bright, dark) = sealed_rooms(wall);
        let mut rooms = scene.clone();
        let is_wall = |name: &str| name == "outside" || name.ends_with("room");
        rooms.nodes.retain(|node| is_wall(&node.name));
        assert_eq!(rooms.nodes.len(), 3);
        assert_closed("sealed rooms", &whole(&rooms));
        // From room to room there are exactly two faces, as far apart as asked for.
        let through = DVec3::new(0.0, 1.9, 0.4);
        let (left, _) = first_normal(&scene, through - DVec3::X, DVec3::X).unwrap();
        let (right, _) = first_normal(&scene, through + DVec3::X, DVec3::NEG_X).unwrap();
        // Positions of about 4 m are rounded to 2.4e-7 m.
        assert!((2.0 - left - right - wall).abs() < 1e-6, "{left} {right}");
        assert!(bright.camera.position.x < 0.0 && dark.camera.position.x > 0.0);
    }
}

#[test]
fn the_furnace_has_what_it_was_given() {
    let (scene, view) = furnace(0.25, 3.0);
    assert_eq!(scene.materials[0].base_color, Vec3::splat(0.25));
    assert_eq!(scene.materials[0].emission, Vec3::splat(3.0));
    assert_eq!(view.environment, Environment::default());
}

#[test]
fn the_clip_closes_and_stays_inside_the_box() {
    let (scene, view) = scene("moving");
    assert_eq!(view.animation, [(0, 0.0)]);
    let clip = &scene.animations[0];
    for channel in &clip.channels {
        assert_eq!((channel.times[0], channel.times.last()), (0.0, Some(&4.0)));
        if let Keyframes::Translation(values) = &channel.keyframes {
            // A sine of 2 pi differs from that of 0 by 2.4e-16.
            assert!(values[0].distance(*values.last().unwrap()) < 1e-12);
        }
    }
    for step in 0..=40 {
        let pose = scene.pose(&[(0, f64::from(step) / 10.0)]);
        for (id, node) in scene
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.name.ends_with("box"))
        {
            for p in scene
                .skinned_positions(&pose, id as u32, node.meshes[0])
                .positions
            {
                let inside = p.min_element() > 0.0 && p.max_element() < 5.48;
                assert!(inside, "{} leaves the room at {p}", node.name);
            }
        }
    }
}

/// Names of what has triangles that lie in one plane, look the same way and overlap by more than `least` square metres,
/// which would flicker in a picture; with a corner of one of them.
fn coincident(scene: &Scene, least: f64) -> HashMap<[&str; 2], DVec3> {
    // Planes are compared after rounding to half a millimetre, on a grid of cells of 1 m.
    type Key = ([i64; 3], i64, [i64; 3]);
    let mut cells: HashMap<Key, Vec<(&str, [DVec3; 3])>> = HashMap::new();
    for (name, t) in drawn(scene) {
        let normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
        let direction = (normal * 1e3).round().to_array().map(|c| c as i64);
        let distance = (normal.dot(t[0]) * 2e3).round() as i64;
        let low = t[0].min(t[1]).min(t[2]).floor();
        let high = t[0].max(t[1]).max(t[2]).floor();
        for x in low.x as i64..=high.x as i64 {
            for y in low.y as i64..=high.y as i64 {
                for z in low.z as i64..=high.z as i64 {
                    cells
                        .entry((direction, distance, [x, y, z]))
                        .or_default()
                        .push((name, t));
                }
            }
        }
    }
    let mut found = HashMap::new();
    for group in cells.values() {
        for (i, (a, t)) in group.iter().enumerate() {
            let over = group[..i].iter().filter(|(_, b)| overlap(t, b) > least);
            found.extend(over.map(|(b, _)| ([*a, *b], t[0])));
        }
    }
    found
}

/// Area that two triangles in one plane share, by clipping (Sutherland and Hodgman).
fn overlap(a: &[DVec3; 3], b: &[DVec3; 3]) -> f64 {
    let normal = (a[1] - a[0]).cross(a[2] - a[0]).normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |p: &DVec3| DVec2::new(p.dot(u), p.dot(v));
    let (a, mut clipped) = (
        a.each_ref().map(flat),
        b.iter().map(flat).collect::<Vec<_>>(),
    );
    for i in 0..3 {
        let (from, to) = (a[i], a[(i + 1) % 3]);
        let side = |p: DVec2| (to - from).perp_dot(p - from);
        let mut next = Vec::new();
        for k in 0..clipped.len() {
            let (p, q) = (clipped[k], clipped[(k + 1) % clipped.len()]);
            if side(p) >= 0.0 {
                next.push(p);
            }
            if (side(p) >= 0.0) != (side(q) >= 0.0) {
                next.push(p + (q - p) * (side(p) / (side(p) - side(q))));
            }
        }
        clipped = next;
    }
    let area: f64 = (0..clipped.len())
        .map(|k| clipped[k].perp_dot(clipped[(k + 1) % clipped.len()]))
        .sum();
    area.abs() / 2.0
}

#[test]
fn no_two_faces_coincide() {
    for (name, _) in names() {
        // A square of 1.4 cm is smaller than a pixel from where the cameras stand.
        let (scene, _) = scene(name);
        let found = coincident(&scene, 2e-4);
        assert!(found.is_empty(), "{name}: {found:#?}");
    }
    for case in SEALED {
        let (scene, ..) = (case.make)();
        let found = coincident(&scene, 2e-4);
        assert!(found.is_empty(), "{}: {found:#?}", case.name);
    }
}

#[test]
fn sealed_buildings_are_ten_metres_across_and_sound() {
    let (open, ..) = colonnade();
    let sealed = SEALED.map(|case| (case.make)().0);
    for mut scene in sealed.into_iter().chain([open]) {
        let notes = scene.validate().expect("sound");
        assert!(notes.is_empty(), "{}: {notes:?}", scene.name);
        let points = triangles(&scene).into_iter().flatten();
        let (low, high) = points.fold((f64::MAX, f64::MIN), |(low, high), p| {
            (low.min(p.x), high.max(p.x))
        });
        assert!(
            (high - low - 10.0).abs() < 1e-5,
            "{}: {low} to {high}",
            scene.name
        );
    }
}

#[test]
fn coincident_faces_are_noticed() {
    let (mut scene, _) = scene("cornell");
    let mut again = Shape::default();
    let corners = [
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::new(1.0, 0.0, 2.0),
        Vec3::new(2.0, 0.0, 2.0),
    ];
    again.polygon(&corners);
    assert_eq!(again.uvs[0], flat_uv(corners[0], Vec3::Y));
    assert_eq!(again.uvs[0], Vec2::ONE);
    scene.meshes[0].positions.extend(again.positions);
    let first = scene.meshes[0].positions.len() as u32 - 3;
    scene.meshes[0]
        .triangles
        .push([first, first + 1, first + 2]);
    assert!(!coincident(&scene, 2e-4).is_empty());
}
