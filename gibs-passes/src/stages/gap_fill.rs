//! `spawn/gap_fill`: the least covered texel of each tile (S2).
use super::positional_update::radius_at;
use crate::data::{Camera, Frame, GridShape, NONE, SurfacePoint, SurfelPose, SurfelSettings};
use crate::shared::depth::Depths;
use crate::shared::lists::{Surfels, is_crowded, is_full};
use crate::shared::lookup::{self, AT_A_TIME, Points};
use crate::shared::{hash, surface, upsample};
use crate::simd;
use gibs_graph::{AtomicView, Workgroup, stage};
use glam::UVec2;

stage! {
    /// Finds the texel with the least surfel coverage in each tile; ties are broken by a hash. Where that coverage
    /// passes a randomized threshold, the texel is where a surfel will be born (GIBS, "Surfelization of the Scene"). Beside
    /// surfels that walls keep small, every quarter of the tile that has a hole gets one.
    /// Coverage is the summed weight of apply. Surfels that cover a pixel are seen: `unseen`, the frames since that, starts
    /// over. A workgroup has one tile of 16x16 texels, or several smaller ones. Where a texel is more than a pixel, one of
    /// its pixels stands for it, another each frame; but where that is not amply covered all of them are looked at, so that
    /// the least covered one does not wait for its turn while the camera moves on. A cell that is full gets none: where one that
    /// is crowded has a hole, and the quarter of the tile gets no surfel elsewhere, the candidate is [`CROWDED`].
    pub stage GapFill {
        wgsl: gibs_shaders::stages::GAP_FILL,
        workgroup: [16, 16, 1],
        ports: {
            uniform camera: Camera,
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            optional_read depths: u32,
            atomic unseen: u32,
            write candidates: u32,
            write flags: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

/// In place of a pixel: a hole in a crowded cell, in which no surfel may be born.
pub const CROWDED: u32 = NONE - 1;

/// Side of a workgroup, texels: that of the largest tile.
pub const GROUP: u32 = 16;

/// Side of the smallest tile, texels.
pub const LEAST_TILE: u32 = 2;

/// Coverage, over that at which spawning stops, below which a birth is certain: where the average of the cell would make
/// up more of a pixel's light than its surfels.
pub const HOLE: f32 = 0.5;

/// Coverage, over that at which spawning stops, below which a texel may have a gap at another pixel: coverage falls from
/// here to a hole within a quarter of a radius.
pub const AMPLE: f32 = 2.0;

/// Radius of surfels, over what it would be in the open, beside which a tile's other quarters get one as well: one alone would
/// not fill them.
pub const FINE: f32 = 0.5;

/// Quarters of the tiles in a workgroup, at most.
const MOST_PARTS: usize = (2 * GROUP / LEAST_TILE).pow(2) as usize;

const SIDE: usize = GROUP as usize;

const _: () = assert!(SIDE == AT_A_TIME);

fn kernel(p: &Views<'_>, group: Workgroup) {
    fill(p, group, |points, surfels, unseen| {
        lookup::coverages(points, surfels, |id| see(unseen, id))
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    fill(p, group, |points, surfels, unseen| {
        wide.coverages(points, surfels, |id| see(unseen, id))
    });
}

/// A pixel sees a surfel. Nothing is stored where that was known, so that threads do not fight for the memory.
#[inline(always)]
fn see(unseen: AtomicView<'_>, id: usize) {
    if unseen.load(id) != 0 {
        unseen.store(id, 0);
    }
}

#[inline(always)]
fn fill(
    p: &Views<'_>,
    group: Workgroup,
    coverages: impl Fn(&Points<'_>, &Surfels<'_>, AtomicView<'_>) -> [f32; AT_A_TIME],
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let (stride, number) = (p.settings.stride, p.frame.number);
    let size = UVec2::new(p.camera.width, p.camera.height);
    // As many quarters of tiles as there is room for: two, four, eight or sixteen along each side.
    let across = (p.candidates.len() as u32 / (group.count[0] * group.count[1])).isqrt();
    let side = GROUP / across;
    let first = group.linear() * across * across;
    let mut least = [NONE; MOST_PARTS];
    let mut crowded = [false; MOST_PARTS];
    let frame = hash::hash2(number, p.frame.seed);
    let within = |lane: u32| lane / GROUP / side * across + lane % GROUP / side;
    let texel = |lane: u32| {
        UVec2::new(group.id[0], group.id[1]) * GROUP + UVec2::new(lane % GROUP, lane / GROUP)
    };
    // Which of a texel's pixels stands for it: the first of this frame, or one of the others.
    let pixel = |lane: u32, turn: u32| {
        upsample::pixel_of(texel(lane), stride, number.wrapping_add(turn), size)
    };
    // The pixel's index and point, where there is one and it shows a surface.
    let seen = |lane: u32, turn: u32| {
        if (texel(lane) * stride).cmpge(size).any() {
            return None;
        }
        let at = pixel(lane, turn);
        let point = &p.points[(at.y * size.x + at.x) as usize];
        surface::is_surface(point).then_some(point)
    };
    // Looks at pixels of texels, and calls `thin` with the texels that have none there or one that is not covered amply.
    let mut look = |places: &[(u32, u32)], thin: &mut dyn FnMut(u32)| {
        let mut points = [None; AT_A_TIME];
        for (point, &(lane, turn)) in points.iter_mut().zip(places) {
            *point = seen(lane, turn);
        }
        let coverages = coverages(&points, &surfels, p.unseen);
        for ((&(lane, turn), point), coverage) in places.iter().zip(points).zip(coverages) {
            let share = (coverage / (AMPLE * p.settings.coverage)).min(1.0);
            if point.is_none() || share < 1.0 {
                thin(lane);
            }
            let Some(point) = point else { continue };
            // What is covered amply bears none.
            if share == 1.0 {
                continue;
            }
            let place = turn << 8 | lane;
            let tie = hash::hash3(first + within(lane), frame, place) & 0x3f;
            let candidate = (((share * 65_534.0) as u32) << 16) | (tie << 10) | place;
            let cell = || surfels.cell(point.position);
            if is_hole(share) && is_crowded(cell(), p.settings) {
                crowded[within(lane) as usize] = true;
            }
            let least = &mut least[within(lane) as usize];
            if candidate < *least && !is_full(cell(), p.settings) {
                *least = candidate;
            }
        }
    };
    // At most 15 are left when a row adds the three other pixels of each of its texels: a texel is one pixel wide, or two.
    let mut waiting = [(0, 0); 4 * AT_A_TIME];
    let mut count = 0;
    for row in 0..GROUP {
        let lanes: [_; SIDE] = std::array::from_fn(|column| (row * GROUP + column as u32, 0));
        look(&lanes, &mut |lane| {
            for turn in 1..stride * stride {
                waiting[count] = (lane, turn);
                count += 1;
            }
        });
        while count >= AT_A_TIME {
            count -= AT_A_TIME;
            look(&waiting[count..count + AT_A_TIME], &mut |_| {});
        }
    }
    if count > 0 {
        look(&waiting[..count], &mut |_| {});
    }
    // Where one of the candidates is, a pixel.
    let at = |candidate: u32| {
        let at = pixel(candidate & 0xff, (candidate >> 8) & 3);
        at.y * size.x + at.x
    };
    let share = |candidate: u32| (candidate >> 16) as f32 * (AMPLE / 65_534.0);
    for part in 0..across * across {
        let (x, y) = ((part % across) & !1, (part / across) & !1);
        let corner = y * across + x;
        let quarters = [corner, corner + 1, corner + across, corner + across + 1];
        let chosen = quarters.map(|part| least[part as usize]).into_iter().min();
        let (chosen, own) = (chosen.unwrap_or(NONE), least[part as usize]);
        let is_wanted = if own == NONE {
            false
        } else if own == chosen {
            let random = hash::unit(hash::hash3(number, first + corner, p.frame.seed));
            random * (1.0 - HOLE) < 1.0 - share(own)
        } else {
            share(own) < HOLE && is_fine(p, &surfels, &p.points[at(chosen) as usize])
        };
        let candidate = match (is_wanted, crowded[part as usize]) {
            (true, _) => at(own),
            (false, true) => CROWDED,
            (false, false) => NONE,
        };
        let part = (first + part) as usize;
        p.candidates.set(part, candidate);
        p.flags.set(part, u32::from(is_wanted));
    }
}

/// A coverage, over what is ample, at which a birth is certain.
#[inline]
fn is_hole(share: f32) -> bool {
    share * AMPLE < HOLE
}

/// Whether a surfel within reach of a point, as far as it would be in the open, is smaller than that by [`FINE`].
fn is_fine(p: &Views<'_>, surfels: &Surfels<'_>, point: &SurfacePoint) -> bool {
    let open = radius_at(point.position, f32::MAX, p.camera, p.grid, p.settings);
    let list = surfels.around(point.position);
    list.ids.iter().any(|&id| {
        let pose = &p.poses[id as usize];
        let d = pose.position - point.position;
        pose.radius < FINE * open && d.dot(d) < open * open
    })
}
