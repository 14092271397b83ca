//! The ensemble: its start, its pool of guides, its sweeps.

pub mod agreement;
pub mod autocorrelation;
pub mod bootstrap;
pub mod build;
pub mod candidate;
pub mod crossings;
pub mod cuts;
pub mod groups;
pub mod guidance;
pub mod mix;
pub mod mixing;
pub mod path_traced;
pub mod photons;
pub mod pool;
mod runs;
mod seeds;
pub mod sightings;
pub mod similarity;
pub mod strategies;
pub mod subpaths;
pub mod sweep;
pub mod two_stage;
mod type_key;
pub mod type_shares;
mod work;
