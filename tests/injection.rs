//! The grid's lists after injection are those that the host builds from the surfels that live then.
mod common;

use common::{all_backends, settings};
use gibs::passes::data::{GridShape, SurfelPose};
use gibs::passes::frame::Settings;
use gibs::passes::scene::Camera;
use gibs::passes::shared::lists::DROPPED;
use gibs::passes::shared::{bounds, grid, hash, mark};
use gibs::{Counters, Renderer, builtin};
use glam::UVec2;
use std::collections::BTreeMap;

/// A transient or state of the frame, as it was left. With `queries`, what a lookup reads outlives the frame.
fn left<T: bytemuck::Pod>(renderer: &mut Renderer, key: &str) -> Vec<T> {
    let exec = renderer.executable();
    let resource = exec.schedule().resource(key).expect("a resource");
    bytemuck::pod_collect_to_vec(&exec.read(resource).expect("read"))
}

/// Holds every list against the surfels; gives how many were dropped.
fn check(renderer: &mut Renderer, place: &str) -> usize {
    let shape: GridShape = left(renderer, "grid")[0];
    let poses: Vec<SurfelPose> = left(renderer, "surfel_poses");
    let cells: Vec<UVec2> = left(renderer, "grid_cells");
    let entries: Vec<u32> = left(renderer, "grid_entries");
    let mut expected: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for (id, pose) in (0..).zip(&poses).filter(|(_, pose)| pose.radius > 0.0) {
        grid::overlapped(pose, &shape, |cell| {
            let list = expected.entry(cell).or_default();
            list.push((hash::pcg(mark::identity(pose.mark)), id));
        });
    }
    let (mut dropped, mut taken) = (0, Vec::new());
    for (cell, list) in (0..).zip(&cells) {
        let mut ids = expected.remove(&cell).unwrap_or_default();
        if *list == DROPPED {
            // Behind the last that fits there is no room for an empty one either.
            dropped += 1;
            continue;
        }
        ids.sort_unstable();
        let (first, count) = (list.x as usize, list.y as usize);
        let listed = &entries[first..first + 2 * count];
        let steps = bounds::steps_in(cell, &shape);
        let bounds = |&(_, id): &(u32, u32)| {
            let pose = &poses[id as usize];
            bounds::pack(pose.position - shape.centre, pose.radius, steps)
        };
        let whole: Vec<u32> = ids
            .iter()
            .map(|&(_, id)| id)
            .chain(ids.iter().map(bounds))
            .collect();
        assert_eq!(
            listed, whole,
            "{place}, cell {cell}: surfels, then their bounds"
        );
        taken.push(first..first + 2 * count);
    }
    assert!(expected.is_empty(), "{place}: cells beyond the grid");
    assert!(dropped < cells.len(), "{place}: no list is left");
    // Lists that new surfels joined are in the second half, one behind the other; they have left holes in the first.
    let half = entries.len() / 2;
    taken.retain(|range| !range.is_empty());
    taken.sort_by_key(|range| range.start);
    for pair in taken.windows(2) {
        assert!(pair[0].end <= pair[1].start, "{place}: lists overlap");
        if dropped == 0 && pair[0].start >= half {
            assert_eq!(pair[0].end, pair[1].start, "{place}: a hole");
        }
    }
    // What was dropped had no room behind the last that fits of its half: most of that is used by then, since no cell here has as
    // many surfels as a quarter of the buffer holds. Lists that were carried have not become shorter.
    let used: usize = taken.iter().map(std::ops::Range::len).sum();
    assert!(
        dropped == 0 || 2 * used > half,
        "{place}: {used} words, of {half} for lists as built, and lists were dropped"
    );
    dropped
}

/// Flies through the atrium with few slots, so that many surfels go and are born in each frame.
fn fly(settings: &Settings) -> Vec<(Counters, usize)> {
    let (scene, view) = builtin::by_name("atrium").expect("built in");
    let mut ends = Vec::new();
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [96, 54], settings, 0)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let [_, _, forward] = view.camera.axes();
        let mut dropped = 0;
        for frame in 0..30 {
            let along = forward * (0.1 * f64::from(frame));
            renderer.set_camera(Camera {
                position: view.camera.position + along,
                target: view.camera.target + along,
                ..view.camera
            });
            renderer.frame().expect("a frame");
            dropped += check(&mut renderer, &format!("{name}, frame {frame}"));
        }
        ends.push((renderer.counters().expect("counters"), dropped));
    }
    ends
}

#[test]
fn lists_are_those_of_the_surfels_that_live() {
    let settings = Settings {
        surfels: 1024,
        queries: 1,
        grid_lists: 64,
        ..settings(2000)
    };
    for (end, dropped) in fly(&settings) {
        assert!(end.recycled > 100 && end.born > end.recycled, "{end:?}");
        assert_eq!((dropped, end.overflow), (0, 0), "{end:?}");
    }
}

/// A list that does not fit is none, and the others are whole.
#[test]
fn lists_that_fit_are_whole_where_others_do_not() {
    let settings = Settings {
        surfels: 1024,
        queries: 1,
        grid_lists: 2,
        ..settings(2000)
    };
    for (end, dropped) in fly(&settings) {
        assert!(dropped > 0 && end.overflow > 0, "{end:?}");
    }
}
