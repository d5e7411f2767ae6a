//! What the surfels around a point say.
use super::declare::ROUNDED;
use super::inputs::Draw;
use super::surfels::depths;
use gibs_graph::glam::{UVec2, Vec3};
use gibs_passes::data::{Gathered, GridShape, SurfelLight, SurfelPose, SurfelSettings};
use gibs_passes::shared::depth::Depths;
use gibs_passes::shared::grid::{self, GridLayout};
use gibs_passes::shared::lists::{DROPPED, Surfels};
use gibs_passes::shared::lookup::{self, Place};
use gibs_passes::shared::{bounds, hash, mark, plane};
use gibs_passes::stages::grid_order::{bounds_of, is_before};

/// Surfels, a bumpy sheet of them; as many as there are depth functions.
const SURFELS: u32 = 64;

fn shape() -> GridShape {
    GridLayout::new(4, 4.0).at(Vec3::new(0.25, -0.5, 0.0), 1.0)
}
fn pose(i: u32) -> SurfelPose {
    let mut d = Draw::of(i);
    let position = Vec3::new(
        d.between(-2.0, 2.0),
        d.between(-2.0, 2.0),
        d.between(-0.1, 0.1),
    );
    let most = grid::cell_side(position, &shape()) * grid::RADIUS_SHARE;
    let plane = plane::pack((Vec3::Z + 0.3 * d.direction()).normalize());
    SurfelPose {
        position,
        radius: most * d.between(0.6, 1.0),
        normal: (Vec3::Z + 0.3 * d.direction()).normalize(),
        mark: mark::of(hash::pcg(i), plane, hash::pcg(i) >> 31 != 0),
    }
}
fn poses() -> Vec<SurfelPose> {
    (0..SURFELS).map(pose).collect()
}
/// Some have had no rays.
fn light() -> Vec<SurfelLight> {
    let light = |i: u32| {
        let mut d = Draw::of(i);
        let trust = d.unit();
        SurfelLight {
            irradiance: d.light(-4, 4),
            trust: if i.is_multiple_of(7) { 0.0 } else { trust },
        }
    };
    (0..SURFELS).map(light).collect()
}
/// The lists of all cells, and where they are; one that did not fit.
fn lists() -> (Vec<UVec2>, Vec<u32>) {
    let (shape, poses) = (shape(), poses());
    let layout = GridLayout {
        side: shape.side,
        slices: shape.slices,
    };
    let mut lists = vec![Vec::new(); layout.cells() as usize];
    for (id, pose) in (0..).zip(&poses) {
        grid::overlapped(pose, &shape, |cell| lists[cell as usize].push(id));
    }
    let (mut cells, mut entries) = (Vec::new(), Vec::new());
    for (cell, list) in (0..).zip(&mut lists) {
        list.sort_by(|&a, &b| is_before(&poses, b, a).cmp(&is_before(&poses, a, b)));
        cells.push(UVec2::new(entries.len() as u32, list.len() as u32));
        entries.extend_from_slice(list);
        let steps = bounds::steps_in(cell, &shape);
        entries.extend(
            list.iter()
                .map(|&id| bounds_of(&poses[id as usize], &shape, steps)),
        );
    }
    let dropped = cells.len() / 3;
    cells[dropped] = DROPPED;
    (cells, entries)
}

/// A point on the sheet or near it, and a normal that looks its way or any other.
fn at(d: &mut Draw) -> (Vec3, Vec3) {
    let near = Vec3::new(
        d.between(-2.0, 2.0),
        d.between(-2.0, 2.0),
        d.between(-0.1, 0.1),
    );
    let pose = pose(d.below(SURFELS));
    let beside = pose.position + 1e-3 * d.direction();
    let centre = d.one_of(&[pose.position, beside]);
    let alike = (Vec3::Z + 0.3 * d.direction()).normalize();
    let any = d.direction();
    (
        d.one_of(&[near, near, near, centre]),
        d.one_of(&[alike, alike, alike, any]),
    )
}

/// The settings matter in how many surfels a lookup visits.
fn visiting(lookup: u32) -> SurfelSettings {
    SurfelSettings {
        lookup,
        depth_side: 4,
        ..SurfelSettings::default()
    }
}

// Grid and settings are uniforms of the stages; here the case has them.
twin! {
    lookup_gather ["gather::lookup_gather", "gather::gather_openness", "gather::gather_share"],
    (point: Vec3, normal: Vec3, enough: f32, averaged: u32, beyond: Vec3, shape: GridShape, visits: u32) -> Gathered,
    wgsl "grid = shape; settings.lookup = visits; settings.depth_side = 4u; return lookup_gather(point, normal, enough, averaged != 0u, beyond);",
    rust {
        let settings = super::visiting(visits);
        let s = Surfels { cells, entries, poses, depths: Depths::new(depths, settings.depth_side), grid: &shape, settings: &settings };
        let place = Place { position: point, normal, list: s.around(point) };
        lookup::gather(&place, enough, (averaged != 0).then_some(beyond), &s, light)
    },
    draw |d| {
        let (point, normal) = super::at(d);
        let enough = d.one_of(&[2.0, f32::MAX, 0.5]);
        (point, normal, enough, d.flag(), d.light(-4, 4), super::shape(), d.one_of(&[4, 64]))
    },
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> grid: GridShape;
        var<private> settings: SurfelSettings;",
    features ["depths"],
    globals {
        cells: UVec2 = super::lists().0,
        entries: u32 = super::lists().1,
        poses: SurfelPose = super::poses(),
        light: SurfelLight = super::light(),
        depths: u32 = super::depths(),
    },
}
twin! {
    lookup_coverage ["coverage::lookup_coverage", "coverage::coverage_share"],
    (point: Vec3, normal: Vec3, shape: GridShape, visits: u32) -> [f32; 2],
    wgsl "grid = shape; settings.lookup = visits; settings.depth_side = 4u; seen = 0u;
        let covered = lookup_coverage(point, normal);
        return array<f32, 2>(covered, f32(seen));",
    rust {
        let settings = super::visiting(visits);
        let s = Surfels { cells, entries, poses, depths: Depths::new(depths, settings.depth_side), grid: &shape, settings: &settings };
        let place = Place { position: point, normal, list: s.around(point) };
        let mut seen = 0;
        let covered = lookup::coverage(&place, &s, |id| seen += id as u32 + 1);
        [covered, seen as f32]
    },
    draw |d| { let (point, normal) = super::at(d); (point, normal, super::shape(), d.one_of(&[4, 64])) },
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> grid: GridShape;
        var<private> settings: SurfelSettings;
        var<private> seen: u32;
        fn coverage_seen(id: u32) { seen += id + 1u; }",
    features ["depths"],
    globals {
        cells: UVec2 = super::lists().0,
        entries: u32 = super::lists().1,
        poses: SurfelPose = super::poses(),
        depths: u32 = super::depths(),
    },
}

twins!(lookup_gather, lookup_coverage);
