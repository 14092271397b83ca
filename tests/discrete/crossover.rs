//! The chain of a pair of paths under crossover (METHOD.md 3.6 b), enumerated: cuts and their numbers are the
//! renderer's, paths are short strings of points.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use super::world::hash;
use crate::{EXACT, largest_difference, largest_relative_difference};
use emlt::ensemble::crossings::{crossings, log_cut};
use emlt::ensemble::pool::{Tag, TypeKey};

/// Two diffuse points, which also shine, and a mirror.
const POINTS: u8 = 3;
const MIRROR: u8 = 2;

/// A path from its light to the point next to the camera.
type Path = Vec<u8>;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Twin {
    Correct,
    /// The light's side of v is copied and v stays: "sharing" it.
    OnlyX,
    /// As many cuts there as back, whatever the types.
    CutLeftOut,
}

struct World {
    lengths: RangeInclusive<u32>,
    paths: Vec<Path>,
    keys: Vec<TypeKey>,
    /// I, a whole number, 0 for some.
    weights: Vec<f64>,
    number: HashMap<Path, usize>,
}

impl World {
    fn new(lengths: RangeInclusive<u32>) -> Self {
        let longer = |path: &Path| (0..POINTS).map(|p| [&path[..], &[p]].concat()).collect::<Vec<Path>>();
        let mut of_length: Vec<Path> = (0..MIRROR).map(|light| vec![light]).collect();
        let mut paths = Vec::new();
        for edges in 1..=*lengths.end() {
            if lengths.contains(&edges) {
                paths.extend(of_length.clone());
            }
            of_length = of_length.iter().flat_map(longer).collect();
        }
        let tag = |p: &u8| if *p == MIRROR { Tag::Reflection } else { Tag::Diffuse };
        let keys = paths.iter().map(|p| TypeKey::from_tags(&p[1..].iter().map(tag).collect::<Vec<_>>())).collect();
        let weight = |path: &Path| {
            let scramble = path.iter().fold(path.len() as u64, |h, p| hash(h, u64::from(*p)));
            [0, 1, 1, 2, 3, 5, 9][scramble as usize % 7] as f64
        };
        let weights = paths.iter().map(weight).collect();
        let number = paths.iter().cloned().zip(0..).collect();
        Self { lengths, paths, keys, weights, number }
    }

    /// pi x pi.
    fn target(&self) -> Vec<f64> {
        let sum: f64 = self.weights.iter().sum();
        self.weights.iter().flat_map(|x| self.weights.iter().map(move |v| x * v / (sum * sum))).collect()
    }

    /// The law of the pair after one crossover from `law`.
    fn step(&self, law: &[f64], twin: Twin) -> Vec<f64> {
        let n = self.paths.len();
        let mut after = law.to_vec();
        for (from, &mass) in law.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
            let (x, v) = (from / n, from % n);
            let pair = [self.keys[x], self.keys[v]];
            let choices: Vec<_> = crossings(pair, self.lengths.clone()).collect();
            for &crossing in &choices {
                let (a, c) = (crossing.x as usize, crossing.v as usize);
                let joined = |light: &[u8], camera: &[u8]| self.number[&[light, camera].concat()];
                let x_new = joined(&self.paths[v][..c], &self.paths[x][a..]);
                let v_new = joined(&self.paths[x][..a], &self.paths[v][c..]);
                assert_eq!(crossing.exchanged(pair), [self.keys[x_new], self.keys[v_new]]);
                let mut ratio = self.weights[x_new] * self.weights[v_new] / (self.weights[x] * self.weights[v]);
                if twin != Twin::CutLeftOut {
                    ratio *= log_cut(pair, crossing, self.lengths.clone()).exp();
                }
                let to = x_new * n + if twin == Twin::OnlyX { v } else { v_new };
                let moved = mass / choices.len() as f64 * ratio.min(1.0);
                after[from] -= moved;
                after[to] += moved;
            }
        }
        after
    }
}

#[test]
fn crossovers_keep_the_product_of_targets() {
    for lengths in [1..=4, 2..=5] {
        let world = World::new(lengths.clone());
        let target = world.target();
        let defect = |twin| {
            let after = world.step(&target, twin);
            (largest_difference(&after, &target), largest_relative_difference(&after, &target))
        };
        let (defect_of_all, relative) = defect(Twin::Correct);
        println!("{lengths:?}, {} paths: {defect_of_all:.1e}, relative {relative:.1e}", world.paths.len());
        assert!(defect_of_all < EXACT && relative < EXACT);
        for twin in [Twin::OnlyX, Twin::CutLeftOut] {
            let (defect, relative) = defect(twin);
            println!("{lengths:?}, {twin:?}: {defect:.1e}, relative {relative:.1e}");
            assert!(relative > 0.01, "{twin:?} passes with {relative:e}");
        }
    }
}
