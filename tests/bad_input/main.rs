//! Bad input as its users meet it: real files, read by the library and by the program, and scenes that a program builds in
//! memory. All of it is either refused with a message that names the file or the object, the value and the remedy, or
//! drawn right with a warning for what is missing; never a panic, never silence. Everything runs on the CPU, so that it
//! needs no device.
#![cfg(feature = "cpu")]

mod absent;
mod file;
mod geometry;
mod many;
mod memory;
mod memory_indices;
mod memory_values;
mod memory_views;
mod parts;
mod radiance;
mod references;
mod run;
mod sizes;
mod textures;
mod transforms;
