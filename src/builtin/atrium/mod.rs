//! A courtyard in the manner of a Florentine palace: arcades on two storeys around a paved court with a fountain.
//!
//! The sun reaches part of the floor and the upper walls; the galleries are lit by what these reflect.
mod arcade;
mod banner;
mod column;
mod court;
mod gallery;
mod palette;
mod plants;
mod roof;

use super::assemble::{Assembly, sky, sun, view};
use crate::view::View;
use gibs_passes::scene::Scene;
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance between columns, metres.
const BAY: f32 = 3.3;

/// Bays along x and along z.
const BAYS: [i32; 2] = [6, 4];

/// Half sides (x, z) of the rectangle of the column axes. Distances *inwards* are measured from it towards the court, so
/// the galleries have negative ones.
const HALF: [f32; 2] = [BAY * BAYS[0] as f32 / 2.0, BAY * BAYS[1] as f32 / 2.0];

/// Distance inwards of the wall behind the galleries.
const BACK_WALL: f32 = -3.07;

/// What differs between the two storeys; metres.
struct Storey {
    /// Floor of the gallery.
    floor: f32,
    /// Foot of the columns.
    foot: f32,
    /// Springing of the arches.
    spring: f32,
    /// Upper end of the wall above the arches.
    top: f32,
    /// Radius of the arches.
    radius: f32,
    /// Half the thickness of the wall above the arches.
    half_wall: f32,
    /// Diameter of the columns.
    column: f32,
}

const GROUND: Storey = Storey {
    floor: 0.16,
    foot: 0.16,
    spring: 3.56,
    top: 5.62,
    radius: 1.40,
    half_wall: 0.23,
    column: 0.44,
};

const UPPER: Storey = Storey {
    floor: 5.60,
    foot: 6.56,
    spring: 8.9,
    top: 11.2,
    radius: 1.42,
    half_wall: 0.20,
    column: 0.33,
};

/// Builds the courtyard.
pub(super) fn atrium() -> (Scene, View) {
    let mut a = Assembly::new("atrium");
    let palette = palette::palette(&mut a);
    arcade::arcades(&mut a, &palette);
    gallery::galleries(&mut a, &palette);
    roof::roof(&mut a, &palette);
    court::court(&mut a, &palette);
    plants::plants(&mut a, &palette);
    banner::banners(&mut a, &palette);

    let mut view = view([-9.1, 1.75, 1.9], [9.0, 3.15, -1.5], 66.0, [960, 540]);
    view.sun = sun([0.30, -1.0, -0.36], [15.0, 13.8, 11.8]);
    view.environment = sky([0.55, 0.85, 1.45]);
    view.exposure = 0.65;
    (a.scene, view)
}

/// A side of the court. Things are built for the side towards +z: along x, with the court towards -z; then they are
/// turned about the y axis.
#[derive(Clone, Copy)]
struct Side {
    /// Turn about y that brings the side from +z to its place.
    turn: f64,
    /// Bays of this side.
    bays: i32,
    /// Distance of its column axis from the middle of the court.
    depth: f32,
    /// Whether it is one of the two long sides.
    is_long: bool,
}

const SIDES: [Side; 4] = [
    Side {
        turn: 0.0,
        bays: BAYS[0],
        depth: HALF[1],
        is_long: true,
    },
    Side {
        turn: FRAC_PI_2,
        bays: BAYS[1],
        depth: HALF[0],
        is_long: false,
    },
    Side {
        turn: PI,
        bays: BAYS[0],
        depth: HALF[1],
        is_long: true,
    },
    Side {
        turn: -FRAC_PI_2,
        bays: BAYS[1],
        depth: HALF[0],
        is_long: false,
    },
];

impl Side {
    /// The place `along` the side (0 in its middle), `inwards` from the column axis, at height `y`.
    fn at(&self, along: f32, inwards: f32, y: f32) -> [f64; 3] {
        let (sin, cos) = self.turn.sin_cos();
        let (x, z) = (f64::from(along), f64::from(self.depth - inwards));
        [x * cos + z * sin, f64::from(y), -x * sin + z * cos]
    }

    /// Where the columns stand along the side. Those in the corners belong to the long sides.
    fn columns(&self) -> impl Iterator<Item = f32> {
        let bays = self.bays;
        let (first, last) = if self.is_long {
            (0, bays)
        } else {
            (1, bays - 1)
        };
        (first..=last).map(move |i| (i as f32 - bays as f32 / 2.0) * BAY)
    }

    /// The middles of the bays along the side.
    fn bays(&self) -> impl Iterator<Item = f32> {
        let bays = self.bays;
        (0..bays).map(move |i| (i as f32 + 0.5 - bays as f32 / 2.0) * BAY)
    }
}
