//! The lookup of surfels around a point where there is no wide one.
use crate::data::{Gathered, SurfelLight};
use crate::shared::lookup::{self, Surfels};
use glam::Vec3;

/// The lookup with the best instructions of this processor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lookup;

impl Lookup {
    /// The scalar lookup.
    pub fn new() -> Self {
        Lookup
    }

    /// Same as [`lookup::coverage`].
    pub fn coverage(
        self,
        point: Vec3,
        normal: Vec3,
        s: &Surfels<'_>,
        seen: impl FnMut(usize),
    ) -> f32 {
        lookup::coverage(point, normal, s, seen)
    }

    /// Same as [`lookup::neighbours`].
    pub fn neighbours(
        self,
        point: Vec3,
        normal: Vec3,
        reach: f32,
        s: &Surfels<'_>,
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, f32),
    ) {
        lookup::neighbours(point, normal, reach, s, wanted, each);
    }

    /// Same as [`lookup::gather`].
    pub fn gather(
        self,
        point: Vec3,
        normal: Vec3,
        enough: f32,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> Gathered {
        lookup::gather(point, normal, enough, s, light)
    }
}
