use super::*;
use crate::bench::{After, Errors, Kind, Look, Mean, Shot, Spread};
use crate::compare::{MaskCounts, Metrics};
use crate::picture::Picture;

fn mean(value: f64) -> Mean {
    Mean::of([0.99 * value, 1.01 * value].into_iter())
}

fn measured() -> Measured {
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
    let after = |frames: u32, asked| After {
        frames,
        asked,
        errors: Errors::of([metrics(0.99), metrics(1.01)].into_iter()),
        mape_ratio: mean(1.5),
        rays: 109_876.4,
        total_rays: 109_876.4 * f64::from(frames),
        milliseconds: 131.26,
        seconds: mean(0.131 * f64::from(frames)),
        ratio: Spread {
            low: 0.9,
            median: 1.0,
            high: 1.25,
        },
        taken: None,
        pareto: frames == 16,
    };
    let row = |name: &str, kind| Row {
        name: name.into(),
        about: String::new(),
        kind,
        after: vec![after(8, false), after(16, true)],
    };
    let equal = |metric, reached: bool| EqualError {
        baseline: "path tracing".into(),
        frames: 16,
        metric,
        error: mean(0.0363),
        unreached: u32::from(!reached),
        fewer: 0,
        samples: mean(412.0),
        rays: mean(1.6e8),
        seconds: mean(37.7),
        times: mean(18.0),
    };
    let mut picture = Picture::new(4, 2);
    let plane = || vec![0.5; 8];
    let set = picture.set_rgb("", [plane(), plane(), plane()]);
    set.expect("eight values");
    let shot = Shot {
        name: "defaults".into(),
        frames: 16,
        picture: picture.clone(),
        heat: image::RgbImage::new(4, 2),
        mape: 0.0971,
    };
    Measured {
        scene: "a \"quoted\" <name>".into(),
        backend: "cpu".into(),
        device: "a device".into(),
        driver: "a driver".into(),
        size: [4, 2],
        rays: 100_000,
        seeds: 2,
        view: serde_json::Value::Null,
        settings: Default::default(),
        truth: AboutTruth {
            file: None,
            mask: MaskCounts {
                pixels: 8,
                valid: 7,
                missed: 0,
                blended: 0,
                fireflies: 1,
            },
            elsewhere: None,
            step: 1,
            samples: Some(64),
            standard_error: Some(0.01),
            noise: None,
        },
        rows: vec![
            row("defaults", Kind::Settings),
            row("without depth", Kind::Element),
            row("path tracing, equal rays", Kind::EqualRays),
            row("path tracing, equal time", Kind::EqualTime),
        ],
        same_as_path_tracing: Vec::new(),
        equal_error: vec![equal("rel_mse", true), equal("mape", false)],
        exposure: 1.0,
        pictures: Pictures {
            look: Some(Look {
                picture,
                samples: Some(64),
                warning: None,
            }),
            shots: vec![shot],
        },
    }
}

fn report(measured: Measured) -> BenchReport {
    BenchReport {
        command: "gibs bench 'a <b>'".into(),
        machine: Machine::here(),
        not_run: vec![NotRun {
            backend: "vulkan".into(),
            reason: "no <driver>".into(),
        }],
        failed: vec![Failed {
            scene: "a <scene>".into(),
            backend: None,
            reason: "it is <dark>".into(),
        }],
        measured: vec![measured],
    }
}

fn same_columns(lines: &[&str], separator: char) {
    let columns = |line: &str| line.matches(separator).count();
    assert!(
        lines.iter().all(|line| columns(line) == columns(lines[0])),
        "{lines:?}"
    );
}

#[test]
fn the_heading_says_what_errors_are_against() {
    let mut measured = measured();
    assert_eq!(
        heading(&measured),
        "a \"quoted\" <name> on cpu (a device): 4x2, 100000 rays a frame, 2 seeds; truth of every pixel, 64 samples, standard error \
         1.0 % per pixel; errors are of 7 pixels, 1 left out (fireflies)"
    );
    measured.truth = AboutTruth {
        file: Some("ref.exr".into()),
        step: 3,
        samples: None,
        standard_error: None,
        elsewhere: Some(5),
        ..measured.truth
    };
    measured.same_as_path_tracing = vec!["brute force".into()];
    let text = heading(&measured);
    let part = "truth ref.exr of one of 9 pixels; its noise is not known; errors are of 7 pixels, 1 left out \
                (fireflies); 5 show another surface in the truth: is it of this scene and view?; brute force is path tracing here";
    assert!(text.contains(part), "{text}");
    measured.truth.noise = Some(Metrics {
        rel_mse: 0.0091,
        mape: 0.0554,
        bias: 0.0,
        rmse: 0.0,
        p99: 0.0,
        block_error: 0.0,
        blocks: 1,
        flip: 0.0,
    });
    let text = heading(&measured);
    let noise =
        "of whose noise alone a picture without errors has relMSE 0.0091, MAPE 5.5 %; errors";
    assert!(text.contains(noise), "{text}");
    assert!(html(&report(measured)).contains("the same</tr>"));
}

#[test]
fn tables_are_markdown_with_confidence_intervals() {
    let text = table(&measured().rows);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 6, "frames that were asked for only: {text}");
    // Two seeds, one per cent to either side: a standard error of one per cent, and 12.7 of them.
    assert_eq!(
        lines[2],
        "| defaults | 0.0363 ± 0.0046 | 9.7 ± 1.2 % | -0.280 ± 0.036 % | 0.400 ± 0.051 | 0.0500 ± 0.0064 | 109876 | 131 | \
         1.00 (0.90 .. 1.25) | 2.10 | yes |"
    );
    same_columns(&lines, '|');
}

#[test]
fn an_equal_time_that_was_missed_says_so() {
    let mut measured = measured();
    let rows = |measured: &Measured| {
        let text = table(&measured.rows);
        let names = text.lines().filter_map(|line| line.split(" | ").next());
        names.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(rows(&measured)[5], "| path tracing, equal time");
    let mut took = |taken: f64| {
        for after in &mut measured.rows[3].after {
            after.taken = Some(taken);
        }
        rows(&measured)
    };
    assert_eq!(took(1.049)[5], "| path tracing, equal time");
    assert_eq!(took(0.951)[5], "| path tracing, equal time");
    assert_eq!(
        took(0.94)[5],
        "| path tracing, equal time (took 0.94 of it)"
    );
    let names = took(1.46);
    assert_eq!(names[5], "| path tracing, equal time (took 1.46 of it)");
    // Other times are not meant to be equal.
    assert_eq!(names[2..5], rows(&self::measured())[2..5]);
}

#[test]
fn what_is_reached_too_easily_is_said_to_be_less() {
    let mut equal = measured().equal_error;
    equal[0].fewer = 1;
    let text = equal_error_table(&equal);
    assert_eq!(
        text.lines().nth(2),
        Some("| path tracing | 16 | relMSE of 0.0363 | < 412 | < 1.60e8 | < 37.7 | < 18 |")
    );
    // Where another seed needs more than was tried, no figure says anything.
    equal[0].unreached = 1;
    let text = equal_error_table(&equal);
    let both = "| - | - | - | more than was tried with 1 seed, less than a sample with 1 seed |";
    assert!(text.contains(both), "{text}");
}

#[test]
fn what_was_not_reached_is_said_to_be_more() {
    let text = equal_error_table(&measured().equal_error);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[2],
        "| path tracing | 16 | relMSE of 0.0363 | 412 | 1.60e8 | 37.7 | 18.0 ± 2.3 |"
    );
    assert_eq!(
        lines[3],
        "| path tracing | 16 | MAPE of 3.63 % | > 412 | > 1.60e8 | > 37.7 | > 18 |"
    );
    same_columns(&lines, '|');
    assert_eq!(equal_error_table(&[]), "");
}

#[test]
fn csv_has_a_line_for_everything() {
    let text = csv(&[measured()]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 4 * 2);
    let start = "\"a \"\"quoted\"\" <name>\",cpu,\"a device\",4,2,100000,2,64,\"defaults\",settings,8,false,";
    assert!(lines[1].starts_with(start), "{}", lines[1]);
    assert!(lines[1].ends_with(",false") && lines[2].ends_with(",true"));
    same_columns(&lines[..5], ',');
    let text = equal_error_csv(&[measured()]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[1].contains("rel_mse,0,0,") && lines[2].contains("mape,1,0,"));
    same_columns(&lines, ',');
}

#[test]
fn plots_name_what_they_show() {
    let all = plots(&measured());
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["seconds", "rays", "frames", "front"]);
    for (name, svg) in &all {
        assert!(
            svg.contains("defaults") && svg.contains("&lt;name&gt;"),
            "{name}"
        );
        let rays = svg.contains("equal rays");
        assert_eq!(rays, ["rays", "front"].contains(&name.as_str()), "{name}");
    }
    assert!(all[3].1.contains("Pareto front") && all[3].1.contains("without depth"));
}

#[test]
fn the_page_has_everything_and_asks_for_nothing() {
    let page = html(&report(measured()));
    for text in [
        "gibs bench &#x27;a &lt;b&gt;&#x27;",
        "no &lt;driver&gt;",
        "a &lt;scene&gt;</code>: it is &lt;dark&gt;",
        "a device",
        "a driver",
        " ± 2.3 times",
        "&gt; 412",
        "without depth",
        "<svg",
        "path-traced with 64 samples",
        "0.0363 ± 0.0046",
    ] {
        let text = text.replace("&#x27;", "'");
        assert!(page.contains(&text), "{text}");
    }
    assert_eq!(
        page.matches("data:image/png").count(),
        3,
        "the truth, a picture and its errors"
    );
    for text in ["<script", "href=\"http", "src=\"http", "url(", "@import"] {
        assert!(!page.contains(text), "{text}");
    }
}
