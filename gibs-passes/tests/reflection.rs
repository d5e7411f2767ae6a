//! Every device kernel against the ports of its stage: needs no device.
use gibs_graph::ShaderCompiler;
use gibs_passes::stages;
use std::collections::BTreeSet;

#[test]
fn every_kernel_matches_its_ports() {
    let compiler = gibs_shaders::Compiler::new();
    let mut problems = Vec::new();
    for stage in stages::all() {
        if let Err(found) = compiler.check(stage.name, &stage.kernel, &stage.ports, &[]) {
            problems.extend(found.iter().map(ToString::to_string));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// A stage file that nobody listed, or a shader without a stage, would escape the check above.
#[test]
fn every_stage_file_is_listed_and_has_a_shader_of_its_name() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/stages");
    let files: BTreeSet<String> = std::fs::read_dir(folder)
        .expect("the stages are there")
        .map(|entry| {
            entry
                .expect("readable")
                .path()
                .file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .filter(|name| name != "mod")
        .collect();
    let listed: BTreeSet<String> = stages::all()
        .iter()
        .map(|stage| stage.kernel.wgsl.name.to_string())
        .collect();
    assert_eq!(files, listed);
}

/// The check can fail: a port with the wrong access is found.
#[test]
fn a_wrong_port_is_found() {
    let mut stage = stages::all().remove(0);
    stage.ports[0].access = gibs_graph::Access::ReadWrite;
    assert!(
        gibs_shaders::Compiler::new()
            .check(stage.name, &stage.kernel, &stage.ports, &[])
            .is_err()
    );
}
