//! What happened to the surfels, in numbers.
use serde::Serialize;

/// Surfels and what happened to them; see [`Renderer::counters`](crate::Renderer::counters).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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
    /// Entries that did not fit the lists of the grid's cells, in the last frame: raise the setting `grid_lists`.
    pub overflow: u32,
    /// Rays of the last frame, from surfels.
    pub rays: u32,
    /// Slots that were lost or given twice, after the last frame; `None` without the setting `check_slots`.
    pub slot_errors: Option<u32>,
}
