//! Ray queries of the device against the traversal in software: the same hits, and the same frames.
#![cfg(any(feature = "wgpu", feature = "vulkan"))]
mod common;

use common::{all_backends, cpu, is_strict, render, settings};
use gibs::builtin;
use gibs::check::{CheckOptions, Participant, Verdict, check, surfels};
use gibs::compare::{CompareOptions, compare};
use gibs::graph::glam::{DAffine3, DQuat, DVec3, Vec3};
use gibs::graph::{
    Backend, Buffer, Capabilities, Dispatch, DispatchArgs, Executable, Graph, NullBackend,
    Schedule, bytemuck,
};
use gibs::passes::data::{Hit, NONE, Ray};
use gibs::passes::device::DeviceScene;
use gibs::passes::frame::{SceneInputs, SceneSizes, Screen, Settings, upload, upload_scene};
use gibs::passes::scene::{LocalTransform, Node, Scene};
use gibs::passes::shared::batch;
use gibs::passes::stages::{trace_any, trace_closest};
use gibs::picture::FINAL_IMAGE;
use gibs::renderer::device_scene;
use gibs::view::View;
use gibs::{Gi, shaders};
use std::sync::Arc;

/// The backends whose devices have ray queries. One that has none is a failure under `GIBS_STRICT=1`.
fn backends() -> Vec<Box<dyn Backend>> {
    let mut found = all_backends();
    found.retain(|backend| {
        let traces = backend.capabilities().ray_query;
        let name = backend.name();
        assert!(traces || !is_strict(), "{name} has no ray queries");
        if !traces {
            eprintln!("not run on {name}: it has no ray queries");
        }
        traces && name != "cpu"
    });
    found
}

/// Numbers in 0..1, the same on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f64 / (1_u64 << 24) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// The meshes of a scene with a blended pane and a cut-out grid, many times over: turned, mirrored, scaled differently
/// along each axis, sheared, and one in a dozen flattened to nothing.
fn crowd(seed: u64) -> (Scene, View) {
    let (mut scene, view) = builtin::by_name("glass").expect("built in");
    let mut random = Random(seed);
    for copy in 0..40 {
        for mesh in 0..scene.meshes.len() as u32 {
            let signs = (random.vector() - 0.3).signum();
            let mut scale = signs * (0.05 + 0.5 * random.vector());
            if copy % 12 == 11 {
                scale.z = 0.0;
            }
            let turn = DQuat::from_scaled_axis(6.0 * random.vector());
            let place = 6.0 * (random.vector() - 0.5);
            let turned = DAffine3::from_scale_rotation_translation(scale, turn, place);
            let mut sheared = DAffine3::IDENTITY;
            sheared.matrix3.y_axis.x = random.unit() - 0.5;
            scene.nodes.push(Node {
                local: LocalTransform::Affine(turned * sheared),
                meshes: vec![mesh],
                ..Node::default()
            });
        }
    }
    (scene, view)
}

fn device((scene, view): &(Scene, View)) -> DeviceScene {
    device_scene(scene, view, view.camera.position).expect("a scene")
}

/// Rays between points in and about a scene: as a camera's, as any other, as a shadow ray's with an end, and some that
/// can hit nothing.
fn rays(scene: &DeviceScene, count: usize) -> Vec<Ray> {
    let mut random = Random(7);
    let (low, high) = scene.bounds;
    let mut point = || low + (high - low) * (random.vector() * 1.2 - 0.1).as_vec3();
    let ray = |i: usize| {
        let (from, to) = (point(), point());
        let way = to - from;
        let (t_min, direction, t_max) = match i % 8 {
            0..3 => (-0.0, way.normalize_or(Vec3::X), f32::MAX),
            3..5 => (0.0, way, f32::INFINITY),
            5..7 => (0.0, way, 1.0),
            _ => [
                (0.0, Vec3::splat(f32::NAN), 1.0),
                (0.0, way, f32::NAN),
                (0.0, way, 0.0),
                (2.0, way, 1.0),
            ][i / 8 % 4],
        };
        Ray {
            origin: from,
            t_min,
            direction,
            t_max,
        }
    };
    (0..count).map(ray).collect()
}

/// A schedule that traces rays, the closest hit and any.
fn schedule(scene: &DeviceScene, rays: u64, ray_queries: bool) -> Arc<Schedule> {
    let mut g = Graph::new("rays");
    let mut inputs = SceneInputs::declare(&mut g, &SceneSizes::of(scene));
    if ray_queries {
        inputs = inputs.with_ray_queries(&mut g);
    }
    let scene = &inputs;
    let cut_outs = scene.cut_outs();
    let batch: Buffer<DispatchArgs> = g.input("batch", 1);
    let given: Buffer<Ray> = g.input("rays", rays);
    let closest = trace_closest::Inputs {
        batch: &batch,
        nodes: &scene.nodes,
        triangles: &scene.triangles,
        instances: &scene.instances,
        corners: cut_outs.map(|(corners, _)| corners),
        materials: cut_outs.map(|(_, materials)| materials),
        texels: cut_outs.and(scene.textures()),
        rays: &given,
        hits: g.transient("hits", rays),
        structure: scene.structure.as_ref(),
        wide_nodes: &scene.wide_nodes,
        wide_packets: &scene.wide_packets,
    };
    let size = || Dispatch::Elements(rays);
    let closest = g.add::<trace_closest::TraceClosest>("closest", closest, size());
    let any = trace_any::Inputs {
        batch: &batch,
        nodes: &scene.nodes,
        triangles: &scene.triangles,
        instances: &scene.instances,
        corners: cut_outs.map(|(corners, _)| corners),
        materials: cut_outs.map(|(_, materials)| materials),
        texels: cut_outs.and(scene.textures()),
        rays: &given,
        visible: g.transient("visible", rays),
        structure: scene.structure.as_ref(),
        wide_nodes: &scene.wide_nodes,
        wide_packets: &scene.wide_packets,
    };
    let any = g.add::<trace_any::TraceAny>("any", any, size());
    g.output("hits", &closest.hits);
    g.output("visible", &any.visible);
    Arc::new(
        g.compile(Some(&shaders::Compiler::new()))
            .expect("compiles"),
    )
}

fn give(exec: &mut dyn Executable, scene: &DeviceScene, rays: &[Ray]) {
    upload_scene(exec, scene).expect("uploads");
    upload(exec, "rays", rays).expect("uploads");
    upload(exec, "batch", &[batch::args(rays.len() as u32)]).expect("uploads");
}

/// Closest hits, and whether nothing stops each ray.
fn run(exec: &mut dyn Executable) -> (Vec<Hit>, Vec<u32>) {
    exec.run().expect("runs");
    let mut read = |name| {
        let resource = exec.schedule().output(name).expect("an output");
        exec.read(resource).expect("reads")
    };
    let (hits, visible) = (read("hits"), read("visible"));
    (
        bytemuck::pod_collect_to_vec(&hits),
        bytemuck::pod_collect_to_vec(&visible),
    )
}

/// Holds hits against those of the traversal in software. Most are equal to the bit; rays along edges, and those that hit
/// two triangles within rounding, may differ, and are few.
fn alike(what: &str, software: &(Vec<Hit>, Vec<u32>), device: &(Vec<Hit>, Vec<u32>)) {
    let count = software.0.len();
    let (mut other, mut apart, mut found) = (0, 0, 0);
    for (a, b) in software.0.iter().zip(&device.0) {
        found += usize::from(a.instance != NONE);
        if bytemuck::bytes_of(a) == bytemuck::bytes_of(b) {
            continue;
        }
        let near = (a.t - b.t).abs() <= 1e-5 * a.t.abs().max(1e-3);
        let both = a.instance != NONE && b.instance != NONE;
        match both && near {
            true => other += 1,
            false => apart += 1,
        }
    }
    let shadows = software.1.iter().zip(&device.1);
    let shadows = shadows.filter(|(a, b)| a != b).count();
    println!(
        "{what}: of {count} rays, of which {found} hit, {other} differ within rounding and {apart} beyond; {shadows} \
         differ in whether anything is hit"
    );
    assert!(found > count / 4, "{what}: too few rays hit anything");
    let few = |differ: usize| differ <= count / 2000;
    assert!(few(other) && few(apart) && few(shadows), "{what}");
}

const RAYS: usize = 16_384;

fn hits(name: &str, scene: &(Scene, View)) {
    let scene = device(scene);
    let rays = rays(&scene, RAYS);
    let prepared = |backend: &dyn Backend, ray_queries| {
        let schedule = schedule(&scene, RAYS as u64, ray_queries);
        let mut exec = backend.prepare(schedule).expect("prepares");
        give(exec.as_mut(), &scene, &rays);
        exec
    };
    let oracle = run(prepared(cpu().as_ref(), false).as_mut());
    for backend in backends() {
        let what = format!("{name} on {}", backend.name());
        let software = run(prepared(backend.as_ref(), false).as_mut());
        alike(&format!("{what}, software"), &oracle, &software);
        let queried = run(prepared(backend.as_ref(), true).as_mut());
        alike(&what, &software, &queried);
    }
}

#[test]
fn hits_are_those_of_the_software() {
    for name in ["cornell", "atrium", "glass", "many-lights"] {
        hits(name, &builtin::by_name(name).expect("built in"));
    }
}

#[test]
fn instances_of_any_transform_are_hit() {
    hits("crowd", &crowd(1));
}

/// A structure is built anew when its instances move, and carries over to another schedule.
#[test]
fn a_structure_follows_the_scene() {
    let [before, after] = [1, 2].map(|seed| device(&crowd(seed)));
    let rays = rays(&before, RAYS);
    let plain = schedule(&after, RAYS as u64, false);
    let mut oracle = cpu().prepare(plain).expect("prepares");
    give(oracle.as_mut(), &after, &rays);
    let oracle = run(oracle.as_mut());
    for backend in backends() {
        let what = |done| format!("{done} on {}", backend.name());
        let traced = || schedule(&before, RAYS as u64, true);
        let mut exec = backend.prepare(traced()).expect("prepares");
        // Nothing was uploaded, so there is nothing to hit.
        upload(exec.as_mut(), "rays", &rays).expect("uploads");
        upload(exec.as_mut(), "batch", &[batch::args(RAYS as u32)]).expect("uploads");
        let (nothing, _) = run(exec.as_mut());
        assert!(nothing.iter().all(|hit| hit.instance == NONE));
        give(exec.as_mut(), &before, &rays);
        let first = run(exec.as_mut());
        give(exec.as_mut(), &after, &rays);
        let second = run(exec.as_mut());
        assert_ne!(
            bytemuck::cast_slice::<_, u8>(&first.0),
            bytemuck::cast_slice::<_, u8>(&second.0)
        );
        alike(&what("moved"), &oracle, &second);
        exec.adopt(traced()).expect("adopts");
        alike(&what("adopted"), &second, &run(exec.as_mut()));
        let structure = exec.schedule().resource("scene_structure").expect("there");
        let held = exec.read(structure).expect("reads");
        let given = gibs::passes::accel::hardware::instances(&after.tree);
        assert_eq!(held, bytemuck::cast_slice::<_, u8>(&given));
    }
}

/// The same frames come out, within a bound far below the difference between two seeds (`agree`).
#[test]
fn frames_are_those_of_the_software() {
    for name in ["cornell", "glass"] {
        let scene = builtin::by_name(name).expect("built in");
        for backend in backends() {
            let [software, queried] = [false, true].map(|ray_queries| {
                let settings = Settings {
                    ray_queries,
                    ..settings(2000)
                };
                render(backend.as_ref(), &scene, [48, 32], 8, &settings, 0)
            });
            let options = CompareOptions {
                layer: FINAL_IMAGE.into(),
                ..CompareOptions::default()
            };
            let report = compare(&software, &queried, &options).expect("comparable");
            let flip = report.metrics.flip;
            println!("{name} on {}: FLIP {flip:.6}", backend.name());
            assert!(report.passed() && flip < 0.002, "{report}");
        }
    }
}

/// Every stage from equal inputs, the scalar CPU kernels first: what a step alone traces in goes along with it.
#[test]
fn every_stage_agrees_with_the_cpu() {
    let scene = builtin::by_name("glass").expect("built in");
    let settings = Settings {
        ray_queries: true,
        rays: 2000,
        surfels: 512,
        ..Settings::default()
    };
    let frames = vec![0, 2, 5];
    let case = surfels("glass", &scene, [32, 24], frames, &settings).expect("a frame");
    let (oracle, backends) = (cpu(), backends());
    let mut participants = vec![Participant::new(oracle.as_ref())];
    participants.extend(backends.iter().map(|b| Participant::new(b.as_ref())));
    if participants.len() == 1 {
        return;
    }
    let options = CheckOptions::default();
    let checked = check(&mut [case], &participants, &options, |_, _, _| {});
    let report = checked.expect("every backend runs").report;
    let traced = report.cases.iter().flat_map(|case| &case.steps);
    assert!(
        traced
            .filter(|step| step.stage.starts_with("Trace"))
            .count()
            > 2
    );
    for (_, step, port, pair) in report.pairs() {
        let found = format!("{} {}: {pair:?}", step.label, port.port);
        assert!(pair.verdict < Verdict::Expected, "{found}");
    }
}

/// The same words as Vulkan's, through wgpu.
#[cfg(feature = "wgpu")]
#[test]
fn wgpu_takes_the_words_of_vulkan() {
    use gibs_backend_wgpu::{Options, WgpuBackend};
    let scene = device(&crowd(1));
    let rays = rays(&scene, RAYS);
    let options = Options {
        same_spirv: true,
        ..Options::default()
    };
    let backend = match WgpuBackend::new(options) {
        Ok(backend) if backend.capabilities().ray_query => backend,
        Ok(_) if is_strict() => panic!("wgpu has no ray queries"),
        Err(error) if is_strict() => panic!("{error}"),
        _ => return eprintln!("not run: wgpu takes no SPIR-V, or has no ray queries"),
    };
    let [software, queried] = [false, true].map(|ray_queries| {
        let schedule = schedule(&scene, RAYS as u64, ray_queries);
        let mut exec = backend.prepare(schedule).expect("prepares");
        give(exec.as_mut(), &scene, &rays);
        run(exec.as_mut())
    });
    alike("crowd, the same words", &software, &queried);
}

#[test]
fn a_device_without_them_says_what_to_do() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let settings = Settings {
        ray_queries: true,
        ..settings(1000)
    };
    let gi = Gi::new(&scene, &view, [16, 16], &settings, Screen::Traced).expect("made");
    assert!(gi.schedule().to_text().contains("q:scene_structure"));
    let without = NullBackend::with_capabilities(Capabilities::webgpu());
    let refused = without
        .prepare(gi.schedule().clone())
        .err()
        .expect("an error");
    let text = refused.to_string();
    assert!(
        text.contains("no ray queries") && text.contains("ray_queries=off"),
        "{text}"
    );
    // A CPU takes no notice.
    let mut exec = cpu().prepare(gi.schedule().clone()).expect("prepares");
    exec.run().expect("runs");
}
