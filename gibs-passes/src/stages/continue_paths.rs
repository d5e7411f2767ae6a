//! `persistent/continue_paths`: the next segment of each path that goes on.
use crate::data::{Emitter, Path, Ray, SurfacePoint};
use crate::shared::{hash, mixture, octahedral, sampling};
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Packs the paths that go on, in order, and draws each a ray over the cosine lobe of the surface where it is, or to
    /// an emitter.
    pub stage ContinuePaths {
        wgsl: gibs_shaders::stages::CONTINUE_PATHS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read points: SurfacePoint,
            read paths: Path,
            read goes_on: u32,
            read scanned: u32,
            optional_read emitters: Emitter,
            write next_rays: Ray,
            write next_paths: Path,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let emitters = !p.emitters.is_empty();
    for i in group.range(p.batch.count) {
        if p.goes_on[i] == 0 {
            continue;
        }
        let (point, path) = (&p.points[i], &p.paths[i]);
        let first = hash::pcg(path.seed);
        let second = hash::pcg(first);
        let third = hash::pcg(second);
        let normal = octahedral::unpack(point.shading_normal);
        let uv = (hash::unit(first), hash::unit(second));
        let drawn = if emitters && hash::unit(third) < mixture::TO_EMITTERS {
            mixture::to_emitter(&p.emitters, point.position, normal, uv, second)
        } else {
            mixture::over_the_lobe(normal, uv, emitters)
        };
        let direction = drawn.direction;
        let geometric = octahedral::unpack(point.geometric_normal);
        let origin = sampling::start(point.position, geometric, point.offset, direction);
        let slot = p.scanned[i] as usize;
        p.next_rays.set(
            slot,
            Ray {
                origin,
                t_min: 0.0,
                direction,
                t_max: drawn.t_max,
            },
        );
        p.next_paths.set(
            slot,
            Path {
                seed: third,
                remaining: path.remaining - 1,
                cosine: drawn.cosine,
                density: drawn.density,
                ..*path
            },
        );
    }
}
