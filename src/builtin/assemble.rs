//! Puts a scene together.
use super::shapes::Shape;
use gibs_passes::scene::{
    Camera, Environment, LocalTransform, Material, Mesh, Node, NodeId, Sampler, Scene, Sun,
    Texture, TextureRef,
};
use glam::{Affine2, DQuat, DVec3, Vec2, Vec3};

use crate::view::View;

/// A scene that grows.
#[derive(Default)]
pub(super) struct Assembly {
    pub scene: Scene,
}

impl Assembly {
    pub fn new(name: &str) -> Self {
        Self {
            scene: Scene {
                name: name.to_owned(),
                ..Scene::default()
            },
        }
    }

    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }

    /// A plain opaque material.
    pub fn paint(&mut self, name: &str, base_color: [f32; 3]) -> u32 {
        let base_color = Vec3::from_array(base_color);
        self.material(Material {
            name: name.to_owned(),
            base_color,
            ..Material::default()
        })
    }

    /// A material that shines with the given radiance.
    pub fn glow(&mut self, name: &str, base_color: f32, emission: [f32; 3]) -> u32 {
        let (base_color, emission) = (Vec3::splat(base_color), Vec3::from_array(emission));
        self.material(Material {
            name: name.to_owned(),
            base_color,
            emission,
            ..Material::default()
        })
    }

    /// A material with a texture that repeats every `size` (metres, or units of the shape's coordinates).
    pub fn textured(&mut self, texture: Texture, size: [f32; 2], base_color: [f32; 3]) -> u32 {
        let name = texture.name.clone();
        let base_color_texture = Some(self.texture(texture, size));
        let base_color = Vec3::from_array(base_color);
        self.material(Material {
            name,
            base_color,
            base_color_texture,
            ..Material::default()
        })
    }

    pub fn texture(&mut self, texture: Texture, size: [f32; 2]) -> TextureRef {
        self.scene.textures.push(texture);
        TextureRef {
            texture: self.scene.textures.len() as u32 - 1,
            sampler: Sampler::default(),
            transform: Affine2::from_scale(Vec2::from(size).recip()),
        }
    }

    pub fn mesh(&mut self, name: &str, material: u32, shape: &Shape) -> u32 {
        let Shape {
            positions,
            normals,
            uvs,
            triangles,
        } = shape.clone();
        let name = name.to_owned();
        self.scene.meshes.push(Mesh {
            name,
            positions,
            normals,
            uvs,
            skin: Vec::new(),
            triangles,
            material,
        });
        self.scene.meshes.len() as u32 - 1
    }

    /// Draws meshes turned about the y axis (radians, counter-clockwise from above) and moved.
    pub fn place(&mut self, name: &str, meshes: &[u32], at: [f64; 3], turn: f64) -> NodeId {
        let local = LocalTransform::Parts {
            translation: DVec3::from_array(at),
            rotation: DQuat::from_rotation_y(turn),
            scale: DVec3::ONE,
        };
        let (name, meshes) = (name.to_owned(), meshes.to_vec());
        self.scene.nodes.push(Node {
            name,
            parent: None,
            local,
            meshes,
            skin: None,
        });
        self.scene.nodes.len() as NodeId - 1
    }

    /// Draws a shape where it is.
    pub fn draw(&mut self, name: &str, material: u32, shape: &Shape) -> NodeId {
        let mesh = self.mesh(name, material, shape);
        self.place(name, &[mesh], [0.0; 3], 0.0)
    }
}

/// A view of a built-in scene with no light from outside.
pub(super) fn view(
    position: [f64; 3],
    target: [f64; 3],
    vfov_degrees: f64,
    resolution: [u32; 2],
) -> View {
    View {
        scene: None,
        camera: Camera {
            position: DVec3::from_array(position),
            target: DVec3::from_array(target),
            up: DVec3::Y,
            vfov: vfov_degrees.to_radians(),
        },
        resolution,
        sun: None,
        environment: Environment::default(),
        animation: Vec::new(),
        exposure: 1.0,
        warnings: Vec::new(),
    }
}

/// A sun that shines along `direction`.
pub(super) fn sun(direction: [f64; 3], irradiance: [f32; 3]) -> Option<Sun> {
    let direction = DVec3::from_array(direction).normalize_or(DVec3::NEG_Y);
    Some(Sun {
        direction,
        irradiance: Vec3::from_array(irradiance),
    })
}

/// A sky that is the same everywhere.
pub(super) fn sky(radiance: [f32; 3]) -> Environment {
    Environment::Constant(Vec3::from_array(radiance))
}
