//! Images of every method against closed forms, against Mitsuba, and against themselves.
//!
//! Seeds are fixed. When a change of the renderer gives it other random numbers, all statistical tests together raise
//! a false alarm with probability below 1.2e-3: there are fewer than 40 comparisons, each at [`comparison::LEVEL`]. That
//! is for normal replicates; `calibration` says what skewed ones make of it.

mod acceptance;
mod calibration;
#[path = "../common/changed_sources.rs"]
mod changed_sources;
mod comparison;
mod coverage;
mod crossover;
mod culling;
mod furnace;
mod glass_furnace;
mod groups;
mod invariance;
mod lens;
mod many;
mod mitsuba;
mod mixing;
mod options;
mod renders;
mod repetition;
mod sphere;
mod start;
mod threshold;
mod tiles;
mod types;
mod workgroups;
