//! The reader of settings.
use crate::edits::byte_edits;
use crate::texts::damaged;
use crate::watch::{cases, watched};
use gibs::graph::NullBackend;
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};
use proptest::prelude::*;
use proptest::sample::select;

/// Values that a settings file may give.
fn setting() -> impl Strategy<Value = (usize, String)> {
    let values = vec![
        "0",
        "1",
        "-1",
        "true",
        "false",
        "nan",
        "inf",
        "-inf",
        "1e30",
        "1e-30",
        "-0.0",
        "0.5",
        "4294967295",
        "4294967296",
        "9223372036854775807",
        "-9223372036854775808",
        "\"on\"",
        "\"\"",
        "[]",
        "{}",
        "1e400",
        "99999999999999999999999",
        "0x7fffffff",
        "1979-05-27",
    ];
    let edge = (any::<usize>(), select(values)).prop_map(|(i, value)| (i, value.to_owned()));
    // Around what the setting itself allows.
    let bound = (any::<usize>(), 0_usize..6).prop_map(|(i, which)| {
        let all = Settings::all();
        let info = &all[i % all.len()];
        let number = [
            info.least,
            info.most,
            info.default,
            info.least - 1.0,
            info.most + 1.0,
            info.most / 2.0,
        ][which];
        (
            i,
            if number.fract() == 0.0 && which < 5 {
                format!("{number:.0}")
            } else {
                format!("{number:?}")
            },
        )
    });
    prop_oneof![edge, bound]
}

proptest! {
    #![proptest_config(cases(400))]

    /// What a settings file may say makes a frame; memory is not asked for before it runs.
    #[test]
    fn settings_make_a_frame_or_are_refused(pairs in prop::collection::vec(setting(), 0..5), bytes in prop::option::of(byte_edits())) {
        let all = Settings::all();
        let mut lines: Vec<String> =
            pairs.iter().map(|(i, value)| format!("{} = {value}", all[i % all.len()].name)).collect();
        lines.sort();
        lines.dedup_by_key(|line| line.split(' ').next().map(str::to_owned));
        let mut text = lines.join("\n");
        if let Some(edits) = bytes {
            text = damaged(&text, &edits);
        }
        watched(|| {
            let Ok(settings) = toml::from_str::<Settings>(&text) else { return };
            if settings.check().is_err() {
                return;
            }
            let (scene, view) = builtin::by_name("cornell").expect("built in");
            let made = Renderer::new(&NullBackend::new(), &scene, &view, [8, 8], &settings, 0);
            // Too large for a buffer of WebGPU is a reason that names itself.
            if let Err(error) = made {
                assert!(!error.to_string().is_empty());
            }
        });
    }

    #[test]
    fn a_setting_takes_what_it_says(i: usize, value in "\\PC{0,12}", number: f64) {
        let all = Settings::all();
        let name = all[i % all.len()].name;
        for value in [value, number.to_string()] {
            let mut settings = Settings::default();
            match settings.set(name, &value) {
                Ok(()) => prop_assert!(settings.check().is_ok(), "{} = {}", name, value),
                Err(error) => prop_assert!(error.to_string().contains(name)),
            }
        }
    }
}
