//! From a glTF file to a [`Scene`](super::Scene).
