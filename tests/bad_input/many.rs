//! Ten thousand uses of one mesh.
use super::file::{BRIGHT, Doc, Folder, SQUARE};
use super::run::{drawn_file, gibs, stderr};
use gibs::renderer::device_scene;
use gibs::view::View;
use serde_json::json;

/// Instances along each side.
const SIDE: u32 = 100;

/// A field of small squares one unit apart, which the camera sees from above with three pixels per unit: only the
/// middle pixel of nine has a square.
fn field(scale: [f32; 3]) -> Doc {
    let mut doc = Doc::square();
    doc.shape(&SQUARE.map(|x| x * 0.2), &[0, 1, 2, 0, 2, 3]);
    let middle = f64::from(SIDE - 1) / 2.0;
    // Half of the picture's height is half as long as the distance.
    doc.root["nodes"] = json!([
        {"camera": 0, "translation": [middle, -middle, SIDE]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    doc.root["scenes"] = json!([{"nodes": [0, 1]}]);
    for i in 0..SIDE * SIDE {
        let place = [f64::from(i % SIDE), -f64::from(i / SIDE), 0.0];
        doc.node(json!({"mesh": 0, "translation": place, "scale": scale}));
    }
    doc
}

#[test]
fn ten_thousand_instances_are_all_drawn_from_one_mesh() {
    let folder = Folder::new();
    let path = field([1.0; 3]).write(&folder);
    let imported = gibs::gltf_import::load(&path).unwrap();
    let count = (SIDE * SIDE) as usize;
    assert_eq!(
        (imported.scene.meshes.len(), imported.warnings.len()),
        (1, 0)
    );
    let view = View::framing(&imported.scene);
    let device = device_scene(&imported.scene, &view, view.camera.position).unwrap();
    assert_eq!(device.tree.instances.len(), count);
    assert_eq!(
        device.tree.triangles.len(),
        2,
        "all share the mesh's triangles"
    );

    let drawn = drawn_file(&path, [3 * SIDE, 3 * SIDE]).warns(&[]);
    assert_eq!(drawn.seen(), count);
    for y in 0..3 * SIDE {
        for x in 0..3 * SIDE {
            let inside = x % 3 == 1 && y % 3 == 1;
            assert_eq!(drawn.sees(x, y), inside, "{x}, {y}");
            drawn.is_grey(x, y, if inside { BRIGHT } else { 0.0 });
        }
    }
}

/// What is wrong with all of them is said once.
#[test]
fn ten_thousand_flat_instances_are_one_warning() {
    let folder = Folder::new();
    let path = field([1.0, 0.0, 1.0]).write(&folder);
    let output = gibs(&["graph", path.to_str().unwrap()]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2, "{text}");
    for part in [
        "10000 nodes are left out",
        "node 2",
        "singular; give every axis",
    ] {
        assert!(lines[0].contains(part), "{part:?} is not in: {text}");
    }
    assert!(lines[1].contains("no triangles to draw"), "{text}");
}
