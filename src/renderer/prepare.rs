//! What every picture needs before its first frame: a scene for the device, a schedule, sizes and cameras that can be rendered.
use super::RenderError;
use crate::view::View;
use gibs_graph::{Graph, GraphErrors, Schedule};
use gibs_passes::device::{DeviceScene, DeviceSceneError};
use gibs_passes::scene::{Camera, Scene};
use glam::DVec3;

/// Longest side of a picture, pixels.
pub const MOST_PIXELS: u32 = crate::view::MAX_RESOLUTION;

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
