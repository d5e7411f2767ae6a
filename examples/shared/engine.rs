//! What an engine has of its own: meshes in buffers of its own layout, cameras, and a renderer for them.
use gibs::passes::scene::{Camera, LocalTransform, Material, Mesh, Node, Scene, Sun};
use gibs::view::View;
use glam::{DVec3, Mat4, Vec3};

/// A vertex of the engine's, in the world.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub albedo: [f32; 3],
    /// Index of the object, which is that of its node in the scene for gibs.
    pub object: u32,
}

/// The engine's world: a room that is open to the front, where the sun shines in on two blocks.
pub struct World {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    objects: Vec<(std::ops::Range<usize>, std::ops::Range<usize>, Vec3)>,
}

impl World {
    pub fn room() -> Self {
        let mut world = Self {
            vertices: Vec::new(),
            indices: Vec::new(),
            objects: Vec::new(),
        };
        let (white, red, green) = (
            Vec3::splat(0.75),
            Vec3::new(0.65, 0.06, 0.05),
            Vec3::new(0.12, 0.45, 0.1),
        );
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        world.object(white, &[(Vec3::new(-2.0, 0.0, 2.0), x * 4.0, z * -4.0)]);
        world.object(white, &[(Vec3::new(-2.0, 3.0, -2.0), x * 4.0, z * 4.0)]);
        world.object(white, &[(Vec3::new(-2.0, 0.0, -2.0), x * 4.0, y * 3.0)]);
        world.object(red, &[(Vec3::new(-2.0, 0.0, 2.0), z * -4.0, y * 3.0)]);
        world.object(green, &[(Vec3::new(2.0, 0.0, -2.0), z * 4.0, y * 3.0)]);
        world.block(white, Vec3::new(-1.2, 0.0, -1.0), Vec3::new(1.0, 1.8, 1.0));
        world.block(white, Vec3::new(0.3, 0.0, 0.0), Vec3::new(1.0, 0.9, 1.0));
        world
    }

    fn block(&mut self, albedo: Vec3, low: Vec3, size: Vec3) {
        let (x, y, z) = (Vec3::X * size, Vec3::Y * size, Vec3::Z * size);
        self.object(
            albedo,
            &[
                (low + z, x, y),
                (low + x, -x, y),
                (low, z, y),
                (low + x + z, -z, y),
                (low + y + z, x, -z),
                (low, x, z),
            ],
        );
    }

    /// Adds an object of parallelograms: a corner and two sides, counter-clockwise from the front.
    fn object(&mut self, albedo: Vec3, faces: &[(Vec3, Vec3, Vec3)]) {
        let object = self.objects.len() as u32;
        let (first, from) = (self.vertices.len(), self.indices.len());
        for &(corner, a, b) in faces {
            let base = self.vertices.len() as u32;
            let normal = a.cross(b).normalize().to_array();
            for position in [corner, corner + a, corner + a + b, corner + b] {
                self.vertices.push(Vertex {
                    position: position.to_array(),
                    normal,
                    albedo: albedo.to_array(),
                    object,
                });
            }
            self.indices.extend([0, 1, 2, 0, 2, 3].map(|i| base + i));
        }
        let (vertices, indices) = (first..self.vertices.len(), from..self.indices.len());
        self.objects.push((vertices, indices, albedo));
    }

    /// The same world for gibs: a node, a mesh and a material per object.
    pub fn scene(&self) -> Scene {
        let mut scene = Scene {
            name: "room".into(),
            ..Scene::default()
        };
        for (i, (vertices, indices, albedo)) in self.objects.iter().enumerate() {
            let own = &self.vertices[vertices.clone()];
            let (corners, _) = self.indices[indices.clone()].as_chunks::<3>();
            let first = vertices.start as u32;
            scene.materials.push(Material {
                base_color: *albedo,
                ..Material::default()
            });
            scene.meshes.push(Mesh {
                positions: own.iter().map(|v| Vec3::from(v.position)).collect(),
                normals: own.iter().map(|v| Vec3::from(v.normal)).collect(),
                triangles: corners.iter().map(|t| t.map(|i| i - first)).collect(),
                material: i as u32,
                ..Mesh::default()
            });
            scene.nodes.push(Node {
                name: format!("object {i}"),
                parent: None,
                local: LocalTransform::IDENTITY,
                meshes: vec![i as u32],
                skin: None,
            });
        }
        scene
    }
}

/// Two cameras in the room, and the sun.
pub fn views() -> [View; 2] {
    let sun = Sun {
        direction: DVec3::new(-0.35, -0.55, -0.75).normalize(),
        irradiance: Vec3::new(3.0, 2.9, 2.6),
    };
    [DVec3::new(0.0, 1.5, 5.5), DVec3::new(1.4, 2.2, 3.2)].map(|position| {
        let camera = Camera {
            position,
            target: DVec3::new(-0.2, 1.2, -0.5),
            up: DVec3::Y,
            vfov: 0.8,
        };
        View {
            sun: Some(sun),
            ..View::of(camera)
        }
    })
}

/// The same view some hours later.
pub fn evening(view: &View) -> View {
    let sun = Sun {
        direction: DVec3::new(-0.55, -0.25, -0.8).normalize(),
        irradiance: Vec3::new(2.4, 1.7, 1.0),
    };
    View {
        sun: Some(sun),
        ..view.clone()
    }
}

/// From the world to the eye.
pub fn look(camera: &Camera) -> Mat4 {
    let [eye, target, up] = [camera.position, camera.target, camera.up].map(|v| v.as_vec3());
    glam::camera::rh::view::look_at_mat4(eye, target, up)
}
