//! A posed scene as device data: what the input buffers of the frames hold.
mod emitters;
mod environment;
mod error;
mod geometry;
mod lights;
mod materials;

pub use emitters::EmitterTable;
pub use environment::EnvironmentTable;
pub use error::DeviceSceneError;

use crate::accel::{TwoLevel, Wide};
use crate::data::{Corners, Light, Material, NONE, Transform};
use crate::scene::{self, Environment, Lighting, Pose, Scene, SceneDataError, Sun};
use crate::shared::estimator::luminance;
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
    /// This is the gate: nothing of the scene, the sun or the environment is taken on trust. What has an obvious repair
    /// (see [`Scene::validate`]) is repaired in a copy and named in [`DeviceScene::warnings`]; texels of an environment
    /// map are clamped likewise; the sun's direction may have any length but zero.
    ///
    /// # Errors
    /// [`DeviceSceneError`]: a scene that [`Scene::validate`] refuses, a pose of another scene, a sun or an environment
    /// that is none, an origin that is not finite, geometry that no tree can be built from.
    pub fn build(
        scene: &Scene,
        pose: &Pose,
        origin: DVec3,
        sun: Option<&Sun>,
        environment: &Environment,
    ) -> Result<Self, DeviceSceneError> {
        check_origin(origin)?;
        check_pose(scene, pose)?;
        let sound = scene.sound().map_err(DeviceSceneError::Scene)?;
        let outside = Outside::check(sun, environment)?;
        let (materials, texels) = materials::pack(&sound).map_err(DeviceSceneError::Scene)?;
        let mut geometry = geometry::build(&sound, pose, origin)?;
        let emitters = EmitterTable::build(&geometry.tree, &materials);
        let mut geometry_warnings = sound.warnings;
        geometry_warnings.append(&mut geometry.warnings);
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
            geometry_warnings,
        };
        built.light(scene, pose, sound.lighting, outside);
        Ok(built)
    }

    /// Takes other lights, sun and sky for the same geometry; lights at the nodes of `pose`. Vertices and textures of
    /// `scene` are not looked at.
    ///
    /// # Errors
    /// As [`DeviceScene::build`], of all but geometry. Nothing has changed then.
    pub fn relight(
        &mut self,
        scene: &Scene,
        pose: &Pose,
        sun: Option<&Sun>,
        environment: &Environment,
    ) -> Result<(), DeviceSceneError> {
        check_pose(scene, pose)?;
        let lighting = scene.sound_lighting().map_err(DeviceSceneError::Scene)?;
        let outside = Outside::check(sun, environment)?;
        self.light(scene, pose, lighting, outside);
        Ok(())
    }

    /// Takes lights that have passed the gate.
    fn light(&mut self, scene: &Scene, pose: &Pose, lighting: Lighting<'_>, outside: Outside) {
        self.warnings = self.geometry_warnings.clone();
        self.warnings.extend(lighting.warnings);
        self.warnings.extend(outside.warnings);
        let (lights, sun) = (&lighting.lights, outside.sun.as_ref());
        self.lights = lights::pack(
            lights,
            &scene.nodes,
            pose,
            self.origin,
            sun,
            &mut self.warnings,
        );
        self.environment = outside.environment;
        if self.lights.is_empty() && !shines(scene) && self.environment.is_black() {
            self.warnings.push(
                "nothing in the scene or the view shines, so the picture is black; add a light, a sun or a sky"
                    .to_owned(),
            );
        }
    }

    /// Irradiance below which a surfel counts what its rays bring as none, W/m^2: a 2^24th of what comes from the brightest of
    /// emitters, lights and sky to somewhere in the scene. Light that has leaked through several walls is less; its square could
    /// be no number any more, and where it could depended on how bright the lights are.
    pub fn faintest(&self) -> f32 {
        const SHARE: f32 = 1.0 / (1u32 << 24) as f32;
        /// Textures of emission say nothing of their area; few texels may shine.
        const PICTURED: f32 = 1.0 / 1024.0;
        let area = self.extent() * self.extent();
        let lights = self.lights.iter().map(|light| match light.kind {
            0 => luminance(light.intensity),
            _ => luminance(light.intensity) / area,
        });
        let pictured = |m: &&Material| m.emission_texels != NONE;
        let pictures = self.materials.iter().filter(pictured);
        let pictures = pictures.map(|m| luminance(m.emission) * PICTURED);
        let outside = [self.emitters.power / area, self.environment.power];
        SHARE * lights.chain(pictures).chain(outside).fold(0.0, f32::max)
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

/// Sun and environment that have passed the gate.
struct Outside {
    sun: Option<Sun>,
    environment: EnvironmentTable,
    warnings: Vec<String>,
}

impl Outside {
    fn check(sun: Option<&Sun>, environment: &Environment) -> Result<Self, DeviceSceneError> {
        let mut warnings = Vec::new();
        let sun = sun.map(scene::sun).transpose();
        let sun = sun.map_err(DeviceSceneError::View)?;
        let environment = scene::environment(environment, &mut warnings);
        let environment = environment.map_err(DeviceSceneError::View)?;
        Ok(Self {
            sun,
            environment: EnvironmentTable::build(&environment),
            warnings,
        })
    }
}

fn check_origin(origin: DVec3) -> Result<(), DeviceSceneError> {
    if origin.is_finite() {
        return Ok(());
    }
    Err(DeviceSceneError::View(SceneDataError::Value {
        element: "the floating origin".to_owned(),
        what: "position".to_owned(),
        value: origin.to_string(),
        expected: "finite",
    }))
}

fn check_pose(scene: &Scene, pose: &Pose) -> Result<(), DeviceSceneError> {
    let (found, expected) = (pose.world.len(), scene.nodes.len());
    if found == expected {
        return Ok(());
    }
    Err(DeviceSceneError::Pose { found, expected })
}

/// Whether any mesh that is drawn emits light.
fn shines(scene: &Scene) -> bool {
    let meshes = scene.nodes.iter().flat_map(|node| &node.meshes);
    let mut materials = meshes.filter_map(|&mesh| {
        let mesh = scene.meshes.get(mesh as usize)?;
        scene.materials.get(mesh.material as usize)
    });
    materials.any(|material| material.emission != Vec3::ZERO)
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
    // Nothing is visible of a node that is flattened; its surfels lie where it is flattened to.
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
