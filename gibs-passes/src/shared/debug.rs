//! The debug views: what each shows, in which unit, how a picture colours it; and their pixels.
use crate::data::DebugPixel;
use crate::frame::Settings;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// How a picture colours the values of a debug view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DebugScale {
    /// Values name things: each has a colour of its own, from a hash.
    Names,
    /// Values name the grid's seven parts: 0 is the cube in grey, from 1 on the half-axes +x, -x, +y, -y, +z, -z.
    Parts,
    /// Black at 0 to pale yellow at this value and beyond.
    Heat(f32),
    /// Grey at 1, blue down to 1 over this value and below, red up to this value and beyond; logarithmic.
    BlueToRed(f32),
}

macro_rules! debug_views {
    ($($(#[doc = $doc:literal])* $view:ident = $number:literal, $name:literal, $unit:literal, $scale:expr;)*) => {
        /// A picture of what the technique does, in place of what it renders.
        ///
        /// A frame with [`Settings::debug`] has stages in the group `debug`, and the output `debug`
        /// with a [`DebugPixel`] for each pixel: the state after the frame.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[repr(u32)]
        #[non_exhaustive]
        pub enum DebugView {
            $(
                $(#[doc = $doc])*
                #[serde(rename = $name)]
                $view = $number,
            )*
        }

        impl DebugView {
            /// Every view.
            pub const ALL: &'static [Self] = &[$(Self::$view),*];

            /// Name, as in `--debug NAME`.
            pub fn name(self) -> &'static str {
                match self { $(Self::$view => $name,)* }
            }

            /// Unit of the values.
            pub fn unit(self) -> &'static str {
                match self { $(Self::$view => $unit,)* }
            }

            /// How a picture colours the values.
            pub fn scale(self) -> DebugScale {
                match self { $(Self::$view => $scale,)* }
            }

            /// What it shows.
            pub fn about(self) -> &'static str {
                match self { $(Self::$view => concat!($($doc),*).trim(),)* }
            }
        }
    };
}

use DebugScale::{BlueToRed, Heat, Names, Parts};

debug_views! {
    /// surfels as discs; of those that overlap, the one with the nearest centre
    Surfels = 1, "surfels", "slot", Names;
    /// summed weight of the surfels; below 1, the cell's average fills in
    Coverage = 2, "coverage", "summed weight", BlueToRed(4.0);
    /// radius of the nearest surfel, as it is projected
    Radius = 3, "radius", "pixels", Heat(16.0);
    /// standard deviation of four rays of the nearest surfel, over its mean
    Variance = 4, "variance", "standard deviation / mean", BlueToRed(4.0);
    /// rays that the surfels got in this frame, their mean by weight
    RayCount = 5, "ray-count", "rays", Heat(32.0);
    /// frames since the nearest surfel was born
    Life = 6, "life", "frames", Heat(64.0);
    /// frames, up to this one, since a pixel last saw the nearest surfel
    Unseen = 7, "unseen", "frames", Heat(64.0);
    /// transform id of the visible surface
    TransformId = 8, "transform-id", "node", Names;
    /// cells, by which of the seven grids they belong to
    Grid = 9, "grid", "part of the grid", Parts;
    /// surfels listed in the cell
    CellHeat = 10, "cell-heat", "surfels", Heat(128.0);
    /// mean distance in the depth function of the nearest surfel, in the direction from it to the pixel
    DepthFunction = 11, "depth-function", "diameters", Heat(1.0);
    /// guide of the nearest surfel, drawn on the middle of its disc as its hemisphere looks from above
    Guide = 12, "guide", "share of its brightest texel", Heat(1.0);
}

impl DebugView {
    /// Number of the view, as stages know it.
    pub fn number(self) -> u32 {
        self as u32
    }

    /// It shows what was so before this frame looked at the scene.
    pub fn is_of_the_past(self) -> bool {
        self == Self::Unseen
    }

    /// The channel of a picture that holds the values.
    pub fn channel(self) -> String {
        format!("debug.{}", self.name())
    }

    /// The view of a number.
    pub fn of(number: u32) -> Option<Self> {
        Self::ALL.iter().copied().find(|v| v.number() == number)
    }

    /// The setting that would have to be on for there to be anything to show.
    pub fn missing(self, settings: &Settings) -> Option<&'static str> {
        match self {
            Self::DepthFunction if !settings.depth => Some("depth"),
            Self::Guide if !settings.guiding => Some("guiding"),
            _ => None,
        }
    }
}

impl fmt::Display for DebugView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Not the name of a debug view.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no debug view `{0}`; choose {names}", names = names())]
pub struct UnknownDebugView(pub String);

fn names() -> String {
    let names: Vec<_> = DebugView::ALL.iter().map(|view| view.name()).collect();
    names.join(", ")
}

impl FromStr for DebugView {
    type Err = UnknownDebugView;

    fn from_str(name: &str) -> Result<Self, UnknownDebugView> {
        let found = Self::ALL.iter().copied().find(|view| view.name() == name);
        found.ok_or_else(|| UnknownDebugView(name.into()))
    }
}

/// There is nothing to show.
pub const NOTHING: DebugPixel = DebugPixel {
    value: -1.0,
    shade: 0.0,
};

/// A value of the view.
#[inline]
pub fn pixel(value: f32, shade: f32) -> DebugPixel {
    DebugPixel { value, shade }
}

/// Brightness of a surface that is lit from the eye, so that shapes can be told in pictures of flat colours.
#[inline]
pub fn headlight(to_eye: Vec3, normal: Vec3) -> f32 {
    let cosine = to_eye.dot(normal).max(0.0) / to_eye.length().max(1e-20);
    0.4 + 0.6 * cosine
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stages know views by number: the constants of the WGSL module are those of the enum.
    #[test]
    fn device_kernels_know_the_same_numbers() {
        let modules = gibs_shaders::MODULES;
        let (_, text) = modules
            .iter()
            .find(|(path, _)| *path == "debug")
            .expect("the module");
        let mut known: Vec<(&str, u32)> = Vec::new();
        for line in text
            .lines()
            .filter(|line| line.starts_with("const DEBUG_VIEW_"))
        {
            let (name, number) = line["const DEBUG_VIEW_".len()..]
                .trim_end_matches("u;")
                .split_once(": u32 = ")
                .expect("a number");
            known.push((name, number.parse().expect("a number")));
        }
        let views = DebugView::ALL.iter();
        let wanted: Vec<_> = views
            .map(|v| (v.name().to_uppercase().replace('-', "_"), v.number()))
            .collect();
        let wanted: Vec<_> = wanted.iter().map(|(n, i)| (n.as_str(), *i)).collect();
        assert_eq!(known, wanted);
    }

    #[test]
    fn names_are_read_back() {
        for &view in DebugView::ALL {
            assert_eq!(view.name().parse::<DebugView>().expect("a view"), view);
            assert!(!view.about().is_empty() && !view.unit().is_empty());
        }
        let message = "probe".parse::<DebugView>().unwrap_err().to_string();
        for view in DebugView::ALL {
            assert!(message.contains(view.name()), "{message}");
        }
    }
}
