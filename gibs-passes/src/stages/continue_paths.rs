//! `persistent/continue_paths`: the next segment of each path that goes on.
use crate::data::{Path, Ray, SurfacePoint};
use crate::shared::{hash, octahedral, sampling};
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Packs the paths that go on, in order, and draws each a ray over the cosine lobe of the surface where it is.
    pub stage ContinuePaths {
        wgsl: gibs_shaders::stages::CONTINUE_PATHS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read points: SurfacePoint,
            read paths: Path,
            read goes_on: u32,
            read scanned: u32,
            write next_rays: Ray,
            write next_paths: Path,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        if p.goes_on[i] == 0 {
            continue;
        }
        let (point, path) = (&p.points[i], &p.paths[i]);
        let first = hash::pcg(path.seed);
        let second = hash::pcg(first);
        let normal = octahedral::unpack(point.shading_normal);
        let local = sampling::cosine_hemisphere(hash::unit(first), hash::unit(second));
        let direction = sampling::to_world(local, normal);
        let geometric = octahedral::unpack(point.geometric_normal);
        let origin = sampling::start(point.position, geometric, point.offset, direction);
        let slot = p.scanned[i] as usize;
        p.next_rays.set(
            slot,
            Ray {
                origin,
                t_min: 0.0,
                direction,
                t_max: f32::MAX,
            },
        );
        p.next_paths.set(
            slot,
            Path {
                seed: second,
                remaining: path.remaining - 1,
                ..*path
            },
        );
    }
}
