//! Checks of animation clips.
use super::hierarchy::unit_rotation;
use super::{SceneDataError, Tally, bad_value, check_finite, check_index, label};
use crate::scene::{Animation, Channel, Interpolation, Keyframes};

/// Keyframes in order, as many as their times ask for, finite, of nodes that exist.
pub(super) fn animations(
    animations: &mut [Animation],
    node_count: usize,
    warnings: &mut Vec<String>,
) -> Result<(), SceneDataError> {
    let mut unturned = Tally::default();
    for (i, animation) in animations.iter_mut().enumerate() {
        let clip = label("animation", i, &animation.name);
        for (c, channel) in animation.channels.iter_mut().enumerate() {
            let element = || format!("{clip}, channel {c}");
            check_index(element, "node", channel.node, node_count)?;
            times(element, channel)?;
            unturned.add(values(element, channel)?, element);
        }
    }
    unturned.report(
        "keyframe",
        "keyframes",
        "had a rotation of no length, now none",
        warnings,
    );
    Ok(())
}

fn times(element: impl Fn() -> String, channel: &Channel) -> Result<(), SceneDataError> {
    let times = &channel.times;
    if times.is_empty() {
        let expected = "at least one".to_owned();
        return Err(SceneDataError::Length {
            element: element(),
            what: "keyframe times",
            found: 0,
            expected,
        });
    }
    for (k, &time) in times.iter().enumerate() {
        // Equal times are a jump; some exporters write them.
        if !time.is_finite() || (k > 0 && time < times[k - 1]) {
            let what = format!("time of keyframe {k}");
            return Err(bad_value(
                element(),
                what,
                time,
                "finite and not before the previous one",
            ));
        }
    }
    let per_time = if channel.interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    let found = match &channel.keyframes {
        Keyframes::Translation(values) | Keyframes::Scale(values) => values.len(),
        Keyframes::Rotation(values) => values.len(),
    };
    if found != times.len() * per_time {
        let expected = format!("{per_time} for each of {} times", times.len());
        return Err(SceneDataError::Length {
            element: element(),
            what: "keyframe values",
            found,
            expected,
        });
    }
    Ok(())
}

/// Returns how many rotations had no length.
fn values(element: impl Fn() -> String, channel: &mut Channel) -> Result<usize, SceneDataError> {
    let mut replaced = 0;
    match &mut channel.keyframes {
        Keyframes::Translation(values) | Keyframes::Scale(values) => {
            for (k, value) in values.iter().enumerate() {
                check_finite(&element, &format!("value {k}"), *value)?;
            }
        }
        Keyframes::Rotation(values) => {
            let spline = channel.interpolation == Interpolation::CubicSpline;
            for (k, value) in values.iter_mut().enumerate() {
                // Tangents are differences, of any length.
                if spline && k % 3 != 1 {
                    if !value.is_finite() {
                        return Err(bad_value(
                            element(),
                            format!("tangent {k}"),
                            *value,
                            "finite",
                        ));
                    }
                } else {
                    replaced += usize::from(!unit_rotation(&element, value)?);
                }
            }
        }
    }
    Ok(replaced)
}
