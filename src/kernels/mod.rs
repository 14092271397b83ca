//! The transition kernels: what each is called, which shader it is, and which path types it applies to.
//!
//! The mathematics is in the file of the same name under `shaders/kernels`; acceptance, splatting and counting are in one
//! place for all (`shaders/transport/accept.wesl`).

pub mod bidirectional;
pub mod caustic;
pub mod crossover;
pub mod difference;
pub mod guided_bidirectional;
pub mod guided_caustic;
pub mod guided_lens;
pub mod guided_light_subpath;
pub mod guided_multi_chain;
pub mod independence;
pub mod jump;
pub mod kept_lens;
pub mod lens;
pub mod lens_subpath;
pub mod light_subpath;
pub mod manifold;
pub mod multi_chain;
pub mod walk_lens;

use crate::ensemble::pool::TypeKey;
use crate::scene::Features;

/// One transition kernel.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// For the command line, statistics and metadata.
    pub name: &'static str,
    /// What moves, in words.
    pub about: &'static str,
    /// File stem under `shaders/passes`.
    pub pass: &'static str,
    /// Flags of the pass that make it this kernel.
    pub flags: &'static [&'static str],
    pub family: Family,
    /// Whether it moves paths of this type; others rest for the pass, with their weight (METHOD.md C6a).
    pub applies: fn(TypeKey, Features) -> bool,
    /// Why no path of such a scene can use it; then it is neither compiled nor scheduled. `None` where some can.
    pub useless: fn(Features) -> Option<&'static str>,
    /// Whether it reads the complementary ensemble.
    pub guided: bool,
}

/// When in a half-sweep a kernel runs (METHOD.md C6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// May change a path's type: before the lists are sorted.
    Structural,
    /// As structural ones, but of a path of either half at once: after it both halves are new (METHOD.md C6d).
    Pair,
    /// Keeps the type and starts on the light's side. These run before those at the camera, which keep no account of
    /// what they do to log C of the light's side.
    LightSide,
    /// Keeps the type and starts at the camera.
    CameraSide,
}

impl Family {
    /// Whether kernels of the family keep the type of a path: they run over sorted lists.
    pub fn keeps_types(self) -> bool {
        matches!(self, Self::LightSide | Self::CameraSide)
    }
}

/// Every kernel there is, in the order of their names on the command line.
pub const ALL: [&Kernel; 18] = [
    &independence::KERNEL,
    &bidirectional::KERNEL,
    &guided_bidirectional::KERNEL,
    &lens::KERNEL,
    &multi_chain::KERNEL,
    &caustic::KERNEL,
    &guided_lens::KERNEL,
    &walk_lens::KERNEL,
    &kept_lens::KERNEL,
    &difference::KERNEL,
    &jump::KERNEL,
    &guided_multi_chain::KERNEL,
    &guided_caustic::KERNEL,
    &crossover::KERNEL,
    &lens_subpath::KERNEL,
    &light_subpath::KERNEL,
    &guided_light_subpath::KERNEL,
    &manifold::KERNEL,
];

/// Where a sweep from the camera ends (twin of `camera_sweep_end` in shaders/transport/path.wesl): index of the first
/// diffuse vertex that can be connected to its neighbour on the light's side, or 0, on the light.
pub fn camera_sweep_end(key: TypeKey) -> u32 {
    (1..key.edges()).rev().find(|&j| key.is_diffuse(j) && (j == 1 || key.is_diffuse(j - 1))).unwrap_or(0)
}

/// Whether only specular vertices lie between the camera and the end of its sweep.
fn sees_the_sweep_end(key: TypeKey) -> bool {
    let first_diffuse = (1..key.edges()).rev().find(|&i| key.is_diffuse(i)).unwrap_or(0);
    first_diffuse == camera_sweep_end(key)
}

/// Where a sweep from the light begins (twin of `light_sweep_start` in shaders/transport/path.wesl): the vertex before
/// the specular ones that light the diffuse one next to the camera.
pub fn light_sweep_start(key: TypeKey, features: Features) -> Option<u32> {
    let k = key.edges();
    if k < 3 || !key.is_diffuse(k - 1) || key.is_diffuse(k - 2) {
        return None;
    }
    let l = (1..k - 2).rev().find(|&i| key.is_diffuse(i)).unwrap_or(0);
    // Nothing is traced from a point of the sky.
    (l > 0 || !features.sky).then_some(l)
}

/// For kernels that every scene can use.
fn never_useless(_: Features) -> Option<&'static str> {
    None
}

/// For kernels that need specular vertices.
fn useless_without_mirrors(features: Features) -> Option<&'static str> {
    (!features.mirror).then_some("no material is specular")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{self, Diffuse as D, Reflection as R, Transmission as T};

    #[test]
    fn sweeps_end_where_a_connection_can_be_made() {
        // Tags from the light to the camera; end of the camera's sweep, start of the light's (under no sky, under a sky).
        type Case<'a> = (&'a [Tag], u32, Option<u32>, Option<u32>);
        let cases: [Case; 10] = [
            (&[], 0, None, None),                 // L E
            (&[D], 1, None, None),                // L D E
            (&[R], 0, None, None),                // L S E: on to the light
            (&[T, T], 0, None, None),             // L S S E
            (&[D, D], 2, None, None),             // L D D E
            (&[D, T, T], 1, None, None),          // L D S S E
            (&[T, D], 0, Some(0), None),          // L S D E: a caustic
            (&[D, T, R, D], 1, Some(1), Some(1)), // L D S S D E
            (&[D, R, D, T], 1, None, None),       // L D S D S E
            (&[T, D, D, R], 3, None, None),       // L S D D S E
        ];
        for (tags, end, start, start_under_sky) in cases {
            let key = TypeKey::from_tags(tags);
            assert_eq!(camera_sweep_end(key), end, "{tags:?}");
            assert_eq!(light_sweep_start(key, Features::default()), start, "{tags:?}");
            let sky = Features { sky: true, ..Default::default() };
            assert_eq!(light_sweep_start(key, sky), start_under_sky, "{tags:?}");
        }
    }

    /// A chain may end on a lamp, not in a sky.
    #[test]
    fn the_manifold_kernel_needs_a_place_behind_the_chain() {
        let under = |sky, mixed| Features { mirror: true, sky, mixed, ..Default::default() };
        let cases: [(&[Tag], [bool; 3]); 6] = [
            (&[T, D], [true, false, true]),      // L S D E
            (&[T, D, R], [true, false, true]),   // L S D S E
            (&[D, T, D, T], [true, true, true]), // L D S D S E
            (&[D, D, T], [false, false, false]), // L D D S E: what lens moves
            (&[T, T], [false, false, false]),    // L S S E
            (&[D], [false, false, false]),       // L D E
        ];
        for (tags, expected) in cases {
            let key = TypeKey::from_tags(tags);
            let applies =
                [under(false, false), under(true, false), under(true, true)].map(|f| manifold::applies(key, f));
            assert_eq!(applies, expected, "{tags:?}");
        }
    }

    /// Whatever its type, a path is moved by one of the two kernels at the camera.
    #[test]
    fn lens_or_multi_chain_applies_to_every_type() {
        for edges in 1..=7 {
            for tags in 0..1u128 << (2 * (edges - 1)) {
                let key = TypeKey::new(edges, tags);
                let features = Features { mirror: true, ..Default::default() };
                let applies = [&lens::KERNEL, &multi_chain::KERNEL].map(|k| (k.applies)(key, features));
                assert!(applies[0] != applies[1], "{key:?}");
            }
        }
    }

    #[test]
    fn names_are_unique() {
        let names: std::collections::BTreeSet<&str> = ALL.iter().map(|k| k.name).collect();
        assert_eq!(names.len(), ALL.len());
    }
}
