//! Rendering a scene with the surfel frame.
mod error;
mod prepare;
mod read;

pub use error::RenderError;
pub use prepare::{MOST_PIXELS, device_scene};
pub(crate) use prepare::{Shaders, check_camera, check_size, compile, refused};

use crate::gi::Gi;
use crate::view::View;
use gibs_graph::{Backend, Executable, Graph};
use gibs_passes::data;
use gibs_passes::frame::{Screen, Settings, SurfelOutputs};
use gibs_passes::scene::{Camera, Scene};
use std::sync::Arc;

/// Renders one scene on one backend, frame by frame.
pub struct Renderer {
    exec: Box<dyn Executable>,
    gi: Gi,
    view: View,
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

    /// Runs two frames and forgets them, so that what is measured from then on starts from an empty cache and yet with kernels that
    /// have run: drivers compile them when they first do, and memory is touched for the first time then.
    ///
    /// # Errors
    /// As [`Renderer::frame`].
    pub fn warm_up(&mut self) -> Result<(), RenderError> {
        // The surfels that the first frame makes trace rays in the second.
        for _ in 0..2 {
            self.frame()?;
            self.wait()?;
        }
        self.reset()
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

    /// The camera of the next frame as the device sees it, relative to the floating origin.
    pub(crate) fn device_camera(&self) -> data::Camera {
        self.gi.device_camera(&self.view.camera)
    }
}
