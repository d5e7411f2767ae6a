//! What one frame costs and does.
use crate::{Counters, RenderError, Renderer};
use gibs_graph::Action;
use serde::Serialize;
use std::time::Instant;

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameRow {
    /// Its number, from 0.
    pub frame: u32,
    /// From its start until the device is done, milliseconds.
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
    groups: Vec<String>,
    /// Group of each step of the schedule.
    of_step: Vec<usize>,
    before: Counters,
    frame: u32,
}

impl FrameMeter {
    /// Switches measuring on. The renderer has run no frame yet, and changes its schedule no more.
    pub fn new(renderer: &mut Renderer) -> Self {
        renderer.executable().measure(true);
        let (mut groups, mut of_step) = (Vec::<String>::new(), Vec::new());
        let schedule = renderer.executable().schedule().clone();
        for i in 0..schedule.steps.len() {
            // A clear belongs to the stage that it comes right before.
            let mut from_here = schedule.steps[i..].iter();
            let stage = from_here.find(|step| matches!(step.action, Action::Dispatch(_)));
            let group = stage.and_then(|step| step.label.split_once('/'));
            let name = group.map_or(OTHERS, |(group, _)| group);
            let place = groups.iter().position(|group| group == name);
            of_step.push(place.unwrap_or_else(|| {
                groups.push(name.to_owned());
                groups.len() - 1
            }));
        }
        Self {
            groups,
            of_step,
            before: Counters::default(),
            frame: 0,
        }
    }

    /// The groups of the frame, in the order in which they first run: the parts of the steps' labels before `/`.
    pub fn groups(&self) -> &[String] {
        &self.groups
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
        let mut groups_ms = Vec::new();
        if let Some(times) = renderer.executable().timings()? {
            groups_ms.resize(self.groups.len(), 0.0);
            for time in times {
                // Of a step that another schedule has, nothing is known.
                let group = self.of_step.get(time.step);
                if let Some(sum) = group.and_then(|group| groups_ms.get_mut(*group)) {
                    *sum += time.time.as_secs_f64() * 1e3;
                }
            }
        }
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

/// Group of steps whose label has none.
const OTHERS: &str = "others";
