//! A frame has stages, buffers and bindings for what its scene needs, and none for the rest.
use gibs_graph::{Graph, Schedule};
use gibs_passes::device::DeviceScene;
use gibs_passes::frame::{
    DebugView, SceneSizes, Screen, Settings, SurfelFrame, needs, surfel_frame,
};
use gibs_passes::scene::{Environment, Material, Mesh, Node, Scene};
use glam::{DVec3, Vec3};
use std::collections::BTreeSet;

/// One triangle.
fn sizes() -> SceneSizes {
    let scene = Scene {
        meshes: vec![Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }],
        materials: vec![Material::default()],
        nodes: vec![Node {
            meshes: vec![0],
            ..Node::default()
        }],
        ..Scene::default()
    };
    let pose = scene.pose(&[]);
    let sky = Environment::Constant(Vec3::ZERO);
    let device = DeviceScene::build(&scene, &pose, DVec3::ZERO, None, &sky);
    SceneSizes::of(&device.expect("a triangle"))
}

fn frame(screen: Screen, depth: bool) -> SurfelFrame {
    let settings = Settings {
        depth,
        continuations: 1,
        queries: 16,
        ..Settings::default()
    };
    SurfelFrame {
        size: [64, 64],
        grid: settings.grid(0.01, [64, 64]),
        settings,
        screen,
    }
}

/// Compiled with every device kernel held against the ports that are bound.
fn compile(frame: &SurfelFrame, sizes: &SceneSizes) -> Schedule {
    let mut g = Graph::new("surfels");
    surfel_frame(&mut g, frame, sizes);
    g.compile(Some(&gibs_shaders::Compiler::new()))
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// Every combination of needs compiles, and what it leaves out is neither bound nor allocated.
#[test]
fn every_combination_of_needs_is_a_frame_of_its_own() {
    for combination in 0..512u32 {
        let bit = |i: u32| combination >> i & 1 != 0;
        let screen = [Screen::Traced, Screen::Imported][usize::from(bit(0))];
        let sizes = sizes()
            .with_lights(u64::from(bit(1)))
            .with_sky(bit(2))
            .with_textures(bit(3))
            .with_cut_outs(bit(4))
            .with_emitters(u64::from(bit(6)));
        let mut frame = frame(screen, bit(5));
        frame.settings.guiding = bit(7);
        frame.settings.half_resolution = bit(8);
        let schedule = compile(&frame, &sizes);
        let ports = |port: &str| {
            schedule
                .dispatches()
                .flat_map(|(_, step, d)| d.ports.iter().map(move |p| (&step.label, p.name)))
                .filter(|(_, name)| *name == port)
                .map(|(label, _)| label.as_str())
                .collect::<BTreeSet<_>>()
        };
        let has = |key: &str| schedule.resource(key).is_some();
        assert_eq!(has("scene_lights"), bit(1), "{combination:b}");
        assert_eq!(ports("direct").is_empty(), !bit(1), "{combination:b}");
        assert_eq!(has("scene_environment"), bit(2), "{combination:b}");
        assert_eq!(has("scene_texels"), bit(3), "{combination:b}");
        assert_eq!(has("surfel_depths"), bit(5), "{combination:b}");
        assert_eq!(has("scene_emitters"), bit(6), "{combination:b}");
        assert_eq!(has("surfel_guides"), bit(7), "{combination:b}");
        let upsamples = schedule
            .dispatches()
            .any(|(_, s, _)| s.label == "apply/upsample");
        assert_eq!(upsamples, bit(8), "{combination:b}");
        assert_eq!(has("apply_selected_pixels"), bit(8), "{combination:b}");
        let traces_materials = ports("materials").iter().any(|l| l.contains("ray_trace"));
        assert_eq!(traces_materials, bit(4), "{combination:b}");
        let traces_texels = ports("texels").iter().any(|l| l.contains("ray_trace"));
        assert_eq!(traces_texels, bit(3) && bit(4), "{combination:b}");
    }
}

/// Each debug view compiles with and without what it may look at, and adds stages of its own group alone.
#[test]
fn a_debug_view_adds_stages_of_its_own() {
    let sizes = sizes();
    for combination in 0..4u32 {
        let mut frame = frame(Screen::Traced, combination & 1 != 0);
        frame.settings.guiding = combination & 2 != 0;
        let steps = |frame: &SurfelFrame| {
            let schedule = compile(frame, &sizes);
            let labels = schedule.dispatches().map(|(_, step, _)| step.label.clone());
            labels.collect::<BTreeSet<_>>()
        };
        let plain = steps(&frame);
        assert!(!plain.iter().any(|label| label.starts_with("debug/")));
        for &view in DebugView::ALL {
            frame.settings.debug = Some(view);
            let mut more: Vec<_> = steps(&frame).difference(&plain).cloned().collect();
            more.retain(|label| label != "debug/surfels");
            assert!(
                more == ["debug/discs"] || more == ["debug/surface"],
                "{view}: {more:?}"
            );
        }
    }
}

/// What is said to be left out is what the other frame has more, and nothing else.
#[test]
fn what_a_need_adds_is_what_the_frame_with_it_has_more() {
    let (frame, sizes) = (frame(Screen::Traced, true), sizes());
    let listed = needs(&frame, &sizes).expect("the frame compiles");
    let sky = listed.iter().find(|n| n.name == "sky").expect("listed");
    assert!(!sky.present && sky.stages.is_empty());
    assert_eq!(
        sky.bindings,
        [
            "persistent/shade_hits.environment",
            "persistent/shade_hits_1.environment",
            "apply/compose.environment"
        ]
    );
    let check = listed.iter().find(|n| n.name == "slot check");
    let check = check.expect("listed");
    let added = ["check/mark_slots", "check/count_slots"];
    assert!(!check.present && check.stages == added, "{check:?}");
    assert!(check.bindings.is_empty(), "{check:?}");
    let half = listed.iter().find(|n| n.name == "half resolution");
    let half = half.expect("listed");
    let added = [
        "apply/select_pixels",
        "apply/select_scan_blocks",
        "apply/select_scan_sums",
        "apply/select_scan_apply",
        "apply/batch",
        "apply/pack_pixels",
        "apply/count_contrasts",
        "apply/contrasts_scan_blocks",
        "apply/contrasts_scan_sums",
        "apply/contrasts_scan_apply",
        "apply/contrasts_batch",
        "apply/pack_contrasts",
        "apply/lighting_apply_contrasts",
        "apply/upsample",
    ];
    assert!(half.present && half.stages == added, "{half:?}");
    assert_eq!(half.bindings, ["apply/lighting_apply.pixels"]);
    let with = compile(&frame, &sizes.with_sky(true));
    let without = compile(&frame, &sizes);
    let more = with.bytes(false) as i64 - without.bytes(false) as i64;
    assert_eq!(sky.bytes, more);
    let names: Vec<_> = listed.iter().map(|n| (n.name, n.present)).collect();
    assert_eq!(
        names,
        [
            ("direct light", false),
            ("sky", false),
            ("emitter sampling", false),
            ("textures", false),
            ("cut-outs", false),
            ("half resolution", true),
            ("depth functions", true),
            ("ray guiding", false),
            ("irradiance sharing", true),
            ("ray sorting", false),
            ("ray queries", false),
            ("paths beyond a hit", true),
            ("births at hits", false),
            ("slot check", false),
            ("debug view", false),
            ("irradiance at points", true)
        ]
    );
}
