//! `persistent/request_rays`: how many rays each surfel would like (I4).
use crate::data::{Neighbours, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::{requests, sharing::Said};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Requests rays for every live surfel, in units of the least: by how uncertain its irradiance is, from the
    /// variance of its neighbours' rays or its own, how long no pixel has seen it, and how new it is (GIBS, "Global Ray
    /// Budget").
    pub stage RequestRays {
        wgsl: gibs_shaders::stages::REQUEST_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            read unseen: u32,
            optional_read neighbours: Neighbours,
            write requests: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let request = if p.poses[i].radius <= 0.0 {
            0
        } else {
            let said = p
                .neighbours
                .slice()
                .get(i)
                .map_or(0.0, |said| Said::unpack(said).ray_variance);
            requests::request(&p.irradiance[i], said, p.unseen[i], p.settings.steered != 0)
        };
        p.requests.set(i, request);
    }
}
