//! Rendering a scene with the surfel frame.
use crate::channels::{read_output, set, surface_channels};
use crate::gi::Gi;
use crate::picture::{Picture, PictureError};
use crate::query::{self, Irradiance};
use crate::view::View;
use gibs_graph::{Backend, BackendError, Element, Executable, Graph, GraphErrors, Schedule};
use gibs_passes::accel::BuildError;
use gibs_passes::data::{SurfacePoint, SurfelCounters};
use gibs_passes::device::DeviceScene;
use gibs_passes::frame::{Screen, SettingError, Settings, SurfelOutputs};
use gibs_passes::scene::Scene;
use gibs_passes::shared::surface;
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;
use thiserror::Error;

/// Why a picture could not be rendered.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The scene has no usable geometry.
    #[error("the scene `{scene}` cannot be traced: {source}")]
    Scene {
        /// Scene.
        scene: String,
        /// Why not.
        source: BuildError,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The frame's graph is wrong.
    #[error(transparent)]
    Graph(#[from] GraphErrors),
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A picture is too small or too large.
    #[error("the picture cannot be {width}x{height}: each side takes 1 to {most} pixels")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Largest side.
        most: u32,
    },
    /// What is said of an engine's G-buffer does not fit the frame.
    #[error("{problem}; pass `Some` for Screen::Imported and `None` for Screen::Traced")]
    Host {
        /// What is wrong.
        problem: &'static str,
    },
    /// Irradiance cannot be asked for like this.
    #[error("irradiance of {points} points with {normals} normals: {problem}")]
    Queries {
        /// Points given.
        points: usize,
        /// Normals given.
        normals: usize,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A picture could not be made of the channels.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Longest side of a picture, pixels.
pub const MOST_PIXELS: u32 = crate::view::MAX_RESOLUTION;

/// Renders one scene on one backend, frame by frame.
pub struct Renderer {
    exec: Box<dyn Executable>,
    gi: Gi,
    view: View,
}

/// A backend's shader compiler check, where this build has one.
pub(crate) fn compile(g: Graph) -> Result<Schedule, GraphErrors> {
    #[cfg(any(feature = "wgpu", feature = "vulkan"))]
    return g.compile(Some(&gibs_shaders::Compiler::new()));
    #[cfg(not(any(feature = "wgpu", feature = "vulkan")))]
    g.compile(None)
}

/// Prepares a scene as `view` sees it; the floating origin is at the eye.
///
/// # Errors
/// [`RenderError::Scene`].
pub fn device_scene(scene: &Scene, view: &View) -> Result<DeviceScene, RenderError> {
    let pose = scene.pose(&view.animation);
    // On a lattice, so that the origin does not depend on tiny changes of the camera.
    let origin = (view.camera.position / 16.0).round() * 16.0;
    DeviceScene::build(scene, &pose, origin, view.sun.as_ref(), &view.environment).map_err(
        |source| RenderError::Scene {
            scene: scene.name.clone(),
            source,
        },
    )
}

pub(crate) fn check_size(size: [u32; 2]) -> Result<(), RenderError> {
    let [width, height] = size;
    if size.iter().all(|&side| (1..=MOST_PIXELS).contains(&side)) {
        Ok(())
    } else {
        Err(RenderError::Size {
            width,
            height,
            most: MOST_PIXELS,
        })
    }
}

impl Renderer {
    /// Prepares the frame for a scene in a view.
    ///
    /// # Errors
    /// Anything in the way; see [`RenderError`].
    pub fn new(
        backend: &dyn Backend,
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        settings: &Settings,
        seed: u32,
    ) -> Result<Self, RenderError> {
        Self::extended(backend, scene, view, size, settings, seed, |_, _| {})
    }

    /// As [`Renderer::new`], with more stages: `extend` records them into the frame's graph, after what the frame
    /// gives. [`Renderer::output`] reads what they make.
    ///
    /// # Errors
    /// As [`Gi::extended`].
    pub fn extended(
        backend: &dyn Backend,
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        settings: &Settings,
        seed: u32,
        extend: impl FnOnce(&mut Graph, SurfelOutputs),
    ) -> Result<Self, RenderError> {
        let gi = Gi::extended(scene, view, size, settings, Screen::Traced, extend)?;
        let gi = gi.with_seed(seed);
        let mut exec = backend.prepare(Arc::clone(gi.schedule()), None)?;
        gi.upload_scene(exec.as_mut())?;
        Ok(Self {
            exec,
            gi,
            view: view.clone(),
        })
    }

    /// Renders the next frame.
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn frame(&mut self) -> Result<(), RenderError> {
        self.gi
            .begin_frame(self.exec.as_mut(), &self.view.camera, None)?;
        self.exec.run()?;
        Ok(())
    }

    /// Looks from elsewhere from the next frame on. Everything that the surfels know stays. The floating origin and the
    /// number of grid cells stay as well: for a place more than some kilometres away, or a much narrower field of view,
    /// make a new renderer.
    pub fn set_camera(&mut self, camera: gibs_passes::scene::Camera) {
        self.view.camera = camera;
    }

    /// Waits for all frames.
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn wait(&mut self) -> Result<(), RenderError> {
        Ok(self.exec.wait()?)
    }

    /// What runs on it: scene, size, schedule.
    pub fn gi(&self) -> &Gi {
        &self.gi
    }

    /// The executable, for profiling and checks. It is `'static`, so that `dyn Any` can give a backend's own type back.
    pub fn executable(&mut self) -> &mut (dyn Executable + 'static) {
        self.exec.as_mut()
    }

    /// What the scene lost on the way to the device.
    pub fn warnings(&self) -> &[String] {
        &self.gi.scene().warnings
    }

    /// Light at points on surfaces, or anywhere: indirect irradiance from the surfels of the last frame, and direct
    /// irradiance from the sun and the lights, drawn anew. Positions in the world, metres; unit normals. There is an
    /// answer per point, as many points at a time as the setting `queries` says.
    ///
    /// # Errors
    /// [`RenderError::Queries`] before the first frame, if the setting is 0, if the numbers of points and normals differ,
    /// or if one of them is not finite;
    /// [`RenderError::Backend`].
    pub fn irradiance(
        &mut self,
        points: &[DVec3],
        normals: &[Vec3],
    ) -> Result<Vec<Irradiance>, RenderError> {
        query::irradiance(self.exec.as_mut(), &self.gi, points, normals)
    }

    /// Counters of the surfels after the last frame, and list entries that did not fit the grid.
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn counters(&mut self) -> Result<SurfelCounters, RenderError> {
        let mut counters: SurfelCounters = self
            .output("counters")?
            .first()
            .copied()
            .unwrap_or_default();
        counters.overflow = self
            .output::<u32>("overflow")?
            .first()
            .copied()
            .unwrap_or_default();
        Ok(counters)
    }

    /// The picture after the last frame: the final image in `R G B`, and the channels of a truth.
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn picture(&mut self) -> Result<Picture, RenderError> {
        let points: Vec<SurfacePoint> = self.output("points")?;
        let direct = match self.gi.schedule().output("direct") {
            Some(_) => self.output("direct")?,
            None => vec![Vec4::ZERO; points.len()],
        };
        let irradiance: Vec<Vec4> = self.output("irradiance")?;
        let color: Vec<Vec4> = self.output("color")?;
        let mut picture =
            surface_channels(&points, self.gi.size(), &self.view, self.gi.scene().origin)?;
        set(&mut picture, "", color.iter().map(|c| c.truncate()))?;
        set(&mut picture, "E", irradiance.iter().map(|e| e.truncate()))?;
        set(&mut picture, "direct", direct.iter().map(|d| d.truncate()))?;
        let albedos = points.iter().map(surface::albedo);
        let indirect = irradiance
            .iter()
            .zip(albedos)
            .map(|(e, a)| a * e.truncate() * std::f32::consts::FRAC_1_PI);
        set(&mut picture, "indirect", indirect)?;
        picture.set_scalar("coverage.A", irradiance.iter().map(|e| e.w).collect())?;
        Ok(picture)
    }

    /// The elements of an output after the last frame: one of
    /// [`surfel_frame`](gibs_passes::frame::surfel_frame)'s, or of the stages that extend it.
    ///
    /// # Errors
    /// [`BackendError::Refused`] if the frame has no such output, or its elements are of another type.
    pub fn output<T: Element>(&mut self, name: &str) -> Result<Vec<T>, RenderError> {
        read_output(self.exec.as_mut(), name)
    }
}
