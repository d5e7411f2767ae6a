use super::*;
use crate::compare::Metrics;
use gibs_passes::frame::{ELEMENTS, Settings};

#[test]
fn every_element_is_switched_once() {
    let settings = Settings::default();
    let all = configurations(&settings, &Configuration::elements());
    assert_eq!(all.len(), ELEMENTS.len() + 3);
    assert_eq!(all[0].name, "defaults");
    for (element, configuration) in ELEMENTS.iter().zip(&all[1..]) {
        let own = &configuration.settings;
        assert_ne!(element.is_on(own), element.is_on(&settings), "{element:?}");
        let back = element.switched(own, element.is_on(&settings));
        assert_eq!(back, settings, "{element:?} changes something else");
        let word = if element.is_on(own) {
            "with"
        } else {
            "without"
        };
        assert_eq!(configuration.name, format!("{word} {}", element.name));
    }
    let rays: Vec<u32> = all[ELEMENTS.len() + 1..]
        .iter()
        .map(|c| c.settings.rays)
        .collect();
    assert_eq!(rays, [25_000, 400_000]);
    let most = Settings {
        rays: 4_000_000,
        ..Settings::default()
    };
    for configuration in configurations(&most, &[]) {
        configuration.settings.check().expect("within the range");
    }
}

#[test]
fn powers_of_two_are_measured_on_the_way() {
    assert_eq!(checkpoints(&[1]), [(1, true)]);
    assert_eq!(
        checkpoints(&[12, 4]),
        [(1, false), (2, false), (4, true), (8, false), (12, true)]
    );
}

#[test]
fn means_and_spreads_are_those_of_the_values() {
    let one = Mean::of([3.0].into_iter());
    assert_eq!((one.mean, one.standard_error), (3.0, None));
    // Variance 4, of four values: standard error 1.
    let four = Mean::of([1.0, 5.0, 3.0, 3.0].into_iter());
    assert_eq!(four.mean, 3.0);
    let error = four.standard_error.expect("of four");
    assert!((error - (8.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
    let spread = Spread::of((0..=10).rev().map(f64::from));
    assert_eq!((spread.low, spread.median, spread.high), (1.0, 5.0, 9.0));
    let two = Spread::of([4.0, 2.0].into_iter());
    assert_eq!((two.low, two.median, two.high), (2.2, 3.0, 3.8));
    assert!(Spread::of([].into_iter()).median.is_nan());
}

fn rows() -> Vec<Row> {
    let metrics = |scale: f64| Metrics {
        rel_mse: 0.0363 * scale,
        rmse: 0.0,
        mape: 0.0971 * scale,
        bias: -0.0028 * scale,
        p99: 0.4 * scale,
        block_error: 0.0,
        blocks: 1,
        flip: 0.05 * scale,
    };
    let after = |frames, asked| After {
        frames,
        asked,
        errors: Errors::of([metrics(0.99), metrics(1.01)].into_iter()),
        rays: 109_876.4,
        milliseconds: 131.26,
        ratio: Spread {
            low: 0.9,
            median: 1.0,
            high: 1.25,
        },
    };
    let row = |name: &str| Row {
        name: name.into(),
        about: String::new(),
        after: vec![after(8, false), after(16, true)],
    };
    vec![row("defaults"), row("without depth")]
}

#[test]
fn tables_are_markdown_with_standard_errors() {
    let text = table(&rows());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4, "frames that were asked for only: {text}");
    assert_eq!(
        lines[2],
        "| defaults | 0.0363 ± 0.0004 | 9.71 ± 0.10 % | -0.280 ± 0.003 % | 0.400 ± 0.004 | 0.0500 ± 0.0005 | 109876 | 131 | \
         1.00 (0.90 .. 1.25) |"
    );
    let columns = |line: &str| line.matches('|').count();
    assert!(lines.iter().all(|line| columns(line) == columns(lines[0])));
}

#[test]
fn csv_has_a_line_for_everything() {
    let rows = rows();
    let text = csv([("a \"quoted\" name", rows.as_slice())].into_iter());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 2 * 2);
    assert!(lines[1].starts_with("\"a \"\"quoted\"\" name\",\"defaults\",8,"));
    let fields = |line: &str| line.matches(',').count();
    assert!(lines.iter().all(|line| fields(line) == fields(lines[0])));
}

#[test]
fn plots_name_every_configuration() {
    let svg = plot("cornell", &rows());
    for text in ["cornell", "defaults", "without depth", "frames from"] {
        assert!(svg.contains(text), "{text}");
    }
}
