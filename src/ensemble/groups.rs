//! Groups: independent ensembles that the same dispatches move (METHOD.md 5.10).
//!
//! Paths of one ensemble guide each other, so their scatter does not tell the image's error. Groups do: each has its own
//! halves, start and layer of the film, and nothing of one reaches another, so that the scatter of their images does.
//! A group is a stretch of either half, so that its guides lie side by side, and dispatches still go over whole halves,
//! sorted by type before they are sorted by group.

use super::pool::Pool;

/// Groups unless told otherwise, which is also the most there may be: each has a layer of the film.
pub const MOST_GROUPS: u32 = 8;

/// How the paths of both halves are split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Groups {
    /// Paths of both halves together.
    paths: u32,
    count: u32,
}

impl Groups {
    /// The most groups, but no more than `wanted`, into which both halves of `paths` can be split evenly: their images
    /// then count alike.
    pub fn new(paths: u32, wanted: u32) -> Self {
        let half = paths / 2;
        let count = (1..=wanted.max(1)).rev().find(|count| half.is_multiple_of(*count)).unwrap_or(1);
        Self { paths, count }
    }

    pub fn count(self) -> u32 {
        self.count
    }

    /// Paths of both halves and all groups.
    pub fn paths(self) -> u32 {
        self.paths
    }

    /// Paths of one half, all groups together.
    pub fn half_paths(self) -> u32 {
        self.paths / 2
    }

    /// Paths of one group in one half.
    pub fn group_paths(self) -> u32 {
        self.half_paths() / self.count
    }

    /// The first path of a half (0 or 1).
    pub fn first_of_half(self, half: usize) -> u32 {
        half as u32 * self.half_paths()
    }

    /// The first path of a group in a half.
    pub fn first(self, half: usize, group: u32) -> u32 {
        self.first_of_half(half) + group * self.group_paths()
    }

    /// The group of a path. Twin: `layer_of` in shaders/target/film.wesl.
    pub fn of_path(self, path: u32) -> u32 {
        path % self.half_paths() / self.group_paths()
    }
}

/// One group of a half while it is frozen: its pool, and the median log similarity of its members (METHOD.md 3.4).
#[derive(Debug, Clone, Default)]
pub struct Group {
    pub pool: Pool,
    pub similarity_median: f32,
}

impl Group {
    pub fn new(pool: Pool) -> Self {
        Self { pool, similarity_median: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_has_its_group() {
        let groups = Groups::new(48, 8);
        assert_eq!((groups.count(), groups.half_paths(), groups.group_paths()), (8, 24, 3));
        for half in 0..2 {
            for group in 0..8 {
                let first = groups.first(half, group);
                assert!((first..first + 3).all(|path| groups.of_path(path) == group));
            }
        }
        assert_eq!((groups.first(0, 0), groups.first(1, 7) + 3), (0, 48));
    }

    #[test]
    fn halves_that_cannot_be_split_in_eight_are_split_in_fewer() {
        for (paths, wanted, count) in [(16384, 8, 8), (16384, 5, 4), (36, 8, 6), (26, 8, 1), (2, 8, 1), (64, 0, 1)] {
            assert_eq!(Groups::new(paths, wanted).count(), count, "{paths} {wanted}");
        }
    }
}
