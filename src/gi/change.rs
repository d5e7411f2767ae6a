//! Changes of what is lit, between frames: a new schedule that keeps every surfel that can be kept.
use super::{Extend, Gi, Parts};
use crate::renderer::{RenderError, check_camera, check_size, compile, device_scene, refused};
use crate::view::View;
use gibs_graph::{Executable, Graph, Kind, Schedule};
use gibs_passes::device::DeviceScene;
use gibs_passes::frame::{
    SceneSizes, Screen, Settings, SurfelFrame, pixel_angle, surfel_frame, upload_scene_where,
};
use gibs_passes::scene::{Camera, Scene};
use glam::DVec3;
use std::collections::HashSet;
use std::sync::Arc;

impl Parts {
    pub(super) fn frame(&self, screen: Screen) -> SurfelFrame {
        SurfelFrame {
            size: self.size,
            grid: self.grid,
            settings: self.settings.clone(),
            screen,
        }
    }

    pub(super) fn schedule(
        &self,
        screen: Screen,
        extend: &Extend,
    ) -> Result<Arc<Schedule>, RenderError> {
        let mut g = Graph::new("surfels");
        let outputs = surfel_frame(&mut g, &self.frame(screen), &SceneSizes::of(&self.scene));
        extend(&mut g, outputs);
        Ok(Arc::new(compile(g)?))
    }
}

/// Each call takes the executable that runs [`Gi::schedule`], has it adopt a new one, and writes what that needs. After
/// an error of these calls the frame is what it was before, unless the device failed. What an engine has lent for images
/// is forgotten: lend again before the next frame.
impl Gi {
    /// Goes on with other settings. Surfels stay, also where their capacity grows; where it shrinks they start over.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn set_settings(
        &mut self,
        exec: &mut dyn Executable,
        settings: &Settings,
        camera: &Camera,
    ) -> Result<(), RenderError> {
        settings.check()?;
        check_camera(camera)?;
        let grid = settings.grid(pixel_angle(camera, self.parts.size), self.parts.size);
        self.change(
            exec,
            Parts {
                settings: settings.clone(),
                grid,
                ..self.parts.clone()
            },
        )
    }

    /// Goes on with a picture of another size, or another field of view. Surfels stay, and take the size that this
    /// camera asks for.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn resize(
        &mut self,
        exec: &mut dyn Executable,
        size: [u32; 2],
        camera: &Camera,
    ) -> Result<(), RenderError> {
        check_size(size)?;
        check_camera(camera)?;
        let grid = self.parts.settings.grid(pixel_angle(camera, size), size);
        self.change(
            exec,
            Parts {
                size,
                grid,
                ..self.parts.clone()
            },
        )
    }

    /// Goes on with other lights, another sun or sky, in the geometry that is there: `scene` differs in its lights only.
    /// Surfels stay, and their light follows.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn set_lights(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        let pose = scene.pose(&view.animation);
        let mut lit = DeviceScene::clone(&self.parts.scene);
        lit.relight(scene, &pose, view.sun.as_ref(), &view.environment)
            .map_err(refused(scene))?;
        let scene = Arc::new(lit);
        self.change(
            exec,
            Parts {
                scene,
                ..self.parts.clone()
            },
        )
    }

    /// Goes on in another scene: things added, moved or taken away. Surfels stay on the node that they were born on, by
    /// its index, and follow it; those of an index that is gone stay where they are until they are recycled.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn set_scene(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        self.set_scene_at(exec, scene, view, self.parts.scene.origin)
    }

    /// Moves the floating origin to the eye of `view`: for a camera that has gone some kilometres. Surfels stay.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn shift_origin(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        self.set_scene_at(exec, scene, view, view.camera.position)
    }

    /// Goes on at another place and with another field of view: the floating origin goes to the eye of `view`, and the
    /// grid follows the field of view. Surfels stay, and those that the new view sees light it from its first frame on.
    ///
    /// # Errors
    /// As [`Gi::new`].
    pub fn cut(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        let Parts { settings, size, .. } = &self.parts;
        let grid = settings.grid(pixel_angle(&view.camera, *size), *size);
        let scene = Arc::new(device_scene(scene, view, view.camera.position)?);
        self.change(
            exec,
            Parts {
                scene,
                grid,
                ..self.parts.clone()
            },
        )
    }

    fn set_scene_at(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
        origin: DVec3,
    ) -> Result<(), RenderError> {
        let scene = Arc::new(device_scene(scene, view, origin)?);
        self.change(
            exec,
            Parts {
                scene,
                ..self.parts.clone()
            },
        )
    }

    fn change(&mut self, exec: &mut dyn Executable, parts: Parts) -> Result<(), RenderError> {
        let schedule = parts.schedule(self.screen, self.extend.as_ref())?;
        let same_scene = Arc::ptr_eq(&parts.scene, &self.parts.scene);
        let kept: HashSet<String> = schedule
            .adoptions(exec.schedule())
            .into_iter()
            .map(|(_, to)| &schedule.resources[to as usize])
            .filter(|r| r.kind == Kind::Input && same_scene)
            .map(|r| r.key.clone())
            .collect();
        exec.adopt(Arc::clone(&schedule))?;
        let fewer = parts.settings.surfels < self.parts.settings.surfels;
        (self.schedule, self.parts) = (schedule, parts);
        if fewer {
            // Some states carry over and some do not; together they make sense only from the start.
            exec.reset()?;
        }
        Ok(upload_scene_where(exec, &self.parts.scene, |key| {
            !kept.contains(key)
        })?)
    }
}
