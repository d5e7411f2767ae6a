//! Real scenes, where they are at hand: the folder in the environment variable `GIBS_SHARED`, or `../shared`.
use super::*;

#[test]
fn real_scenes_have_their_triangles() {
    let folder =
        std::env::var_os("GIBS_SHARED").map_or_else(|| PathBuf::from("../shared"), PathBuf::from);
    for (name, triangles) in [
        ("cornell", 32),
        ("glass-room", 125_044),
        ("skinned-room", 9_464),
        // One of its 262,267 triangles has its corners on a line and is dropped.
        ("sponza", 262_266),
    ] {
        let path = folder
            .join("scenes")
            .join(name)
            .join(format!("{name}.gltf"));
        if !path.is_file() {
            continue;
        }
        let scene = load(&path).unwrap().scene;
        let drawn = scene.nodes.iter().flat_map(|node| &node.meshes);
        assert_eq!(
            drawn
                .map(|&mesh| scene.meshes[mesh as usize].triangles.len())
                .sum::<usize>(),
            triangles,
            "{name}"
        );
        let pose = scene.pose(&[(0, 0.6), (1, 1.4)]);
        for (id, node) in scene.nodes.iter().enumerate() {
            for &mesh in &node.meshes {
                let posed = scene.skinned_positions(&pose, id as u32, mesh);
                assert!(
                    posed.positions.iter().all(|p| p.is_finite()),
                    "{name}, node {id}"
                );
            }
        }
    }
}
