//! Lookups at several points, and around several surfels, at a time.
use super::{PEAK, Place, alignment, coverage, gather, nearness};
use crate::data::{Gathered, SurfacePoint, SurfelLight, SurfelPose};
use crate::shared::depth::visibility;
use crate::shared::lists::{List, Surfels};
use crate::shared::surface;
use glam::Vec3;

/// Points that are looked up at a time.
pub const AT_A_TIME: usize = 16;

/// Points on surfaces that are looked up at a time; none where there is none.
pub type Points<'a> = [Option<&'a SurfacePoint>; AT_A_TIME];

/// Calls `each` with the places of the points that `place` has for a range, [`AT_A_TIME`], and with those points.
#[inline(always)]
pub fn at_points(
    points: &[SurfacePoint],
    range: std::ops::Range<usize>,
    place: impl Fn(usize) -> usize,
    mut each: impl FnMut(&[usize], &Points<'_>),
) {
    for start in range.clone().step_by(AT_A_TIME) {
        let mut places = [0; AT_A_TIME];
        let mut surfaces = [None; AT_A_TIME];
        let count = (range.end - start).min(AT_A_TIME);
        let both = places.iter_mut().zip(&mut surfaces);
        for (i, (at, surface)) in (start..range.end).zip(both) {
            *at = place(i);
            *surface = Some(&points[*at]).filter(|point| surface::is_surface(point));
        }
        each(&places[..count], &surfaces);
    }
}

/// Surfels around which is looked at a time.
#[derive(Clone, Copy)]
pub struct Owns<'a> {
    /// The surfels; none where there is none.
    pub ids: [Option<usize>; AT_A_TIME],
    /// Of each, the surfels that a lookup there visits.
    pub lists: [List<'a>; AT_A_TIME],
}

/// Calls `each` with those surfels of a range that `wanted` wants, [`AT_A_TIME`].
#[inline(always)]
pub fn at_surfels<'a>(
    s: &Surfels<'a>,
    range: std::ops::Range<usize>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(&Owns<'a>),
) {
    let mut all = range.filter(|&i| wanted(i));
    loop {
        let mut ids = [None; AT_A_TIME];
        for (id, found) in ids.iter_mut().zip(&mut all) {
            *id = Some(found);
        }
        if ids[0].is_none() {
            return;
        }
        let lists = s.lists(|at| Some(s.poses[ids[at]?].position));
        each(&Owns { ids, lists });
    }
}

/// What others cover each of several surfels' places: [`coverage`] there, less that by the surfel itself, which a lookup may not
/// visit where the list is long. Zero where there is none.
#[inline]
pub fn crowds(owns: &Owns<'_>, s: &Surfels<'_>) -> [f32; AT_A_TIME] {
    std::array::from_fn(|at| {
        let Some(own) = owns.ids[at] else {
            return 0.0;
        };
        let pose = &s.poses[own];
        let place = Place {
            position: pose.position,
            normal: pose.normal,
            list: owns.lists[at],
        };
        let mut by_itself = 0.0;
        let all = coverage(&place, s, |id| {
            if id == own {
                by_itself = PEAK;
            }
        });
        all - by_itself
    })
}

/// [`coverage`] at each of several points, zero where there is none.
#[inline]
pub fn coverages(
    points: &Points<'_>,
    s: &Surfels<'_>,
    mut seen: impl FnMut(usize),
) -> [f32; AT_A_TIME] {
    points.map(|point| match point {
        Some(point) => coverage(&Place::new(point, s), s, &mut seen),
        None => 0.0,
    })
}

/// [`gather`] at each of several points, nothing where there is none.
#[inline]
pub fn gathers(
    points: &Points<'_>,
    enough: f32,
    beyond: impl Fn(usize) -> Option<Vec3>,
    s: &Surfels<'_>,
    light: &[SurfelLight],
) -> [Gathered; AT_A_TIME] {
    std::array::from_fn(|i| match points[i] {
        Some(point) => gather(&Place::new(point, s), enough, beyond(i), s, light),
        None => Gathered::default(),
    })
}

/// Calls `each` with the place of each surfel among several, the surfels in its list that `wanted` wants, and their weights: with the normal and depth
/// factors of [`gather`], a reach of so many radii, and the surfel's own depth function beside theirs, since a wall between the
/// two may be known to only one of them. Distance counts by [`nearness`]: with its square, which is smooth at the end for the
/// eye, fewer of them would count.
#[inline]
pub fn neighbours<const REACH: u32>(
    owns: &Owns<'_>,
    s: &Surfels<'_>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, usize, f32),
) {
    let all = (0..).zip(&owns.ids).zip(&owns.lists);
    let pairs = all.filter_map(|((at, own), list)| Some((at, (*own)?, list)));
    let pairs = pairs.flat_map(|(at, own, list)| list.ids.iter().map(move |&id| (at, own, id)));
    for (at, own, id) in pairs {
        let (place, id) = (&s.poses[own], id as usize);
        let pose = &s.poses[id];
        let wide = SurfelPose {
            radius: REACH as f32 * pose.radius,
            ..*pose
        };
        let d = place.position - pose.position;
        let mut weight = nearness(d, &wide) * alignment(place.normal, pose);
        if weight <= 0.0 || !wanted(id) {
            continue;
        }
        if let (Some(depth), Some(own_depth)) = (s.depths.get(id), s.depths.get(own)) {
            weight *= visibility(depth, pose, d);
            weight *= visibility(own_depth, place, pose.position - place.position);
        }
        each(at, id, weight);
    }
}
