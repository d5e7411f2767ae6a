//! The lookup of surfels around a point where there is no wide one.
use crate::data::{Gathered, SurfelLight};
use crate::shared::lookup::{self, Place, Surfels};

/// The lookup with the best instructions of this processor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lookup;

impl Lookup {
    /// The scalar lookup.
    pub fn new() -> Self {
        Lookup
    }

    /// Same as [`lookup::coverage`].
    pub fn coverage(self, place: &Place<'_>, s: &Surfels<'_>, seen: impl FnMut(usize)) -> f32 {
        lookup::coverage(place, s, seen)
    }

    /// Same as [`lookup::neighbours`].
    pub fn neighbours(
        self,
        own: usize,
        list: &[u32],
        reach: f32,
        s: &Surfels<'_>,
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, f32),
    ) {
        lookup::neighbours(own, list, reach, s, wanted, each);
    }

    /// Same as [`lookup::gather`].
    pub fn gather(
        self,
        place: &Place<'_>,
        enough: f32,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> Gathered {
        lookup::gather(place, enough, s, light)
    }
}
