//! Scenes and views that a program builds in memory, without a loader. Every way to a frame refuses what a loader would
//! refuse, by a message that names the object, the value and the remedy, and repairs with a warning what it would repair.
use gibs::graph::{Backend, Executable, NullBackend};
use gibs::passes::data::HostGbuffer;
use gibs::passes::device::{DeviceScene, DeviceSceneError};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{
    Animation, Camera, Channel, Environment, EnvironmentMap, Interpolation, Keyframes, Light,
    LightKind, LocalTransform, Material, Mesh, Node, Sampler, Scene, Skin, SkinVertex, Sun,
    Texture, TextureRef,
};
use gibs::picture::Picture;
use gibs::view::View;
use gibs::{Gi, RenderError, Renderer};
use gibs_backend_cpu::{CpuBackend, Options};
use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2, Vec3};

const SIZE: [u32; 2] = [8, 8];

/// What goes wrong, in a scene and its view.
type Breaking<'a> = &'a dyn Fn(&mut Scene, &mut View);

fn settings() -> Settings {
    Settings {
        rays: 256,
        surfels: 64,
        ..Settings::default()
    }
}

fn mesh(name: &str) -> Mesh {
    Mesh {
        name: name.to_owned(),
        positions: vec![
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, 0.0),
        ],
        normals: vec![Vec3::Z; 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A square that fills the picture, with one of everything else.
fn whole() -> (Scene, View) {
    let texture = TextureRef {
        texture: 0,
        sampler: Sampler::default(),
        transform: Affine2::IDENTITY,
    };
    let mut boned = mesh("flag");
    boned.skin = vec![
        SkinVertex {
            weights: vec![(0, 1.0)]
        };
        4
    ];
    let behind = LocalTransform::Affine(DAffine3::from_translation(DVec3::NEG_Z * 4.0));
    let node = |name: &str, parent, local, mesh, skin| Node {
        name: name.to_owned(),
        parent,
        local,
        meshes: vec![mesh],
        skin,
    };
    let scene = Scene {
        name: "room".to_owned(),
        meshes: vec![mesh("wall"), boned],
        materials: vec![Material {
            name: "paint".to_owned(),
            base_color: Vec3::splat(0.5),
            base_color_texture: Some(texture),
            ..Material::default()
        }],
        textures: vec![Texture {
            name: "weave".to_owned(),
            width: 2,
            height: 2,
            texels: vec![[255; 4]; 4],
        }],
        nodes: vec![
            node("house", None, LocalTransform::IDENTITY, 0, None),
            node("pole", Some(0), behind, 1, Some(0)),
        ],
        skins: vec![Skin {
            joints: vec![1],
            inverse_bind: vec![DAffine3::IDENTITY],
        }],
        animations: vec![Animation {
            name: "wind".to_owned(),
            channels: vec![Channel {
                node: 0,
                times: vec![0.0],
                keyframes: Keyframes::Rotation(vec![DQuat::IDENTITY]),
                interpolation: Interpolation::Linear,
            }],
        }],
        lights: vec![Light {
            node: 0,
            kind: LightKind::Directional,
            intensity: Vec3::ONE,
        }],
        cameras: Vec::new(),
    };
    let mut view = View::of(Camera {
        position: DVec3::Z * 2.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        vfov: 0.8,
    });
    view.sun = Some(Sun {
        direction: DVec3::NEG_Z,
        irradiance: Vec3::ONE,
    });
    view.environment = Environment::Constant(Vec3::ONE);
    view.animation = vec![(0, 0.0)];
    (scene, view)
}

fn map(width: u32, height: u32, texels: Vec<Vec3>) -> Environment {
    Environment::Map(EnvironmentMap {
        width,
        height,
        texels,
        rotation_y: 0.0,
    })
}

/// A frame that runs, without a device.
struct Running {
    gi: Gi,
    exec: Box<dyn Executable>,
}

impl Running {
    fn new(screen: Screen) -> Self {
        let (scene, view) = whole();
        let mut gi = Gi::new(&scene, &view, SIZE, &settings(), screen).expect("a frame");
        let exec = NullBackend::new().prepare(gi.schedule().clone());
        let mut exec = exec.expect("prepares");
        gi.upload_scene(exec.as_mut()).expect("uploads");
        Self { gi, exec }
    }

    /// All calls that take a scene and a view, by name.
    fn change(
        &mut self,
        scene: &Scene,
        view: &View,
    ) -> [(&'static str, Result<(), RenderError>); 4] {
        let exec = self.exec.as_mut();
        [
            ("cut", self.gi.cut(exec, scene, view)),
            ("set_scene", self.gi.set_scene(exec, scene, view)),
            ("shift_origin", self.gi.shift_origin(exec, scene, view)),
            ("set_lights", self.gi.set_lights(exec, scene, view)),
        ]
    }

    /// Every way in refuses this, with all parts in the message, and the frame that runs stays what it was. Lights are
    /// changed without a look at vertices and the camera, so that `set_lights` may take what is wrong with those.
    #[track_caller]
    fn refuses(&mut self, breaking: Breaking<'_>, parts: &[&str]) {
        self.refuses_in(
            breaking,
            parts,
            &["new", "cut", "set_scene", "shift_origin"],
        );
    }

    /// As [`Running::refuses`], and lights are not changed either.
    #[track_caller]
    fn refuses_everywhere(&mut self, breaking: Breaking<'_>, parts: &[&str]) {
        let ways = ["new", "cut", "set_scene", "shift_origin", "set_lights"];
        self.refuses_in(breaking, parts, &ways);
    }

    #[track_caller]
    fn refuses_in(&mut self, breaking: Breaking<'_>, parts: &[&str], ways: &[&str]) {
        let (mut scene, mut view) = whole();
        breaking(&mut scene, &mut view);
        // Has no way to refuse, so it must cope.
        View::framing(&scene);
        let before = format!("{:?}", self.gi.scene());
        let new = Gi::new(&scene, &view, SIZE, &settings(), Screen::Traced).map(|_| ());
        let mut results = vec![("new", new)];
        for (way, result) in self.change(&scene, &view) {
            if ways.contains(&way) {
                results.push((way, result));
            }
        }
        for (way, result) in results {
            let text = match result {
                Ok(()) => panic!("{way} accepts what should be refused by {parts:?}"),
                Err(error) => error.to_string(),
            };
            for part in parts {
                assert!(text.contains(part), "{way}: {part:?} is not in: {text}");
            }
        }
        if ways.contains(&"set_lights") {
            assert_eq!(before, format!("{:?}", self.gi.scene()), "it has changed");
        }
    }
}

/// The picture of a broken scene on the CPU, with these parts in its only warning.
#[track_caller]
fn repaired(breaking: Breaking<'_>, warning: &[&str]) -> Picture {
    let (mut scene, mut view) = whole();
    breaking(&mut scene, &mut view);
    let (picture, warnings) = picture(&scene, &view);
    assert_eq!(
        warnings.len(),
        usize::from(!warning.is_empty()),
        "{warnings:?}"
    );
    for part in warning {
        assert!(
            warnings[0].contains(part),
            "{part:?} is not in {warnings:?}"
        );
    }
    let mut validated = scene.clone();
    validated.validate().expect("what is repaired is valid");
    let expected = self::picture(&validated, &view).0;
    assert_eq!(picture.channels, expected.channels, "as if validated");
    picture
}

fn picture(scene: &Scene, view: &View) -> (Picture, Vec<String>) {
    let backend = CpuBackend::new(Options::default()).expect("a CPU");
    let mut renderer = Renderer::new(&backend, scene, view, SIZE, &settings(), 0).expect("a frame");
    for _ in 0..2 {
        renderer.frame().expect("renders");
    }
    let picture = renderer.picture().expect("reads");
    for (name, values) in &picture.channels {
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
    }
    let mask = picture.scalar("mask.A").expect("a mask");
    assert!(
        mask.iter().all(|&m| m == 1.0),
        "the square fills the picture"
    );
    (picture, renderer.warnings().to_vec())
}

#[test]
fn what_is_broken_here_is_sound() {
    repaired(&|_, _| (), &[]);
    let (scene, view) = whole();
    for (way, result) in Running::new(Screen::Traced).change(&scene, &view) {
        result.unwrap_or_else(|e| panic!("{way}: {e}"));
    }
}

#[test]
fn a_scene_without_materials_is_white() {
    let bare = repaired(&|s, _| s.materials.clear(), &[]);
    let white = repaired(&|s, _| s.materials = vec![Material::default()], &[]);
    assert_eq!(bare.channels, white.channels);
}

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

/// Numbers that are sound one by one, and together move a vertex out of range.
#[test]
fn a_skin_that_poses_vertices_out_of_range_is_named() {
    Running::new(Screen::Traced).refuses(
        &|s, _| s.skins[0].inverse_bind[0].translation.x = 1e13,
        &[
            "mesh 1 \"flag\", vertex 0",
            "node 1 \"pole\"",
            "bring the joints closer",
        ],
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
fn lights_that_are_none_are_named() {
    let mut running = Running::new(Screen::Traced);
    for (value, text) in [
        (f32::NAN, "NaN"),
        (-1.0, "-1"),
        (f32::INFINITY, "inf"),
        (1e14, "100000000000000"),
    ] {
        let parts = [text, "must be finite, not negative and at most 1e13"];
        let named = |name: &'static str| [&[name][..], &parts].concat();
        running.refuses_everywhere(
            &|s, _| s.lights[0].intensity.y = value,
            &named("light 0: intensity"),
        );
        running.refuses_everywhere(
            &|_, v| v.sun.as_mut().expect("a sun").irradiance.y = value,
            &named("the view cannot be rendered: the sun: irradiance"),
        );
        running.refuses_everywhere(
            &|_, v| v.environment = Environment::Constant(Vec3::splat(value)),
            &named("the sky: radiance"),
        );
        running.refuses_everywhere(
            &|s, _| s.materials[0].emission.y = value,
            &named("material 0 \"paint\": emission"),
        );
    }
}

#[test]
fn a_sun_without_a_direction_is_named() {
    let mut running = Running::new(Screen::Traced);
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        let value = direction.to_string();
        running.refuses_everywhere(
            &|_, v| v.sun.as_mut().expect("a sun").direction = direction,
            &["the sun: direction", &value, "finite and have a length"],
        );
    }
}

#[test]
fn the_length_of_the_suns_direction_counts_for_nothing() {
    let expected = repaired(&|_, _| (), &[]);
    for length in [1e-200, 3.0, 1e200] {
        let long = |_: &mut Scene, v: &mut View| {
            v.sun.as_mut().expect("a sun").direction *= length;
        };
        assert_eq!(repaired(&long, &[]).channels, expected.channels, "{length}");
    }
}

#[test]
fn environment_maps_with_too_few_texels_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses_everywhere(
        &|_, v| v.environment = map(4, 2, vec![Vec3::ONE; 7]),
        &[
            "environment map has 7 texels",
            "width 4 x height 2",
            "give exactly as many",
        ],
    );
    running.refuses_everywhere(
        &|_, v| v.environment = map(0, 0, Vec::new()),
        &["environment map has 0 texels", "at least one"],
    );
    running.refuses_everywhere(
        &|_, v| {
            let mut turned = map(1, 1, vec![Vec3::ONE]);
            if let Environment::Map(map) = &mut turned {
                map.rotation_y = f64::NAN;
            }
            v.environment = turned;
        },
        &["environment map: rotation is NaN", "must be finite"],
    );
}

#[test]
fn texels_of_environment_maps_are_clamped_with_a_warning() {
    let bad = [Vec3::NAN, Vec3::NEG_ONE, Vec3::ONE, Vec3::splat(1e20)];
    let clamped = [Vec3::ZERO, Vec3::ZERO, Vec3::ONE, Vec3::splat(1e13)];
    let warning = ["environment map: 3 of 4 texels", "were clamped"];
    let got = repaired(&|_, v| v.environment = map(2, 2, bad.to_vec()), &warning);
    let want = repaired(&|_, v| v.environment = map(2, 2, clamped.to_vec()), &[]);
    assert_eq!(got.channels, want.channels);
}

#[test]
fn materials_that_are_no_numbers_are_named() {
    let mut running = Running::new(Screen::Traced);
    running.refuses_everywhere(
        &|s, _| s.materials[0].base_color.x = f32::NAN,
        &["material 0 \"paint\": base colour", "NaN", "must be finite"],
    );
    running.refuses_everywhere(
        &|s, _| s.materials[0].alpha = f32::INFINITY,
        &["material 0 \"paint\": alpha is inf", "must be finite"],
    );
    running.refuses_everywhere(
        &|s, _| {
            let used = s.materials[0].base_color_texture.as_mut();
            used.expect("a texture").transform.translation.x = f32::NAN;
        },
        &["material 0 \"paint\": texture transform", "must be finite"],
    );
}

#[test]
fn an_albedo_above_one_is_clamped_with_a_warning() {
    let warning = [
        "1 material had a factor outside 0..1",
        "material 0 \"paint\"",
    ];
    let got = repaired(
        &|s, _| s.materials[0].base_color = Vec3::splat(10.0),
        &warning,
    );
    let white = repaired(&|s, _| s.materials[0].base_color = Vec3::ONE, &[]);
    assert_eq!(got.channels, white.channels);
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
fn normals_that_are_none_are_replaced_with_a_warning() {
    let expected = repaired(&|_, _| (), &[]);
    let warning = ["2 normals of no length replaced", "mesh 0 \"wall\""];
    let broken = |s: &mut Scene, _: &mut View| {
        (s.meshes[0].normals[0], s.meshes[0].normals[2]) = (Vec3::NAN, Vec3::ZERO);
    };
    assert_eq!(repaired(&broken, &warning).channels, expected.channels);
    // The length of a normal counts for nothing.
    for length in [1e-15, 5.0, f32::MAX] {
        let long = |s: &mut Scene, _: &mut View| s.meshes[0].normals[1] *= length;
        assert_eq!(repaired(&long, &[]).channels, expected.channels, "{length}");
    }
}

#[test]
fn other_blemishes_are_repaired_with_a_warning() {
    let expected = repaired(&|_, _| (), &[]);
    let same = |breaking: Breaking<'_>, warning: &[&str]| {
        assert_eq!(repaired(breaking, warning).channels, expected.channels);
    };
    same(
        &|s, _| s.meshes[0].triangles.push([1, 1, 2]),
        &["1 triangle without area dropped", "mesh 0"],
    );
    same(
        &|s, _| s.meshes[0].uvs[1].x = f32::NAN,
        &["1 texture coordinate not finite", "mesh 0"],
    );
    same(
        &|s, _| s.meshes[1].skin[1].weights.clear(),
        &["1 vertex without skin weights", "mesh 1"],
    );
    // Weights count by their shares; what has none follows nothing.
    same(
        &|s, _| s.meshes[1].skin[1].weights = vec![(0, 7.0), (99, 0.0)],
        &[],
    );
    let none = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let turned = move |rotation| LocalTransform::Parts {
        translation: DVec3::ZERO,
        rotation,
        scale: DVec3::ONE,
    };
    same(
        &|s, _| s.nodes[0].local = turned(none),
        &["1 node had a rotation of no length", "node 0"],
    );
    same(
        &|s, _| s.nodes[0].local = turned(DQuat::IDENTITY * 3.0),
        &[],
    );
    same(
        &|s, _| s.animations[0].channels[0].keyframes = Keyframes::Rotation(vec![none]),
        &["1 keyframe had a rotation of no length", "animation 0"],
    );
    same(
        &|s, _| {
            let long = DQuat::IDENTITY * 3.0;
            s.animations[0].channels[0].keyframes = Keyframes::Rotation(vec![long]);
        },
        &[],
    );
    repaired(
        &|s, _| {
            s.lights[0].kind = LightKind::Spot {
                inner: 3.0,
                outer: 3.0,
            }
        },
        &["1 spot light had angles outside", "light 0"],
    );
}

/// What the lights have lost is told anew when they change, and what the geometry has lost is told still.
#[test]
fn warnings_follow_the_lights() {
    let (mut scene, view) = whole();
    scene.meshes[0].triangles.push([1, 1, 2]);
    let mut gi = Gi::new(&scene, &view, SIZE, &settings(), Screen::Traced).expect("a frame");
    let exec = NullBackend::new().prepare(gi.schedule().clone());
    let mut exec = exec.expect("prepares");
    for outer in [1.0f32, 3.0, 1.0] {
        scene.lights[0].kind = LightKind::Spot { inner: 0.0, outer };
        gi.set_lights(exec.as_mut(), &scene, &view)
            .expect("changes");
        let told = |part| {
            gi.scene()
                .warnings
                .iter()
                .filter(|w| w.contains(part))
                .count()
        };
        assert_eq!(told("without area"), 1, "{outer}");
        assert_eq!(told("spot light"), usize::from(outer > 2.0), "{outer}");
    }
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

/// Cameras that show nothing, each with what the message says of it.
fn blind() -> Vec<(Camera, [&'static str; 2])> {
    let sound = whole().1.camera;
    let at = |position| Camera { position, ..sound };
    let to = |target| Camera { target, ..sound };
    let wide = |vfov| Camera { vfov, ..sound };
    let field = "between 0 and pi radians";
    vec![
        (at(DVec3::NAN), ["position is [NaN", "must be finite"]),
        (at(DVec3::INFINITY), ["position is [inf", "must be finite"]),
        (at(DVec3::X * 1e16), ["position is [1", "at most 1e15"]),
        (to(DVec3::NAN), ["target is [NaN", "must be finite"]),
        (
            to(sound.position),
            ["target is [0, 0, 2]", "another point than the position"],
        ),
        (
            Camera {
                up: DVec3::NAN,
                ..sound
            },
            ["up direction is [NaN", "must be finite"],
        ),
        (wide(f64::NAN), ["vertical field of view is NaN", field]),
        (wide(0.0), ["vertical field of view is 0", field]),
        (wide(-1.0), ["vertical field of view is -1", field]),
        (
            wide(std::f64::consts::PI),
            ["vertical field of view is 3.14", field],
        ),
        (wide(50.0), ["vertical field of view is 50", field]),
    ]
}

#[test]
fn cameras_without_a_picture_are_named() {
    let mut running = Running::new(Screen::Traced);
    for (camera, parts) in blind() {
        let parts = [&["the view's camera"][..], &parts].concat();
        // The change of lights takes no camera, and keeps the one that is there.
        running.refuses(&|_, v| v.camera = camera, &parts);
        let (gi, exec) = (&mut running.gi, running.exec.as_mut());
        for (way, result) in [
            ("begin_frame", gi.begin_frame(exec, &camera, None)),
            ("resize", gi.resize(exec, [9, 9], &camera)),
            ("set_settings", gi.set_settings(exec, &settings(), &camera)),
        ] {
            let text = result.map_err(|e| e.to_string()).expect_err(way);
            for part in &parts {
                assert!(text.contains(part), "{way}: {part:?} is not in: {text}");
            }
        }
        assert_eq!((gi.size(), gi.frames()), (SIZE, 0));
    }
}

/// A camera that looks along its own up direction has a picture: the way an engine looks straight down.
#[test]
fn a_camera_may_look_along_its_up_direction() {
    repaired(&|_, v| v.camera.up = DVec3::Z, &[]);
    repaired(&|_, v| v.camera.up = DVec3::ZERO, &[]);
}

#[test]
fn planes_that_make_no_projection_are_named() {
    for reversed in [false, true] {
        let of = |near, far| HostGbuffer::perspective(near, far, reversed);
        assert_eq!(of(0.1, Some(f64::INFINITY)), of(0.1, None));
        for (near, text) in [
            (f64::NAN, "NaN m"),
            (0.0, "at 0 m"),
            (-0.1, "-0.1 m"),
            (f64::INFINITY, "inf m"),
            (1e-60, "m; give a finite distance above zero"),
        ] {
            for far in [None, Some(10.0)] {
                let error = of(near, far).expect_err("refused").to_string();
                for part in ["near plane", text, "give a finite distance above zero"] {
                    assert!(error.contains(part), "{part:?} is not in: {error}");
                }
            }
        }
        for (far, text) in [
            (0.1, "far plane is at 0.1 m"),
            (0.05, "far plane is at 0.05 m"),
            (-1.0, "far plane is at -1 m"),
            (f64::NEG_INFINITY, "far plane is at -inf m"),
            (f64::NAN, "far plane is at NaN m"),
        ] {
            let error = of(0.1, Some(far)).expect_err("refused").to_string();
            for part in [
                text,
                "near plane at 0.1 m",
                "beyond the near one, or `None`",
            ] {
                assert!(error.contains(part), "{part:?} is not in: {error}");
            }
        }
        for far in [0.100_001, 1e6, 1e300, f64::MAX] {
            let host = of(0.1, Some(far)).expect("planes");
            assert_eq!(host.check(), Ok(()), "{far}");
        }
    }
}

#[test]
fn descriptions_of_gbuffers_that_mean_nothing_are_named() {
    let mut running = Running::new(Screen::Imported);
    let camera = whole().1.camera;
    let sound = HostGbuffer::perspective(0.1, None, true).expect("planes");
    type Breaks = fn(&mut HostGbuffer);
    let cases: [(Breaks, [&str; 2]); 11] = [
        (
            |h| h.depth_scale = f32::NAN,
            ["`depth_scale`", "is NaN; it must be finite and not zero"],
        ),
        (
            |h| h.depth_scale = 0.0,
            ["`depth_scale`", "is 0; it must be finite and not zero"],
        ),
        (
            |h| h.depth_offset = f32::INFINITY,
            ["`depth_offset`", "is inf; it must be finite"],
        ),
        (
            |h| h.depth_clear = f32::NAN,
            ["`depth_clear`", "is NaN; it must be finite"],
        ),
        (
            |h| h.depth_step = -1.0,
            ["`depth_step`", "is -1; it must be finite and not negative"],
        ),
        (
            |h| h.jitter.x = f32::NAN,
            ["`jitter.x`", "is NaN; it must be finite"],
        ),
        (
            |h| h.jitter.y = f32::INFINITY,
            ["`jitter.y`", "is inf; it must be finite"],
        ),
        (
            |h| h.exposure = f32::NAN,
            ["`exposure`", "is NaN; it must be finite"],
        ),
        (
            |h| h.exposure = -2.0,
            ["`exposure`", "is -2; it must be finite and not negative"],
        ),
        (
            |h| h.normals = 3,
            ["`normals`", "is 3; it must be one of `NORMALS_SIGNED` (0)"],
        ),
        (
            |h| h.radiance = 2,
            ["`radiance`", "is 2; it must be 1 to get radiance"],
        ),
    ];
    let (gi, exec) = (&mut running.gi, running.exec.as_mut());
    for (breaking, parts) in cases {
        let mut host = sound;
        breaking(&mut host);
        let error = gi
            .begin_frame(exec, &camera, Some(&host))
            .expect_err("refused");
        assert!(matches!(error, RenderError::Gbuffer(_)), "{error:?}");
        for part in parts {
            let text = error.to_string();
            assert!(text.contains(part), "{part:?} is not in: {text}");
        }
    }
    assert_eq!(gi.frames(), 0);
    gi.begin_frame(exec, &camera, Some(&sound))
        .expect("a frame");
}
