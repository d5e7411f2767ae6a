//! What one frame costs and does.
use crate::stages::{fold, group_of};
use crate::{Counters, RenderError, Renderer};
use serde::Serialize;
use std::time::Instant;

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameRow {
    /// Its number, from 0.
    pub frame: u32,
    /// From its start until the device is done, milliseconds. Its steps are timed, which is part of it.
    pub ms: f64,
    /// Time of each of [`FrameMeter::groups`], milliseconds; empty where the device measures none.
    pub groups_ms: Vec<f64>,
    /// Surfels that live after it.
    pub live: u32,
    /// Surfels born in it.
    pub births: u32,
    /// Surfels that gave up their slots in it.
    pub recycled: u32,
    /// Births in it that found no free slot.
    pub starved: u32,
    /// Holes in crowded cells, in which no surfel was born: see [`Counters::crowded`].
    pub crowded: u32,
    /// Entries that did not fit the grid's lists.
    pub grid_overflow: u32,
    /// Slots lost or given twice; `None` without the setting `check_slots`.
    pub slot_errors: Option<u32>,
    /// Rays from surfels.
    pub rays: u32,
    /// Rays that went on beyond hits, on top of those.
    pub continued: u32,
}

/// Runs frames of a renderer and measures each.
#[derive(Clone, Debug)]
pub struct FrameMeter {
    /// Each with its steps.
    groups: Vec<(String, Vec<usize>)>,
    before: Counters,
    frame: u32,
}

impl FrameMeter {
    /// Switches measuring on. The renderer starts from an empty cache, and changes its schedule no more.
    pub fn new(renderer: &mut Renderer) -> Self {
        renderer.executable().measure(true);
        let schedule = renderer.executable().schedule();
        let of_steps = fold((0..schedule.steps.len()).map(|step| group_of(schedule, step)));
        Self {
            groups: of_steps,
            before: Counters::default(),
            frame: 0,
        }
    }

    /// The groups of the frame, in the order in which they first run: the parts of the steps' labels before `/`.
    pub fn groups(&self) -> Vec<String> {
        self.groups.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Runs a frame and waits for it.
    ///
    /// # Errors
    /// As [`Renderer::frame`].
    pub fn frame(&mut self, renderer: &mut Renderer) -> Result<FrameRow, RenderError> {
        let start = Instant::now();
        renderer.frame()?;
        renderer.wait()?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let times = renderer.executable().timings()?;
        let groups_ms = times.map_or_else(Vec::new, |times| {
            let of_group = |(_, steps): &(String, Vec<usize>)| {
                let own = times.iter().filter(|time| steps.contains(&time.step));
                own.map(|time| time.time.as_secs_f64() * 1e3).sum()
            };
            self.groups.iter().map(of_group).collect()
        });
        let now = renderer.counters()?;
        let before = std::mem::replace(&mut self.before, now);
        let frame = self.frame;
        self.frame += 1;
        Ok(FrameRow {
            frame,
            ms,
            groups_ms,
            live: now.live,
            births: now.born.wrapping_sub(before.born),
            recycled: now.recycled.wrapping_sub(before.recycled),
            starved: now.starved.wrapping_sub(before.starved),
            crowded: now.crowded,
            grid_overflow: now.overflow,
            slot_errors: now.slot_errors,
            rays: now.rays,
            continued: now.continued,
        })
    }
}
