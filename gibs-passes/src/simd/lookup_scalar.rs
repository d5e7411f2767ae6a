//! The lookup of surfels around a point where there is no wide one.
use crate::data::{Gathered, SurfelLight};
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Owns, Points};
use glam::Vec3;

/// The lookup with the best instructions of this processor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lookup;

impl Lookup {
    /// The scalar lookup.
    pub fn new() -> Self {
        Lookup
    }

    /// Same as [`lookup::crowds`].
    pub fn crowds(self, owns: &Owns<'_>, s: &Surfels<'_>) -> [f32; AT_A_TIME] {
        lookup::crowds(owns, s)
    }

    /// Same as [`lookup::neighbours`].
    pub fn neighbours<const REACH: u32>(
        self,
        owns: &Owns<'_>,
        s: &Surfels<'_>,
        _: impl Fn(usize),
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, usize, f32),
    ) {
        lookup::neighbours::<REACH>(owns, s, wanted, each);
    }

    /// Same as [`lookup::coverages`].
    pub fn coverages(
        self,
        points: &Points<'_>,
        s: &Surfels<'_>,
        seen: impl FnMut(usize),
    ) -> [f32; AT_A_TIME] {
        lookup::coverages(points, s, seen)
    }

    /// Same as [`lookup::gathers`].
    pub fn gathers(
        self,
        points: &Points<'_>,
        enough: f32,
        beyond: impl Fn(usize) -> Option<Vec3>,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> [Gathered; AT_A_TIME] {
        lookup::gathers(points, enough, beyond, s, light)
    }
}
