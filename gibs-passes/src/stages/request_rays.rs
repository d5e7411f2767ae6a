//! `persistent/request_rays`: how many rays each surfel would like (I4).
use crate::data::{Frame, Neighbours, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::{requests, sharing::Said};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Requests rays for every live surfel, in units of the least: by how uncertain its irradiance is, from the
    /// variance of its neighbours' rays or its own, how long no pixel has seen it, and how new it is (GIBS, "Global Ray
    /// Budget"). `requests` has two elements per surfel: first those of surfels that were there before, then those of new
    /// ones; each surfel's other one is 0.
    pub stage RequestRays {
        wgsl: gibs_shaders::stages::REQUEST_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read births: SurfelBirth,
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
    let surfels = p.poses.len();
    for i in group.range(surfels as u32) {
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
        let is_new = p.births[i].frame == p.frame.number;
        let (before, new) = if is_new { (0, request) } else { (request, 0) };
        p.requests.set(i, before);
        p.requests.set(surfels + i, new);
    }
}
