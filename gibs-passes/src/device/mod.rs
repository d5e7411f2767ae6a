//! A posed scene as device data: what the input buffers of the frames hold.
mod emitters;
mod environment;
mod geometry;
mod lights;
mod materials;

pub use emitters::EmitterTable;
pub use environment::EnvironmentTable;

use crate::accel::{BuildError, TwoLevel, Wide};
use crate::data::{Corners, Light, Material, Transform};
use crate::scene::{Environment, Pose, Scene, Sun};
use glam::{DAffine3, DVec3, Vec3, Vec4};

/// Everything that the frames need of a scene in a pose, relative to a floating origin.
#[derive(Clone, Debug)]
pub struct DeviceScene {
    /// World position of the floating origin, metres.
    pub origin: DVec3,
    /// Two-level tree for devices and for the scalar CPU kernel.
    pub tree: TwoLevel,
    /// The same tree for the wide CPU kernel.
    pub wide: Wide,
    /// Vertex attributes, indexed by `Triangle::primitive`.
    pub corners: Vec<Corners>,
    /// Materials.
    pub materials: Vec<Material>,
    /// The sRGB table, then the texels of every used texture.
    pub texels: Vec<u32>,
    /// Sun first, then the scene's lights.
    pub lights: Vec<Light>,
    /// Transform of every node.
    pub transforms: Vec<Transform>,
    /// The environment map and its sampling table.
    pub environment: EnvironmentTable,
    /// Emissive triangles, for emitter sampling.
    pub emitters: EmitterTable,
    /// Lower and upper corner of all geometry, relative to the origin.
    pub bounds: (Vec3, Vec3),
    /// What was left out or changed, for the user.
    pub warnings: Vec<String>,
    geometry_warnings: Vec<String>,
}

impl DeviceScene {
    /// Prepares `scene` in `pose`, with everything relative to `origin`.
    ///
    /// # Errors
    /// Geometry that no tree can be built from.
    pub fn build(
        scene: &Scene,
        pose: &Pose,
        origin: DVec3,
        sun: Option<&Sun>,
        environment: &Environment,
    ) -> Result<Self, BuildError> {
        let (materials, texels) = materials::pack(scene);
        let geometry = geometry::build(scene, pose, origin)?;
        let emitters = EmitterTable::build(&geometry.tree, &materials);
        let mut built = Self {
            origin,
            tree: geometry.tree,
            wide: geometry.wide,
            corners: geometry.corners,
            materials,
            texels,
            lights: Vec::new(),
            transforms: pose
                .world
                .iter()
                .map(|world| transform(relative(world, origin)))
                .collect(),
            environment: EnvironmentTable::default(),
            emitters,
            bounds: geometry.bounds,
            warnings: Vec::new(),
            geometry_warnings: geometry.warnings,
        };
        built.relight(scene, pose, sun, environment);
        Ok(built)
    }

    /// Takes other lights, sun and sky for the same geometry; lights at the nodes of `pose`.
    pub fn relight(
        &mut self,
        scene: &Scene,
        pose: &Pose,
        sun: Option<&Sun>,
        environment: &Environment,
    ) {
        self.warnings = self.geometry_warnings.clone();
        self.lights = lights::pack(scene, pose, self.origin, sun, &mut self.warnings);
        self.environment = EnvironmentTable::build(environment);
        if self.lights.is_empty() && !shines(scene) && self.environment.is_black() {
            self.warnings.push(
                "nothing in the scene or the view shines, so the picture is black; add a light, a sun or a sky"
                    .to_owned(),
            );
        }
    }

    /// Length of the diagonal of all geometry, metres; 1 for an empty scene.
    pub fn extent(&self) -> f32 {
        let extent = (self.bounds.1 - self.bounds.0).length();
        if extent.is_finite() && extent > 0.0 {
            extent
        } else {
            1.0
        }
    }
}

/// Whether any mesh that is drawn emits light.
fn shines(scene: &Scene) -> bool {
    let meshes = scene.nodes.iter().flat_map(|node| &node.meshes);
    let mut materials = meshes.map(|&mesh| scene.meshes[mesh as usize].material);
    materials.any(|material| scene.materials[material as usize].emission != Vec3::ZERO)
}

/// A world transform relative to the floating origin.
fn relative(world: &DAffine3, origin: DVec3) -> DAffine3 {
    DAffine3 {
        matrix3: world.matrix3,
        translation: world.translation - origin,
    }
}

fn rows(affine: DAffine3) -> [Vec4; 3] {
    let m = affine.matrix3.transpose();
    let t = affine.translation;
    [
        m.x_axis.extend(t.x).as_vec4(),
        m.y_axis.extend(t.y).as_vec4(),
        m.z_axis.extend(t.z).as_vec4(),
    ]
}

fn transform(world: DAffine3) -> Transform {
    let inverse = world.inverse();
    // Nothing is visible of a node that is flattened; its surfels stay where they are.
    let inverse = if inverse.is_finite() {
        inverse
    } else {
        DAffine3::IDENTITY
    };
    Transform {
        to_world: rows(world),
        to_local: rows(inverse),
    }
}
