//! Scenes built in memory whose parts do not fit together: indices of what is not there, and arrays of another length.
use super::memory::{Running, whole};
use gibs::passes::device::{DeviceScene, DeviceSceneError};
use gibs::passes::frame::Screen;
use gibs::passes::scene::{LocalTransform, Texture};
use glam::{DAffine3, DVec3};

#[test]
fn a_material_that_is_not_there_is_named() {
    Running::new(Screen::Traced).refuses_everywhere(
        &|s, _| s.meshes[1].material = 7,
        &[
            "`room`",
            "mesh 1 \"flag\"",
            "material 7",
            "there are 1",
            "correct the index",
        ],
    );
}

#[test]
fn a_mesh_that_is_not_there_is_named() {
    Running::new(Screen::Traced).refuses_everywhere(
        &|s, _| s.nodes[1].meshes.push(9),
        &[
            "node 1 \"pole\"",
            "mesh 9",
            "there are 2",
            "correct the index",
        ],
    );
}

#[test]
fn a_skin_or_a_joint_that_is_not_there_is_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses_everywhere(
        &|s, _| s.nodes[1].skin = Some(3),
        &[
            "node 1 \"pole\"",
            "skin 3",
            "there are 1",
            "correct the index",
        ],
    );
    running.refuses(
        &|s, _| s.skins[0].joints[0] = 5,
        &["skin 0", "joint node 5", "there are 2", "correct the index"],
    );
    running.refuses(
        &|s, _| s.skins[0].inverse_bind.clear(),
        &["skin 0", "0 inverse bind matrices", "give exactly as many"],
    );
    running.refuses(
        &|s, _| s.meshes[1].skin[2].weights = vec![(4, 1.0)],
        &[
            "mesh 1 \"flag\"",
            "vertex 2",
            "joint 4",
            "correct the index",
        ],
    );
    running.refuses(
        &|s, _| s.meshes[1].skin.truncate(2),
        &["mesh 1 \"flag\"", "2 skin vertices", "give exactly as many"],
    );
}

#[test]
fn a_texture_that_is_not_there_is_named() {
    Running::new(Screen::Traced).refuses_everywhere(
        &|s, _| s.textures.clear(),
        &[
            "material 0 \"paint\"",
            "texture 0",
            "there are 0",
            "add what it refers to",
        ],
    );
}

#[test]
fn textures_with_too_few_texels_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses(
        &|s, _| s.textures[0].texels.truncate(3),
        &[
            "texture 0 \"weave\"",
            "3 texels",
            "width 2 x height 2",
            "give exactly as many",
        ],
    );
    running.refuses(
        &|s, _| {
            s.textures[0] = Texture {
                name: "weave".to_owned(),
                ..Texture::default()
            }
        },
        &[
            "texture 0 \"weave\"",
            "0 texels",
            "width 0 x height 0",
            "at least one",
        ],
    );
}

#[test]
fn a_light_in_a_node_that_is_not_there_is_named() {
    Running::new(Screen::Traced).refuses_everywhere(
        &|s, _| s.lights[0].node = 2,
        &["light 0", "node 2", "there are 2", "correct the index"],
    );
}

#[test]
fn arrays_that_are_too_short_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses(
        &|s, _| s.meshes[0].normals.truncate(3),
        &[
            "mesh 0 \"wall\"",
            "3 normals",
            "none or 4",
            "give exactly as many",
        ],
    );
    running.refuses(
        &|s, _| s.meshes[0].uvs.truncate(1),
        &[
            "mesh 0 \"wall\"",
            "1 texture coordinates",
            "none or 4",
            "give exactly as many",
        ],
    );
    running.refuses(
        &|s, _| s.meshes[0].triangles[1][2] = 4,
        &[
            "mesh 0 \"wall\", triangle 1",
            "vertex 4",
            "there are 4",
            "correct the index",
        ],
    );
    running.refuses(
        &|s, _| s.meshes[0].positions[2].z = f32::NAN,
        &["mesh 0 \"wall\", vertex 2: position", "NaN", "below 1e12"],
    );
}

#[test]
fn parents_that_do_not_stand_before_their_children_are_named() {
    let mut running = Running::new(Screen::Traced);
    for parent in [1, 2, u32::MAX] {
        let text = format!("node {parent} as parent");
        running.refuses_everywhere(
            &|s, _| s.nodes[1].parent = Some(parent),
            &[
                "node 1 \"pole\"",
                &text,
                "put every parent before its children",
            ],
        );
    }
    running.refuses_everywhere(
        &|s, _| s.nodes[1].local = LocalTransform::Affine(DAffine3::NAN),
        &["node 1 \"pole\": transform", "NaN", "must be finite"],
    );
    running.refuses_everywhere(
        &|s, _| s.animations[0].channels[0].times = vec![f32::NAN],
        &[
            "animation 0 \"wind\", channel 0: time of keyframe 0",
            "NaN",
            "must be finite",
        ],
    );
}

#[test]
fn a_pose_of_another_scene_is_named() {
    let (scene, view) = whole();
    let sky = &view.environment;
    let pose = scene.pose(&[]);
    let mut short = pose.clone();
    short.world.pop();
    let built = DeviceScene::build(&scene, &short, DVec3::ZERO, None, sky).map(|_| ());
    let mut device = DeviceScene::build(&scene, &pose, DVec3::ZERO, None, sky).expect("builds");
    let before = format!("{device:?}");
    let relit = device.relight(&scene, &short, None, sky);
    assert_eq!(before, format!("{device:?}"));
    for result in [built, relit] {
        let error = result.expect_err("refused");
        assert_eq!(
            error,
            DeviceSceneError::Pose {
                found: 1,
                expected: 2
            }
        );
        assert!(
            error.to_string().contains("make it with `Scene::pose`"),
            "{error}"
        );
    }
    let nowhere = DeviceScene::build(&scene, &pose, DVec3::NAN, None, sky);
    let text = nowhere.map(|_| ()).expect_err("refused").to_string();
    assert!(
        text.contains("origin: position is [NaN, NaN, NaN]; it must be finite"),
        "{text}"
    );
}
