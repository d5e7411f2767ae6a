//! Irradiance probes under a sky, without geometry: the test bed of the talk for where rays go (GIBS, "Ray Guiding").
use super::upload;
use crate::data::*;
use crate::device::EnvironmentTable;
use crate::shared::grid::{self, GridLayout};
use crate::shared::{batch, guide, hash, mark, plane};
use crate::stages::*;
use gibs_graph::{BackendError, Dispatch, DispatchArgs, Executable, Graph, Initial};
use glam::{UVec2, Vec3};

/// Most places that probes can be at.
pub const MOST_PLACES: u32 = SIDE * SIDE * SIDE;

/// Cells along each side of the cube: one place is in the middle of each.
const SIDE: u32 = 16;

const LAYOUT: GridLayout = GridLayout {
    side: SIDE,
    slices: 1,
};

/// Probes that integrate the light of a sky: surfels that nothing covers.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeFrame {
    /// Unit normal of each place; at most [`MOST_PLACES`].
    pub normals: Vec<Vec3>,
    /// Probes at each place. They are neighbours, and their guides learn from each other's rays.
    pub per_place: u32,
    /// Rays of each probe and frame.
    pub rays: u32,
    /// Texels along each side of the guides that rays follow: 2, 4, 6 or 8; `None` where they follow none.
    pub guide_side: Option<u32>,
}

impl ProbeFrame {
    /// Probes at all places; those of one place lie one after the other.
    pub fn probes(&self) -> u32 {
        self.normals.len() as u32 * self.per_place
    }
}

/// Records the frame: the stages of the surfel frame that draw rays, weigh what they find, learn from it and integrate it.
/// Its output `irradiance` has a [`SurfelIrradiance`] for each probe.
pub fn probe_frame(g: &mut Graph, frame: &ProbeFrame, sky: &EnvironmentTable) {
    let probes = u64::from(frame.probes());
    let most = probes * u64::from(frame.rays);
    let device_frame = g.input("frame", 1);
    let shape = g.input("grid", 1);
    let cells = g.input("cells", u64::from(LAYOUT.cells()));
    let entries = g.input("entries", probes);
    let settings = g.input("settings", 1);
    let poses = g.input("poses", probes);
    let births = g.input("births", probes);
    let spans = g.input("spans", probes);
    let args = g.input("batch", 1);
    let points = g.input("points", most);
    let environment = g.input("environment", sky.texels.len() as u64);
    let (irradiance_state, irradiance) = g.state("irradiance", probes, Initial::Zero);
    let (guides_state, guides) = frame
        .guide_side
        .map(|side| g.state("guides", probes * guide::words(side) as u64, Initial::Zero))
        .unzip();
    let rays = g.transient("rays", most);
    let paths = g.transient("paths", most);
    let generated = g.add::<generate_rays::GenerateRays>(
        "probes/generate_rays",
        generate_rays::Inputs {
            frame: &device_frame,
            settings: &settings,
            poses: &poses,
            births: &births,
            irradiance: &irradiance,
            spans: &spans,
            emitters: None,
            guides: guides.as_ref(),
            rays,
            paths,
        },
        Dispatch::Elements(probes),
    );
    let gathered = g.zeroed("gathered", most);
    let radiance = g.zeroed("radiance", most);
    let shaded = g.add::<shade_hits::ShadeHits>(
        "probes/shade_hits",
        shade_hits::Inputs {
            batch: &args,
            frame: &device_frame,
            rays: &generated.rays,
            points: &points,
            direct: None,
            gathered: &gathered,
            environment: Some(&environment),
            paths: generated.paths,
            radiance,
            goes_on: None,
        },
        Dispatch::Elements(most),
    );
    let guides = guides.map(|guides| {
        g.add::<update_guide::UpdateGuide>(
            "probes/update_guide",
            update_guide::Inputs {
                frame: &device_frame,
                grid: &shape,
                settings: &settings,
                cells: &cells,
                entries: &entries,
                poses: &poses,
                spans: &spans,
                rays: &generated.rays,
                paths: &shaded.paths,
                radiance: &shaded.radiance,
                guides,
            },
            Dispatch::Elements(probes),
        )
        .guides
    });
    // Nothing changes here.
    let forget = g.zeroed("forget", u64::from(LAYOUT.cells()));
    let light = g.transient("light", probes);
    let integrated = g.add::<integrate::Integrate>(
        "probes/integrate",
        integrate::Inputs {
            frame: &device_frame,
            grid: &shape,
            settings: &settings,
            poses: &poses,
            spans: &spans,
            radiance: &shaded.radiance,
            forget: &forget,
            irradiance,
            light,
            neighbours: None,
            clamped: None,
        },
        Dispatch::Elements(probes),
    );
    g.output("irradiance", &integrated.irradiance);
    g.keep(irradiance_state, integrated.irradiance);
    if let (Some(state), Some(guides)) = (guides_state, guides) {
        g.keep(state, guides);
    }
}

/// Writes the inputs of [`probe_frame`] that stay. A probe's random numbers
/// follow from its index.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_probes(
    exec: &mut dyn Executable,
    frame: &ProbeFrame,
    sky: &EnvironmentTable,
) -> Result<(), BackendError> {
    let probes = frame.probes();
    let shape = LAYOUT.at(Vec3::ZERO, SIDE as f32);
    let position = |place: u32| {
        let at = |i: u32| (i * 2 + 1) as f32 - SIDE as f32;
        Vec3::new(
            at(place % SIDE),
            at(place / SIDE % SIDE),
            at(place / SIDE / SIDE),
        )
    };
    let normal = |probe: u32| frame.normals[(probe / frame.per_place) as usize];
    let poses: Vec<SurfelPose> = (0..probes)
        .map(|probe| SurfelPose {
            position: position(probe / frame.per_place),
            radius: 1.0,
            normal: normal(probe),
            mark: mark::of(hash::pcg(probe), plane::pack(normal(probe)), false),
        })
        .collect();
    let mut cells = vec![UVec2::ZERO; LAYOUT.cells() as usize];
    for place in 0..frame.normals.len() as u32 {
        let cell = grid::cell(position(place), &shape) as usize;
        cells[cell] = UVec2::new(place * frame.per_place, frame.per_place);
    }
    let spans: Vec<UVec2> = (0..probes)
        .map(|i| UVec2::new(i * frame.rays, frame.rays))
        .collect();
    let settings = SurfelSettings {
        capacity: probes,
        ray_budget: probes * frame.rays,
        guide_side: frame.guide_side.unwrap_or_default(),
        ..SurfelSettings::default()
    };
    let missed = SurfacePoint {
        transform_id: u32::MAX,
        ..SurfacePoint::default()
    };
    let most = probes * frame.rays;
    upload(exec, "grid", &[shape])?;
    upload(exec, "cells", &cells)?;
    upload(exec, "entries", &(0..probes).collect::<Vec<u32>>())?;
    upload(exec, "poses", &poses)?;
    upload(exec, "births", &vec![SurfelBirth::default(); poses.len()])?;
    upload(exec, "spans", &spans)?;
    upload(exec, "settings", &[settings])?;
    upload(exec, "points", &vec![missed; most as usize])?;
    upload(exec, "environment", &sky.texels)?;
    upload::<DispatchArgs>(exec, "batch", &[batch::args(most)])
}

/// Writes the input of [`probe_frame`] that changes every frame.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_probe_frame(
    exec: &mut dyn Executable,
    sky: &EnvironmentTable,
    number: u32,
    seed: u32,
) -> Result<(), BackendError> {
    let frame = Frame {
        number,
        seed,
        environment_side: sky.side,
        ..Frame::default()
    };
    upload(exec, "frame", &[frame])
}
