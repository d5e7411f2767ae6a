//! Buildings with a lit part and a part that no light can reach: what is seen in the dark has leaked.
mod halls;
mod open;
mod parts;
mod rooms;

pub use open::colonnade;
pub use rooms::{SEALED_ROOMS_WALL, sealed_rooms};

use crate::view::View;
use gibs_passes::scene::Scene;

/// A scene with a view into its lit part and one into its dark part, where the irradiance is exactly zero.
#[derive(Clone, Copy, Debug)]
pub struct SealedCase {
    /// Name.
    pub name: &'static str,
    /// What separates the two parts.
    pub about: &'static str,
    /// Makes the scene, the view of the lit part and that of the dark part.
    pub make: fn() -> (Scene, View, View),
}

/// Every sealed scene. The buildings are 10 m across, thin walls and partitions 1 mm thick; floors and ceilings run on
/// beneath partitions, so that equal surfaces go on from the light into the dark.
pub const SEALED: [SealedCase; 6] = [
    SealedCase {
        name: "rooms-10cm",
        about: "two rooms beside each other, a wall of 10 cm between them",
        make: || sealed_rooms(SEALED_ROOMS_WALL),
    },
    SealedCase {
        name: "rooms-1mm",
        about: "two rooms beside each other, a wall of 1 mm between them",
        make: || sealed_rooms(0.001),
    },
    SealedCase {
        name: "edge",
        about: "four rooms, of which the lit and the dark one meet at an edge only",
        make: rooms::edge,
    },
    SealedCase {
        name: "pillars",
        about: "a hall divided by pillars and partitions, with columns and fins on both sides",
        make: halls::pillars,
    },
    SealedCase {
        name: "bend",
        about: "a lit hall around the corner of a dark one, partitions between them",
        make: halls::bend,
    },
    SealedCase {
        name: "box",
        about: "a thin box in a lit room, seen from inside",
        make: halls::closet,
    },
];
