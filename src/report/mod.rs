//! What a render says about itself: progress while it runs, statistics at its end, metadata in its file.

pub mod log;
pub mod metadata;
pub mod observer;
pub mod outputs;
pub mod progress;
pub mod statistics;
pub mod student;
pub mod summary;
