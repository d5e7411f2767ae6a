//! Parsing and validation with naga. The build script uses this part, too.
use crate::compose::{Composed, Place};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage, Span};
use std::error::Error;
use thiserror::Error;

/// What naga says about a composed text, in terms of the original files.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}{message}{}{}", start(place), snippet(place), notes.iter().map(|n| format!("\n  note: {n}")).collect::<String>())]
pub struct WgslError {
    /// Where, if naga says so.
    pub place: Option<Box<Place>>,
    /// What.
    pub message: String,
    /// Causes and further places.
    pub notes: Vec<String>,
}

fn start(place: &Option<Box<Place>>) -> String {
    place.as_ref().map(|p| format!("{p}: ")).unwrap_or_default()
}

fn snippet(place: &Option<Box<Place>>) -> String {
    place
        .as_ref()
        .map(|p| format!("\n{}", p.snippet()))
        .unwrap_or_default()
}

/// What a kernel may use: what WebGPU guarantees, and what `features` ask for.
///
/// `RAY_QUERY`, `SUBGROUPS` and `F16` are such features; others only decide conditions.
pub fn capabilities(features: &[&str]) -> Capabilities {
    // Packing halves is core WGSL; naga counts it as a capability.
    features
        .iter()
        .fold(Capabilities::SHADER_FLOAT16_IN_FLOAT32, |all, feature| {
            all | match *feature {
                "RAY_QUERY" => Capabilities::RAY_QUERY,
                "SUBGROUPS" => Capabilities::SUBGROUP | Capabilities::SUBGROUP_BARRIER,
                "F16" => Capabilities::SHADER_FLOAT16,
                _ => Capabilities::empty(),
            }
        })
}

/// Parses and validates a composed text.
///
/// # Errors
/// What naga rejects; anything but exactly one entry point, `@compute fn main`.
pub fn validate(
    composed: &Composed,
    capabilities: Capabilities,
) -> Result<(Module, ModuleInfo), WgslError> {
    let mut options = naga::front::wgsl::Options::new();
    options.capabilities = capabilities;
    let module = naga::front::wgsl::Frontend::new_with_options(options)
        .parse(composed.text())
        .map_err(|error| parse_error(composed, &error))?;
    let info = Validator::new(ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| validation_error(composed, &error))?;
    match module.entry_points.as_slice() {
        [only] if only.name == "main" && only.stage == ShaderStage::Compute => Ok((module, info)),
        others => {
            let found: Vec<&str> = others.iter().map(|e| e.name.as_str()).collect();
            let found = if found.is_empty() {
                "none".into()
            } else {
                found.join(", ")
            };
            Err(WgslError {
                place: None,
                message: format!("a kernel has one entry point, `@compute fn main`; found {found}"),
                notes: Vec::new(),
            })
        }
    }
}

fn parse_error(composed: &Composed, error: &naga::front::wgsl::ParseError) -> WgslError {
    let mut labels = error
        .labels()
        .map(|(span, text)| (place(composed, span), text.to_owned()));
    let (place, what) = labels.next().unwrap_or_default();
    let others = labels.map(|(place, text)| match place {
        Some(place) => format!("{place}: {text}"),
        None => text,
    });
    let mut message = error.message().to_owned();
    if !what.is_empty() && what != message {
        message = format!("{message} ({what})");
    }
    WgslError {
        place,
        message,
        notes: others.chain(error.notes().map(str::to_owned)).collect(),
    }
}

fn validation_error(
    composed: &Composed,
    error: &naga::WithSpan<naga::valid::ValidationError>,
) -> WgslError {
    // The first span is the innermost; the texts of spans are names of naga's types.
    let place = error.spans().find_map(|(span, _)| place(composed, *span));
    let causes = std::iter::successors(error.as_inner().source(), |e| (*e).source());
    WgslError {
        place,
        message: error.as_inner().to_string(),
        notes: causes.map(|e| e.to_string()).collect(),
    }
}

fn place(composed: &Composed, span: Span) -> Option<Box<Place>> {
    Some(Box::new(composed.place(span.to_range()?.start)))
}
