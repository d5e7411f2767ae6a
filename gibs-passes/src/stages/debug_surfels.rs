//! `debug/surfels`: what a debug view shows of each surfel (F3).
use crate::data::{Camera, Frame, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::debug::{self, DebugView};
use crate::shared::estimator;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// A number for each surfel, in the unit of the view that [`SurfelSettings::debug`] names; -1 for slots that are free,
    /// and where `irradiance` is bound also for surfels without a ray yet, which know nothing of their own. Of what else is
    /// optional, a view has what it shows.
    pub stage DebugSurfels {
        wgsl: gibs_shaders::stages::DEBUG_SURFELS,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            optional_read births: SurfelBirth,
            optional_read irradiance: SurfelIrradiance,
            optional_read spans: UVec2,
            optional_read unseen: u32,
            write values: f32,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Of a surfel at the eye itself, for a radius that is a number.
const LEAST_DISTANCE: f32 = 1e-20;

/// Standard deviation of what so many rays bring that the estimator is fully confident, over the mean.
#[inline]
pub fn deviation(state: &SurfelIrradiance) -> f32 {
    let level = estimator::luminance(state.mean).max(estimator::luminance(state.short_mean));
    if level <= 0.0 {
        return 0.0;
    }
    (state.variance / estimator::FULL_CONFIDENCE).sqrt() / level
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let view = DebugView::of(p.settings.debug);
    for i in group.range(p.poses.len() as u32) {
        let pose = &p.poses[i];
        let is_dark = p.irradiance.get(i).is_some_and(|state| state.samples == 0);
        if pose.radius <= 0.0 || is_dark {
            p.values.set(i, debug::NOTHING.value);
            continue;
        }
        let value = match view {
            Some(DebugView::Surfels) => i as f32,
            Some(DebugView::Radius) => {
                let distance = (pose.position - p.camera.eye).length();
                pose.radius / (p.camera.pixel_angle * distance.max(LEAST_DISTANCE))
            }
            Some(DebugView::Variance) => p.irradiance.get(i).map_or(0.0, deviation),
            Some(DebugView::RayCount) if !p.spans.is_empty() => p.spans[i].y as f32,
            Some(DebugView::Life) => {
                let born = p.births.get(i).map_or(0, |birth| birth.frame);
                p.frame.number.wrapping_sub(born) as f32
            }
            Some(DebugView::Unseen) => p.unseen.get(i).map_or(0.0, |&frames| frames as f32),
            Some(DebugView::RayCount) => 0.0,
            _ => 1.0,
        };
        p.values.set(i, value);
    }
}
