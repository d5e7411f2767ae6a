//! Where things are: the grid, bounds in its lists, bins of rays, sizes of surfels, the order of lists.
use super::declare::{EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::Vec3;
use gibs_passes::data::{Camera, GridShape, SurfelPose, SurfelSettings};
use gibs_passes::shared::grid::{self, GridLayout};
use gibs_passes::shared::{bounds, hash, mark, sorting};
use gibs_passes::stages::grid_order;
use gibs_passes::stages::positional_update::radius_at;

/// A grid as frames have it, or one of a single cell.
pub fn shape(d: &mut Draw) -> GridShape {
    let side = d.one_of(&[1, 2, 8, 16, 32, 33]);
    let reach = d.magnitude(1, 12);
    let half = d.magnitude(-2, 6);
    GridLayout::new(side, reach).at(d.vector(-6, 10), half)
}

/// A place in or about a grid: within the cube, on its faces and edges, far out, on the axes.
pub fn place(d: &mut Draw, shape: &GridShape) -> Vec3 {
    let part = |d: &mut Draw| match d.below(4) {
        0 => d.around(shape.half),
        1 => d.signed(-10, 20),
        _ => d.between(-1.0, 1.0) * shape.half,
    };
    let v = Vec3::new(part(d), part(d), part(d));
    let to = match d.below(5) {
        0 => v.abs().max_element() * d.direction().signum(),
        1 => d.direction() * d.magnitude(-10, 20),
        _ => v,
    };
    shape.centre + to
}

/// A surfel about a place, as large as the grid allows at most.
pub fn pose(d: &mut Draw, shape: &GridShape) -> SurfelPose {
    let position = place(d, shape);
    let most = grid::cell_side(position, shape) * grid::RADIUS_SHARE;
    SurfelPose {
        position,
        radius: most * d.one_of(&[1.0, 0.5, 1e-4]) * d.between(0.5, 1.0),
        normal: d.direction(),
        mark: d.word(),
    }
}

twin! {
    cell ["grid::grid_cell"], (position: Vec3, shape: GridShape) -> u32,
    wgsl "grid_cell(position, shape)",
    rust grid::cell(position, &shape),
    draw |d| { let g = super::shape(d); (super::place(d, &g), g) },
    bound ROUNDED,
}
twin! {
    cell_side ["grid::grid_cell_side"], (position: Vec3, shape: GridShape) -> f32,
    wgsl "grid_cell_side(position, shape)",
    rust grid::cell_side(position, &shape),
    draw |d| { let g = super::shape(d); (super::place(d, &g), g) },
    bound ROUNDED,
}
twin! {
    extents ["grid::grid_extents"], (pose: SurfelPose) -> Vec3,
    wgsl "grid_extents(pose)",
    rust grid::extents(&pose),
    draw |d| { let g = super::shape(d); (super::pose(d, &g),) },
    bound ROUNDED,
}
twin! {
    span ["grid::grid_span"], (position: Vec3, reach: Vec3, shape: GridShape, part: u32) -> [u32; 8],
    wgsl "let s = grid_span(position, reach, shape, part);
        return array<u32, 8>(u32(s.found), s.base, s.low.x, s.low.y, s.low.z, s.high.x, s.high.y, s.high.z);",
    rust match grid::span(position, reach, &shape, part) {
        Some(s) => {
            let ([a, b, c], [x, y, z]) = (s.low, s.high);
            [1, s.base, a, b, c, x, y, z]
        }
        None => [0; 8],
    },
    draw |d| {
        let g = super::shape(d);
        let p = super::pose(d, &g);
        let part = d.below(grid::PARTS);
        if d.once_in(8) {
            // Boxes that touch the cube's faces, and those of half-axes, to the bit.
            let g = GridShape { centre: Vec3::ZERO, half: 2.0, ..g };
            let mut at = || d.one_of(&[-2.5, -2.0, -1.5, 0.0, 1.5, 2.0, 2.5, 3.0]);
            return (Vec3::new(at(), at(), at()), Vec3::splat(0.5), g, part);
        }
        (p.position, grid::extents(&p), g, part)
    },
    bound ROUNDED,
}

twin! {
    steps_in ["bounds::bounds_steps_in"], (cell: u32, shape: GridShape) -> f32,
    wgsl "bounds_steps_in(cell, shape)",
    rust bounds::steps_in(cell, &shape),
    draw |d| {
        let g = super::shape(d);
        let cube = g.side * g.side * g.side;
        let slice = g.side * g.side;
        let cells = cube + 6 * g.slices * slice;
        let any = d.below(cells);
        (d.one_of(&[0, cube - 1, cube.min(cells - 1), cells - 1, any, any]), g)
    },
    bound ROUNDED,
}
twin! {
    bounds_place ["bounds::bounds_place"], (from_centre: Vec3, steps: f32) -> u32,
    wgsl "bounds_place(from_centre, steps)",
    rust bounds::place(from_centre, steps),
    draw |d| {
        let whole = |d: &mut Draw| {
            let whole = d.below(4096) as f32 - 2048.0;
            d.one_of(&[whole, whole.next_up(), whole.next_down()])
        };
        let near = Vec3::new(whole(d), whole(d), whole(d));
        let any = d.vector(-20, 20);
        (d.one_of(&[near, any]), d.one_of(&[1.0, 128.0, 0.37]))
    },
    bound ROUNDED,
}
twin! {
    bounds_pack ["bounds::bounds_pack"], (from_centre: Vec3, radius: f32, steps: f32) -> u32,
    wgsl "bounds_pack(from_centre, radius, steps)",
    rust bounds::pack(from_centre, radius, steps),
    draw |d| {
        let steps = d.magnitude(-6, 10);
        let far = Vec3::new(d.around(262_144.0 / steps), 0.0, 1.0);
        let near = d.vector(-20, 12);
        let pairs = 2.0 * d.below(32) as f32;
        let radius = d.around(pairs / steps).abs();
        (d.one_of(&[near, near, far]), radius, steps)
    },
    bound ROUNDED,
}
twin! {
    may_reach ["bounds::bounds_may_reach"], (of_surfel: u32, place: u32, reach: u32) -> u32,
    wgsl "u32(bounds_may_reach(of_surfel, place, reach))",
    rust u32::from(bounds::may_reach(of_surfel, place, reach)),
    // Within a few steps of each other along each axis, or anywhere.
    draw |d| {
        let place = d.bits() & 0x07ff_ffff;
        let near = |d: &mut Draw, at: u32| {
            let step = (place >> at & 0x1ff) + d.below(64) + 512 - 32;
            (step & 0x1ff) << at
        };
        let at = near(d, 0) | near(d, 9) | near(d, 18);
        let radius = d.one_of(&[0, 1, 2, 5, 12, 30, 31]) << 27;
        let any = d.bits();
        (d.one_of(&[at | radius, at | radius, any]), place, d.one_of(&[1, 2]))
    },
    bound EXACT,
}

twin! {
    sorting_place ["sorting::sorting_place"], (position: Vec3, shape: GridShape) -> u32,
    wgsl "sorting_place(position, shape)",
    rust sorting::place(position, &shape),
    draw |d| { let g = super::shape(d); (super::place(d, &g), g) },
    bound ROUNDED,
}
twin! {
    sorting_bin ["sorting::sorting_bin"], (place: u32, direction: Vec3) -> u32,
    wgsl "sorting_bin(place, direction)",
    rust sorting::bin(place, direction),
    draw |d| (d.below(8192) << 4, d.direction()),
    bound ROUNDED,
}

twin! {
    radius ["surfel::surfel_radius_at"],
    (position: Vec3, clearance: f32, camera: Camera, shape: GridShape, settings: SurfelSettings) -> f32,
    wgsl "surfel_radius_at(position, clearance, camera, shape, settings)",
    rust radius_at(position, clearance, &camera, &shape, &settings),
    draw |d| {
        let g = super::shape(d);
        let eye = d.one_of(&[g.centre, Vec3::ZERO]);
        let camera = Camera { eye, pixel_angle: d.magnitude(-12, -6), ..Camera::default() };
        let settings = SurfelSettings { radius_pixels: d.between(1.0, 32.0), ..SurfelSettings::default() };
        let place = super::place(d, &g);
        (d.one_of(&[place, place, eye]), d.number(-10, 10).abs(), camera, g, settings)
    },
    bound ROUNDED,
}

/// Surfels of which some have equal identities, so that the slots decide.
fn poses() -> Vec<SurfelPose> {
    let identity = |i| hash::pcg(i) & 0xff;
    (0..512)
        .map(|i| SurfelPose {
            mark: mark::of(identity(i), i, i % 3 == 0),
            ..SurfelPose::default()
        })
        .collect()
}
twin! {
    is_before ["list_order::list_is_before", "list_order::list_key"], (id: u32, other: u32) -> u32,
    wgsl "u32(list_is_before(list_key(id), id, other))",
    rust u32::from(grid_order::is_before(poses, id, other)),
    draw |d| { let id = d.below(512); let other = d.below(512); (id, d.one_of(&[id, other, other, other])) },
    bound EXACT,
    text "var<private> entries: array<u32, 40>;",
    globals { poses: SurfelPose = super::poses() },
}
twin! {
    list_sort ["list_order::list_sort"], (list: [u32; 40], count: u32) -> [u32; 40],
    wgsl "entries = list; list_sort(1u, count); return entries;",
    rust {
        let mut sorted = list;
        let key = |id: &u32| (hash::pcg(mark::identity(poses[*id as usize].mark)), *id);
        sorted[1..1 + count as usize].sort_by_key(key);
        sorted
    },
    draw |d| (std::array::from_fn(|_| d.below(512)), d.below(40)),
    bound EXACT,
    text "var<private> entries: array<u32, 40>;",
    globals { poses: SurfelPose = super::poses() },
    cases 4096,
}

twins!(
    cell,
    cell_side,
    extents,
    span,
    steps_in,
    bounds_place,
    bounds_pack,
    may_reach,
    sorting_place,
    sorting_bin,
    radius,
    is_before,
    list_sort,
);
