//! `gibs guiding`.
use crate::program::*;
use std::path::Path;

#[test]
fn guiding_is_measured_under_environments() {
    let folder = Folder::new("guiding");
    let report = folder.path("report");
    let few = [
        "--backend",
        "cpu",
        "--probes",
        "4",
        "--seeds",
        "2",
        "--rays",
        "64",
    ];
    let args = [
        &["guiding", "sun", "overcast", "--json", "--report", &report],
        &few[..],
    ]
    .concat();
    let all = json(&args);
    assert_eq!(all.as_array().unwrap().len(), 2);
    let rows = all[0]["rows"].as_array().unwrap();
    let rays: Vec<u64> = rows
        .iter()
        .map(|row| row["rays"].as_u64().unwrap())
        .collect();
    assert_eq!(rays, [8, 16, 32, 64]);
    assert!(
        rows.iter()
            .all(|row| row["guided"]["error"].as_f64().unwrap() > 0.0)
    );
    for name in ["sun.svg", "overcast.svg"] {
        let svg = std::fs::read_to_string(Path::new(&report).join(name)).unwrap();
        assert!(
            svg.starts_with("<svg") && svg.ends_with("</svg>\n"),
            "{svg}"
        );
    }
    let csv = std::fs::read_to_string(Path::new(&report).join("guiding.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 4);

    let mut columns = csv.lines().map(|line| line.split(',').nth(1).unwrap());
    assert!(columns.next() == Some("guide_side") && columns.all(|side| side == "6"));

    let twice = folder.path("twice");
    succeed(&[&["guiding", "sun", "sun", "--report", &twice], &few[..]].concat());
    let named = std::fs::read_to_string(Path::new(&twice).join("guiding.csv")).unwrap();
    assert!(Path::new(&twice).join("sun-2.svg").is_file());
    for name in ["\"sun\",", "\"sun-2\","] {
        assert_eq!(named.matches(name).count(), 4, "{named}");
    }

    let text = succeed(&[&["guiding", "windows", "--guide-side", "8"], &few[..]].concat());
    for part in ["windows on cpu: 4 probes", "guides of 8x8 texels", " % +- "] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn environments_that_cannot_be_read_are_refused() {
    let folder = Folder::new("environments");
    let broken = folder.write("broken.hdr", "#?RADIANCE\n\n-Y nothing");
    let missing = folder.path("missing.hdr");
    refused(&["guiding", "nowhere"], &["nowhere", "windows", "sun"]);
    refused(
        &["guiding", "sun", "--guide-side", "5"],
        &["--guide-side", "'5'", "2, 4, 6 or 8"],
    );
    refused(&["guiding", &missing], &["missing.hdr", "cannot read"]);
    refused(
        &["guiding", "sun", &broken],
        &["broken.hdr", "save it again"],
    );
    let text = folder.write("sky.txt", "blue");
    refused(&["guiding", &text], &["sky.txt", ".hdr"]);
    refused(
        &["guiding", "sun", "--backend", "cpu", "--report", &text],
        &["sky.txt", "is not a folder"],
    );
    refused(&["guiding"], &["ENV"]);
}
