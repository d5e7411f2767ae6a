//! `gibs devices`: what this machine offers.
use super::CommandError;
use super::output::say;
use crate::backends::{self, BUILT};
use gibs_graph::DeviceInfo;
use serde::Serialize;

/// List the backends and devices of this machine
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Entry {
    backend: String,
    devices: Vec<DeviceInfo>,
    missing: Option<String>,
}

fn entry(choice: backends::Choice) -> Entry {
    let backend = choice.to_string();
    let devices = match choice {
        #[cfg(feature = "wgpu")]
        backends::Choice::Wgpu => gibs_backend_wgpu::devices(),
        #[cfg(feature = "vulkan")]
        backends::Choice::Vulkan => {
            gibs_backend_vulkan::VulkanBackend::devices().unwrap_or_default()
        }
        _ => Vec::new(),
    };
    if !devices.is_empty() {
        return Entry {
            backend,
            devices,
            missing: None,
        };
    }
    match backends::open(choice) {
        Ok(opened) => Entry {
            backend,
            devices: vec![opened.device().clone()],
            missing: None,
        },
        Err(error) => Entry {
            backend,
            devices,
            missing: Some(error.to_string()),
        },
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let entries: Vec<Entry> = BUILT.iter().map(|&choice| entry(choice)).collect();
    if args.json {
        say!(
            "{}",
            serde_json::to_string_pretty(&entries).unwrap_or_default()
        );
        return Ok(());
    }
    for entry in &entries {
        for device in &entry.devices {
            say!(
                "{:<7} {} ({}, {})",
                entry.backend,
                device.name,
                device.kind,
                device.driver
            );
            for note in &device.notes {
                say!("        {note}");
            }
        }
        if let Some(missing) = &entry.missing {
            say!("{:<7} not available: {missing}", entry.backend);
        }
    }
    match backends::open(backends::Choice::Auto) {
        Ok(best) => say!("auto picks {} on {}", best.name(), best.device().name),
        Err(error) => say!("auto finds nothing: {error}"),
    }
    Ok(())
}
