//! Global illumination of a scene, apart from any device: what to run, and what to tell it each frame.
mod change;
mod lit;

use crate::query::{self, Irradiance};
use crate::renderer::{RenderError, Shaders, check_camera, check_size};
use crate::view::View;
use gibs_graph::{Executable, Graph, ResourceId, Schedule};
use gibs_passes::data::{self, HostGbuffer};
use gibs_passes::device::DeviceScene;
use gibs_passes::frame::{
    DebugView, FrameUpdate, Need, SceneSizes, Screen, Settings, SurfelFrame, SurfelOutputs,
    Variant, needs, pixel_angle, surfel_frame, upload, upload_frame, upload_scene, variants,
};
use gibs_passes::scene::{Camera, Scene};
use gibs_passes::shared::grid::GridLayout;
use glam::{DVec3, Vec3};
use lit::Lit;
use std::sync::Arc;

/// The images of an engine that a frame with [`Screen::Imported`] works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HostImage {
    /// Depth, in the first component.
    Depth,
    /// Normals, encoded as [`HostGbuffer::normals`] says.
    Normal,
    /// Linear albedo.
    Albedo,
    /// Index of the scene node, in the first component; `u32::MAX` where there is none.
    Ids,
    /// Where indirect light goes.
    Indirect,
}

impl HostImage {
    /// Key of the resource.
    pub fn key(self) -> &'static str {
        match self {
            HostImage::Depth => "host_depth",
            HostImage::Normal => "host_normal",
            HostImage::Albedo => "host_albedo",
            HostImage::Ids => "host_ids",
            HostImage::Indirect => "host_indirect",
        }
    }
}

/// Surfel global illumination of one scene at one size.
///
/// An engine prepares [`Gi::schedule`] on a backend made from its own device, uploads the scene once, and then, each
/// frame, calls [`Gi::begin_frame`] and records the executable into its own commands. [`crate::Renderer`] does the same
/// with an executable of its own.
///
/// ```
/// use gibs::{Gi, HostImage};
/// use gibs::graph::Backend;
/// use gibs::passes::data::HostGbuffer;
/// use gibs::passes::frame::{Screen, Settings};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # #[cfg(feature = "cpu")] {
/// let (scene, view) = gibs::builtin::by_name("cornell").ok_or("no such scene")?;
/// let mut gi = Gi::new(&scene, &view, [64, 64], &Settings::default(), Screen::Imported)?;
/// let backend = gibs_backend_cpu::CpuBackend::new(Default::default())?;
/// let mut exec = backend.prepare(gi.schedule().clone())?;
/// gi.upload_scene(exec.as_mut())?;
/// let host = HostGbuffer::perspective(0.1, None, true)?;
/// gi.begin_frame(exec.as_mut(), &view.camera, Some(&host))?;
/// exec.run()?;
/// let indirect = exec.read(gi.image(HostImage::Indirect).ok_or("not imported")?)?;
/// # assert_eq!(indirect.len(), 64 * 64 * 16);
/// # }
/// # Ok(())
/// # }
/// ```
pub struct Gi {
    parts: Parts,
    /// What the schedule was made from.
    plan: Plan,
    schedule: Arc<Schedule>,
    screen: Screen,
    seed: u32,
    frame: u32,
    /// A frame was begun since the last change, so that what it makes belongs to this scene, size and schedule.
    begun: bool,
    extend: Box<Extend>,
    shaders: Shaders,
}

/// What is lit and how, which may change.
#[derive(Clone, Debug)]
struct Parts {
    lit: Arc<Lit>,
    settings: Settings,
    size: [u32; 2],
    grid: GridLayout,
}

/// What decides about the schedule.
#[derive(Clone, Debug, PartialEq)]
struct Plan {
    frame: SurfelFrame,
    sizes: SceneSizes,
}

impl Parts {
    fn plan(&self, screen: Screen) -> Plan {
        Plan {
            frame: SurfelFrame {
                size: self.size,
                grid: self.grid,
                settings: self.settings.clone(),
                screen,
            },
            sizes: self.lit.sizes,
        }
    }
}

impl Plan {
    fn schedule(&self, extend: &Extend, shaders: &Shaders) -> Result<Schedule, RenderError> {
        let mut g = Graph::new("surfels");
        let outputs = surfel_frame(&mut g, &self.frame, &self.sizes);
        extend(&mut g, outputs);
        Ok(shaders.compile(g)?)
    }
}

/// Records further stages after the frame.
type Extend = dyn Fn(&mut Graph, SurfelOutputs) + Send + Sync;

impl Gi {
    /// Prepares a scene as `view` sees it: its sun, environment and animation; and, of its camera, the place, which the
    /// floating origin stays at, and the field of view.
    ///
    /// # Errors
    /// Anything in the way; see [`RenderError`].
    pub fn new(
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        settings: &Settings,
        screen: Screen,
    ) -> Result<Self, RenderError> {
        Self::extended(scene, view, size, settings, screen, |_, _| {})
    }

    /// As [`Gi::new`], with more stages: `extend` records them into the frame's graph, after what the frame gives.
    ///
    /// # Errors
    /// As [`Gi::new`]; of the stages of `extend`, [`RenderError::Graph`] names what is wrong, in a build with a GPU
    /// backend also where a device kernel does not match its ports.
    pub fn extended(
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        settings: &Settings,
        screen: Screen,
        extend: impl Fn(&mut Graph, SurfelOutputs) + Send + Sync + 'static,
    ) -> Result<Self, RenderError> {
        check_size(size)?;
        settings.check()?;
        let parts = Parts {
            lit: Arc::new(Lit::new(scene, view, view.camera.position)?),
            settings: settings.clone(),
            size,
            grid: settings.grid(pixel_angle(&view.camera, size), size),
        };
        let (plan, shaders) = (parts.plan(screen), Shaders::default());
        Ok(Self {
            schedule: Arc::new(plan.schedule(&extend, &shaders)?),
            plan,
            parts,
            screen,
            seed: 0,
            frame: 0,
            begun: false,
            extend: Box::new(extend),
            shaders,
        })
    }

    /// The same with another seed of its random numbers; 0 unless set.
    pub fn with_seed(self, seed: u32) -> Self {
        Self { seed, ..self }
    }

    /// What the scene and the settings need of the frame, and what each need adds to it.
    ///
    /// # Errors
    /// [`RenderError::Graph`].
    pub fn needs(&self) -> Result<Vec<Need>, RenderError> {
        Ok(needs(&self.plan.frame, &self.plan.sizes)?)
    }

    /// The needs of the frame, each switched, for [`Gi::variant`].
    pub(crate) fn variants(&self) -> Vec<Variant> {
        variants(&self.plan.frame, &self.plan.sizes)
    }

    /// The frame with a need switched, from the start and without what extends it. What a scene does not have of a need is
    /// empty: a light without power, a black sky.
    pub(crate) fn variant(&self, variant: &Variant) -> Result<Self, RenderError> {
        self.with_plan(Plan {
            frame: variant.frame.clone(),
            sizes: variant.sizes,
        })
    }

    /// The same from the start, without what extends it.
    pub(crate) fn again(&self) -> Result<Self, RenderError> {
        self.with_plan(self.plan.clone())
    }

    fn with_plan(&self, plan: Plan) -> Result<Self, RenderError> {
        let (extend, shaders): (Box<Extend>, _) = (Box::new(|_, _| {}), Shaders::default());
        Ok(Self {
            schedule: Arc::new(plan.schedule(&extend, &shaders)?),
            parts: Parts {
                settings: plan.frame.settings.clone(),
                ..self.parts.clone()
            },
            plan,
            screen: self.screen,
            seed: self.seed,
            frame: 0,
            begun: false,
            extend,
            shaders,
        })
    }

    /// What a backend prepares.
    pub fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    /// The resource that an image of the engine stands for; `None` unless the frame is [`Screen::Imported`].
    pub fn image(&self, image: HostImage) -> Option<ResourceId> {
        self.schedule.resource(image.key())
    }

    /// The scene as the device has it.
    pub fn scene(&self) -> &DeviceScene {
        &self.parts.lit.device
    }

    /// Number of the next frame: the frames begun so far, or since [`Gi::reset`], wrapping; after [`Gi::start_at`], on top of
    /// the number given there.
    pub fn frames(&self) -> u32 {
        self.frame
    }

    /// Width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.parts.size
    }

    /// The debug view that the frame draws: the setting `debug`.
    pub fn debug_view(&self) -> Option<DebugView> {
        self.parts.settings.debug
    }

    /// Writes geometry, materials, lights and the sky: once for each executable that was prepared from
    /// [`Gi::schedule`]. One `Gi` belongs to one executable at a time, which goes through all of its changes.
    ///
    /// # Errors
    /// [`RenderError::Executable`], [`RenderError::Backend`].
    pub fn upload_scene(&mut self, exec: &mut dyn Executable) -> Result<(), RenderError> {
        self.check(exec)?;
        self.begun = false;
        Ok(upload_scene(exec, &self.parts.lit.device)?)
    }

    /// Fails where the executable is not the one of this schedule.
    pub(crate) fn check(&self, exec: &dyn Executable) -> Result<(), RenderError> {
        match Arc::ptr_eq(exec.schedule(), &self.schedule) {
            true => Ok(()),
            false => Err(RenderError::Executable),
        }
    }

    /// A frame was begun since the last change.
    pub(crate) fn has_begun(&self) -> bool {
        self.begun
    }

    /// Light at points on surfaces, or anywhere: indirect irradiance from the surfels of the last frame of `exec`, and
    /// direct irradiance from the sun and the lights, drawn anew. Positions in the world, metres; normals of any length.
    /// There is an answer per point, as many points at a time as the setting `queries` says. Waits for the device.
    ///
    /// # Errors
    /// [`RenderError::Queries`] before the first frame and between a change and the next frame, if the setting is 0, if
    /// the numbers of points and normals differ, or if one of them is not finite;
    /// [`RenderError::Executable`], [`RenderError::Backend`].
    pub fn irradiance(
        &self,
        exec: &mut dyn Executable,
        points: &[DVec3],
        normals: &[Vec3],
    ) -> Result<Vec<Irradiance>, RenderError> {
        query::irradiance(exec, self, points, normals)
    }

    /// Writes what changes every frame: call it once before each frame is run or recorded. `host` says how to read an
    /// imported G-buffer; it is there if and only if the frame is [`Screen::Imported`].
    ///
    /// # Errors
    /// [`RenderError::Host`], [`RenderError::Gbuffer`]; [`RenderError::View`] of a camera that has no picture;
    /// [`RenderError::Executable`]; [`RenderError::Backend`]. But for the last, nothing has been written then.
    pub fn begin_frame(
        &mut self,
        exec: &mut dyn Executable,
        camera: &Camera,
        host: Option<&HostGbuffer>,
    ) -> Result<(), RenderError> {
        self.check(exec)?;
        if host.is_some() != (self.screen == Screen::Imported) {
            return Err(RenderError::Host {
                problem: match host {
                    Some(_) => "a G-buffer was described, but the frame traces its surfaces",
                    None => "the frame imports a G-buffer, and nothing says how to read it",
                },
            });
        }
        host.map_or(Ok(()), HostGbuffer::check)?;
        check_camera(camera)?;
        let update = self.update(camera);
        let Parts { lit, settings, .. } = &self.parts;
        let scene = &lit.device;
        upload_frame(exec, scene, settings, &update)?;
        if let Some(host) = host {
            let host = HostGbuffer {
                nodes: scene.transforms.len() as u32,
                ..*host
            };
            upload(exec, "host", &[host])?;
        }
        self.frame = self.frame.wrapping_add(1);
        self.begun = true;
        Ok(())
    }
}

impl Gi {
    fn update<'a>(&self, camera: &'a Camera) -> FrameUpdate<'a> {
        FrameUpdate {
            camera,
            size: self.parts.size,
            number: self.frame,
            seed: self.seed,
            grid: self.parts.grid,
        }
    }

    /// A camera as the device sees it, relative to the floating origin.
    pub(crate) fn device_camera(&self, camera: &Camera) -> data::Camera {
        self.update(camera).camera(self.scene().origin)
    }
}

impl std::fmt::Debug for Gi {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gi")
            .field("schedule", &self.schedule.name)
            .field("settings", &self.parts.settings)
            .field("size", &self.parts.size)
            .field("frame", &self.frame)
            .finish_non_exhaustive()
    }
}
