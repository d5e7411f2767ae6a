//! Rendering a scene with the surfel frame.
use crate::Counters;
use crate::channels::{find_output, read_output, set, surface_channels};
use crate::debug::DebugPicture;
use crate::gi::Gi;
use crate::picture::{Picture, PictureError};
use crate::query::Irradiance;
use crate::view::View;
use gibs_graph::{
    Backend, BackendError, DispatchArgs, Element, Executable, Graph, GraphErrors, Schedule,
};
use gibs_passes::data::{self, ClampedLight, HostGbufferError, SurfacePoint, SurfelCounters};
use gibs_passes::device::{DeviceScene, DeviceSceneError};
use gibs_passes::frame::{Screen, SettingError, Settings, SurfelOutputs};
use gibs_passes::scene::{Camera, Scene, SceneDataError};
use gibs_passes::shared::surface;
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;
use thiserror::Error;

/// Why a picture could not be rendered.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The scene breaks a promise of its types, or has no usable geometry.
    #[error("the scene `{scene}` cannot be traced: {source}")]
    Scene {
        /// Scene.
        scene: String,
        /// Why not.
        source: DeviceSceneError,
    },
    /// The camera, the sun or the sky of a view has a value that none can have.
    #[error("the view cannot be rendered: {source}")]
    View {
        /// What is wrong.
        source: SceneDataError,
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
    /// An executable is not the one that a [`Gi`] prepared everything for.
    #[error(
        "the executable runs another schedule than `Gi::schedule`; pass the one that was prepared from this `Gi`'s \
         schedule and that every change since then went through"
    )]
    Executable,
    /// More than lights changed.
    #[error(
        "the scene `{scene}` differs from what is lit in more than its lights: {difference}; call `set_scene`"
    )]
    Lights {
        /// Scene.
        scene: String,
        /// The first difference.
        difference: String,
    },
    /// There is nothing to read yet.
    #[error(
        "`{what}` cannot be read: no frame has run since the start or the last change; call `frame` first"
    )]
    NoFrame {
        /// The output asked for.
        what: String,
    },
    /// The frame draws no debug view.
    #[error("the frame draws no debug view; name one in the setting `debug`")]
    NoDebugView,
    /// An engine's G-buffer cannot be read as it is described.
    #[error(transparent)]
    Gbuffer(#[from] HostGbufferError),
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

/// What holds device kernels against the stages of a graph, where this build has it. Remembers kernels, which take
/// longer to compile than a graph does.
#[derive(Debug, Default)]
pub(crate) struct Shaders {
    #[cfg(any(feature = "wgpu", feature = "vulkan"))]
    compiler: gibs_shaders::Compiler,
}

impl Shaders {
    pub fn compile(&self, g: Graph) -> Result<Schedule, GraphErrors> {
        #[cfg(any(feature = "wgpu", feature = "vulkan"))]
        return g.compile(Some(&self.compiler));
        #[cfg(not(any(feature = "wgpu", feature = "vulkan")))]
        g.compile(None)
    }
}

/// A schedule of its own, checked as [`Shaders`] does.
pub(crate) fn compile(g: Graph) -> Result<Schedule, GraphErrors> {
    Shaders::default().compile(g)
}

/// Prepares a scene as `view` sees it, with the floating origin near `origin`.
///
/// # Errors
/// [`RenderError::Scene`], [`RenderError::View`].
pub fn device_scene(scene: &Scene, view: &View, origin: DVec3) -> Result<DeviceScene, RenderError> {
    check_camera(&view.camera)?;
    let pose = scene.pose(&view.animation);
    // On a lattice, so that it does not depend on tiny changes of the camera.
    let origin = (origin / 16.0).round() * 16.0;
    DeviceScene::build(scene, &pose, origin, view.sun.as_ref(), &view.environment)
        .map_err(refused(scene))
}

/// Names the scene, unless it is the view that is refused.
pub(crate) fn refused(scene: &Scene) -> impl FnOnce(DeviceSceneError) -> RenderError {
    |source| match source {
        DeviceSceneError::View(source) => RenderError::View { source },
        source => RenderError::Scene {
            scene: scene.name.clone(),
            source,
        },
    }
}

pub(crate) fn check_camera(camera: &Camera) -> Result<(), RenderError> {
    camera
        .check()
        .map_err(|source| RenderError::View { source })
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
        extend: impl Fn(&mut Graph, SurfelOutputs) + Send + Sync + 'static,
    ) -> Result<Self, RenderError> {
        let gi = Gi::extended(scene, view, size, settings, Screen::Traced, extend)?;
        Self::of(backend, gi.with_seed(seed), view)
    }

    /// Prepares a frame that is recorded.
    pub(crate) fn of(backend: &dyn Backend, mut gi: Gi, view: &View) -> Result<Self, RenderError> {
        let mut exec = backend.prepare(Arc::clone(gi.schedule()))?;
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
        #[cfg(feature = "tracy")]
        let _span = tracing::info_span!("frame").entered();
        self.begin()?;
        self.exec.run()?;
        #[cfg(feature = "tracy")]
        tracing::info!(tracy.frame_mark = true);
        Ok(())
    }

    /// Begins the next frame and leaves its steps to the caller.
    pub(crate) fn begin(&mut self) -> Result<(), RenderError> {
        self.gi
            .begin_frame(self.exec.as_mut(), &self.view.camera, None)
    }

    /// Looks from elsewhere from the next frame on. Everything that the surfels know stays. Where the camera has gone
    /// some kilometres or has another field of view, [`Renderer::cut`] is better.
    pub fn set_camera(&mut self, camera: Camera) {
        self.view.camera = camera;
    }

    /// As [`Gi::cut`].
    ///
    /// # Errors
    /// As [`Gi::cut`].
    pub fn cut(&mut self, scene: &Scene, view: &View) -> Result<(), RenderError> {
        self.gi.cut(self.exec.as_mut(), scene, view)?;
        self.view = view.clone();
        Ok(())
    }

    /// As [`Gi::shift_origin`].
    ///
    /// # Errors
    /// As [`Gi::shift_origin`].
    pub fn shift_origin(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.gi.shift_origin(self.exec.as_mut(), scene, &self.view)
    }

    /// As [`Gi::resize`].
    ///
    /// # Errors
    /// As [`Gi::resize`].
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        self.gi.resize(self.exec.as_mut(), size, &self.view.camera)
    }

    /// As [`Gi::set_settings`].
    ///
    /// # Errors
    /// As [`Gi::set_settings`].
    pub fn set_settings(&mut self, settings: &Settings) -> Result<(), RenderError> {
        self.gi
            .set_settings(self.exec.as_mut(), settings, &self.view.camera)
    }

    /// As [`Gi::set_lights`].
    ///
    /// # Errors
    /// As [`Gi::set_lights`].
    pub fn set_lights(&mut self, scene: &Scene, view: &View) -> Result<(), RenderError> {
        self.gi.set_lights(self.exec.as_mut(), scene, view)?;
        self.view = view.clone();
        Ok(())
    }

    /// As [`Gi::set_scene`].
    ///
    /// # Errors
    /// As [`Gi::set_scene`].
    pub fn set_scene(&mut self, scene: &Scene, view: &View) -> Result<(), RenderError> {
        self.gi.set_scene(self.exec.as_mut(), scene, view)?;
        self.view = view.clone();
        Ok(())
    }

    /// As [`Gi::reset`].
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn reset(&mut self) -> Result<(), RenderError> {
        self.gi.reset(self.exec.as_mut())
    }

    /// As [`Gi::start_at`].
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn start_at(&mut self, number: u32) -> Result<(), RenderError> {
        self.gi.start_at(self.exec.as_mut(), number)
    }

    /// Waits for all frames.
    ///
    /// # Errors
    /// [`RenderError::Backend`].
    pub fn wait(&mut self) -> Result<(), RenderError> {
        #[cfg(feature = "tracy")]
        let _span = tracing::info_span!("wait for the device").entered();
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

    /// As [`Gi::irradiance`], after the last frame.
    ///
    /// # Errors
    /// As [`Gi::irradiance`].
    pub fn irradiance(
        &mut self,
        points: &[DVec3],
        normals: &[Vec3],
    ) -> Result<Vec<Irradiance>, RenderError> {
        self.gi.irradiance(self.exec.as_mut(), points, normals)
    }

    /// What happened to the surfels up to the last frame. Waits for it.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`], [`RenderError::Backend`].
    pub fn counters(&mut self) -> Result<Counters, RenderError> {
        let surfels: SurfelCounters = self.only("counters")?;
        let has = |name| self.gi.schedule().output(name).is_some();
        let (slot_errors, clamped) = (has("slot_errors"), has("clamped"));
        let mut continued = 0;
        for depth in 1.. {
            let name = format!("rays_{depth}");
            if self.gi.schedule().output(&name).is_none() {
                break;
            }
            continued += self.only::<DispatchArgs>(&name)?.count;
        }
        Ok(Counters {
            live: surfels.live,
            born: surfels.born,
            recycled: surfels.recycled,
            starved: surfels.starved,
            crowded: self.only("crowded")?,
            overflow: self.only("overflow")?,
            rays: self.only::<DispatchArgs>("rays")?.count,
            continued,
            slot_errors: match slot_errors {
                true => Some(self.only("slot_errors")?),
                false => None,
            },
            clamped: match clamped {
                true => Some(self.only::<ClampedLight>("clamped")?.into()),
                false => None,
            },
        })
    }

    /// The one element of an output.
    fn only<T: Element + Default>(&mut self, name: &str) -> Result<T, RenderError> {
        Ok(self.output(name)?.first().copied().unwrap_or_default())
    }

    /// The camera of the next frame as the device sees it, relative to the floating origin.
    pub(crate) fn device_camera(&self) -> data::Camera {
        self.gi.device_camera(&self.view.camera)
    }

    /// The picture after the last frame: the final image in `R G B`, the channels of a truth, and the values of the debug
    /// view, if there is one, as `debug.NAME`.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`] before the first frame and between a change and the next one, [`RenderError::Backend`].
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
        if let Some(view) = self.gi.debug_view() {
            picture.set_scalar(&view.channel(), self.debug_picture()?.values().to_vec())?;
        }
        Ok(picture)
    }

    /// The debug view after the last frame: that of the setting `debug`, which [`Renderer::set_settings`] may change.
    ///
    /// # Errors
    /// [`RenderError::NoDebugView`] where there is none; [`RenderError::NoFrame`] before the first frame and between a
    /// change and the next one; [`RenderError::Backend`].
    pub fn debug_picture(&mut self) -> Result<DebugPicture, RenderError> {
        let view = self.gi.debug_view().ok_or(RenderError::NoDebugView)?;
        Ok(DebugPicture::new(
            view,
            self.gi.size(),
            &self.output("debug")?,
        ))
    }

    /// The elements of an output after the last frame: one of
    /// [`surfel_frame`](gibs_passes::frame::surfel_frame)'s, or of the stages that extend it.
    ///
    /// # Errors
    /// [`RenderError::NoFrame`] before the first frame and between a change and the next one;
    /// [`BackendError::Refused`] if the frame has no such output, or its elements are of another type.
    pub fn output<T: Element>(&mut self, name: &str) -> Result<Vec<T>, RenderError> {
        find_output::<T>(self.gi.schedule(), name)?;
        if !self.gi.has_begun() {
            return Err(RenderError::NoFrame { what: name.into() });
        }
        read_output(self.exec.as_mut(), name)
    }
}
