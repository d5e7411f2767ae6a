//! Scenes and views that a program builds in memory, without a loader. Every way to a frame refuses what a loader would
//! refuse, by a message that names the object, the value and the remedy, and repairs with a warning what it would repair.
//! Here is what is sound, and how it is broken.
use gibs::graph::{Backend, Executable, NullBackend};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{
    Animation, Camera, Channel, Environment, Interpolation, Keyframes, Light, LightKind,
    LocalTransform, Material, Mesh, Node, Sampler, Scene, Skin, SkinVertex, Sun, Texture,
    TextureRef,
};
use gibs::picture::Picture;
use gibs::view::View;
use gibs::{Gi, RenderError, Renderer};
use gibs_backend_cpu::{CpuBackend, Options};
use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2, Vec3};

pub(super) const SIZE: [u32; 2] = [8, 8];

/// What goes wrong, in a scene and its view.
pub(super) type Breaking<'a> = &'a dyn Fn(&mut Scene, &mut View);

pub(super) fn settings() -> Settings {
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
pub(super) fn whole() -> (Scene, View) {
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

/// A frame that runs, without a device.
pub(super) struct Running {
    pub(super) gi: Gi,
    pub(super) exec: Box<dyn Executable>,
}

impl Running {
    pub(super) fn new(screen: Screen) -> Self {
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
    pub(super) fn refuses(&mut self, breaking: Breaking<'_>, parts: &[&str]) {
        self.refuses_in(
            breaking,
            parts,
            &["new", "cut", "set_scene", "shift_origin"],
        );
    }

    /// As [`Running::refuses`], and lights are not changed either.
    #[track_caller]
    pub(super) fn refuses_everywhere(&mut self, breaking: Breaking<'_>, parts: &[&str]) {
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
pub(super) fn repaired(breaking: Breaking<'_>, warning: &[&str]) -> Picture {
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
