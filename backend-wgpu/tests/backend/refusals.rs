//! Limits, broken kernels, and kernels as SPIR-V.
use super::*;

#[test]
fn a_limit_names_the_resource() {
    let Some(backend) = backend() else { return };
    let len = backend.capabilities().storage_binding / 4 + 1;
    let Err(error) = backend.prepare(doubling(len)) else {
        panic!("{len} elements were accepted")
    };
    assert!(
        matches!(&error, BackendError::Limit { what, need, .. }
        if what.contains("`numbers`") && *need == 4 * len),
        "{error}"
    );
}

#[test]
fn a_broken_kernel_names_the_stage() {
    let Some(backend) = backend() else { return };
    let errors =
        [
            refusal::<broken::syntax::Syntax>(&backend, |numbers, doubled| {
                broken::syntax::Inputs { numbers, doubled }
            }),
            refusal::<broken::unnamed::Unnamed>(&backend, |numbers, doubled| {
                broken::unnamed::Inputs { numbers, doubled }
            }),
            refusal::<broken::refused::Refused>(&backend, |numbers, doubled| {
                broken::refused::Inputs { numbers, doubled }
            }),
        ];
    for (error, word) in errors.iter().zip(["expected", "doubled", "refused"]) {
        assert!(
            matches!(error, BackendError::Kernel { stage, message } if stage == "bad" && message.contains(word)),
            "{error}"
        );
    }
    let mut run = backend.prepare(doubling(1)).unwrap();
    run.run().unwrap();
    run.wait().unwrap();
}

/// What preparing a stage called `bad`, with one port to read and one to write, fails with.
fn refusal<S>(
    backend: &WgpuBackend,
    inputs: impl for<'g> Fn(&'g gibs_graph::Buffer<u32>, gibs_graph::Buffer<u32>) -> S::Inputs<'g>,
) -> BackendError
where
    S: gibs_graph::Stage,
    S::Outputs: Doubled,
{
    let mut g = Graph::new("broken");
    let numbers = g.input::<u32>("numbers", 4);
    let doubled = g.transient::<u32>("doubled", 4);
    let out = g.add::<S>("bad", inputs(&numbers, doubled), Dispatch::Elements(4));
    g.output("doubled", out.doubled());
    match backend.prepare(compile(g)) {
        Ok(_) => panic!("{} was accepted", S::NAME),
        Err(error) => error,
    }
}

#[test]
fn spirv_gives_what_wgsl_gives() {
    let Some(wgsl) = backend() else { return };
    let spirv = match WgpuBackend::new(Options {
        same_spirv: true,
        ..Options::default()
    }) {
        Ok(spirv) => spirv,
        Err(error) => {
            assert!(error.to_string().contains("PASSTHROUGH_SHADERS"), "{error}");
            return;
        }
    };
    for backend in [wgsl, spirv] {
        let mut run = backend.prepare(counting(100)).unwrap();
        upload(&mut *run, "numbers", &[3; 100]);
        run.run().unwrap();
        assert_eq!(read(&mut *run, "marks"), [1; 100]);
        let mut run = backend.prepare(aging(3, 3)).unwrap();
        upload(&mut *run, "amount", &[2; 4]);
        run.run().unwrap();
        run.run().unwrap();
        assert_eq!(
            (read(&mut *run, "totals"), read(&mut *run, "ages")),
            (vec![9; 3], vec![7; 3])
        );
    }
}
