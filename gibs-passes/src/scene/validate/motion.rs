//! Checks of animation clips.
use super::hierarchy::check_rotation;
use super::{SceneDataError, Tally, bad_value, check_finite, check_index, label};
use crate::scene::{Animation, Channel, Interpolation, Keyframes, unit_rotation};

/// Keyframes in order, as many as their times ask for, finite, of nodes that exist.
pub(super) fn animations(
    animations: &[Animation],
    node_count: usize,
    warnings: &mut Vec<String>,
) -> Result<(), SceneDataError> {
    let mut unturned = Tally::default();
    for (i, animation) in animations.iter().enumerate() {
        for (c, channel) in animation.channels.iter().enumerate() {
            let element = || {
                let clip = label("animation", i, &animation.name);
                format!("{clip}, channel {c}")
            };
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

/// Returns how many rotations have no length.
fn values(element: impl Fn() -> String, channel: &Channel) -> Result<usize, SceneDataError> {
    let mut unturned = 0;
    match &channel.keyframes {
        Keyframes::Translation(values) | Keyframes::Scale(values) => {
            for (k, value) in values.iter().enumerate() {
                if !value.is_finite() {
                    check_finite(&element, &format!("value {k}"), *value)?;
                }
            }
        }
        Keyframes::Rotation(values) => {
            let spline = channel.interpolation == Interpolation::CubicSpline;
            for (k, value) in values.iter().enumerate() {
                if !is_tangent(spline, k) {
                    unturned += usize::from(!check_rotation(&element, *value)?);
                } else if !value.is_finite() {
                    let what = format!("tangent {k}");
                    return Err(bad_value(element(), what, *value, "finite"));
                }
            }
        }
    }
    Ok(unturned)
}

/// Tangents are differences, of any length.
fn is_tangent(spline: bool, k: usize) -> bool {
    spline && k % 3 != 1
}

/// Makes all rotations unit; those of no length become none.
pub(super) fn make_unit(animations: &mut [Animation]) {
    let channels = animations.iter_mut().flat_map(|clip| &mut clip.channels);
    for channel in channels {
        let spline = channel.interpolation == Interpolation::CubicSpline;
        if let Keyframes::Rotation(values) = &mut channel.keyframes {
            for (k, value) in values.iter_mut().enumerate() {
                if !is_tangent(spline, k) {
                    *value = unit_rotation(*value);
                }
            }
        }
    }
}
