//! What bidirectional mutations replace (METHOD.md 2.2): drawn on the host from the path's own random numbers, so that the
//! dispatch list can be sorted by it.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::pool::{Pool, TypeKey};
use super::runs::merged;
use crate::reference::rng;

/// Dimension blocks from which the host draws: the cut, and the guide.
const DIMENSION_CUT: u32 = 0xffff;
const DIMENSION_GUIDE: u32 = 0xfffe;

/// Vertices `first .. first + deleted` of a path are replaced by `added` new ones, `light_new` of them from the light's
/// side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    pub added: u32,
    pub light_new: u32,
    pub first: u32,
    pub deleted: u32,
}

impl Cut {
    /// As `unpack_cut` in shaders/kernels/bidirectional.wesl reads it.
    pub fn packed(self) -> u32 {
        self.first | self.deleted << 8 | self.added << 16 | self.light_new << 24
    }

    /// Cuts in the order of this number trace alike with their neighbours.
    fn order(self) -> u32 {
        self.added << 24 | self.light_new << 16 | self.first << 8 | self.deleted
    }

    /// The cut that leads back.
    pub fn reversed(self) -> Self {
        Self { added: self.deleted, deleted: self.added, ..self }
    }

    /// Draws a cut of a path of the type of `places` from four random words; `None` where it would leave `lengths` or has
    /// no place: the path rests then, as after any proposal that fails.
    ///
    /// The number of deleted vertices is 0 with probability 1/4, 1 with 1/2, then halves (Veach's law); that of the added
    /// ones differs from it by a symmetric law. Places and splits are uniform. The shader has the densities.
    pub fn draw(places: &mut Places, words: [u32; 4], lengths: &RangeInclusive<u32>) -> Option<Self> {
        let [deletion, change, place, split] = words.map(rng::uniform);
        let deleted = match deletion {
            u if u < 0.25 => 0,
            u if u < 0.75 => 1,
            // P(n) = 2^-(n + 1) from n = 2 on.
            u => (-(1.0 - u).log2()).floor() as u32,
        };
        let change = match change {
            u if u < 0.5 => 0,
            u if u < 0.65 => 1,
            u if u < 0.8 => -1,
            u if u < 0.875 => 2,
            u if u < 0.95 => -2,
            u if u < 0.975 => 3,
            _ => -3,
        };
        let added = u32::try_from(deleted as i32 + change).ok()?;
        let edges = (places.key.edges() + added).checked_sub(deleted)?;
        if !lengths.contains(&edges) || (deleted == 0 && added == 0) {
            return None;
        }
        let places = places.of(deleted);
        let first = *places.get((place * places.len() as f64) as usize)?;
        if first == 0 && added == 0 {
            return None;
        }
        let light_new = ((split * f64::from(added + 1)) as u32).min(added);
        Some(Self { added, light_new, first, deleted })
    }
}

/// Where the paths of one type can be cut, looked up once for each number of deleted vertices.
pub struct Places {
    key: TypeKey,
    by_deleted: Vec<Option<Vec<u32>>>,
}

impl Places {
    pub fn new(key: TypeKey) -> Self {
        Self { key, by_deleted: vec![None; key.edges() as usize + 2] }
    }

    fn of(&mut self, deleted: u32) -> &[u32] {
        match self.by_deleted.get_mut(deleted as usize) {
            Some(known) => known.get_or_insert_with(|| places(self.key, deleted).collect()),
            // More than there are.
            None => &[],
        }
    }
}

/// One entry of the pass `bidirectional`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CutEntry {
    pub path: u32,
    pub cut: Cut,
    /// Column and edges of the guide.
    pub guide: [u32; 2],
}

impl CutEntry {
    pub fn words(self) -> [u32; 4] {
        [self.path, self.cut.packed(), self.guide[0], self.guide[1]]
    }
}

/// The work of one bidirectional pass over a half.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CutList {
    /// Sorted so that neighbours trace alike.
    pub entries: Vec<CutEntry>,
    /// The entries, then (path, 0) for every path that has no cut and rests.
    pub words: Vec<u32>,
    pub resting: u32,
    pub resting_offset: u32,
}

impl CutList {
    /// Draws a cut for every path of every group with `random(path, dimension)`. A group is its moving half, the frozen
    /// one, and the column of the latter's first guide. The guide of a path is any member of the frozen half of its group,
    /// whatever the types, the same for the way back (METHOD.md 3.6a).
    pub fn draw(
        groups: &[(&Pool, &Pool, u32)],
        random: impl Fn(u32, u32) -> [u32; 4] + Sync,
        lengths: RangeInclusive<u32>,
    ) -> Self {
        let of_group = |&(moving, guides, guides_first): &(&Pool, &Pool, u32)| {
            let mut entries: Vec<(u32, TypeKey, CutEntry)> = Vec::with_capacity(moving.order.len());
            let mut resting: Vec<u32> = Vec::new();
            for node in &moving.types {
                let mut places = Places::new(node.key);
                for &path in moving.members(node.range) {
                    match Cut::draw(&mut places, random(path, DIMENSION_CUT), &lengths) {
                        Some(cut) => {
                            let place = random(path, DIMENSION_GUIDE)[0] % guides.order.len() as u32;
                            let guide = [guides_first + place, guides.key_at(place).edges()];
                            entries.push((cut.order(), node.key, CutEntry { path, cut, guide }));
                        }
                        None => resting.extend([path, 0]),
                    }
                }
            }
            // Types are in order already.
            entries.sort_by_key(|entry| entry.0);
            (entries, resting)
        };
        let (entries, resting): (Vec<_>, Vec<_>) = groups.par_iter().map(of_group).unzip();
        let (entries, resting) = (merged(&entries, |(order, key, _)| (*order, *key)), resting.concat());
        let mut list = Self { entries: entries.into_iter().map(|(_, _, entry)| entry).collect(), ..Self::default() };
        list.words.extend(list.entries.iter().flat_map(|entry| entry.words()));
        list.resting_offset = list.words.len() as u32;
        list.resting = resting.len() as u32 / 2;
        list.words.extend(resting);
        list
    }
}

/// First vertices of the stretches of `deleted` vertices that can be taken out: both kept ends diffuse, the light or the
/// camera, and the stretch one that can be made, by a connection somewhere in it or by hitting the light.
/// Twin: `count_places` in shaders/kernels/bidirectional.wesl.
pub fn places(key: TypeKey, deleted: u32) -> impl Iterator<Item = u32> {
    let edges = key.edges();
    let is_end = move |i: u32| i == 0 || i == edges || key.is_diffuse(i);
    (0..(edges + 1).saturating_sub(deleted)).filter(move |&first| {
        let end = first + deleted;
        let made = first == 0 || (first..=end).any(|i| is_end(i - 1) && is_end(i));
        let light_end = first == 0 || is_end(first - 1);
        // With x_0 goes at least one vertex, since the next is on no light.
        made && light_end && end > 0 && is_end(end)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{Diffuse as D, Transmission as T};

    #[test]
    fn ends_are_diffuse_or_the_paths_own() {
        let key = TypeKey::from_tags(&[D, T, D, D]);
        let found = |deleted| places(key, deleted).collect::<Vec<_>>();
        // Edges x_0 x_1, x_3 x_4 and x_4 E.
        assert_eq!(found(0), [1, 4, 5]);
        // Vertices x_0 and x_4, but not x_2: nothing connects to it.
        assert_eq!(found(1), [0, 4]);
        assert_eq!(found(5), [0]);
        assert!(found(6).is_empty());
    }

    /// Every cut leads to a path from which the way back can be drawn.
    #[test]
    fn the_way_back_has_a_place() {
        let key = TypeKey::from_tags(&[D, T, D, D]);
        let mut at = Places::new(key);
        let mut drawn = [0; 2];
        for i in 0..20_000 {
            let Some(cut) = Cut::draw(&mut at, rng::random_words(7, i, 0, 0), &(1..=8)) else {
                drawn[0] += 1;
                continue;
            };
            drawn[1] += 1;
            assert!(cut.light_new <= cut.added && cut.first + cut.deleted <= key.edges());
            // New vertices all diffuse.
            let kept = |i: u32| if i < cut.first { i } else { i + cut.deleted - cut.added };
            let edges = key.edges() + cut.added - cut.deleted;
            assert!((1..=8).contains(&edges));
            let is_new = |i: u32| (cut.first..cut.first + cut.added).contains(&i);
            let tags = (1..edges).map(|i| if is_new(i) { 0 } else { u128::from(key.tag_bits(kept(i))) });
            let y = TypeKey::new(edges, tags.enumerate().map(|(i, tag)| tag << (2 * i)).sum());
            assert!(places(y, cut.added).any(|first| first == cut.first), "{cut:?} of {y:?}");
            assert_eq!(cut.reversed().reversed(), cut);
        }
        assert!(drawn[1] > 10_000, "{drawn:?}");
    }

    #[test]
    fn deletions_follow_their_law() {
        // A path with a place for every deletion: all diffuse, 31 edges.
        let key = TypeKey::new(31, 0);
        let mut at = Places::new(key);
        let mut counts = [0u32; 8];
        let n = 100_000;
        for i in 0..n {
            if let Some(cut) = Cut::draw(&mut at, rng::random_words(1, i, 0, 0), &(1..=60)) {
                counts[(cut.deleted as usize).min(7)] += u32::from(cut.added == cut.deleted + 1);
            }
        }
        // Added one more than deleted: 0.15 of the draws.
        for (deleted, probability) in [(1, 0.5), (2, 0.125), (3, 0.0625)] {
            let expected = 0.15 * probability * f64::from(n);
            let z = (f64::from(counts[deleted]) - expected) / expected.sqrt();
            assert!(z.abs() < 4.5, "{deleted}: {counts:?}");
        }
    }

    #[test]
    fn guides_are_of_the_paths_own_group() {
        let keys = |n: usize| -> Vec<TypeKey> { (0..n).map(|i| TypeKey::from_tags(&[D, D, D][..1 + i % 3])).collect() };
        // Two groups of 30: halves 0 to 59 and 60 to 119.
        let pools: Vec<Pool> = (0..4).map(|i| Pool::build(&keys(30), 30 * i)).collect();
        let groups = [(&pools[0], &pools[2], 60), (&pools[1], &pools[3], 90)];
        let list = CutList::draw(&groups, |path, dimension| rng::random_words(5, path, 1, dimension), 1..=8);
        assert!(list.entries.len() > 30 && list.entries.is_sorted_by_key(|entry| entry.cut.order()));
        for entry in &list.entries {
            let group = entry.path / 30;
            assert!((60 + 30 * group..90 + 30 * group).contains(&entry.guide[0]), "{entry:?}");
        }
        assert_eq!(list.entries.len() as u32 + list.resting, 60);
    }
}
