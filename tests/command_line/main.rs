//! The program as a user meets it: what it says, its exit status, and which files it leaves.

mod outputs;
mod place;
mod refusals;
mod study;
