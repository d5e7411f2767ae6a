//! The backends that are measured, of commands that take several.
use crate::backends::{self, BUILT, Choice, NotRun};
use crate::cli::CommandError;
use crate::cli::output::warning;
use gibs_graph::Backend;
use std::str::FromStr;

/// What an option for backends takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chosen {
    /// One.
    One(Choice),
    /// All that the machine has.
    All,
}

impl FromStr for Chosen {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "all" => Ok(Self::All),
            _ => name
                .parse()
                .map(Self::One)
                .map_err(|error: backends::UnknownBackend| format!("{error}, or all of them")),
        }
    }
}

/// The backends, and those that could not be had.
#[derive(Default)]
pub struct Opened {
    pub backends: Vec<Box<dyn Backend>>,
    pub not_run: Vec<NotRun>,
}

/// Opens each backend once that `option` names, in the order in which they were asked for. One that was named has to be there; of `all` the
/// others are left out, with a warning.
pub fn open(option: &'static str, chosen: &[Chosen]) -> Result<Opened, CommandError> {
    let mut opened = Opened::default();
    for each in chosen {
        let (choices, named) = match each {
            Chosen::One(choice) => (vec![*choice], true),
            Chosen::All => (BUILT.to_vec(), false),
        };
        for choice in choices {
            match backends::open(choice) {
                Ok(backend) if opened.has(backend.name()) => {}
                Ok(backend) => opened.backends.push(backend),
                Err(error) if named => return Err(error.into()),
                Err(error) => opened.not_run.push(NotRun {
                    backend: choice.to_string(),
                    reason: error.to_string(),
                }),
            }
        }
    }
    for missing in &opened.not_run {
        warning!("not run: {}: {}", missing.backend, missing.reason);
    }
    match opened.not_run.first() {
        Some(first) if opened.backends.is_empty() => Err(CommandError::Value {
            option,
            value: "all".into(),
            want: format!("none of them is there; {}", first.reason),
        }),
        _ => Ok(opened),
    }
}

impl Opened {
    fn has(&self, name: &str) -> bool {
        self.backends.iter().any(|backend| backend.name() == name)
    }
}
