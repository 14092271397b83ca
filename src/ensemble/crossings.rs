//! What crossovers exchange (METHOD.md 3.6b): partners and cuts, drawn on the host, which knows every path's type. So
//! the probability of a cut is counted here both ways, and the shaders have no law of their own to keep in step.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use super::pool::{Pool, TypeKey};
use crate::reference::rng;

/// Dimension block from which the host draws the cut of a pair, under its first path.
const DIMENSION_CUT: u32 = 0xffff;

/// Where a pair of paths is cut: x gives up its first `x` vertices for the first `v` of v.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    pub x: u32,
    pub v: u32,
}

impl Crossing {
    /// As `part_of` in shaders/kernels/crossover.wesl reads it.
    pub fn packed(self) -> u32 {
        self.x | self.v << 8
    }

    /// The crossing of the exchanged paths that gives the old ones back.
    pub fn reversed(self) -> Self {
        Self { x: self.v, v: self.x }
    }

    /// The types of the exchanged paths.
    pub fn exchanged(self, [x, v]: [TypeKey; 2]) -> [TypeKey; 2] {
        [joined(v, self.v, x, self.x), joined(x, self.x, v, self.v)]
    }
}

/// The type of the first `light_count` vertices of `light`, then those of `camera` from number `camera_first` on.
fn joined(light: TypeKey, light_count: u32, camera: TypeKey, camera_first: u32) -> TypeKey {
    let edges = light_count + camera.edges() - camera_first;
    let tag = |i: u32| {
        if i < light_count { light.tag_bits(i) } else { camera.tag_bits(i - light_count + camera_first) }
    };
    TypeKey::new(edges, (1..edges).map(|i| u128::from(tag(i)) << (2 * (i - 1))).sum())
}

/// Numbers of vertices that can be taken from the light's side of a path: both ends of the edge that this opens are
/// diffuse, or the light. The last edge, to the camera, stays, and with it the pixel.
fn joints(key: TypeKey) -> impl Iterator<Item = u32> + Clone {
    (1..key.edges()).filter(move |&a| key.is_diffuse(a) && (a == 1 || key.is_diffuse(a - 1)))
}

/// The admissible crossings of a pair: between joints, with both lengths in `lengths`. The exchanged paths have the
/// same joints there, so every way has its way back.
pub fn crossings([x, v]: [TypeKey; 2], lengths: RangeInclusive<u32>) -> impl Iterator<Item = Crossing> {
    joints(x).flat_map(move |a| joints(v).map(move |c| Crossing { x: a, v: c })).filter(move |crossing| {
        let edges = [x.edges() - crossing.x + crossing.v, v.edges() - crossing.v + crossing.x];
        edges.iter().all(|k| lengths.contains(k))
    })
}

/// log P(cut | x', v') - log P(cut | x, v): cuts are uniform over the admissible ones, whose number is not the same both
/// ways.
pub fn log_cut(pair: [TypeKey; 2], crossing: Crossing, lengths: RangeInclusive<u32>) -> f64 {
    let log_count = |pair| (crossings(pair, lengths.clone()).count() as f64).ln();
    log_count(pair) - log_count(crossing.exchanged(pair))
}

/// One entry of the passes `crossover` and `exchange`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// x and v.
    pub paths: [u32; 2],
    pub crossing: Crossing,
    /// See [`log_cut`].
    pub log_cut: f32,
}

impl Pair {
    pub fn words(self) -> [u32; 4] {
        [self.paths[0], self.paths[1], self.crossing.packed(), self.log_cut.to_bits()]
    }
}

/// Both halves of a group, where their paths begin, and how far partners are apart.
#[derive(Debug, Clone, Copy)]
pub struct Partners<'a> {
    pub halves: [&'a Pool; 2],
    pub first: [u32; 2],
    pub shift: u32,
}

/// The work of one crossover over both halves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PairList {
    /// Sorted so that neighbours are composed alike.
    pub pairs: Vec<Pair>,
    /// The pairs, then (path, 0) for both paths of every pair that has no crossing: they rest.
    pub words: Vec<u32>,
    pub resting: u32,
    pub resting_offset: u32,
}

impl PairList {
    /// In every group pairs path i of the one half with path i + shift (modulo their number) of the other, whatever the
    /// two are, and draws a crossing for every pair with `random(path, dimension)`.
    pub fn draw<'a>(
        groups: impl IntoIterator<Item = Partners<'a>>,
        random: impl Fn(u32, u32) -> [u32; 4],
        lengths: RangeInclusive<u32>,
    ) -> Self {
        let mut list = Self::default();
        let mut resting: Vec<u32> = Vec::new();
        // Types are few: every pair of them is counted once.
        let mut known: HashMap<[TypeKey; 2], Vec<(Crossing, f32)>> = HashMap::new();
        for Partners { halves, first, shift } in groups {
            let [x_keys, v_keys] = [0, 1].map(|half| keys_by_path(halves[half], first[half]));
            let count = x_keys.len() as u32;
            for i in 0..count {
                let partner = (i + shift % count) % count;
                let paths = [first[0] + i, first[1] + partner];
                let keys = [x_keys[i as usize], v_keys[partner as usize]];
                let choices = known.entry(keys).or_insert_with(|| {
                    let with_cut = |crossing| (crossing, log_cut(keys, crossing, lengths.clone()) as f32);
                    crossings(keys, lengths.clone()).map(with_cut).collect()
                });
                let place = rng::uniform(random(paths[0], DIMENSION_CUT)[0]) * choices.len() as f64;
                match choices.get(place as usize) {
                    Some(&(crossing, log_cut)) => list.pairs.push(Pair { paths, crossing, log_cut }),
                    None => resting.extend(paths.into_iter().flat_map(|path| [path, 0])),
                }
            }
        }
        list.pairs.sort_by_key(|pair| pair.crossing);
        list.words.extend(list.pairs.iter().flat_map(|pair| pair.words()));
        list.resting_offset = list.words.len() as u32;
        list.resting = resting.len() as u32 / 2;
        list.words.extend(resting);
        list
    }
}

/// The type of every path of a half, whose paths count from `first` on.
fn keys_by_path(half: &Pool, first: u32) -> Vec<TypeKey> {
    let mut keys = vec![TypeKey::new(1, 0); half.order.len()];
    for node in &half.types {
        half.members(node.range).iter().for_each(|path| keys[(path - first) as usize] = node.key);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{Diffuse as D, Reflection as R, Transmission as T};

    #[test]
    fn parts_are_joined_between_diffuse_vertices() {
        let x = TypeKey::from_tags(&[D, T, D, D]);
        // x_0 x_1 and x_3 x_4, but not x_4 E.
        assert_eq!(joints(x).collect::<Vec<_>>(), [1, 4]);
        let v = TypeKey::from_tags(&[R, D, D]);
        assert_eq!(joints(v).collect::<Vec<_>>(), [3]);
        let crossing = Crossing { x: 4, v: 3 };
        let exchanged = crossing.exchanged([x, v]);
        assert_eq!(exchanged, [&[R, D, D][..], &[D, T, D, D]].map(TypeKey::from_tags));
        let crossing = Crossing { x: 1, v: 3 };
        let exchanged = crossing.exchanged([x, v]);
        assert_eq!(exchanged, [&[R, D, D, T, D, D][..], &[D]].map(TypeKey::from_tags));
        assert_eq!(crossing.reversed().exchanged(exchanged), [x, v]);
        assert!(joints(TypeKey::from_tags(&[])).next().is_none());
    }

    /// Every crossing keeps within the lengths, has its way back, and differs from the others of its pair.
    #[test]
    fn every_crossing_has_its_way_back() {
        let keys: Vec<TypeKey> = [&[D][..], &[D, D], &[T, D, D], &[D, T, T, D], &[R, D, D, D, D], &[D, D, T, D, D, D]]
            .map(TypeKey::from_tags)
            .to_vec();
        let mut uneven = 0;
        for lengths in [1..=8, 3..=6] {
            for pair in keys.iter().flat_map(|x| keys.iter().map(move |v| [*x, *v])) {
                if !pair.iter().all(|key| lengths.contains(&key.edges())) {
                    continue;
                }
                for crossing in crossings(pair, lengths.clone()) {
                    let exchanged = crossing.exchanged(pair);
                    assert!(exchanged.iter().all(|key| lengths.contains(&key.edges())), "{pair:?} {crossing:?}");
                    assert!(crossings(exchanged, lengths.clone()).any(|back| back == crossing.reversed()));
                    assert_eq!(crossing.reversed().exchanged(exchanged), pair);
                    let there = log_cut(pair, crossing, lengths.clone());
                    assert_eq!(there, -log_cut(exchanged, crossing.reversed(), lengths.clone()));
                    uneven += usize::from(there != 0.0);
                }
            }
        }
        assert!(uneven > 20, "{uneven}");
    }

    #[test]
    fn every_path_is_in_one_pair_or_rests() {
        let keys = |n: usize| -> Vec<TypeKey> {
            (0..n).map(|i| TypeKey::from_tags([&[D][..], &[T, D, D], &[T, D], &[D, D]][i * i % 7 % 4])).collect()
        };
        for (count, shift) in [(1, 5), (40, 0), (41, u32::MAX)] {
            let halves = [Pool::build(&keys(count), 0), Pool::build(&keys(count), 100)];
            let random = |path, dimension| rng::random_words(3, path, 9, dimension);
            let group = Partners { halves: [&halves[0], &halves[1]], first: [0, 100], shift };
            let list = PairList::draw([group], random, 1..=8);
            let mut paths: Vec<u32> = list.pairs.iter().flat_map(|pair| pair.paths).collect();
            let resting = &list.words[list.resting_offset as usize..];
            assert_eq!(
                (resting.len(), list.words.len()),
                (2 * list.resting as usize, 4 * list.pairs.len() + resting.len())
            );
            paths.extend(resting.iter().step_by(2));
            paths.sort_unstable();
            let all: Vec<u32> = (0..count as u32).chain(100..100 + count as u32).collect();
            assert_eq!(paths, all);
            assert!(count == 1 || (!list.pairs.is_empty() && list.resting > 0));
        }
    }

    #[test]
    fn partners_are_of_one_group() {
        let pools: Vec<Pool> = (0..4).map(|i| Pool::build(&[TypeKey::from_tags(&[D, D, D]); 30], 30 * i)).collect();
        let group = |i: usize| Partners {
            halves: [&pools[i], &pools[2 + i]],
            first: [30 * i as u32, 60 + 30 * i as u32],
            shift: 7 + i as u32,
        };
        let list = PairList::draw([group(0), group(1)], |path, d| rng::random_words(5, path, 1, d), 1..=8);
        assert_eq!(list.pairs.len(), 60);
        assert!(list.pairs.iter().all(|pair| pair.paths[0] / 30 + 2 == pair.paths[1] / 30));
    }
}
