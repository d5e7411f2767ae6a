//! Surfels' lives: the estimator over a hundred thousand frames, on any backend.
use gibs::graph::bytemuck::{cast_slice, pod_collect_to_vec};
use gibs::graph::{Backend, Dispatch, Graph, WgslSource, Workgroup, stage};
use gibs::passes::data::SurfelIrradiance;
use gibs::passes::shared::{estimator, hash};
use glam::Vec3;
use std::sync::Arc;

pub const FRAMES: u32 = 100_000;
pub const RAYS: u32 = 4;
/// When the count of rays has reached its end, `MOST_SAMPLES / RAYS = 32 768` frames, and as much again.
const FULL: u32 = 2 * estimator::MOST_SAMPLES / RAYS;
/// From [`FULL`] on, one mean in so many is kept.
const EVERY: u32 = 100;
/// Means that are kept.
const KEPT: usize = 344;

// `lives.wgsl` has these as numbers.
const _: () = assert!(FULL == 65_536 && (FRAMES - FULL) / EVERY == KEPT as u32);

/// One surfel.
#[derive(Clone, Copy, Debug)]
pub struct Life {
    /// Mean of its samples, W/m^2.
    pub level: f32,
    /// Of samples that are even on `[0, 2 level)`; 0 for a constant, whose fireflies are clamped as well.
    pub seed: u32,
    /// Frame that it begins in.
    pub birth: u32,
}

stage! {
    /// Lives a life in each workgroup: the kept means, and frames in which the state was not finite or negative.
    pub stage Live {
        wgsl: WgslSource {
            name: "live",
            text: include_str!("lives.wgsl"),
            modules: gibs::shaders::MODULES,
            features: &[],
        },
        workgroup: [1, 1, 1],
        ports: {
            read levels: f32,
            read seeds: u32,
            read births: u32,
            write means: f32,
            write unsound: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let life = group.id[0] as usize;
    let (level, seed) = (p.levels[life], p.seeds[life]);
    let mut state = SurfelIrradiance::default();
    let (mut place, mut unsound) = (0, 0);
    for i in 0..FRAMES {
        let sample = match seed {
            0 => level,
            _ => 2.0 * level * hash::unit(hash::hash2(i, seed)),
        };
        let frame = p.births[life].wrapping_add(i);
        state = estimator::update(&state, Vec3::splat(sample), RAYS, frame, seed == 0);
        let kept = [
            state.mean.x,
            state.short_mean.x,
            state.variance,
            state.short_noise,
        ];
        unsound += u32::from(!kept.iter().all(|x| x.is_finite() && *x >= 0.0));
        if i >= FULL && i.is_multiple_of(EVERY) {
            p.means.set(life * KEPT + place, state.mean.x);
            place += 1;
        }
    }
    p.unsound.set(life, unsound);
}

/// The mean at every 100th frame from the 65 536th on, of each life. The state was sound in every frame.
pub fn means(backend: &dyn Backend, lives: &[Life]) -> Vec<Vec<f32>> {
    let count = lives.len() as u64;
    let mut g = Graph::new("lives");
    let (levels, seeds, births) = (
        g.input("levels", count),
        g.input("seeds", count),
        g.input("births", count),
    );
    let inputs = Inputs {
        levels: &levels,
        seeds: &seeds,
        births: &births,
        means: g.transient("means", count * KEPT as u64),
        unsound: g.transient("unsound", count),
    };
    let out = g.add::<Live>("live", inputs, Dispatch::Groups([count as u32, 1, 1]));
    g.output("means", &out.means);
    g.output("unsound", &out.unsound);
    let compiler = gibs::shaders::Compiler::new();
    let schedule = Arc::new(g.compile(Some(&compiler)).expect("compiles"));
    let mut run = backend.prepare(schedule.clone()).expect("prepares");
    let of = |f: fn(&Life) -> u32| lives.iter().map(f).collect::<Vec<u32>>();
    for (key, words) in [
        ("levels", of(|life| life.level.to_bits())),
        ("seeds", of(|life| life.seed)),
        ("births", of(|life| life.birth)),
    ] {
        let id = schedule.resource(key).expect("an input");
        run.upload(id, 0, cast_slice(&words)).expect("uploads");
    }
    run.run().expect("runs");
    let mut read = |key| {
        run.read(schedule.output(key).expect("an output"))
            .expect("reads")
    };
    let unsound: Vec<u32> = pod_collect_to_vec(&read("unsound"));
    for (life, unsound) in lives.iter().zip(unsound) {
        assert_eq!(
            unsound,
            0,
            "{}: {life:?}: frames that are not sound",
            backend.name()
        );
    }
    let means: Vec<f32> = pod_collect_to_vec(&read("means"));
    means.chunks(KEPT).map(<[f32]>::to_vec).collect()
}
