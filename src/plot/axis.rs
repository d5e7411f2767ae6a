//! Where values lie along an axis, and the values that are written there.
use super::Scale;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// About as many labels as an axis has room for.
const MOST_TICKS: f64 = 9.0;

/// The part of an axis that is drawn. *Places* are what lies at equal distances: values, or their decadic logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Span {
    scale: Scale,
    /// Places at its ends, the second larger.
    pub ends: [f64; 2],
}

impl Span {
    /// Spans all values that have a place, with some room at the ends.
    pub fn of(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in values.filter_map(|value| place(scale, value)) {
            (least, most) = (least.min(place), most.max(place));
        }
        if least > most {
            (least, most) = (0.0, 1.0);
        }
        // A single value, or values that rounding alone keeps apart.
        let width = (most - least).max(1e-6 * (1.0 + most.abs()));
        let margin = 0.04 * width;
        Self {
            scale,
            ends: [least - margin, most + margin],
        }
    }

    /// The place of a value; `None` where it has none.
    pub fn place(&self, value: f64) -> Option<f64> {
        place(self.scale, value)
    }

    /// The place of a value, moved to an end of the span where it lies beyond, or has none.
    pub fn held(&self, value: f64) -> f64 {
        let [least, most] = self.ends;
        self.place(value).unwrap_or(least).clamp(least, most)
    }

    /// Places of round values within the span.
    pub fn ticks(&self) -> Vec<f64> {
        let [least, most] = self.ends;
        match self.scale {
            Scale::Linear => multiples(least, most, step((most - least) / MOST_TICKS)),
            Scale::Log if most - least > MOST_TICKS => {
                multiples(least, most, ((most - least) / MOST_TICKS).ceil())
            }
            Scale::Log => decades(least, most),
        }
    }

    /// The value at a place, as it is written.
    pub fn label(&self, place: f64) -> String {
        let value = match self.scale {
            Scale::Linear => place,
            Scale::Log => 10f64.powf(place),
        };
        written(value)
    }
}

/// An axis of plotters', which is one of places.
impl Ranged for Span {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, limit: (i32, i32)) -> i32 {
        let [least, most] = self.ends;
        let share = (place - least) / (most - least);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.ticks(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.ends[0]..self.ends[1]
    }
}

impl ValueFormatter<f64> for Span {
    fn format_ext(&self, place: &f64) -> String {
        self.label(*place)
    }
}

fn place(scale: Scale, value: f64) -> Option<f64> {
    let place = match scale {
        Scale::Linear => value,
        Scale::Log if value > 0.0 => value.log10(),
        Scale::Log => return None,
    };
    place.is_finite().then_some(place)
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below `least`.
fn step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let digit = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|digit| digit * power >= least);
    digit.unwrap_or(10.0) * power
}

fn multiples(least: f64, most: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((least / step).ceil(), (most / step).floor());
    (0..=(last - first).max(-1.0) as i64)
        .map(|i| (first + i as f64) * step)
        .collect()
}

/// Logarithms of round values: of all that are a digit times a power of ten in less than a decade, of fewer the more decades
/// there are; evenly spaced values where there are not even two of those.
fn decades(least: f64, most: f64) -> Vec<f64> {
    let digits: &[f64] = match most - least {
        width if width > 4.0 => &[1.0],
        width if width > 2.5 => &[1.0, 3.0],
        width if width > 0.8 => &[1.0, 2.0, 5.0],
        _ => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
    };
    let powers = (least.floor() as i32)..=(most.ceil() as i32);
    let within = |place: &f64| (least..=most).contains(place);
    let ticks: Vec<f64> = powers
        .flat_map(|power| digits.iter().map(move |d| d.log10() + f64::from(power)))
        .filter(within)
        .collect();
    if ticks.len() > 1 {
        return ticks;
    }
    let [low, high] = [least, most].map(|end| 10f64.powf(end));
    let values = multiples(low, high, step((high - low) / 5.0));
    values.into_iter().map(f64::log10).filter(within).collect()
}

/// Six significant digits, without zeros at the end, and with a power of ten where there would be many in front.
fn written(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude < 1e-12 {
        return "0".into();
    }
    let exponent = magnitude.log10().floor() as i32;
    if !(-4..7).contains(&exponent) {
        let text = format!("{value:.3e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", short(digits));
    }
    let decimals = (5 - exponent).max(0) as usize;
    short(&format!("{value:.decimals$}")).into()
}

/// A decimal fraction without zeros at its end.
fn short(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}
