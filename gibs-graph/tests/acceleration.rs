//! Acceleration structures in a schedule, and what backends are to build of them.
#![allow(dead_code, reason = "no kernel runs")]
use gibs_graph::{
    AccelerationInstance, AccelerationSource, BottomLevel, Capabilities, Dispatch, Graph, Schedule,
    WgslSource, Workgroup, bytemuck, stage,
};

stage! {
    /// Traces.
    pub stage Trace {
        wgsl: WgslSource { name: "trace", text: "", modules: &[], features: &[] },
        workgroup: [64, 1, 1],
        ports: { optional_acceleration structure: AccelerationInstance, write hits: u32 },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(_: &Views<'_>, _: Workgroup) {}

fn source() -> (Schedule, AccelerationSource) {
    let mut g = Graph::new("traced");
    let structure = g.acceleration("scene", 10, 3);
    let inputs = Inputs {
        structure: Some(&structure),
        hits: g.transient("hits", 64),
    };
    let out = g.add::<Trace>("trace", inputs, Dispatch::Elements(64));
    g.output("hits", &out.hits);
    let schedule = g.compile(None).unwrap();
    let source = AccelerationSource::all(&schedule).remove(0);
    (schedule, source)
}

fn instance(first: u32, count: u32) -> AccelerationInstance {
    AccelerationInstance {
        first,
        count,
        ..AccelerationInstance::default()
    }
}

#[test]
fn a_structure_brings_its_triangles_into_the_schedule() {
    let (schedule, source) = source();
    let [structure, triangles] =
        [source.resource, source.triangles].map(|id| &schedule.resources[id as usize]);
    assert_eq!(
        (&*structure.key, &*triangles.key),
        ("scene", "scene_triangles")
    );
    assert!(structure.usage.acceleration && triangles.usage.triangles);
    assert_eq!((structure.len, triangles.len), (3, 10));
    assert!(
        schedule.to_text().contains("q:scene"),
        "{}",
        schedule.to_text()
    );
    let features = schedule.dispatches().next().unwrap().2.features();
    assert_eq!(features, ["structure", "RAY_QUERY"]);
}

#[test]
fn instances_of_the_same_triangles_share_a_bottom_level() {
    let (_, mut source) = source();
    let given = [instance(4, 6), instance(0, 0), instance(4, 6)];
    source.uploaded(source.resource, 0, bytemuck::cast_slice(&given));
    let plan = source.plan().unwrap();
    let bottom = BottomLevel {
        first: 4,
        count: 6,
        opaque: true,
    };
    assert_eq!(plan.bottoms, [bottom]);
    assert_eq!(plan.instances, [(given[0], 0), (given[2], 0)]);
    assert_eq!(source.bytes(), bytemuck::cast_slice::<_, u8>(&given));
}

#[test]
fn what_cannot_be_built_is_refused() {
    let (_, mut source) = source();
    let wide = AccelerationInstance {
        custom: 1 << 24,
        ..instance(0, 1)
    };
    let mut endless = instance(0, 1);
    endless.to_world[1].w = f32::INFINITY;
    for (given, says) in [
        (instance(9, 2), "end at 11, there are 10"),
        (wide, "24 bits"),
        (endless, "not finite"),
    ] {
        source.uploaded(source.resource, 64, bytemuck::bytes_of(&given));
        let error = source.plan().unwrap_err().to_string();
        assert!(
            error.contains("instance 1") && error.contains(says),
            "{error}"
        );
    }
}

#[test]
fn a_device_without_ray_queries_refuses_it_and_says_what_to_do() {
    let (schedule, _) = source();
    let error = Capabilities::webgpu().check("GPU", &schedule);
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("stage `trace`") && error.contains("ray_queries=off"),
        "{error}"
    );
    assert!(Capabilities::unlimited().check("CPU", &schedule).is_ok());
}
