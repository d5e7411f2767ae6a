//! `persistent/request_rays`: how many rays each surfel would like.
use crate::data::{SurfelIrradiance, SurfelPose};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Requests rays for every live surfel; newly spawned ones ask for more (GIBS, "Global Ray Budget").
    pub stage RequestRays {
        wgsl: gibs_shaders::stages::REQUEST_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            write requests: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Rays that a surfel integrates before it counts as settled.
pub const FRESH: u32 = 128;
/// Request of a fresh surfel, in units of a settled one's.
pub const FRESH_REQUEST: u32 = 4;

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let request = if p.poses[i].radius <= 0.0 {
            0
        } else if p.irradiance[i].samples < FRESH {
            FRESH_REQUEST
        } else {
            1
        };
        p.requests.set(i, request);
    }
}
