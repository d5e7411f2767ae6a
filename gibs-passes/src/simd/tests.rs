//! Wide lookups give the scalar ones' bits.
use super::lookup::FULL;
use super::{Avx2, Lookup};
use crate::data::{Gathered, SurfacePoint, SurfelLight, SurfelPose, SurfelSettings};
use crate::shared::bounds;
use crate::shared::depth::Depths;
use crate::shared::grid::{self, GridLayout};
use crate::shared::hash::{hash2, hash3, unit};
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Points};
use crate::shared::{depth, mark, octahedral, plane};
use glam::{UVec2, Vec3};

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn direction(i: u32, k: u32) -> Vec3 {
    let v = Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2));
    v.try_normalize().unwrap_or(Vec3::Z)
}

/// Surfels in a cube of side 2, all in the list of the one cell where points lie: some small, some without a radius, some
/// without samples, every tenth with the normal -z, where the basis changes its sign.
#[test]
fn the_wide_lookup_is_the_scalar_one() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let ids = || 0..200u32;
    let poses: Vec<SurfelPose> = ids()
        .map(|i| SurfelPose {
            position: Vec3::new(random(i, 0), random(i, 1), random(i, 2)),
            radius: if i % 13 == 0 {
                0.0
            } else {
                [0.2, 0.9][i as usize % 2] * (1.0 + 0.8 * random(i, 3))
            },
            normal: if i % 10 == 0 {
                Vec3::NEG_Z
            } else {
                direction(i, 4)
            },
            mark: mark::of(
                i,
                // Any, but often that across the normal.
                match i % 4 {
                    0 => hash2(i, 13),
                    _ => plane::pack(if i % 10 == 0 {
                        Vec3::Z
                    } else {
                        direction(i, 4)
                    }),
                },
                hash2(i, 12).is_multiple_of(3),
            ),
        })
        .collect();
    // Room for every side.
    let texel = |i: u32, t: u32| match i % 3 {
        0 => 0xffff_ffff,
        1 => hash3(i, t, 7),
        // Moments of one distance, so that the variance is the least there is.
        _ => depth::pack_moments(glam::Vec2::new(0.3, 0.09)),
    };
    let depths: Vec<u32> = ids()
        .flat_map(|i| (0..64).map(move |t| texel(i, t)))
        .collect();
    let light: Vec<SurfelLight> = ids()
        .map(|i| SurfelLight {
            irradiance: Vec3::new(random(i, 8), random(i, 9), random(i, 10)).abs() * 10.0,
            trust: lookup::trust(hash2(i, 11) % 50) * f32::from(u8::from(i % 5 != 0)),
        })
        .collect();
    let layout = GridLayout::new(4, 10.0);
    // Cells of side 2, in one of which all points lie.
    let grid = layout.at(Vec3::ONE, 4.0);
    let cell = grid::cell(Vec3::ZERO, &grid);
    let steps = bounds::steps_in(cell, &grid);
    let bounds = |id: u32| {
        let pose = &poses[id as usize];
        bounds::pack(pose.position - grid.centre, pose.radius, steps)
    };
    let (mut covered, mut averaged, mut long, mut crowded) = (0, 0, 0, 0);
    let both = |case| [(case, Lookup::new()), (case, Lookup::eight_wide())];
    for (case, wide) in (0..3000u32).flat_map(both) {
        // Once in a while more than the wide lookups line up.
        let length = if case % 50 == 0 { 20_000 } else { case % 41 };
        let ids: Vec<u32> = (0..length).map(|k| hash3(case, k, 1) % 200).collect();
        let entries: Vec<u32> = ids
            .iter()
            .copied()
            .chain(ids.iter().map(|&id| bounds(id)))
            .collect();
        let mut cells = vec![UVec2::ZERO; layout.cells() as usize];
        cells[cell as usize] = UVec2::new(0, ids.len() as u32);
        let settings = SurfelSettings {
            lookup: if case % 7 == 0 { 5 } else { 20_000 },
            ..SurfelSettings::default()
        };
        let surfels = Surfels {
            cells: &cells,
            entries: &entries,
            poses: &poses,
            depths: match case % 3 {
                0 => Depths::default(),
                _ => Depths::new(&depths, 2 + case % 7),
            },
            grid: &grid,
            settings: &settings,
        };
        let (mut around, mut same_around) = (Vec::new(), Vec::new());
        let wanted = |id: usize| !id.is_multiple_of(7);
        let owns = |id: usize| hash2(id as u32, case).is_multiple_of(16);
        lookup::at_surfels(&surfels, 0..200, owns, |owns| {
            let crowds = lookup::crowds(owns, &surfels).map(f32::to_bits);
            let same = wide.crowds(owns, &surfels).map(f32::to_bits);
            assert_eq!(crowds, same, "case {case}");
            crowded += crowds.iter().filter(|crowd| **crowd != 0).count();
            let each = |at, id, weight: f32| around.push((at, id, weight.to_bits()));
            lookup::neighbours::<2>(owns, &surfels, wanted, each);
            let each = |at, id, weight: f32| same_around.push((at, id, weight.to_bits()));
            wide.neighbours::<2>(owns, &surfels, |_| {}, wanted, each);
        });
        assert_eq!(around, same_around, "case {case}");
        long += u32::from(around.len() > 2 * FULL);
        let enough = [f32::MAX, lookup::ENOUGH_AT_HITS, 1.0][case as usize % 3];
        // As many points as are looked up at a time, some of which are missing.
        let all: [SurfacePoint; AT_A_TIME] = std::array::from_fn(|i| {
            // Every ninth point is the centre of a surfel.
            let (position, normal) = match ids.get(i) {
                Some(&id) if (case + i as u32).is_multiple_of(9) => {
                    (poses[id as usize].position, poses[id as usize].normal)
                }
                _ => (
                    direction(case, 30 + i as u32) * 0.99 * random(case, 50 + i as u32),
                    direction(case, 70 + i as u32),
                ),
            };
            SurfacePoint {
                position,
                shading_normal: octahedral::pack(normal),
                ..SurfacePoint::default()
            }
        });
        let points: Points<'_> = std::array::from_fn(|i| {
            (!hash3(case, i as u32, 3).is_multiple_of(8)).then_some(&all[i])
        });
        let beyond = |i: usize| (!i.is_multiple_of(3)).then_some(Vec3::splat((i % 2) as f32));
        let gathered = lookup::gathers(&points, enough, beyond, &surfels, &light);
        let same = wide.gathers(&points, enough, beyond, &surfels, &light);
        assert_eq!(
            bytemuck::cast_slice::<_, u8>(&gathered),
            bytemuck::cast_slice::<_, u8>(&same),
            "case {case}: {gathered:?} and {same:?}"
        );
        let (mut seen, mut same_seen) = (Vec::new(), Vec::new());
        let coverages = lookup::coverages(&points, &surfels, |id| seen.push(id));
        let same = wide.coverages(&points, &surfels, |id| same_seen.push(id));
        assert_eq!(
            coverages.map(f32::to_bits),
            same.map(f32::to_bits),
            "case {case}"
        );
        assert_eq!(seen, same_seen, "case {case}");
        let is_covered = |g: &&Gathered| g.weight == 1.0;
        covered += gathered.iter().filter(is_covered).count();
        let is_averaged = |g: &&Gathered| g.weight < 1.0 && g.average.x > 0.0;
        averaged += gathered.iter().filter(is_averaged).count();
    }
    assert!(long > 10 && crowded > 20_000, "{long}, {crowded}");
    assert!(
        covered > 400 && averaged > 3000,
        "{covered} covered, {averaged} averaged"
    );
}
