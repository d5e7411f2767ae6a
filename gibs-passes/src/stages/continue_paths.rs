//! `persistent/continue_paths`: the next segment of each path that goes on.
use super::count_paths::PATHS_PER_WORD;
use crate::data::{Emitter, Path, Ray, SurfacePoint};
use crate::shared::{hash, mixture, octahedral, sampling};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use std::ops::Range;

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
            read before: u32,
            optional_read emitters: Emitter,
            write next_rays: Ray,
            write next_paths: Path,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    simd::continue_paths(&paths(p), group.range(p.batch.count), setter(p));
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    continue_each(&paths(p), group.range(p.batch.count), setter(p));
}

fn setter(p: &Views<'_>) -> impl FnMut(usize, Ray, Path) {
    move |slot, ray, path| {
        p.next_rays.set(slot, ray);
        p.next_paths.set(slot, path);
    }
}

fn paths<'a>(p: &Views<'a>) -> Paths<'a> {
    Paths {
        points: p.points.slice(),
        paths: p.paths.slice(),
        goes_on: p.goes_on.slice(),
        before: p.before.slice(),
        emitters: p.emitters.slice(),
    }
}

/// Paths of which some go on.
#[derive(Clone, Copy)]
pub struct Paths<'a> {
    /// Where they are.
    pub points: &'a [SurfacePoint],
    /// The paths.
    pub paths: &'a [Path],
    /// A bit for each path, set for those that go on.
    pub goes_on: &'a [u32],
    /// How many do before those of each word.
    pub before: &'a [u32],
    /// Emissive triangles; empty in a frame without.
    pub emitters: &'a [Emitter],
}

impl Paths<'_> {
    /// Place of a path among those that go on; `None` for one that does not.
    #[inline]
    pub fn place(&self, path: usize) -> Option<usize> {
        let (word, bit) = (path / PATHS_PER_WORD as usize, path as u32 % PATHS_PER_WORD);
        let bits = self.goes_on[word];
        let before = (bits & ((1 << bit) - 1)).count_ones();
        (bits >> bit & 1 != 0).then(|| (self.before[word] + before) as usize)
    }
}

/// Calls `set` with the place, the next ray and the next state of each path of a range that goes on.
#[inline]
pub fn continue_each(p: &Paths<'_>, range: Range<usize>, mut set: impl FnMut(usize, Ray, Path)) {
    let emitters = !p.emitters.is_empty();
    for (i, place) in range.filter_map(|i| Some((i, p.place(i)?))) {
        let (point, path) = (&p.points[i], &p.paths[i]);
        let first = hash::pcg(path.seed);
        let second = hash::pcg(first);
        let third = hash::pcg(second);
        let normal = octahedral::unpack(point.shading_normal);
        let uv = (hash::unit(first), hash::unit(second));
        let drawn = if emitters && hash::unit(third) < mixture::TO_EMITTERS {
            mixture::to_emitter(p.emitters, point.position, normal, uv, second)
        } else {
            mixture::over_the_lobe(normal, uv, emitters)
        };
        let direction = drawn.direction;
        let geometric = octahedral::unpack(point.geometric_normal);
        let ray = Ray {
            origin: sampling::start(point.position, geometric, point.offset, 0.0, direction),
            t_min: 0.0,
            direction,
            t_max: drawn.t_max,
        };
        let path = Path {
            seed: third,
            cosine: drawn.cosine,
            density: drawn.density,
            ..*path
        };
        set(place, ray, path);
    }
}
