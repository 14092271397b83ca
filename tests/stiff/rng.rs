//! Item 12: random numbers are those of their key alone, and neighbouring keys have nothing in common.

use emlt::ensemble::bootstrap::CANDIDATE_PASS;
use emlt::gpu::context::Context;
use emlt::reference::rng::{pcg4d, random_words, uniform};

use super::bench::Bench;
use super::furnaces::{EDGES, box_furnace};

/// Which of a key's words is counted up: path, pass, dimension, seed.
const DIRECTIONS: usize = 4;
/// Dimensions of a mutation: fewer than 256. Over a million of them, one after another, the first word of the generator
/// collides 40 % more often than chance has it, so they are counted as they are used: 256, then the next path's.
const DIMENSIONS: u32 = 256;

fn words(direction: usize, n: u32) -> [u32; 4] {
    let mut key = [5, 1000, 3, 1];
    if direction == 2 {
        key[0] += n / DIMENSIONS;
        key[2] = n % DIMENSIONS;
    } else {
        key[direction] += n;
    }
    pcg4d(key)
}

/// The device draws what its twin says, bit for bit: the pixels of camera paths among a start's candidates.
#[test]
fn the_device_draws_its_twins_numbers() {
    // Dimension block of a candidate's pixel (DIMENSION_KERNEL + 1), and the film.
    const DIMENSION: u32 = 3;
    const FILM: [u32; 2] = [16, 12];
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut bench = Bench::new(&context, &box_furnace(), FILM, EDGES, 4096);
    let (candidates, strategies) = bench.candidates(1 << 16);
    let mut compared = 0;
    for (i, (candidate, [edges, light])) in (0..).zip(candidates.iter().zip(strategies)) {
        // Walks, and paths of which the camera's ray is traced.
        if edges == 0 || light < edges {
            let words = random_words(bench.start.seed, i, CANDIDATE_PASS, DIMENSION);
            let drawn = |c: usize| ((words[c] >> 8) as f32 + 0.5) * 2f32.powi(-24) * FILM[c] as f32;
            assert_eq!(candidate.pixel, [drawn(0), drawn(1)], "candidate {i}");
            compared += 1;
        }
    }
    assert!(compared > 30_000, "{compared}");
}

/// Rank correlations of numbers with those of the next key, of every word with every word, and of the words of a key.
/// Under independence each is normal with variance 1 / n; Bonferroni's limit for 112 of them, false alarms below 1e-5.
#[test]
fn neighbouring_keys_are_not_correlated() {
    const N: usize = 1 << 17;
    let ranks = |values: Vec<u32>| -> Vec<f64> {
        let mut order: Vec<u32> = (0..values.len() as u32).collect();
        order.sort_unstable_by_key(|i| values[*i as usize]);
        let mut ranks = vec![0.0; values.len()];
        order.iter().zip(0..).for_each(|(i, rank)| ranks[*i as usize] = f64::from(rank) / N as f64 - 0.5);
        ranks
    };
    let mut worst: f64 = 0.0;
    for direction in 0..DIRECTIONS {
        let drawn: Vec<[u32; 4]> = (0..N as u32).map(|n| words(direction, n)).collect();
        let ranks: Vec<Vec<f64>> = (0..4).map(|word| ranks(drawn.iter().map(|w| w[word]).collect())).collect();
        for a in 0..4 {
            for b in 0..4 {
                for lag in [0, 1].into_iter().filter(|lag| *lag == 1 || a < b) {
                    let sum: f64 = ranks[a].iter().zip(ranks[b].iter().cycle().skip(lag)).map(|(x, y)| x * y).sum();
                    worst = worst.max((12.0 * sum / N as f64).abs() * (N as f64).sqrt());
                }
            }
        }
    }
    println!("largest rank correlation of neighbouring keys: {worst:.2} standard deviations");
    assert!(worst < 5.5, "{worst}");
    // What the test can see: numbers that share a fiftieth of their variance.
    assert!(0.02 * (N as f64).sqrt() > 5.5);
}

/// Of 2^20 neighbouring keys' 32-bit words, 128 pairs collide on average; of the first 16 bits of two words, taken
/// together, as many. Poisson's law: false alarms of all 40 counts below 1e-5.
#[test]
fn neighbouring_keys_collide_as_chance_has_it() {
    const N: u32 = 1 << 20;
    let expected = f64::from(N) * f64::from(N - 1) / 2.0 / 2f64.powi(32);
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for direction in 0..DIRECTIONS {
        let drawn: Vec<[u32; 4]> = (0..N).map(|n| words(direction, n)).collect();
        let mut count = |value: &dyn Fn(&[u32; 4]) -> u32| {
            let mut values: Vec<u32> = drawn.iter().map(value).collect();
            values.sort_unstable();
            // Pairs: a value that occurs m times makes m (m - 1) / 2.
            let pairs: usize = values.chunk_by(|a, b| a == b).map(|same| same.len() * (same.len() - 1) / 2).sum();
            least = least.min(pairs as f64);
            most = most.max(pairs as f64);
        };
        for a in 0..4 {
            count(&|w| w[a]);
            (0..a).for_each(|b| count(&|w| w[a] & 0xffff_0000 | w[b] >> 16));
        }
    }
    println!("collisions among {N} neighbouring keys: {least} to {most}, {expected:.0} expected");
    assert!(least > expected - 5.2 * expected.sqrt() && most < expected + 5.8 * expected.sqrt(), "{least} {most}");
}

/// Pairs of numbers of neighbouring keys fill the unit square evenly: chi2 over 64 x 64 cells, 16 tests, false alarms
/// below 1e-5 (Wilson and Hilferty's approximation).
#[test]
fn neighbouring_keys_fill_the_square() {
    const N: u32 = 1 << 19;
    const SIDE: usize = 64;
    let freedom = (SIDE * SIDE - 1) as f64;
    let limit = freedom * (1.0 - 2.0 / (9.0 * freedom) + 4.9 * (2.0 / (9.0 * freedom)).sqrt()).powi(3);
    let mean = f64::from(N) / (SIDE * SIDE) as f64;
    for direction in 0..DIRECTIONS {
        for word in 0..4 {
            let mut cells = vec![0.0; SIDE * SIDE];
            let cell = |n: u32| (uniform(words(direction, n)[word]) * SIDE as f64) as usize;
            (0..N).for_each(|n| cells[cell(n) * SIDE + cell(n + 1)] += 1.0);
            let chi2: f64 = cells.iter().map(|c: &f64| (c - mean).powi(2) / mean).sum();
            assert!(chi2 < limit, "direction {direction}, word {word}: chi2 {chi2} of {freedom}");
        }
    }
}
