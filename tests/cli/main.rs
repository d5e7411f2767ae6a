//! The program as its users see it: exit codes, messages, files. Everything here runs on the CPU, so that it needs no
//! device.
#![cfg(feature = "cpu")]

mod bench;
mod graph;
mod guiding;
mod kept;
mod page;
mod profile;
mod program;
mod render;
mod runs;
mod usage;
