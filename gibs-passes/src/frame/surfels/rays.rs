//! Rays from every surfel, and what they find (I1, I2, I5).
use super::sorting::sort_rays;
use super::spawn::Wanted;
use super::{Grid, Surfels, filtering};
use crate::data::*;
use crate::frame::trace::{Batch, direct_light, resolve, surfaces, trace};
use crate::frame::{SceneInputs, Settings};
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};
use glam::UVec2;

/// Rays from every surfel, light at their hits, and what comes back into irradiance and depth functions. Also gives
/// each surfel's first ray and how many it has.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn integrate_rays(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    device_settings: &Buffer<SurfelSettings>,
    mut surfels: Surfels,
    in_use: &Buffer<DispatchArgs>,
    settings: &Settings,
    per_point: u32,
) -> (Surfels, Buffer<UVec2>, Option<HitGaps>) {
    let capacity = surfels.poses.len();
    let budget = u64::from(settings.rays).max(1);
    let requests = g.zeroed("ray_requests", 2 * capacity);
    let inputs = request_rays::Inputs {
        frame: &scene.frame,
        settings: device_settings,
        poses: &surfels.poses,
        births: &surfels.births,
        irradiance: &surfels.irradiance,
        unseen: &surfels.unseen,
        neighbours: surfels.neighbours.as_ref(),
        requests,
    };
    let requests = g
        .add::<request_rays::RequestRays>(
            "persistent/request_rays",
            inputs,
            Dispatch::Indirect(in_use),
        )
        .requests;
    let (scanned, total) = exclusive_scan(g, "persistent/ray_scan", &requests);
    let spans = g.transient("ray_spans", capacity);
    let [batch, persistent, spawned] =
        ["ray_batch", "persistent_batch", "spawned_batch"].map(|name| g.transient(name, 1));
    let allocated = g.add::<allocate_rays::AllocateRays>(
        "persistent/allocate_rays",
        allocate_rays::Inputs {
            frame: &scene.frame,
            settings: device_settings,
            requests: &requests,
            scanned: &scanned,
            total: &total,
            spans,
            batch,
            persistent,
            spawned,
        },
        Dispatch::Indirect(in_use),
    );
    g.output("rays", &allocated.batch);
    let emitters = scene.emitters().filter(|_| settings.emitters);
    let rays = g.transient("surfel_rays", budget);
    let paths = g.transient("surfel_paths", budget);
    let generated = g.add::<generate_rays::GenerateRays>(
        "persistent/generate_rays",
        generate_rays::Inputs {
            frame: &scene.frame,
            settings: device_settings,
            poses: &surfels.poses,
            births: &surfels.births,
            irradiance: &surfels.irradiance,
            spans: &allocated.spans,
            emitters,
            guides: surfels.guides.as_ref(),
            rays,
            paths,
        },
        Dispatch::Indirect(in_use),
    );
    let own_rays = generated.rays;
    let mut radiance = g.zeroed("ray_radiance", budget);
    let parts = [
        ("persistent", &allocated.persistent),
        ("spawn", &allocated.spawned),
    ]
    .map(|(group, args)| (group, Batch::on_device(args, budget)));
    let (mut segment, own_paths, places) = match settings.sorting {
        true => {
            let (paths, spans) = (&generated.paths, &allocated.spans);
            let poses = &surfels.poses;
            let sorted = sort_rays(g, &parts, in_use, grid, poses, spans, &own_rays, paths);
            let segment = Segment {
                args: allocated.batch,
                rays: Some(sorted.rays),
                paths: sorted.paths,
            };
            (segment, Some(generated.paths), Some(sorted.places))
        }
        false => {
            let segment = Segment {
                args: allocated.batch,
                rays: None,
                paths: generated.paths,
            };
            (segment, None, None)
        }
    };
    let (mut first_hits, mut first_paths, mut hit_gaps) = (None, own_paths, None);
    for depth in 0..=settings.continuations {
        let suffix = if depth == 0 {
            String::new()
        } else {
            format!("_{depth}")
        };
        let batch = Batch::on_device(&segment.args, budget);
        let rays = segment.rays.as_ref().unwrap_or(&own_rays);
        let (hits, points) = match depth {
            0 => {
                let hits = g.transient("persistent_hits", budget);
                let hits = parts.iter().fold(hits, |hits, (group, batch)| {
                    trace(g, &format!("{group}/ray_trace"), scene, batch, rays, hits)
                });
                let points = resolve(g, "persistent", "", scene, &batch, rays, &hits);
                (hits, points)
            }
            _ => surfaces(g, "persistent", &suffix, scene, &batch, rays),
        };
        let direct = direct_light(g, "persistent", &suffix, scene, per_point, &batch, &points);
        let label = format!("persistent/gather_surfels{suffix}");
        let name = format!("persistent_gathered{suffix}");
        let gathered = g.transient(&name, budget);
        let inputs = gather_at_hits::Inputs {
            batch: &segment.args,
            grid: &grid.shape,
            settings: device_settings,
            points: &points,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            light: &surfels.light,
            depths: surfels.depths.as_ref(),
            paths: (depth == settings.continuations).then_some(&segment.paths),
            gathered,
        };
        let gathered = g
            .add::<gather_at_hits::GatherAtHits>(&label, inputs, batch.dispatch())
            .gathered;
        let gaps = (depth == 0 && settings.hit_births > 0).then(|| {
            let candidates = g.transient("hit_candidates", budget);
            let flags = g.transient("hit_flags", budget);
            let inputs = hit_gaps::Inputs {
                batch: &segment.args,
                frame: &scene.frame,
                grid: &grid.shape,
                settings: device_settings,
                points: &points,
                gathered: &gathered,
                cells: &grid.cells,
                candidates,
                flags,
            };
            let found =
                g.add::<hit_gaps::HitGaps>("spawn/hit_gaps", inputs, Dispatch::Elements(budget));
            Wanted {
                candidates: found.candidates,
                flags: found.flags,
            }
        });
        let goes_on = (depth < settings.continuations).then(|| {
            let words = budget.div_ceil(u64::from(count_paths::PATHS_PER_WORD));
            g.transient(&format!("goes_on{suffix}"), words)
        });
        let shaded = g.add::<shade_hits::ShadeHits>(
            &format!("persistent/shade_hits{suffix}"),
            shade_hits::Inputs {
                batch: &segment.args,
                frame: &scene.frame,
                rays,
                points: &points,
                direct: direct.as_ref(),
                gathered: &gathered,
                environment: scene.sky(),
                paths: segment.paths,
                radiance,
                goes_on,
            },
            batch.dispatch(),
        );
        radiance = shaded.radiance;
        first_hits.get_or_insert(hits);
        let next = shaded.goes_on.as_ref().map(|goes_on| {
            continue_segment(
                g,
                depth,
                &segment.args,
                &batch,
                &points,
                &shaded.paths,
                goes_on,
                emitters,
            )
        });
        first_paths.get_or_insert(shaded.paths);
        hit_gaps = hit_gaps.or(gaps.map(|wanted| HitGaps { wanted, points }));
        match next {
            Some(next) => segment = next,
            None => break,
        }
    }
    let guides = match (surfels.guides.take(), &first_paths) {
        (Some(guides), Some(paths)) => {
            let inputs = update_guide::Inputs {
                frame: &scene.frame,
                grid: &grid.shape,
                settings: device_settings,
                cells: &grid.cells,
                entries: &grid.entries,
                poses: &surfels.poses,
                spans: &allocated.spans,
                rays: &own_rays,
                paths,
                radiance: &radiance,
                guides,
            };
            let label = "persistent/update_guide";
            let updated =
                g.add::<update_guide::UpdateGuide>(label, inputs, Dispatch::Indirect(in_use));
            Some(updated.guides)
        }
        (guides, _) => guides,
    };
    let depths = match (surfels.depths.take(), &first_hits) {
        (Some(depths), Some(hits)) => {
            let inputs = update_depth::Inputs {
                settings: device_settings,
                poses: &surfels.poses,
                irradiance: &surfels.irradiance,
                spans: &allocated.spans,
                rays: &own_rays,
                hits,
                places: places.as_ref(),
                depths,
            };
            let label = "persistent/update_depth";
            let updated =
                g.add::<update_depth::UpdateDepth>(label, inputs, Dispatch::Indirect(in_use));
            Some(updated.depths)
        }
        (depths, _) => depths,
    };
    let surfels = Surfels {
        guides,
        depths,
        ..surfels
    };
    let surfels = filtering::filter(
        g,
        scene,
        grid,
        device_settings,
        surfels,
        in_use,
        settings,
        &allocated.spans,
        &radiance,
    );
    (surfels, allocated.spans, hit_gaps)
}

/// Hits that no surfel covers, at each of which one may be born.
pub(super) struct HitGaps {
    pub wanted: Wanted,
    pub points: Buffer<SurfacePoint>,
}

/// The rays of one path depth.
struct Segment {
    args: Buffer<DispatchArgs>,
    /// `None` for the surfels' own rays.
    rays: Option<Buffer<Ray>>,
    paths: Buffer<Path>,
}

#[allow(clippy::too_many_arguments, reason = "the ports of the stage")]
fn continue_segment(
    g: &mut Graph,
    depth: u32,
    args: &Buffer<DispatchArgs>,
    batch: &Batch<'_>,
    points: &Buffer<SurfacePoint>,
    paths: &Buffer<Path>,
    goes_on: &Buffer<u32>,
    emitters: Option<&Buffer<Emitter>>,
) -> Segment {
    let next = depth + 1;
    let inputs = count_paths::Inputs {
        batch: args,
        goes_on,
        before: g.transient(&format!("path_places_{next}"), goes_on.len()),
        next: g.transient(&format!("path_batch_{next}"), 1),
    };
    let label = format!("persistent/count_paths_{next}");
    let counted = g.add::<count_paths::CountPaths>(&label, inputs, Dispatch::Groups([1, 1, 1]));
    g.output(&format!("rays_{next}"), &counted.next);
    let next_rays = g.transient(&format!("path_rays_{next}"), batch.most);
    let next_paths = g.transient(&format!("paths_{next}"), batch.most);
    let continued = g.add::<continue_paths::ContinuePaths>(
        &format!("persistent/continue_paths_{next}"),
        continue_paths::Inputs {
            batch: args,
            points,
            paths,
            goes_on,
            before: &counted.before,
            emitters,
            next_rays,
            next_paths,
        },
        batch.dispatch(),
    );
    Segment {
        args: counted.next,
        rays: Some(continued.next_rays),
        paths: continued.next_paths,
    }
}
