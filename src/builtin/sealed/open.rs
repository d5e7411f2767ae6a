//! A hall like the sealed one, without what seals it: light passes between the pillars, and none of it may be lost.
use super::halls::{DEPTH, furnish, hall, hall_views};
use super::parts::FAR;
use crate::view::View;
use gibs_passes::scene::Scene;

/// The hall of the sealed scene `pillars` without its partitions, and views from its lit part and from the part that light
/// reaches between the pillars.
pub fn colonnade() -> (Scene, View, View) {
    let (mut a, paints) = hall("colonnade", DEPTH, [-FAR / 2.0, 0.0]);
    furnish(&mut a, &paints);
    let [bright, dim] = hall_views();
    (a.scene, bright, dim)
}
