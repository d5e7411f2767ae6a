//! Schedules as DOT, JSON and text.
mod common;

use common::*;
use gibs_graph::{Dispatch, Graph, Initial, Schedule};

/// A frame with a clear, a barrier, an indirect dispatch, a state, a dead stage, and names that need escaping.
fn schedule() -> Schedule {
    let mut g = Graph::new("a \"frame\"");
    let source = g.input("source", LEN);
    let counts = g.zeroed("counts \\ \"odd\"", LEN);
    let args = g.input("args", 1);
    let (state, value) = g.state("value", LEN, Initial::Zero);
    let counts = g
        .add::<tally::Tally>(
            "count/first",
            tally::Inputs {
                source: &source,
                target: counts,
            },
            all(),
        )
        .target;
    let inputs = pass::Inputs {
        source: &counts,
        target: value,
    };
    let value = g
        .add::<pass::Pass>("draw/\"copy\"", inputs, Dispatch::Indirect(&args))
        .target;
    let dead = g.transient("dead", LEN);
    let _ = g.add::<pass::Pass>(
        "draw/dead",
        pass::Inputs {
            source: &value,
            target: dead,
        },
        all(),
    );
    g.output("value", &value);
    g.keep(state, value);
    g.compile(None).unwrap()
}

/// The tokens of DOT: words, strings (unescaped, with a mark before them) and signs. Fails on a string without an end.
fn tokens(dot: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut chars = dot.chars().peekable();
    while let Some(c) = chars.next() {
        if c.is_whitespace() {
            continue;
        }
        let mut token = String::from(c);
        if c == '"' {
            loop {
                match chars.next().expect("an end of the string") {
                    '"' => break,
                    '\\' => token.push(chars.next().expect("an escaped character")),
                    c => token.push(c),
                }
            }
        } else if c.is_alphanumeric() {
            while let Some(c) = chars.next_if(|c| c.is_alphanumeric() || *c == '_') {
                token.push(c);
            }
        }
        tokens.push(token);
    }
    tokens
}

#[test]
fn dot_has_every_live_stage_once_and_every_edge() {
    let schedule = schedule();
    let tokens = tokens(&schedule.to_dot());
    let count = |wanted: &str| tokens.iter().filter(|token| *token == wanted).count();
    assert_eq!(tokens[..3], ["digraph", "\"a \"frame\"", "{"]);
    assert_eq!(count("{"), count("}"));
    assert_eq!(
        labels(&schedule),
        ["clear counts \\ \"odd\"", "count/first", "draw/\"copy\""]
    );
    for label in labels(&schedule) {
        assert_eq!(count(&format!("\"{label}")), 1, "{label}");
    }
    assert_eq!(count("\"draw/dead"), 0);
    // Groups, and one for what has none.
    assert_eq!(count("subgraph"), 3);
    assert_eq!(count("\"count"), 1);
    assert_eq!(count("\"draw"), 1);
    // Both edges are of the counts: clear to count, count to copy.
    assert_eq!(schedule.edges.len(), 2);
    assert_eq!(count("\"counts \\ \"odd\""), 2);
    for (from, to, _) in &schedule.edges {
        let (from, to) = (format!("s{from}"), format!("s{to}"));
        assert!(
            tokens.windows(4).any(|w| w == [&from, "-", ">", &to]),
            "{from} -> {to}"
        );
    }
}

#[test]
fn json_parses_and_says_everything() {
    let schedule = schedule();
    let json: serde_json::Value = serde_json::from_str(&schedule.to_json().unwrap()).unwrap();
    assert_eq!(json["name"], "a \"frame\"");
    let steps = json["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[1]["label"], "count/first");
    assert_eq!(
        steps[0]["action"]["Clear"],
        schedule.resource("counts \\ \"odd\"").unwrap()
    );
    let copy = &steps[2]["action"]["Dispatch"];
    assert_eq!(copy["stage"], "Pass");
    assert_eq!(copy["size"]["Indirect"], schedule.resource("args").unwrap());
    assert_eq!(copy["bindings"][0]["access"], "Read");
    assert_eq!(
        copy["bindings"][1]["resource"],
        schedule.resource("value").unwrap()
    );
    assert_eq!(copy["ports"][0]["element"]["Scalar"], "U32");
    assert_eq!(steps[2]["hazards"][0]["kind"], "ReadAfterWrite");
    assert_eq!(
        json["resources"].as_array().unwrap().len(),
        schedule.resources.len()
    );
    let value = &json["resources"][schedule.resource("value").unwrap() as usize];
    assert_eq!(
        (&value["kind"]["State"], &value["bytes"]),
        (&"Zero".into(), &400.into())
    );
    assert_eq!(json["removed"], serde_json::json!(["draw/dead"]));
    assert_eq!(
        json["outputs"],
        serde_json::json!([{ "name": "value", "resource": schedule.output("value") }])
    );
    assert_eq!(json["edges"].as_array().unwrap().len(), 2);
}

#[test]
fn text_has_a_line_per_step() {
    let schedule = schedule();
    let text = schedule.to_text();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 3 + 1);
    assert_eq!(
        lines[0],
        "a \"frame\": 3 steps (2 dispatches), 2 barriers, 4 resources, 0.0 MB (0.0 MB saved by sharing)"
    );
    let words = |line: usize| lines[line].split_whitespace().collect::<Vec<_>>();
    assert_eq!(words(1)[..2], ["0", "clear"]);
    assert_eq!(
        words(2),
        [
            "1",
            "|",
            "count/first",
            "2x1x1",
            "r:source",
            "a:counts",
            "\\",
            "\"odd\""
        ]
    );
    assert_eq!(words(3)[..4], ["2", "|", "draw/\"copy\"", "args"]);
    assert_eq!(words(3).last(), Some(&"w:value"));
    assert_eq!(lines[4].trim(), "removed: draw/dead (nothing needs it)");
}
