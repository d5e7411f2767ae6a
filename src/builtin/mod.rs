//! Scenes made by code, so that everything works with nothing downloaded.
mod assemble;
mod atrium;
mod cornell;
mod furnace;
mod glass;
mod moving;
mod noise;
mod sealed;
mod shapes;
mod street;
#[cfg(test)]
mod tests;
mod window_room;

pub use furnace::furnace;
pub use sealed::{SEALED, SEALED_ROOMS_WALL, SealedCase, colonnade, sealed_rooms};

use crate::view::View;
use gibs_passes::scene::Scene;

/// Name, description and maker of every scene.
type Entry = (&'static str, &'static str, fn() -> (Scene, View));

const SCENES: [Entry; 8] = [
    (
        "cornell",
        "the Cornell box: two blocks, coloured walls, one emissive quad",
        cornell::cornell,
    ),
    (
        "atrium",
        "a courtyard with two storeys of arcades under sun and sky",
        atrium::atrium,
    ),
    (
        "furnace",
        "a closed cube, albedo 0.5 and emission 1, whose irradiance is 2 pi",
        || furnace(0.5, 1.0),
    ),
    (
        "sealed-rooms",
        "the dark one of two closed rooms that share a thin wall",
        || {
            let (scene, _, dark) = sealed_rooms(SEALED_ROOMS_WALL);
            (scene, dark)
        },
    ),
    (
        "window-room",
        "a room lit by sun and sky through one window",
        window_room::window_room,
    ),
    (
        "many-lights",
        "a street at night under 1400 point lights",
        street::many_lights,
    ),
    (
        "glass",
        "a room with a blended pane and a grid cut out of a texture",
        glass::glass,
    ),
    (
        "moving",
        "the Cornell box with two boxes that a clip moves",
        moving::moving,
    ),
];

/// The built-in scene called `name`, with a view of it; `None` if there is none.
pub fn by_name(name: &str) -> Option<(Scene, View)> {
    SCENES
        .iter()
        .find(|entry| entry.0 == name)
        .map(|entry| entry.2())
}

/// Name and description of every built-in scene.
pub fn names() -> &'static [(&'static str, &'static str)] {
    const NAMES: [(&str, &str); SCENES.len()] = {
        let mut names = [("", ""); SCENES.len()];
        let mut i = 0;
        while i < SCENES.len() {
            names[i] = (SCENES[i].0, SCENES[i].1);
            i += 1;
        }
        names
    };
    &NAMES
}
