//! Scenes made by code.
use gibs::passes::scene::{
    Camera, Environment, Light, LightKind, LocalTransform, Material, Mesh, Node, Scene,
};
use gibs::view::View;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;

/// A scene and a view of it that grow. Fronts are counter-clockwise.
pub struct Build {
    pub scene: Scene,
    pub view: View,
}

impl Build {
    /// Nothing, seen from `eye` towards `target`; `vfov` in radians.
    pub fn new(name: &str, eye: [f64; 3], target: [f64; 3], vfov: f64) -> Self {
        let up = match (eye[0], eye[2]) == (target[0], target[2]) {
            true => DVec3::NEG_Z,
            false => DVec3::Y,
        };
        Self {
            scene: Scene {
                name: name.into(),
                ..Scene::default()
            },
            view: View {
                scene: None,
                camera: Camera {
                    position: DVec3::from(eye),
                    target: DVec3::from(target),
                    up,
                    vfov,
                },
                resolution: [64, 36],
                sun: None,
                environment: Environment::default(),
                animation: Vec::new(),
                exposure: 1.0,
                warnings: Vec::new(),
            },
        }
    }

    /// A grey material that may glow.
    pub fn paint(&mut self, albedo: f32, emission: f32) -> u32 {
        self.scene.materials.push(Material {
            base_color: Vec3::splat(albedo),
            emission: Vec3::splat(emission),
            ..Material::default()
        });
        self.scene.materials.len() as u32 - 1
    }

    /// A node at the world's origin that draws these triangles; its index.
    pub fn mesh(&mut self, material: u32, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> u32 {
        let mesh = self.scene.meshes.len() as u32;
        self.scene.meshes.push(Mesh {
            positions,
            triangles,
            material,
            ..Mesh::default()
        });
        self.scene.nodes.push(Node {
            meshes: vec![mesh],
            ..Node::default()
        });
        self.scene.nodes.len() as u32 - 1
    }

    /// A level square about a point, which faces up.
    pub fn floor(&mut self, material: u32, [x, y, z]: [f32; 3], half: f32) -> u32 {
        let corners = [(-half, half), (half, half), (half, -half), (-half, -half)];
        let corners = corners.map(|(dx, dz)| Vec3::new(x + dx, y, z + dz));
        self.mesh(material, corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    }

    /// A box, which faces outwards, or inwards for a room.
    pub fn cuboid(&mut self, material: u32, low: Vec3, high: Vec3, inwards: bool) -> u32 {
        let (positions, triangles) = cuboid(low, high, inwards);
        self.mesh(material, positions, triangles)
    }

    /// A light that shines straight down.
    pub fn light(&mut self, kind: LightKind, at: [f64; 3], intensity: f32) {
        let node = self.scene.nodes.len() as u32;
        self.scene.nodes.push(Node {
            local: LocalTransform::Parts {
                translation: DVec3::from(at),
                rotation: DQuat::from_rotation_x(-FRAC_PI_2),
                scale: DVec3::ONE,
            },
            ..Node::default()
        });
        self.scene.lights.push(Light {
            node,
            kind,
            intensity: Vec3::splat(intensity),
        });
    }

    pub fn done(self) -> (Scene, View) {
        (self.scene, self.view)
    }
}

/// Corners and triangles of a box.
pub fn cuboid(low: Vec3, high: Vec3, inwards: bool) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| {
        let pick = |bit: u32, low: f32, high: f32| if i & bit == 0 { low } else { high };
        Vec3::new(
            pick(1, low.x, high.x),
            pick(2, low.y, high.y),
            pick(4, low.z, high.z),
        )
    };
    let faces: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let mut triangles: Vec<[u32; 3]> = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    if inwards {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    ((0..8).map(corner).collect(), triangles)
}

/// Where the point light of [`room`] is, and the brightest of its channels, W/sr.
pub const LAMP: DVec3 = DVec3::new(0.0, 0.8125, 9.0);
pub const LAMP_INTENSITY: f64 = 6.0;

/// The Cornell box with a point light of its own, moved so that the eye is at the world's origin: its lattice of floating
/// origins is then the same at every scale. All translations are short binary numbers, which `f64` adds exactly.
pub fn room() -> (Scene, View) {
    let (mut scene, mut view) = gibs::builtin::by_name("cornell").expect("built in");
    // Beside the middle, so that no edge of the box runs through the centres of a row of pixels.
    let eye = DVec3::new(2.8125, 2.6875, -8.0);
    let node = scene.nodes.len() as u32;
    scene.nodes.push(Node {
        local: LocalTransform::Parts {
            translation: eye + LAMP,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
        },
        ..Node::default()
    });
    scene.lights.push(Light {
        node,
        kind: LightKind::Point,
        intensity: Vec3::new(6.0, 4.0, 2.0),
    });
    move_by(&mut scene, -eye);
    view.camera.position = DVec3::ZERO;
    view.camera.target = DVec3::Z;
    (scene, view)
}

/// Moves every root of a scene.
pub fn move_by(scene: &mut Scene, offset: DVec3) {
    for node in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
        match &mut node.local {
            LocalTransform::Parts { translation, .. } => *translation += offset,
            LocalTransform::Affine(affine) => affine.translation += offset,
            _ => unreachable!("there are no other kinds"),
        }
    }
}
