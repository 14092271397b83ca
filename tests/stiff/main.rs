//! Stiff and extreme cases: the list of METHOD.md section 6, whose numbers the tests name. docs/stiff.md has the table of
//! all of them, with those that tests elsewhere hold.
//!
//! Most scenes have a closed form, the others are compared with long path tracing, or with themselves after a change that
//! must not show. Seeds are fixed, and each comparison of images raises a false alarm with probability
//! [`comparison::LEVEL`]. Every render must be finite, lose no weight and count no proposal as not finite
//! ([`renders::render`]).

#[path = "../images/comparison.rs"]
mod comparison;
#[path = "../images/renders.rs"]
#[allow(dead_code)]
mod renders;
#[path = "../images/tiles.rs"]
mod tiles;

#[path = "../textures/room.rs"]
#[allow(dead_code)]
mod room;

mod bench;
mod film;
mod furnaces;
mod gloss;
mod grazing;
mod guides;
mod lamp;
mod lengths;
mod mirrors;
mod nonfinite;
mod normals;
mod rng;
mod scale;
mod shapes;
mod stops;
mod sun;
mod texture;
