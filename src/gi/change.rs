//! Changes of what is lit, between frames: a new schedule that keeps every surfel that can be kept.
use super::lit::Lit;
use super::{Gi, Parts, Plan};
use crate::renderer::{RenderError, check_camera, check_size};
use crate::view::View;
use gibs_graph::{Action, Executable, Kind, Schedule, Step};
use gibs_passes::frame::{Settings, pixel_angle, upload_scene_where};
use gibs_passes::scene::{Camera, Scene};
use glam::DVec3;
use std::collections::HashSet;
use std::sync::Arc;

/// # Changes between frames
///
/// Each call takes the executable that runs [`Gi::schedule`], and writes what the change needs. Where the frame needs
/// other stages or other memory, the executable adopts a new schedule; [`Gi::schedule`] is then another [`Arc`] than
/// before. Where it does not, as with values of lights and of most settings, that costs no more than the upload. After an
/// error the frame is what it was before, unless the device failed.
///
/// Of every call holds:
/// - **Recorded frames come first.** On Vulkan, every frame that was recorded into commands of the engine must be done;
///   on wgpu, it must be submitted. The executable waits by itself only for what it submitted.
/// - **What was lent is forgotten** with a new schedule: images and buffers. Resources may have other numbers then, so ask
///   [`Gi::image`] again and lend again before the next frame. The scene's inputs that were lent are written anew into the
///   executable's own memory. Without a new schedule everything stays lent, and what the engine has lent of the scene's
///   inputs is for the engine to write.
/// - **Large uploads have to be sent off.** On Vulkan, call [`Executable::wait`] before the next frame is recorded where
///   the change wrote more than 64 KiB at a time or 1 MiB in all, as things that are added do; recording is refused
///   otherwise.
/// - **Pictures and queries wait for a frame.** Until the next one was begun and has run, [`Gi::irradiance`] is an error.
impl Gi {
    /// Goes on with other settings. Surfels stay, also where their capacity grows; where it shrinks they start over, and
    /// nothing else does.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames).
    ///
    /// # Errors
    /// As [`Gi::new`], and [`RenderError::Executable`].
    pub fn set_settings(
        &mut self,
        exec: &mut dyn Executable,
        settings: &Settings,
        camera: &Camera,
    ) -> Result<(), RenderError> {
        settings.check()?;
        check_camera(camera)?;
        let grid = settings.grid(pixel_angle(camera, self.parts.size), self.parts.size);
        let parts = Parts {
            settings: settings.clone(),
            grid,
            ..self.parts.clone()
        };
        self.change(exec, parts, |_| false)
    }

    /// Goes on with a picture of another size, or another field of view. Surfels stay, and take the size that this
    /// camera asks for.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames).
    ///
    /// # Errors
    /// As [`Gi::new`], and [`RenderError::Executable`].
    pub fn resize(
        &mut self,
        exec: &mut dyn Executable,
        size: [u32; 2],
        camera: &Camera,
    ) -> Result<(), RenderError> {
        check_size(size)?;
        check_camera(camera)?;
        let grid = self.parts.settings.grid(pixel_angle(camera, size), size);
        let parts = Parts {
            size,
            grid,
            ..self.parts.clone()
        };
        self.change(exec, parts, |_| false)
    }

    /// Goes on with other lights, another sun or sky, in the geometry that is there: `scene` differs in its lights only,
    /// and in nodes that draw nothing. Surfels stay, and their light follows.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames). Only lights and sky are written, and only where they differ.
    ///
    /// # Errors
    /// [`RenderError::Lights`] if the scene has other meshes, triangles or materials by number, or if a node that draws
    /// something draws other meshes or has moved; vertices and the values of materials are not looked at. Else as
    /// [`Gi::new`], and [`RenderError::Executable`].
    pub fn set_lights(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        self.check(exec)?;
        let pose = scene.pose(&view.animation);
        let schedule = Arc::clone(&self.schedule);
        // Nobody else has it, so nothing of the geometry is copied.
        let lit = Arc::make_mut(&mut self.parts.lit);
        // First, because it names what is wrong with the scene itself.
        let before = lit.relight(scene, &pose, view)?;
        if let Some(difference) = lit.drawn.difference(scene, &pose) {
            lit.restore(before);
            return Err(RenderError::Lights {
                scene: scene.name.clone(),
                difference,
            });
        }
        let (lights, sky) = before.differs(&self.parts.lit);
        let parts = self.parts.clone();
        let changed = self.change(exec, parts, |key| match key {
            "scene_lights" => lights,
            "scene_environment" => sky,
            _ => false,
        });
        if changed.is_err() && Arc::ptr_eq(&schedule, &self.schedule) {
            Arc::make_mut(&mut self.parts.lit).restore(before);
        }
        changed
    }

    /// Goes on in another scene: things added, moved or taken away. Surfels stay on the node that they were born on, by
    /// its index, and follow it; those of an index that is gone go as well.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames). The tree over all things is built anew; what is the same in
    /// both scenes is not written again.
    ///
    /// # Errors
    /// As [`Gi::new`], and [`RenderError::Executable`].
    pub fn set_scene(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        let origin = self.parts.lit.device.origin;
        self.set_scene_at(exec, scene, view, origin, self.parts.clone())
    }

    /// Moves the floating origin to the eye of `view`: for a camera that has gone some kilometres. Surfels stay.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames).
    ///
    /// # Errors
    /// As [`Gi::new`], and [`RenderError::Executable`].
    pub fn shift_origin(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        let eye = view.camera.position;
        self.set_scene_at(exec, scene, view, eye, self.parts.clone())
    }

    /// Goes on at another place and with another field of view: the floating origin goes to the eye of `view`, and the
    /// grid follows the field of view. Surfels stay, and those that the new view sees light it from its first frame on.
    ///
    /// Frames that were recorded must be done, and what was lent may be forgotten: see
    /// [changes between frames](#changes-between-frames).
    ///
    /// # Errors
    /// As [`Gi::new`], and [`RenderError::Executable`].
    pub fn cut(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
    ) -> Result<(), RenderError> {
        let Parts { settings, size, .. } = &self.parts;
        let parts = Parts {
            grid: settings.grid(pixel_angle(&view.camera, *size), *size),
            ..self.parts.clone()
        };
        self.set_scene_at(exec, scene, view, view.camera.position, parts)
    }

    /// Starts over: every surfel is gone, the next frame is number 0, and every state that stages beyond the frame's own
    /// keep has its first value again. What follows is what a new executable would do.
    ///
    /// Frames that were recorded must be done; everything stays lent. On Vulkan, call [`Executable::wait`] before the next
    /// frame is recorded.
    ///
    /// # Errors
    /// [`RenderError::Executable`], [`RenderError::Backend`].
    pub fn reset(&mut self, exec: &mut dyn Executable) -> Result<(), RenderError> {
        self.start_at(exec, 0)
    }

    /// As [`Gi::reset`], but the next frame has this number. The number names the frame's random choices and dates what is
    /// born in it; after `u32::MAX` comes 0. So a run can draw other numbers than one before it under the same seed, and a test
    /// can see the count wrap without four billion frames.
    ///
    /// # Errors
    /// As [`Gi::reset`].
    pub fn start_at(&mut self, exec: &mut dyn Executable, number: u32) -> Result<(), RenderError> {
        self.check(exec)?;
        exec.reset()?;
        self.frame = number;
        self.begun = false;
        Ok(())
    }

    fn set_scene_at(
        &mut self,
        exec: &mut dyn Executable,
        scene: &Scene,
        view: &View,
        origin: DVec3,
        parts: Parts,
    ) -> Result<(), RenderError> {
        self.check(exec)?;
        let before = Arc::clone(&self.parts.lit);
        let lit = Arc::new(Lit::new(scene, view, origin)?);
        let after = Arc::clone(&lit);
        self.change(exec, Parts { lit, ..parts }, |key| {
            after.has_other(key, &before)
        })
    }

    /// Goes on with `parts`, where those inputs of the scene have other content than before whose keys are `changed`.
    fn change(
        &mut self,
        exec: &mut dyn Executable,
        parts: Parts,
        changed: impl Fn(&str) -> bool,
    ) -> Result<(), RenderError> {
        self.check(exec)?;
        let plan = parts.plan(self.screen);
        let schedule = self.schedule_for(&plan)?;
        let stays = Arc::ptr_eq(&schedule, &self.schedule);
        let adopted = schedule.adoptions(&self.schedule);
        // Inputs that hold, after the adoption, what they should.
        let holds = |&&(from, to): &&(_, u32)| match exec.lent(from) {
            true => stays,
            false => !changed(&schedule.resources[to as usize].key),
        };
        let held: HashSet<String> = adopted
            .iter()
            .filter(holds)
            .map(|&(_, to)| schedule.resources[to as usize].key.clone())
            .collect();
        if !stays {
            exec.adopt(Arc::clone(&schedule))?;
        }
        let fewer = parts.settings.surfels < self.parts.settings.surfels;
        let other_depths = parts.settings.depth_side != self.parts.settings.depth_side;
        let other_guides = parts.settings.guide_side != self.parts.settings.guide_side;
        (self.schedule, self.plan, self.parts) = (schedule, plan, parts);
        self.begun = false;
        // With fewer slots, what is there for each surfel did not carry over; what counts them did, and makes no sense without.
        // Texels of depth functions and guides that are wider now lie elsewhere.
        let begins_anew = |key: &str| match key {
            "surfel_depths" if other_depths => true,
            "surfel_guides" if other_guides => true,
            _ => fewer && key.starts_with("surfel_"),
        };
        for (_, to) in adopted {
            let resource = &self.schedule.resources[to as usize];
            if let Kind::State(initial) = &resource.kind
                && begins_anew(&resource.key)
            {
                exec.upload(to, 0, &initial.bytes(resource.bytes as usize))?;
            }
        }
        Ok(upload_scene_where(exec, &self.parts.lit.device, |key| {
            !held.contains(key)
        })?)
    }

    /// The schedule of a plan; the present one where that does the same.
    fn schedule_for(&self, plan: &Plan) -> Result<Arc<Schedule>, RenderError> {
        if *plan == self.plan {
            return Ok(Arc::clone(&self.schedule));
        }
        let made = plan.schedule(self.extend.as_ref(), &self.shaders)?;
        Ok(match alike(&made, &self.schedule) {
            true => Arc::clone(&self.schedule),
            false => Arc::new(made),
        })
    }
}

/// Whether two schedules do the same in the same memory.
fn alike(a: &Schedule, b: &Schedule) -> bool {
    let same = |(a, b): (&Step, &Step)| {
        let same_action = match (&a.action, &b.action) {
            (Action::Clear(a), Action::Clear(b)) => a == b,
            (Action::Dispatch(a), Action::Dispatch(b)) => {
                a.stage == b.stage
                    && a.kernel.wgsl.text == b.kernel.wgsl.text
                    && a.features() == b.features()
                    && (&a.ports, &a.bindings, &a.absent, a.size)
                        == (&b.ports, &b.bindings, &b.absent, b.size)
            }
            _ => false,
        };
        same_action && a.label == b.label
    };
    a.resources == b.resources
        && a.outputs == b.outputs
        && a.steps.len() == b.steps.len()
        && a.steps.iter().zip(&b.steps).all(same)
}
