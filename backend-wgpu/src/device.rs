//! Which devices there are, and which one to use.
use crate::context::{Context, NAME, Owner};
use crate::passthrough::takes_words;
use gibs_graph::{BackendError, DeviceInfo};
use wgpu::Features;

/// What time per step is measured with, the first at least.
const TIMING: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::TIMESTAMP_QUERY_INSIDE_PASSES);

/// How the backend runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Part of the device's name, in any case; `None` for the fastest kind that there is.
    pub adapter: Option<String>,
    /// Give the driver the SPIR-V words that the Vulkan backend gives it, instead of WGSL, so that a difference
    /// between the two backends is not one between compilers.
    pub same_spirv: bool,
}

/// Every device that wgpu offers, fastest kind first. Empty without a driver.
pub fn devices() -> Vec<DeviceInfo> {
    adapters()
        .iter()
        .map(|a| describe(&a.get_info(), a.features()))
        .collect()
}

/// Opens the device that `options` ask for.
///
/// # Errors
/// [`BackendError::Unavailable`] if there is none, or if it lacks a feature.
pub(crate) fn open(options: &Options) -> Result<Context, BackendError> {
    let adapter = choose(adapters(), options.adapter.as_deref())?;
    let info = describe(&adapter.get_info(), adapter.features());
    let optional = TIMING | Features::EXPERIMENTAL_RAY_QUERY;
    let mut features = optional & adapter.features();
    if options.same_spirv {
        if !takes_words(&adapter) || !adapter.features().contains(Features::PASSTHROUGH_SHADERS) {
            let reason = format!(
                "the device `{}` takes no SPIR-V (wgpu feature PASSTHROUGH_SHADERS, on Vulkan 1.3)",
                info.name
            );
            return Err(unavailable(
                reason,
                "leave out same-spirv, or use a Vulkan device",
            ));
        }
        features |= Features::PASSTHROUGH_SHADERS;
    }
    let request = adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("gibs"),
        required_features: features,
        required_limits: adapter.limits(),
        experimental_features: experimental(features),
        memory_hints: wgpu::MemoryHints::Performance,
        trace: wgpu::Trace::Off,
    });
    let (device, queue) = pollster::block_on(request).map_err(|error| {
        unavailable(
            format!("the device `{}` cannot be opened: {error}", info.name),
            "update its driver, or name another device",
        )
    })?;
    Ok(Context::new(
        info,
        device,
        queue,
        Owner::Gibs,
        options.same_spirv,
    ))
}

/// Leave to use ray queries, where the device has them.
#[allow(unsafe_code)]
fn experimental(features: Features) -> wgpu::ExperimentalFeatures {
    if !features.contains(Features::EXPERIMENTAL_RAY_QUERY) {
        return wgpu::ExperimentalFeatures::disabled();
    }
    // SAFETY: of the experimental features only ray queries are asked for. What wgpu leaves to those who use them is kept:
    // structures are built from buffers of the lengths that were declared, by ranges that the plan was checked against,
    // and kernels initialize a query before they use it, with a ray whose interval is not empty and without numbers that
    // are none.
    unsafe { wgpu::ExperimentalFeatures::enabled() }
}

/// Takes what an engine has.
pub(crate) fn take(info: &wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Context {
    let info = describe(info, device.features());
    Context::new(info, device, queue, Owner::Engine, false)
}

fn unavailable(reason: String, remedy: &str) -> BackendError {
    BackendError::Unavailable {
        backend: NAME.into(),
        reason,
        remedy: remedy.into(),
    }
}

/// Everything that can compute, fastest kind first; ties as the driver lists them.
fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // The layers' checks only where the environment asks for them (WGPU_VALIDATION), also in debug builds.
    descriptor.flags = wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL.with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    found.retain(|a| {
        a.get_downlevel_capabilities()
            .flags
            .contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
    });
    found.sort_by_key(|a| rank(a.get_info().device_type));
    found
}

fn choose(adapters: Vec<wgpu::Adapter>, name: Option<&str>) -> Result<wgpu::Adapter, BackendError> {
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    let chosen = position(&names, name).and_then(|i| adapters.into_iter().nth(i));
    chosen.ok_or_else(|| match name {
        Some(name) if !names.is_empty() => unavailable(
            format!("no device is called `{name}`"),
            &format!("choose one of: {}", names.join(", ")),
        ),
        _ => unavailable(
            "no device and driver were found".into(),
            "install a Vulkan driver, for example the Debian package mesa-vulkan-drivers",
        ),
    })
}

/// The first name that has `wanted` in it.
fn position(names: &[String], wanted: Option<&str>) -> Option<usize> {
    let wanted = wanted.unwrap_or_default().to_lowercase();
    names
        .iter()
        .position(|name| name.to_lowercase().contains(&wanted))
}

fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn describe(info: &wgpu::AdapterInfo, features: Features) -> DeviceInfo {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => "virtual",
        wgpu::DeviceType::Cpu => "software",
    };
    let mut notes = vec![format!("through {}", info.backend)];
    if info.subgroup_min_size == info.subgroup_max_size {
        notes.push(format!("subgroups of {}", info.subgroup_min_size));
    } else {
        notes.push(format!(
            "subgroups of {} to {}",
            info.subgroup_min_size, info.subgroup_max_size
        ));
    }
    if features.contains(Features::PASSTHROUGH_SHADERS) {
        notes.push("takes SPIR-V".into());
    }
    DeviceInfo {
        name: info.name.clone(),
        driver: format!("{} {}", info.driver, info.driver_info)
            .trim()
            .into(),
        kind: kind.into(),
        timestamps: features.contains(Features::TIMESTAMP_QUERY),
        ray_query: features.contains(Features::EXPERIMENTAL_RAY_QUERY),
        notes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn software_comes_last() {
        use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu, Other, VirtualGpu};
        let mut kinds = [Cpu, Other, VirtualGpu, IntegratedGpu, DiscreteGpu];
        kinds.sort_by_key(|&kind| rank(kind));
        assert_eq!(kinds, [DiscreteGpu, IntegratedGpu, VirtualGpu, Other, Cpu]);
    }

    #[test]
    fn a_name_is_found_in_any_case() {
        let names = ["GeForce RTX".to_string(), "llvmpipe (LLVM)".to_string()];
        assert_eq!(position(&names, Some("LLVMpipe")), Some(1));
        assert_eq!(position(&names, None), Some(0));
        assert_eq!(position(&names, Some("radeon")), None);
        assert_eq!(position(&[], None), None);
    }

    #[test]
    fn without_a_driver_the_error_says_what_to_install() {
        let error = choose(Vec::new(), None).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("mesa-vulkan-drivers"), "{error}");
    }
}
