//! The list of known differences.
use super::participants::WAYS;
use crate::check::{Expectation, Expectations};
use crate::cli::CommandError;
use gibs_passes::stages;
use std::path::Path;

/// Reads the list.
///
/// # Errors
/// Where it cannot be read, or names what there is not.
pub fn load(file: &Path) -> Result<Expectations, CommandError> {
    let wrong = |problem: String| {
        CommandError::CheckKit(crate::check::CheckError::Expectations {
            file: file.into(),
            problem,
        })
    };
    let text = crate::files::read_text(file).map_err(|e| wrong(e.to_string()))?;
    let expectations: Expectations = toml::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    for expectation in &expectations.expected {
        if let Some(problem) = problem_with(expectation) {
            return Err(wrong(problem));
        }
    }
    Ok(expectations)
}

/// What could never come, or would excuse everything.
fn problem_with(expectation: &Expectation) -> Option<String> {
    let said = [
        ("device", &expectation.device),
        ("reason", &expectation.reason),
    ];
    if let Some((name, _)) = said.iter().find(|(_, text)| text.trim().is_empty()) {
        return Some(format!("`{name}` is empty"));
    }
    if let Some(backend) = &expectation.backend
        && !WAYS.iter().any(|(name, _)| name == backend)
    {
        let names = WAYS.map(|(name, _)| name).join(", ");
        return Some(format!(
            "no participant is called `{backend}`: choose of {names}"
        ));
    }
    let stages = stages::all();
    let Some(stage) = stages.iter().find(|stage| stage.name == expectation.stage) else {
        return Some(format!(
            "no stage has the type name `{}`; reports show it beside each step, such as `TraceClosest`",
            expectation.stage
        ));
    };
    let written = stage.ports.iter().filter(|port| port.access.writes());
    let written: Vec<_> = written.map(|port| port.name).collect();
    match &expectation.port {
        Some(port) if !written.contains(&port.as_str()) => Some(format!(
            "`{}` writes no port `{port}`, but {}",
            stage.name,
            written.join(", ")
        )),
        _ => None,
    }
}
