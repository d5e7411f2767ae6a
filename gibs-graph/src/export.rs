//! A schedule as DOT, JSON and text.
use crate::step::{Action, DispatchSize};
use crate::{Access, Schedule};
use std::collections::HashMap;
use std::fmt::Write;

impl Schedule {
    /// Graphviz DOT: stages in clusters by group, edges named by resource.
    pub fn to_dot(&self) -> String {
        let mut dot = format!(
            "digraph {} {{\n  rankdir=TB;\n  node [shape=box, style=rounded];\n",
            quoted(&self.name)
        );
        let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
        let mut place = HashMap::new();
        for (i, step) in self.steps.iter().enumerate() {
            let n = *place.entry(step.group()).or_insert(groups.len());
            if n == groups.len() {
                groups.push((step.group(), Vec::new()));
            }
            groups[n].1.push(i);
        }
        for (n, (group, steps)) in groups.iter().enumerate() {
            let _ = writeln!(
                dot,
                "  subgraph cluster_{n} {{\n    label={};",
                quoted(group)
            );
            for &i in steps {
                let _ = writeln!(dot, "    s{i} [label={}];", quoted(&self.steps[i].label));
            }
            dot.push_str("  }\n");
        }
        for &(from, to, resource) in &self.edges {
            let key = quoted(&self.resources[resource as usize].key);
            let _ = writeln!(dot, "  s{from} -> s{to} [label={key}];");
        }
        dot.push_str("}\n");
        dot
    }

    /// The whole schedule as JSON.
    ///
    /// # Errors
    /// None in practice: every part is plain data.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }

    /// One line per step, with bindings and barriers.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}: {} steps ({} dispatches), {} barriers, {} resources, {:.1} MB ({:.1} MB saved by sharing)\n",
            self.name,
            self.steps.len(),
            self.dispatches().count(),
            self.barriers(),
            self.resources.len(),
            self.bytes(false) as f64 / 1e6,
            self.shared_bytes() as f64 / 1e6
        );
        for (i, step) in self.steps.iter().enumerate() {
            let barrier = if step.hazards.is_empty() { ' ' } else { '|' };
            let _ = write!(text, "{i:3} {barrier} {:<40}", step.label);
            if let Action::Dispatch(dispatch) = &step.action {
                let _ = match dispatch.size {
                    DispatchSize::Groups([x, y, z]) => {
                        write!(text, " {:>12}", format!("{x}x{y}x{z}"))
                    }
                    DispatchSize::Indirect(r) => {
                        write!(text, " {:>12}", self.resources[r as usize].key)
                    }
                };
                for binding in &dispatch.bindings {
                    let mark = match binding.access {
                        Access::Uniform => "u",
                        Access::Read => "r",
                        Access::Write => "w",
                        Access::ReadWrite => "rw",
                        Access::Atomic => "a",
                        Access::Previous => "p",
                        Access::HostOnly => "h",
                        Access::Acceleration => "q",
                        Access::Sampled => "s",
                        Access::Stored => "st",
                        Access::Indirect => "i",
                    };
                    let _ = write!(
                        text,
                        " {mark}:{}",
                        self.resources[binding.resource as usize].key
                    );
                }
            }
            text.push('\n');
        }
        for label in &self.removed {
            let _ = writeln!(text, "    removed: {label} (nothing needs it)");
        }
        text
    }
}

/// A DOT string. A backslash begins an escape there.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
