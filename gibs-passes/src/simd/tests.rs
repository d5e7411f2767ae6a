//! Wide lookups give the scalar ones' bits.
use super::{Avx2, Lookup};
use crate::data::{SurfelDepth, SurfelLight, SurfelPose, SurfelSettings};
use crate::shared::grid::GridLayout;
use crate::shared::hash::{hash2, hash3, unit};
use crate::shared::lookup::{self, Place, Surfels};
use glam::{UVec2, Vec3};

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn direction(i: u32, k: u32) -> Vec3 {
    let v = Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2));
    v.try_normalize().unwrap_or(Vec3::Z)
}

/// Surfels in a cube of side 2, all in the list of every cell: some without a radius, some without samples, every
/// tenth with the normal -z, where the basis changes its sign.
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
                0.9 + 0.8 * random(i, 3)
            },
            normal: if i % 10 == 0 {
                Vec3::NEG_Z
            } else {
                direction(i, 4)
            },
            identity: i,
        })
        .collect();
    let depths: Vec<SurfelDepth> = ids()
        .map(|i| SurfelDepth {
            texels: std::array::from_fn(|t| match i % 3 {
                0 => 0xffff_ffff,
                1 => hash3(i, t as u32, 7),
                // Moments of one distance, so that the variance is the least there is.
                _ => lookup::pack_moments(glam::Vec2::new(0.3, 0.09)),
            }),
        })
        .collect();
    let light: Vec<SurfelLight> = ids()
        .map(|i| SurfelLight {
            irradiance: Vec3::new(random(i, 8), random(i, 9), random(i, 10)).abs() * 10.0,
            trust: lookup::trust(hash2(i, 11) % 50) * f32::from(u8::from(i % 5 != 0)),
        })
        .collect();
    let layout = GridLayout::new(4, 10.0);
    let grid = layout.at(Vec3::ZERO, 4.0);
    let wide = Lookup::new();
    let (mut covered, mut averaged) = (0, 0);
    for case in 0..3000u32 {
        let entries: Vec<u32> = (0..case % 41).map(|k| hash3(case, k, 1) % 200).collect();
        let cells = vec![UVec2::new(0, entries.len() as u32); layout.cells() as usize];
        let settings = SurfelSettings {
            lookup: if case % 7 == 0 { 5 } else { 128 },
            ..SurfelSettings::default()
        };
        let surfels = Surfels {
            cells: &cells,
            entries: &entries,
            poses: &poses,
            depths: if case % 3 == 0 { &[] } else { &depths },
            grid: &grid,
            settings: &settings,
        };
        // Every ninth point is the centre of a surfel.
        let (point, normal) = match entries.first() {
            Some(&id) if case % 9 == 0 => (poses[id as usize].position, poses[id as usize].normal),
            _ => (direction(case, 20) * random(case, 23), direction(case, 24)),
        };
        let place = Place {
            position: point,
            normal,
            list: surfels.around(point),
            average: case % 5 != 0,
        };
        let (mut seen, mut same_seen) = (Vec::new(), Vec::new());
        let coverage = lookup::coverage(&place, &surfels, |id| seen.push(id));
        let same = wide.coverage(&place, &surfels, |id| same_seen.push(id));
        assert_eq!(seen, same_seen, "case {case}");
        assert_eq!(coverage.to_bits(), same.to_bits(), "case {case}");
        let (mut around, mut same_around) = (Vec::new(), Vec::new());
        let own = (case % 200) as usize;
        let wanted = |id: usize| !id.is_multiple_of(7);
        let each = |id, weight: f32| around.push((id, weight.to_bits()));
        lookup::neighbours(own, surfels.around(point), 1.5, &surfels, wanted, each);
        let each = |id, weight: f32| same_around.push((id, weight.to_bits()));
        wide.neighbours(own, surfels.around(point), 1.5, &surfels, wanted, each);
        assert_eq!(around, same_around, "case {case}");
        let enough = [f32::MAX, lookup::ENOUGH_AT_HITS, 1.0][case as usize % 3];
        let gathered = lookup::gather(&place, enough, &surfels, &light);
        let same = wide.gather(&place, enough, &surfels, &light);
        assert_eq!(
            bytemuck::bytes_of(&gathered),
            bytemuck::bytes_of(&same),
            "case {case}: {gathered:?} and {same:?}"
        );
        covered += u32::from(gathered.weight == 1.0);
        averaged += u32::from(gathered.weight < 1.0 && gathered.average.x > 0.0);
    }
    assert!(
        covered > 200 && averaged > 300,
        "{covered} covered, {averaged} averaged"
    );
}
