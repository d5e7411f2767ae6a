//! Line plots as SVG: several curves over one axis, with bands of uncertainty, readable on any background.
mod axis;
mod draw;
#[cfg(test)]
mod tests;

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// The curves, in the order of the legend. One alone has no legend.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it measures, with the unit.
    pub label: String,
    /// How values lie along it.
    pub scale: Scale,
}

/// How values lie along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// By their differences.
    #[default]
    Linear,
    /// By their ratios; values that are not above zero do not show.
    Log,
}

/// A curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Points `[x, y]`, joined in this order. Those that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// Least and largest y at each of the points, for a band behind the curve; empty for none.
    pub band: Vec<[f64; 2]>,
    /// How the points are drawn.
    pub marks: Marks,
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Marks {
    /// Dots on a line.
    #[default]
    Joined,
    /// Dots alone.
    Scattered,
    /// A black line without dots that goes to the right before it goes up or down, as the best of what is left of it does.
    Stairs,
}

impl Axis {
    /// An axis with equal steps.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
        }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Log,
        }
    }
}

impl Plot {
    /// The picture: a white card, so that it can be read wherever it is put. Colours are Okabe and Ito's, which people with
    /// any colour vision tell apart; beyond seven curves they come again, with dashed lines and hollow dots, then with crosses.
    pub fn svg(&self) -> String {
        draw::svg(self)
    }
}
