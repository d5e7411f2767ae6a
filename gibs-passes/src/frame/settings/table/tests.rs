//! Tests of `settings/table.rs`.
use super::*;

#[test]
fn every_default_is_within_its_range() {
    Settings::default().check().expect("defaults are valid");
    for info in Settings::all() {
        assert!(
            !info.about.is_empty() && info.least <= info.default && info.default <= info.most,
            "{info:?}"
        );
    }
}

#[test]
fn bad_values_say_what_is_taken() {
    let mut s = Settings::default();
    s.set("rays", "1000").expect("in range");
    assert_eq!(s.rays, 1000);
    assert!(
        s.set("rays", "-1")
            .unwrap_err()
            .to_string()
            .contains("from 0 to 4000000")
    );
    assert!(
        s.set("depth", "maybe")
            .unwrap_err()
            .to_string()
            .contains("on or off")
    );
    assert!(s.set("radius", "NaN").is_err());
    assert!(
        s.set("nonsense", "1")
            .unwrap_err()
            .to_string()
            .contains("gibs settings")
    );
}

/// Numbers that are not taken, within the range and beyond it, from text and once they are set.
#[test]
fn gaps_in_ranges_are_refused() {
    for (name, wrong, right, want) in [
        ("guide_side", ["7", "9", "x"], "8", "2, 4, 6 or 8"),
        (
            "grid_side",
            ["3", "65", "-1"],
            "4",
            "0 or a whole number from 4",
        ),
    ] {
        let mut s = Settings::default();
        for wrong in wrong {
            let refused = s.set(name, wrong).unwrap_err().to_string();
            assert!(refused.contains(want), "{refused}");
        }
        assert_eq!(s, Settings::default());
        s.set(name, right).expect("taken");
        s.check().expect("taken");
        match name {
            "guide_side" => s.guide_side = 7,
            _ => s.grid_side = 3,
        }
        let refused = s.check().unwrap_err().to_string();
        assert!(refused.contains(want), "{refused}");
    }
}
