//! `persistent/update_guide`: what the rays of its neighbours brought, into a surfel's guide (I6).
use crate::data::{Frame, GridShape, Path, Ray, SurfelPose, SurfelSettings};
use crate::shared::guide::{self, Guide};
use crate::shared::{estimator, grid, hash, mark, requests, sampling};
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec3, Vec4};
use std::f32::consts::PI;

stage! {
    /// Feeds the luminance that came along rays of surfels nearby to the moving averages of their texels, and renormalizes
    /// the guide (GIBS, "Ray Guiding"). The surfels are those of the cell whose normals are about the same; each frame
    /// begins elsewhere in its list. A path's light counts as far as the lobe is there to find it: what emitter sampling
    /// finds as well counts by the lobe's share of the balance heuristic, and rays to emitters teach nothing.
    pub stage UpdateGuide {
        wgsl: gibs_shaders::stages::UPDATE_GUIDE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            read spans: UVec2,
            read rays: Ray,
            read paths: Path,
            read radiance: Vec4,
            read_write guides: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let side = p.settings.guide_side;
    let words = guide::words(side);
    for i in group.range(p.poses.len() as u32) {
        let pose = &p.poses[i];
        if pose.radius <= 0.0 {
            continue;
        }
        let cell = p.cells[grid::cell(pose.position, p.grid) as usize];
        let identity = mark::identity(pose.mark);
        let mut old = [0; guide::MOST_WORDS];
        for (word, slot) in old[..words].iter_mut().enumerate() {
            *slot = p.guides.get(i * words + word);
        }
        let old = Guide::new(&old[..words], side);
        let mut lesson = Lesson::new(old, identity);
        let seed = hash::hash3(identity, p.frame.number, p.frame.seed);
        let mut taught = 0;
        for k in 0..cell.y.min(guide::CANDIDATES) {
            let entry = cell.x + (hash::pcg(seed) % cell.y + k) % cell.y;
            let other = p.entries[entry as usize] as usize;
            let (first, last) = requests::range(p.spans[other]);
            let last = last.min(first + guide::RAYS_OF_NEIGHBOUR);
            let alike = p.poses[other].normal.dot(pose.normal) > guide::ALIKE;
            if other == i || first == last || !alike {
                continue;
            }
            for ray in first as usize..last as usize {
                let path = &p.paths[ray];
                let local = sampling::to_local(p.rays[ray].direction, pose.normal);
                if path.density <= 0.0 || path.cosine <= 0.0 || local.z <= 0.0 {
                    continue;
                }
                let brought = estimator::luminance(p.radiance[ray].truncate());
                lesson.learn(local, brought * (PI * path.density / path.cosine));
            }
            taught += 1;
            if taught == guide::NEIGHBOURS {
                break;
            }
        }
        if lesson.count > 0 {
            let dither = |t| hash::unit(hash::hash2(seed, t));
            let new = lesson.finish(identity, dither);
            for (word, value) in new[..words].iter().enumerate() {
                p.guides.set(i * words + word, *value);
            }
        }
    }
}

/// A guide that learns.
struct Lesson<'a> {
    old: Guide<'a>,
    total: f32,
    share: f32,
    /// Rays that the guide knows already.
    known: u32,
    /// Rays of this frame, and the sum of their squared luminances.
    count: u32,
    sum: f32,
    /// Mean squares of luminance.
    squares: [f32; guide::MOST_TEXELS],
}

impl<'a> Lesson<'a> {
    fn new(old: Guide<'a>, identity: u32) -> Self {
        let known = old.rays(identity);
        // That of the surfel which had the slot before says nothing.
        let (total, squares) = match known {
            0 => (0.0, [0.0; guide::MOST_TEXELS]),
            _ => (old.total(), old.unpack().map(|x| x * x)),
        };
        Self {
            total,
            share: old.share(identity, total),
            known,
            count: 0,
            sum: 0.0,
            squares,
            old,
        }
    }

    fn learn(&mut self, local: Vec3, luminance: f32) {
        let luminance = luminance.min(guide::MOST_LUMINANCE);
        let square = luminance * luminance;
        let texel = self.old.texel_of(local);
        // Of rays that a texel can expect to have had, and not of those that it had, which nobody counts.
        let chance = self.old.probability(self.total, self.share, texel);
        let before = (self.known + self.count) as f32 * chance;
        let blend = (1.0 / (2.0 + before)).max(guide::BLEND);
        let mean = &mut self.squares[texel as usize];
        *mean += (square - *mean) * blend;
        self.sum += square;
        self.count += 1;
    }

    fn finish(mut self, identity: u32, dither: impl Fn(u32) -> f32) -> [u32; guide::MOST_WORDS] {
        let rays = self.known + self.count;
        let texels = self.old.texels() as usize;
        if self.known < guide::PRIOR_RAYS {
            let mean = self.sum / self.count as f32;
            let share = self.count as f32 / rays as f32;
            for square in &mut self.squares[..texels] {
                *square += (mean - *square) * share;
            }
        }
        let luminances = self.squares.map(|x| x.max(0.0).sqrt());
        guide::pack(&luminances[..texels], identity, rays, dither)
    }
}
