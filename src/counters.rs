//! What happened to the surfels, in numbers.
use gibs_passes::data::ClampedLight;
use serde::{Deserialize, Serialize};

/// Surfels and what happened to them; see [`Renderer::counters`](crate::Renderer::counters).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Counters {
    /// Surfels that live.
    pub live: u32,
    /// Surfels born since the start, wrapping.
    pub born: u32,
    /// Surfels that gave up their slots since the start, wrapping.
    pub recycled: u32,
    /// Births that found no free slot since the start, wrapping: raise the setting `surfels`.
    pub starved: u32,
    /// Holes in which no surfel was born in the last frame, as their cells' lists are as long as a lookup: quarters of tiles, and
    /// with `hit_births` hits of rays. Raise the setting `lookup`.
    pub crowded: u32,
    /// Entries that did not fit the lists of the grid's cells, in the last frame: raise the setting `grid_lists`.
    pub overflow: u32,
    /// Rays of the last frame, from surfels.
    pub rays: u32,
    /// Rays of the last frame that went on beyond hits, on top of those.
    pub continued: u32,
    /// Slots that were lost or given twice, after the last frame; `None` without the setting `check_slots`.
    pub slot_errors: Option<u32>,
    /// What the firefly clamp took since the start; `None` without the setting `clamp`.
    pub clamped: Option<Clamped>,
}

/// What the firefly clamp took since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clamped {
    /// Share of the luminance that surfel rays brought, in `[0, 1]`.
    pub share: f32,
    /// How many times it took some from a surfel, wrapping.
    pub times: u32,
}

impl From<ClampedLight> for Clamped {
    fn from(light: ClampedLight) -> Self {
        let share = match light.brought > 0.0 {
            true => light.taken / light.brought,
            false => 0.0,
        };
        Self {
            share,
            times: light.samples,
        }
    }
}
