//! The buffers that the host writes: scene, camera, settings.
use super::Settings;
use crate::accel::hardware;
use crate::data::*;
use crate::device::DeviceScene;
use crate::scene::Camera as SceneCamera;
use crate::shared::batch;
use crate::shared::grid::GridLayout;
use bytemuck::{Pod, cast_slice};
use gibs_graph::{Acceleration, BackendError, Buffer, DispatchArgs, Executable, Graph};
use glam::{DVec3, Vec4};

/// Key of what ray queries trace in.
const STRUCTURE: &str = "scene_structure";
/// Key of its triangles.
const STRUCTURE_TRIANGLES: &str = "scene_structure_triangles";

/// Lengths of the scene's buffers, in elements, and what the scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneSizes {
    nodes: u64,
    triangles: u64,
    instances: u64,
    corners: u64,
    materials: u64,
    texels: u64,
    lights: u64,
    transforms: u64,
    environment: u64,
    wide_nodes: u64,
    wide_packets: u64,
    /// Some material has a texture.
    pub(super) textured: bool,
    /// Some triangle has an alpha test.
    pub(super) cut_outs: bool,
    /// Light comes from the sky.
    pub(super) sky: bool,
    /// Emissive triangles that sampling covers; zero for none.
    pub(super) emitters: u64,
}

impl SceneSizes {
    /// Sizes of a scene.
    pub fn of(scene: &DeviceScene) -> Self {
        Self {
            nodes: scene.tree.nodes.len() as u64,
            triangles: scene.tree.triangles.len() as u64,
            instances: scene.tree.instances.len() as u64,
            corners: scene.corners.len() as u64,
            materials: scene.materials.len() as u64,
            texels: scene.texels.len() as u64,
            lights: scene.lights.len() as u64,
            transforms: scene.transforms.len() as u64,
            environment: scene.environment.texels.len() as u64,
            wide_nodes: scene.wide.nodes.len() as u64,
            wide_packets: scene.wide.packets.len() as u64,
            textured: scene
                .materials
                .iter()
                .any(|m| m.base_texels != NONE || m.emission_texels != NONE),
            cut_outs: scene.tree.triangles.iter().any(Triangle::needs_alpha_test),
            sky: !scene.environment.is_black(),
            emitters: match scene.emitters.power > 0.0 {
                true => scene.emitters.emitters.len() as u64,
                false => 0,
            },
        }
    }

    /// The same with another number of lights.
    pub fn with_lights(self, lights: u64) -> Self {
        Self { lights, ..self }
    }

    /// The same with or without light from the sky.
    pub fn with_sky(self, sky: bool) -> Self {
        Self { sky, ..self }
    }

    /// The same with or without textures.
    pub fn with_textures(self, textured: bool) -> Self {
        Self { textured, ..self }
    }

    /// The same with or without triangles that have an alpha test.
    pub fn with_cut_outs(self, cut_outs: bool) -> Self {
        Self { cut_outs, ..self }
    }

    /// The same with another number of emissive triangles.
    pub fn with_emitters(self, emitters: u64) -> Self {
        Self { emitters, ..self }
    }

    /// Number of lights.
    pub fn lights(&self) -> u64 {
        self.lights
    }
}

/// Handles of the buffers that the host writes.
#[derive(Debug)]
#[allow(
    missing_docs,
    reason = "each is named as its element type, which is documented"
)]
pub struct SceneInputs {
    pub nodes: Buffer<BvhNode>,
    pub triangles: Buffer<Triangle>,
    pub instances: Buffer<Instance>,
    pub corners: Buffer<Corners>,
    pub materials: Buffer<Material>,
    pub texels: Buffer<u32>,
    pub lights: Buffer<Light>,
    pub transforms: Buffer<Transform>,
    pub environment: Buffer<Vec4>,
    pub emitters: Buffer<Emitter>,
    pub wide_nodes: Buffer<WideNode>,
    pub wide_packets: Buffer<WidePacket>,
    pub camera: Buffer<Camera>,
    pub frame: Buffer<Frame>,
    pub pixels: Buffer<DispatchArgs>,
    /// What rays are traced in; `None` where they are traced in the nodes.
    pub structure: Option<Acceleration>,
    sizes: SceneSizes,
}

impl SceneInputs {
    /// Declares the inputs in a graph.
    pub fn declare(g: &mut Graph, sizes: &SceneSizes) -> Self {
        Self {
            nodes: g.input("scene_nodes", sizes.nodes),
            triangles: g.input("scene_triangles", sizes.triangles),
            instances: g.input("scene_instances", sizes.instances),
            corners: g.input("scene_corners", sizes.corners),
            materials: g.input("scene_materials", sizes.materials),
            texels: g.input("scene_texels", sizes.texels),
            lights: g.input("scene_lights", sizes.lights),
            transforms: g.input("scene_transforms", sizes.transforms),
            environment: g.input("scene_environment", sizes.environment),
            emitters: g.input("scene_emitters", sizes.emitters),
            wide_nodes: g.input("scene_wide_nodes", sizes.wide_nodes),
            wide_packets: g.input("scene_wide_packets", sizes.wide_packets),
            camera: g.input("camera", 1),
            frame: g.input("frame", 1),
            pixels: g.input("pixels", 1),
            structure: None,
            sizes: *sizes,
        }
    }

    /// The same with what ray queries trace in.
    pub fn with_ray_queries(self, g: &mut Graph) -> Self {
        let (triangles, instances) = (self.sizes.triangles, self.sizes.instances);
        let structure = g.acceleration(STRUCTURE, triangles, instances);
        Self {
            structure: Some(structure),
            ..self
        }
    }

    /// What the alpha test needs: corners and materials; `None` in a scene without cut-outs.
    pub fn cut_outs(&self) -> Option<(&Buffer<Corners>, &Buffer<Material>)> {
        self.sizes
            .cut_outs
            .then_some((&self.corners, &self.materials))
    }

    /// Texels; `None` in a scene without textures.
    pub fn textures(&self) -> Option<&Buffer<u32>> {
        self.sizes.textured.then_some(&self.texels)
    }

    /// Emissive triangles; `None` where there are none.
    pub fn emitters(&self) -> Option<&Buffer<Emitter>> {
        (self.sizes.emitters > 0).then_some(&self.emitters)
    }

    /// The environment; `None` under a black sky.
    pub fn sky(&self) -> Option<&Buffer<Vec4>> {
        self.sizes.sky.then_some(&self.environment)
    }
}

/// Writes `data` to the input called `key`, if the schedule has it.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload<T: Pod>(
    exec: &mut dyn Executable,
    key: &str,
    data: &[T],
) -> Result<(), BackendError> {
    match exec.schedule().resource(key) {
        Some(resource) if !data.is_empty() => exec.upload(resource, 0, bytemuck::cast_slice(data)),
        _ => Ok(()),
    }
}

/// Writes everything of a scene that the schedule needs.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_scene(exec: &mut dyn Executable, scene: &DeviceScene) -> Result<(), BackendError> {
    upload_scene_where(exec, scene, |_| true)
}

/// As [`upload_scene`], of the inputs only whose keys are `wanted`.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_scene_where(
    exec: &mut dyn Executable,
    scene: &DeviceScene,
    wanted: impl Fn(&str) -> bool,
) -> Result<(), BackendError> {
    let parts: [(&str, &[u8]); 12] = [
        ("scene_nodes", cast_slice(&scene.tree.nodes)),
        ("scene_triangles", cast_slice(&scene.tree.triangles)),
        ("scene_instances", cast_slice(&scene.tree.instances)),
        ("scene_corners", cast_slice(&scene.corners)),
        ("scene_materials", cast_slice(&scene.materials)),
        ("scene_texels", cast_slice(&scene.texels)),
        ("scene_lights", cast_slice(&scene.lights)),
        ("scene_transforms", cast_slice(&scene.transforms)),
        ("scene_environment", cast_slice(&scene.environment.texels)),
        ("scene_emitters", cast_slice(&scene.emitters.emitters)),
        ("scene_wide_nodes", cast_slice(&scene.wide.nodes)),
        ("scene_wide_packets", cast_slice(&scene.wide.packets)),
    ];
    for (key, bytes) in parts {
        if wanted(key) {
            upload(exec, key, bytes)?;
        }
    }
    let structure = [STRUCTURE, STRUCTURE_TRIANGLES].map(|key| exec.schedule().resource(key));
    if let [Some(instances), Some(triangles)] = structure {
        if wanted(STRUCTURE) {
            let placed = hardware::instances(&scene.tree);
            exec.upload(instances, 0, cast_slice(&placed))?;
        }
        if wanted(STRUCTURE_TRIANGLES) {
            let corners = hardware::triangles(&scene.tree);
            exec.upload(triangles, 0, cast_slice(&corners))?;
        }
    }
    Ok(())
}

/// Angle that a pixel in the middle of a picture subtends, radians.
pub fn pixel_angle(camera: &SceneCamera, size: [u32; 2]) -> f32 {
    (2.0 * (camera.vfov * 0.5).tan() / f64::from(size[1])) as f32
}

/// What the host says at the start of each frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameUpdate<'a> {
    /// Camera, in world space.
    pub camera: &'a SceneCamera,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frame number.
    pub number: u32,
    /// Seed of the run.
    pub seed: u32,
    /// The grid's shape, as the frame was made for it; its centre and size follow the camera and the scene.
    pub grid: GridLayout,
}

impl FrameUpdate<'_> {
    /// The camera on the device, relative to the floating origin.
    pub fn camera(&self, origin: DVec3) -> Camera {
        let [right, up, forward] = self.camera.axes();
        let [width, height] = self.size;
        let tan = (self.camera.vfov * 0.5).tan();
        let aspect = f64::from(width) / f64::from(height);
        Camera {
            eye: (self.camera.position - origin).as_vec3(),
            width,
            right: (right * tan * aspect).as_vec3(),
            height,
            up: (up * tan).as_vec3(),
            pixel_angle: pixel_angle(self.camera, self.size),
            forward: forward.as_vec3(),
            pad: 0,
        }
    }
}

/// Writes the inputs that change every frame.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_frame(
    exec: &mut dyn Executable,
    scene: &DeviceScene,
    settings: &Settings,
    update: &FrameUpdate<'_>,
) -> Result<(), BackendError> {
    let camera = update.camera(scene.origin);
    let frame = Frame {
        number: update.number,
        seed: update.seed,
        lights: scene.lights.len() as u32,
        lights_per_point: settings.lights_per_point(scene.lights.len() as u64),
        environment_side: scene.environment.side,
        emitter_power: match settings.emitters {
            true => scene.emitters.power,
            false => 0.0,
        },
        ..Frame::default()
    };
    upload(exec, "camera", &[camera])?;
    upload(exec, "frame", &[frame])?;
    upload(
        exec,
        "grid",
        &[update
            .grid
            .at(camera.eye, scene.extent() * settings.grid_half)],
    )?;
    let on_device = SurfelSettings {
        faintest: scene.faintest(),
        ..settings.device(update.size)
    };
    upload(exec, "settings", &[on_device])?;
    upload(
        exec,
        "pixels",
        &[batch::args(update.size[0] * update.size[1])],
    )
}
