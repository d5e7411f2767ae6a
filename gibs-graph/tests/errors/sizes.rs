//! Sizes that there are not.
use super::*;

#[test]
fn an_initial_value_of_the_wrong_size() {
    let mut g = Graph::new("test");
    let (state, value) = g.state::<u32>("ages", LEN, Initial::fill([1_u32, 2]));
    g.keep(state, value);
    let want = "state `ages`: its initial value has 8 bytes, an element has 4; make it with Initial::fill from one element";
    assert_eq!(messages(g), [want]);
}

#[test]
fn too_many_workgroups() {
    let compile = |size: Dispatch<'_>| {
        let mut g = Graph::new("test");
        let source = g.input("source", LEN);
        let target = g.transient("target", LEN);
        let made = g.add::<pass::Pass>(
            "fill",
            pass::Inputs {
                source: &source,
                target,
            },
            size,
        );
        g.output("result", &made.target);
        g.compile(None).map_err(|errors| errors.errors)
    };
    let groups = [1, MAX_GROUPS + 1, 1];
    let error = compile(Dispatch::Groups(groups)).unwrap_err();
    assert_eq!(
        error,
        [GraphError::DispatchSize {
            stage: "fill".into(),
            groups
        }]
    );
    let want = "stage `fill` asks for [1, 65536, 1] workgroups; at most 65535 along each axis and 2^32 - 1 in all; use \
                Dispatch::Elements, which folds them, or larger workgroups";
    assert_eq!(error[0].to_string(), want);
    // Short enough along each axis, but the last workgroups have no number.
    assert!(compile(Dispatch::Groups([MAX_GROUPS, MAX_GROUPS, 2])).is_err());
    assert!(compile(Dispatch::Groups([MAX_GROUPS, MAX_GROUPS, 1])).is_ok());
    // Folded, and more invocations than 32 bits number, those that fill the last row included.
    let most = u64::from(MAX_GROUPS) * 1024 * 64;
    assert!(compile(Dispatch::Elements(most)).is_ok());
    for count in [most + 1, u32::MAX.into(), 1 << 32, 1 << 33, u64::MAX] {
        let errors = compile(Dispatch::Elements(count)).unwrap_err();
        let want = format!(
            "stage `fill` asks for {count} invocations; kernels number them in 32 bits, those that fill up the last row \
             of workgroups included; have each do several elements, or split the stage"
        );
        assert_eq!(errors[0].to_string(), want);
        assert_eq!(errors.len(), 1);
    }
}

#[test]
fn workgroups_that_webgpu_does_not_guarantee() {
    for (size, compiled) in sized::all() {
        let fits = [[256, 1, 1], [2, 2, 64]].contains(&size);
        let said = compiled.map(drop).map_err(|errors| errors.to_string());
        let want = format!(
            "the graph `test` cannot be compiled:\n  - stage `fill` has workgroups of {size:?} invocations; give it at \
             least 1 along each axis, at most 64 along z and 256 in all"
        );
        assert_eq!(said, if fits { Ok(()) } else { Err(want) });
    }
}

#[test]
fn a_uniform_of_a_size_that_wgsl_refuses() {
    let mut g = Graph::new("test");
    let config = g.input("config", 1);
    let target = g.transient("target", LEN);
    let made = g.add::<small::Small>(
        "draw",
        small::Inputs {
            config: &config,
            target,
        },
        all(),
    );
    g.output("result", &made.target);
    let want = "stage `draw`, port `config`: `u32` has 4 bytes; a uniform has a multiple of 16, at most 65536; pad the \
                struct or bind it as read";
    assert_eq!(messages(g), [want]);
}
