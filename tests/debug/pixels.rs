//! What views of pixels show.
use super::*;

/// Up to 1, where the channel of the picture ends, coverage is the weight that apply found, to the bit.
#[test]
fn coverage_is_the_weight_of_apply() {
    let mut renderer = rendered(DebugView::Coverage, 5);
    let irradiance: Vec<Vec4> = renderer.output("irradiance").expect("an output");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let values = values(&mut renderer);
    for ((value, e), point) in values.iter().zip(&irradiance).zip(&points) {
        let expected = if surface::is_surface(point) {
            e.w
        } else {
            -1.0
        };
        assert_eq!(value.min(1.0), expected);
    }
    assert!(values.iter().any(|v| *v > 1.0) && values.iter().any(|v| (0.0..1.0).contains(v)));
    let picture = renderer.picture().expect("a picture");
    assert_eq!(picture.scalar("debug.coverage").expect("a channel"), values);
}

#[test]
fn transform_ids_are_those_of_the_surfaces() {
    let mut renderer = rendered(DebugView::TransformId, 1);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    for (value, point) in values(&mut renderer).iter().zip(&points) {
        match surface::is_surface(point) {
            true => assert_eq!(*value, point.transform_id as f32),
            false => assert_eq!(*value, -1.0),
        }
    }
}

#[test]
fn cell_heat_is_the_length_of_the_cells_list() {
    let mut renderer = rendered(DebugView::CellHeat, 5);
    let shape: GridShape = buffer(&mut renderer, "grid")[0];
    let cells: Vec<UVec2> = buffer(&mut renderer, "grid_cells");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let values = values(&mut renderer);
    for (value, point) in values.iter().zip(&points) {
        if surface::is_surface(point) {
            let cell = grid::cell(point.position, &shape);
            assert_eq!(*value, cells[cell as usize].y as f32);
        }
    }
    assert!(values.iter().any(|v| *v > 1.0));
}

/// The part is the half-axis of the largest coordinate of the offset from the grid's centre, or the cube; and there is a
/// line exactly where the cell to the right or below is another one.
#[test]
fn parts_of_the_grid_follow_from_the_offset() {
    let mut settings = with_view(DebugView::Grid);
    settings.grid_half = 0.2;
    let mut renderer = renderer(cpu().as_ref(), "atrium", &settings);
    renderer.frame().expect("renders");
    let shape: GridShape = buffer(&mut renderer, "grid")[0];
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let pixels: Vec<DebugPixel> = renderer.output("debug").expect("a view");
    let mut met = [0; 7];
    for (pixel, point) in pixels.iter().zip(&points) {
        if !surface::is_surface(point) {
            assert_eq!(pixel.value, -1.0);
            continue;
        }
        let d = (point.position - shape.centre).to_array();
        let axis = (0..3).fold(0, |m, i| if d[i].abs() > d[m].abs() { i } else { m });
        let part = match d[axis].abs() < shape.half {
            true => 0,
            false => 1 + 2 * axis + usize::from(d[axis] < 0.0),
        };
        assert_eq!(pixel.value, part as f32);
        met[part] += 1;
    }
    assert!(
        met[0] > 100 && met.iter().filter(|n| **n > 100).count() > 2,
        "{met:?}"
    );
    // Shades without lines are at least what a headlight leaves, lines at most their own brightness.
    let width = SIZE[0] as usize;
    let cell = |i: usize| {
        let point = points.get(i).filter(|p| surface::is_surface(p))?;
        Some(grid::cell(point.position, &shape))
    };
    let mut lines = 0;
    for (i, pixel) in pixels.iter().enumerate() {
        let Some(own) = cell(i) else { continue };
        let right = (i % width + 1 < width).then(|| cell(i + 1)).flatten();
        let below = cell(i + width);
        let line = right.is_some_and(|c| c != own) || below.is_some_and(|c| c != own);
        assert_eq!(line, pixel.shade < 0.38, "pixel {i} has {}", pixel.shade);
        lines += usize::from(line);
    }
    assert!(lines > 100);
}

/// Each pixel shows, of all surfels that were there before the frame's births and that overlap its point, the one with
/// the nearest centre. Looked for among all of them, without the grid.
#[test]
fn discs_are_those_of_the_nearest_surfels() {
    let mut renderer = rendered(DebugView::Surfels, 5);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let shown: Vec<f32> = buffer(&mut renderer, "debug_surfels");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let mut met = 0;
    for (value, point) in values(&mut renderer).iter().zip(&points) {
        if !surface::is_surface(point) {
            continue;
        }
        let normal = octahedral::unpack(point.shading_normal);
        let overlapping = (0..poses.len()).filter(|&i| {
            let pose = &poses[i];
            let d = point.position - pose.position;
            shown[i] >= 0.0
                && d.length() <= pose.radius
                && lookup::falloff(d, pose) * lookup::alignment(normal, pose) > 0.0
        });
        let distance = |i: usize| (point.position - poses[i].position).length_squared();
        let nearest = overlapping.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        match nearest {
            None => assert_eq!(*value, -1.0),
            Some(i) => {
                assert_eq!(distance(*value as usize), distance(i));
                met += 1;
            }
        }
    }
    assert!(met > 2000, "{met} pixels show a surfel");
}
