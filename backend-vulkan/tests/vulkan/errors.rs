//! What is refused, and how it is said.
use crate::stages::*;
use crate::support::{compile, watched};
use gibs_backend_vulkan::{Options, VulkanBackend};
use gibs_graph::{Backend, BackendError, Dispatch, Graph};
use std::process::Command;

#[test]
fn a_broken_kernel_names_its_stage() {
    watched(|backend| {
        let mut g = Graph::new("broken");
        let source = g.input("source", 4);
        let target_ = g.transient("target", 4);
        let inputs = broken::Inputs {
            source: &source,
            target_,
        };
        let out = g.add::<broken::Broken>("group/broken", inputs, Dispatch::Elements(4));
        g.output("target", &out.target_);
        let error = backend.prepare(compile(g)).err().unwrap();
        let BackendError::Kernel { stage, message } = &error else {
            panic!("{error}")
        };
        assert_eq!(stage, "group/broken");
        assert!(!message.is_empty());
    });
}

#[test]
fn a_port_without_a_binding_is_named() {
    watched(|backend| {
        let mut g = Graph::new("unbound");
        let source = g.input("source", 4);
        let target_ = g.transient("target", 4);
        let inputs = unbound::Inputs {
            source: &source,
            target_,
        };
        let out = g.add::<unbound::Unbound>("unbound", inputs, Dispatch::Elements(4));
        g.output("target", &out.target_);
        let error = backend.prepare(compile(g)).err().unwrap();
        assert!(matches!(error, BackendError::Kernel { .. }), "{error}");
        assert!(error.to_string().contains("`target_`"), "{error}");
    });
}

#[test]
fn a_resource_beyond_the_limit_is_named() {
    watched(|backend| {
        let len = backend.capabilities().storage_binding / 4 + 1;
        let mut g = Graph::new("large");
        let source = g.input("huge/source", len);
        let target_ = g.transient("target", 4);
        let inputs = double::Inputs {
            source: &source,
            target_,
        };
        let out = g.add::<double::Double>("double", inputs, Dispatch::Elements(4));
        g.output("target", &out.target_);
        let error = backend.prepare(compile(g)).err().unwrap();
        let BackendError::Limit {
            what, need, limit, ..
        } = &error
        else {
            panic!("{error}")
        };
        assert!(what.contains("huge/source"), "{error}");
        assert!(*need == 4 * len && *limit < *need, "{error}");
    });
}

#[test]
fn a_device_is_chosen_by_its_name() {
    watched(|backend| {
        let name = backend.device().name.clone();
        let listed = VulkanBackend::devices().unwrap();
        assert!(listed.iter().any(|d| d.name == name), "{listed:?}");
        let part = name.split_whitespace().next().unwrap().to_uppercase();
        let same = VulkanBackend::new(Options {
            device: Some(part),
            ..Options::default()
        })
        .unwrap();
        assert_eq!(same.device().name, name);

        let wanted = Some("no such device".to_string());
        let error = VulkanBackend::new(Options {
            device: wanted,
            ..Options::default()
        })
        .unwrap_err();
        assert!(matches!(error, BackendError::Unavailable { .. }), "{error}");
        let said = error.to_string();
        assert!(
            said.contains("no such device") && said.contains(&name),
            "{said}"
        );
    });
}

/// Runs the ignored test `name` of this file in a process of its own, where `variables` hide something.
fn run_alone(name: &str, variables: &[&str]) {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "--ignored", name]);
    for variable in variables {
        child.env(variable, "/nonexistent");
    }
    let output = child.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && said.contains("1 passed"),
        "{said}"
    );
}

#[test]
fn without_a_driver_it_says_what_to_install() {
    run_alone(
        "errors::no_driver",
        &["VK_DRIVER_FILES", "VK_ICD_FILENAMES"],
    );
}

#[test]
#[ignore = "part of without_a_driver_it_says_what_to_install"]
fn no_driver() {
    let error = VulkanBackend::new(Options::default()).unwrap_err();
    assert!(matches!(error, BackendError::Unavailable { .. }), "{error}");
    assert!(error.to_string().contains("mesa-vulkan-drivers"), "{error}");
}

#[test]
fn without_the_layer_it_says_what_to_install() {
    watched(|_| run_alone("errors::no_layer", &["VK_LAYER_PATH"]));
}

#[test]
#[ignore = "part of without_the_layer_it_says_what_to_install"]
fn no_layer() {
    VulkanBackend::new(Options::default()).unwrap();
    let error = VulkanBackend::new(Options {
        validation: true,
        ..Options::default()
    })
    .unwrap_err();
    assert!(matches!(error, BackendError::Unavailable { .. }), "{error}");
    assert!(
        error.to_string().contains("vulkan-validationlayers"),
        "{error}"
    );
}
