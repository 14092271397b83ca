//! What a render says about itself: progress while it runs, statistics at its end.

pub mod progress;
pub mod statistics;
