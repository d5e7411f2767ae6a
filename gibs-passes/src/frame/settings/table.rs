//! Names, units and ranges of the settings, and how they are set from text.
use super::Settings;
use crate::shared::debug::{DebugView, UnknownDebugView};
use serde::Serialize;
use thiserror::Error;

/// Describes one setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingInfo {
    /// Name, as in `--set name=value` and in settings files.
    pub name: &'static str,
    /// Unit; empty for a plain number.
    pub unit: &'static str,
    /// Default.
    pub default: f64,
    /// Least value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// Whether it is on or off, 1 or 0 in the numbers above.
    pub is_switch: bool,
    /// What it does.
    pub about: &'static str,
}

/// A setting that does not exist or does not take the value.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingError {
    /// No such setting.
    #[error("there is no setting `{name}`; {}", meant.map_or_else(
        || "`gibs settings` lists them all".to_owned(),
        |meant| format!("is `{meant}` meant?"),
    ))]
    Unknown {
        /// Name given.
        name: String,
        /// A setting with that name but for its underscores.
        meant: Option<&'static str>,
    },
    /// Not a value of the setting's type.
    #[error("setting `{name}` cannot be `{value}`: {want}")]
    Value {
        /// Name.
        name: String,
        /// Value given.
        value: String,
        /// What it takes.
        want: String,
    },
    /// No such debug view.
    #[error(transparent)]
    View(#[from] UnknownDebugView),
    /// There is nothing that a debug view could show.
    #[error(
        "the debug view `{view}` shows what is switched off: set `{needs}=on`, or choose another view"
    )]
    Debug {
        /// View.
        view: DebugView,
        /// Setting that it needs.
        needs: &'static str,
    },
}

/// Fewest cells along a side of the grid's centre cube.
pub(super) const LEAST_SIDE: u32 = 4;

/// What a setting takes, in words, where that is not all of its range.
fn only(name: &str) -> Option<&'static str> {
    const { assert!(LEAST_SIDE == 4) };
    match name {
        "grid_side" => Some("it takes 0 or a whole number from 4 to 64"),
        "guide_side" => Some("it takes 2, 4, 6 or 8"),
        _ => None,
    }
}

/// Whether a setting takes a number.
fn takes(name: &str, number: f64, [least, most]: [f32; 2]) -> bool {
    let within = (f64::from(least)..=f64::from(most)).contains(&number);
    within
        && match name {
            "grid_side" => number == 0.0 || number >= f64::from(LEAST_SIDE),
            "guide_side" => number % 2.0 == 0.0,
            _ => true,
        }
}

macro_rules! settings {
    ($($name:ident: $kind:ident, $unit:literal, $least:expr, $most:expr, $about:literal;)*) => {
        impl Settings {
            /// Every setting that is a number or a switch; beside them there is [`Settings::debug`].
            pub fn all() -> Vec<SettingInfo> {
                let defaults = Settings::default();
                vec![$(SettingInfo {
                    name: stringify!($name),
                    unit: $unit,
                    default: settings!(@number $kind defaults.$name),
                    least: f64::from($least),
                    most: f64::from($most),
                    is_switch: settings!(@switch $kind),
                    about: $about,
                }),*]
            }

            /// Changes one setting from text; `debug` takes the name of a view, or `off`.
            ///
            /// # Errors
            /// An unknown name, or a value out of range.
            pub fn set(&mut self, name: &str, value: &str) -> Result<(), SettingError> {
                match name {
                    $(stringify!($name) => {
                        let wrong = || SettingError::Value {
                            name: name.into(),
                            value: value.into(),
                            want: settings!(@want $name $kind, $least, $most),
                        };
                        let parsed = settings!(@parse $kind value).ok_or_else(wrong)?;
                        let number = settings!(@number $kind parsed);
                        if !takes(name, number, [$least as f32, $most as f32]) {
                            return Err(wrong());
                        }
                        self.$name = parsed;
                        Ok(())
                    })*
                    "debug" => {
                        self.debug = match value {
                            "off" => None,
                            name => Some(name.parse()?),
                        };
                        Ok(())
                    }
                    _ => {
                        let like = name.replace('-', "_");
                        let mut names = [$(stringify!($name)),*].into_iter();
                        Err(SettingError::Unknown {
                            name: name.into(),
                            meant: names.find(|known| *known == like),
                        })
                    }
                }
            }

            /// Holds every setting against its range, and a debug view against what is on; for settings that came from a
            /// file.
            ///
            /// # Errors
            /// The first that is out of range; [`SettingError::Debug`].
            pub fn check(&self) -> Result<(), SettingError> {
                $(
                    let number = settings!(@number $kind self.$name);
                    if !takes(stringify!($name), number, [$least as f32, $most as f32]) {
                        return Err(SettingError::Value {
                            name: stringify!($name).into(),
                            value: self.$name.to_string(),
                            want: settings!(@want $name $kind, $least, $most),
                        });
                    }
                )*
                self.check_debug()
            }
        }
    };
    (@switch bool) => { true };
    (@switch $kind:ident) => { false };
    (@number bool $e:expr) => { f64::from(u8::from($e)) };
    (@number $kind:ident $e:expr) => { f64::from($e) };
    (@parse bool $e:expr) => { match $e { "true" | "on" | "1" => Some(true), "false" | "off" | "0" => Some(false), _ => None } };
    (@parse $kind:ident $e:expr) => { $e.parse::<$kind>().ok() };
    (@want $name:ident $kind:ident, $least:expr, $most:expr) => {
        only(stringify!($name)).map_or_else(|| settings!(@range $kind, $least, $most), String::from)
    };
    (@range bool, $least:expr, $most:expr) => { "it takes on or off".to_string() };
    (@range u32, $least:expr, $most:expr) => { format!("it takes a whole number from {} to {}", $least, $most) };
    (@range f32, $least:expr, $most:expr) => { format!("it takes a number from {} to {}", $least, $most) };
}

settings! {
    surfels: u32, "surfels", 0, 1_048_576, "capacity of the surfel buffers; 0 for direct light only";
    rays: u32, "rays/frame", 0, 4_000_000, "global budget of surfel rays";
    radius: f32, "pixels", 0.0, 64.0, "target radius of a surfel on screen; 0 to fit as many as there is room for";
    coverage: f32, "", 0.1, 8.0, "summed weight of surfels at which spawning stops";
    lookup: u32, "surfels", 1, 4096, "most surfels that a lookup visits in a cell";
    half_resolution: bool, "", 0.0, 1.0, "fill gaps and gather surfels at half the width and height, but for edges; else at every pixel";
    depth: bool, "", 0.0, 1.0, "depth functions, against light leaking through geometry";
    fallback: bool, "", 0.0, 1.0, "the average of the grid's cell makes up for what surfels do not cover";
    depth_side: u32, "texels", 2, 8, "texels along each side of a depth function";
    depth_blend: f32, "", 0.001, 1.0, "share of a new distance in a depth function's texel";
    clamp: bool, "", 0.0, 1.0, "clamp fireflies in the estimator";
    steering: bool, "", 0.0, 1.0, "give rays to surfels by how uncertain they are; else alike";
    guiding: bool, "", 0.0, 1.0, "draw rays by what each surfel has learned about where light comes from";
    guide_side: u32, "texels", 2, 8, "texels along each side of a guide, an even number";
    emitters: bool, "", 0.0, 1.0, "send a share of the rays to emissive triangles";
    sharing: bool, "", 0.0, 1.0, "let uncertain surfels look up the irradiance of their neighbours";
    sorting: bool, "", 0.0, 1.0, "sort rays by where they begin and where they go, before they are traced";
    ray_queries: bool, "", 0.0, 1.0, "trace by ray queries of the device, which it has to have, instead of in software; the CPU backend takes no notice";
    lights: u32, "lights", 1, 64, "lights sampled per point where there are more; else all";
    continuations: u32, "segments", 0, 16, "longest path beyond a hit without surfels";
    hit_births: u32, "surfels/frame", 0, 65_536, "surfels born where rays hit what none covers, at most and on average";
    geometric_normals: bool, "", 0.0, 1.0, "new surfels take the geometric normal, for a G-buffer with normal maps; else that of shading";
    grid_side: u32, "cells", 0, 64, "cells along a side of the centre cube and across a slice, at least 4; 0 to fit the surfels";
    grid_reach: f32, "half cubes", 2.0, 100_000.0, "distance at which the last slice of the grid begins";
    grid_lists: u32, "entries", 1, 64, "room in the lists of the grid's cells, per surfel of capacity";
    grid_half: f32, "scene sizes", 0.0001, 1.0, "half the side of the centre cube, over the scene's diagonal";
    queries: u32, "points", 0, 1_048_576, "most points at a time for which a program asks irradiance; 0 for no stage for it";
    check_slots: bool, "", 0.0, 1.0, "count slots that are lost or given twice, on the device, every frame";
}

#[cfg(test)]
mod tests;
