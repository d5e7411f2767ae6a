//! Time per frame of several backends that take turns in one process, frame by frame.
use gibs::Renderer;
use gibs::backends::{self, Choice};
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::view::View;
use std::error::Error;
use std::time::Instant;

/// What all backends render.
pub struct Work<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its view.
    pub view: &'a View,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Settings of the frame.
    pub settings: &'a Settings,
    /// Frames after the first one.
    pub frames: u32,
}

/// A backend at work.
pub struct Runner {
    renderer: Renderer,
    /// Its device.
    pub device: String,
    /// Seconds of each frame after the first.
    pub seconds: Vec<f64>,
}

impl Runner {
    /// Prepares a backend and renders the first frame, which is not timed.
    ///
    /// # Errors
    /// Why the backend cannot render this.
    pub fn new(choice: Choice, work: &Work<'_>) -> Result<Self, Box<dyn Error>> {
        let backend = backends::open(choice)?;
        let mut renderer = Renderer::new(
            backend.as_ref(),
            work.scene,
            work.view,
            work.size,
            work.settings,
            0,
        )?;
        renderer.frame()?;
        renderer.wait()?;
        Ok(Self {
            renderer,
            device: backend.device().name.clone(),
            seconds: Vec::new(),
        })
    }

    fn frame(&mut self) -> Result<(), Box<dyn Error>> {
        let start = Instant::now();
        self.renderer.frame()?;
        self.renderer.wait()?;
        self.seconds.push(start.elapsed().as_secs_f64());
        Ok(())
    }
}

/// Renders the frames: each backend the same one before any the next, in an order that rotates.
///
/// # Errors
/// Why a frame failed.
pub fn take_turns(runners: &mut [&mut Runner], work: &Work<'_>) -> Result<(), Box<dyn Error>> {
    for frame in 0..work.frames as usize {
        for turn in 0..runners.len() {
            runners[(turn + frame) % runners.len()].frame()?;
        }
    }
    Ok(())
}
