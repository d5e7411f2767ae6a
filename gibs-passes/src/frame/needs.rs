//! What a scene and its settings need of the frame, and what that costs: a frame has stages and buffers for its needs
//! only.
use super::{DebugView, SceneSizes, Settings, SurfelFrame, surfel_frame};
use gibs_graph::{Graph, GraphErrors, Port, Schedule};
use serde::Serialize;
use std::collections::BTreeSet;

/// One thing that a frame may have to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Need {
    /// What it is.
    pub name: &'static str,
    /// The frame has it.
    pub present: bool,
    /// Where it comes from.
    pub reason: String,
    /// Stages that it adds, or would add.
    pub stages: Vec<String>,
    /// Bindings that it adds, or would add, to stages that are there without it, as `stage.port`.
    pub bindings: Vec<String>,
    /// Bytes of device memory that it adds, or would add; negative where memory is shared better with it.
    pub bytes: i64,
}

/// A frame that differs in one need.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The need.
    pub name: &'static str,
    /// The frame as it is has it, and this one does not; or the other way round.
    pub present: bool,
    /// Where the need comes from.
    pub reason: String,
    /// The frame without it, or with it.
    pub frame: SurfelFrame,
    /// The scene without it, or with it.
    pub sizes: SceneSizes,
}

/// The needs of a frame, found by recording it once more without each of them, or with it.
///
/// # Errors
/// As [`Graph::compile`].
pub fn needs(frame: &SurfelFrame, sizes: &SceneSizes) -> Result<Vec<Need>, GraphErrors> {
    let here = record(frame, sizes)?;
    let variants = variants(frame, sizes).into_iter();
    variants
        .map(|variant| {
            let other = record(&variant.frame, &variant.sizes)?;
            Ok(need(variant, &here, &other))
        })
        .collect()
}

/// A frame with each of its needs switched.
pub fn variants(frame: &SurfelFrame, sizes: &SceneSizes) -> Vec<Variant> {
    let settings = &frame.settings;
    let lights = sizes.lights();
    let counted = |count: u64, what: &str| match count {
        0 => format!("no {what}"),
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    };
    let has = |present: bool, what: &str| match present {
        true => format!("the scene has {what}"),
        false => format!("the scene has no {what}"),
    };
    let scene = |name, present, reason, sizes: SceneSizes| Variant {
        name,
        present,
        reason,
        frame: frame.clone(),
        sizes,
    };
    let setting = |name, present, reason, change: &dyn Fn(&mut Settings)| {
        let mut frame = frame.clone();
        change(&mut frame.settings);
        Variant {
            name,
            present,
            reason,
            frame,
            sizes: *sizes,
        }
    };
    let switch = |name, on, key: &str, change: &dyn Fn(&mut Settings)| {
        let value = if on { "on" } else { "off" };
        setting(name, on, format!("the setting {key} = {value}"), change)
    };
    let (paths, queries) = (settings.continuations, settings.queries);
    vec![
        scene(
            "direct light",
            lights > 0,
            counted(lights, "light of the scene or the view"),
            sizes.with_lights(if lights > 0 { 0 } else { 1 }),
        ),
        scene(
            "sky",
            sizes.sky,
            has(sizes.sky, "light from the sky"),
            sizes.with_sky(!sizes.sky),
        ),
        scene(
            "emitter sampling",
            sizes.emitters > 0 && settings.emitters,
            match settings.emitters {
                true => counted(sizes.emitters, "emissive triangle"),
                false => "the setting emitters = off".into(),
            },
            sizes.with_emitters(u64::from(sizes.emitters == 0)),
        ),
        scene(
            "textures",
            sizes.textured,
            has(sizes.textured, "textures"),
            sizes.with_textures(!sizes.textured),
        ),
        scene(
            "cut-outs",
            sizes.cut_outs,
            has(sizes.cut_outs, "surfaces with an alpha test"),
            sizes.with_cut_outs(!sizes.cut_outs),
        ),
        switch(
            "half resolution",
            settings.half_resolution,
            "half_resolution",
            &|other| other.half_resolution = !other.half_resolution,
        ),
        switch("depth functions", settings.depth, "depth", &|other| {
            other.depth = !other.depth
        }),
        switch("ray guiding", settings.guiding, "guiding", &|other| {
            other.guiding = !other.guiding
        }),
        switch(
            "irradiance sharing",
            settings.sharing,
            "sharing",
            &|other| other.sharing = !other.sharing,
        ),
        switch("ray sorting", settings.sorting, "sorting", &|other| {
            other.sorting = !other.sorting
        }),
        switch(
            "ray queries",
            settings.ray_queries,
            "ray_queries",
            &|other| other.ray_queries = !other.ray_queries,
        ),
        setting(
            "paths beyond a hit",
            paths > 0,
            format!("the setting continuations = {paths}"),
            &|other| other.continuations = if paths > 0 { 0 } else { 8 },
        ),
        setting(
            "births at hits",
            settings.hit_births > 0,
            format!("the setting hit_births = {}", settings.hit_births),
            &|other| other.hit_births = if settings.hit_births > 0 { 0 } else { 256 },
        ),
        switch(
            "slot check",
            settings.check_slots,
            "check_slots",
            &|other| other.check_slots = !other.check_slots,
        ),
        setting(
            "debug view",
            settings.debug.is_some(),
            match settings.debug {
                Some(view) => format!("the setting debug = {view}"),
                None => "no debug view".into(),
            },
            &|other| {
                other.debug = match other.debug {
                    Some(_) => None,
                    None => Some(DebugView::Surfels),
                }
            },
        ),
        setting(
            "irradiance at points",
            queries > 0,
            format!("the setting queries = {queries}"),
            &|other| other.queries = if queries > 0 { 0 } else { 1024 },
        ),
    ]
}

fn record(frame: &SurfelFrame, sizes: &SceneSizes) -> Result<Schedule, GraphErrors> {
    let mut g = Graph::new("surfels");
    surfel_frame(&mut g, frame, sizes);
    g.compile(None)
}

fn need(variant: Variant, here: &Schedule, other: &Schedule) -> Need {
    let Variant {
        name,
        present,
        reason,
        ..
    } = variant;
    let (with, without) = if present {
        (here, other)
    } else {
        (other, here)
    };
    let labels = |schedule: &Schedule| -> BTreeSet<String> {
        let steps = schedule.dispatches();
        steps.map(|(_, step, _)| step.label.clone()).collect()
    };
    let left_out = labels(without);
    let stages = with
        .dispatches()
        .map(|(_, step, _)| step.label.clone())
        .filter(|label| !left_out.contains(label))
        .collect();
    let bound = |schedule: &Schedule| -> BTreeSet<String> {
        let steps = schedule.dispatches();
        let ports = steps.flat_map(|(_, step, dispatch)| {
            let name = |port: &Port| format!("{}.{}", step.label, port.name);
            dispatch.ports.iter().map(name).collect::<Vec<_>>()
        });
        ports.collect()
    };
    let fewer = bound(without);
    let bindings = with
        .dispatches()
        .filter(|(_, step, _)| left_out.contains(&step.label))
        .flat_map(|(_, step, dispatch)| {
            let ports = dispatch.ports.iter();
            ports.map(|port| format!("{}.{}", step.label, port.name))
        })
        .filter(|name| !fewer.contains(name))
        .collect();
    Need {
        name,
        present,
        reason,
        stages,
        bindings,
        bytes: with.bytes(false) as i64 - without.bytes(false) as i64,
    }
}
