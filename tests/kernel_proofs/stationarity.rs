//! Weighted paired stationarity (METHOD.md 4.4 S1).
//!
//! X_0 is drawn from the bidirectional density with weight W = I / density, moved t steps to X_t by the kernel under test
//! with fixed guides that do not depend on X_0. For every kernel that leaves the target invariant,
//! E[W (h(X_t) - h(X_0))] = 0 exactly for every h: no reference and no exact samples are needed.

use crate::bench::{Bench, FILM, Guides, HALF, MAX_EDGES};
use emlt::ensemble::pool::TypeKey;
use emlt::gpu::layout::ROW_LENS;
use emlt::kernels::{Family, Kernel};

/// Side of a tile in pixels.
const TILE: u32 = 4;

pub struct Verdict {
    /// How many the kernel applied to.
    pub chains: usize,
    pub worst: f64,
    pub bins: usize,
    /// Sum of z^2 over its expectation: near 1 for an exact kernel.
    pub chi2: f64,
}

/// Rings of pixels around the film's border, where a wrong rule for proposals off the film shows first.
const RINGS: [f32; 4] = [1.0, 2.0, 4.0, 8.0];

/// Which ring a pixel position lies in; `RINGS.len()` inside all of them.
fn ring(p: [f32; 2]) -> usize {
    let distance = p[0].min(p[1]).min(FILM[0] as f32 - p[0]).min(FILM[1] as f32 - p[1]);
    RINGS.iter().position(|r| distance < *r).unwrap_or(RINGS.len())
}

/// Rows of tiles, for each tag of the vertex next to the camera: what passes specular vertices shows apart from the rest.
fn band(p: [f32; 2], key: TypeKey) -> usize {
    let row = (p[1] as u32).min(FILM[1] - 1) / TILE;
    let tag = if key.edges() > 1 { key.tag_bits(key.edges() - 1) } else { 0 };
    (3 * row + tag) as usize
}

/// Stretches of either coordinate of the point on a lens.
const LENS_PARTS: usize = 8;

/// Which part of a lens the first paths' points lie in; all in one where there is no lens.
fn lens_parts(bench: &mut Bench, count: u32) -> Vec<[usize; 2]> {
    let part = |bits: u32| ((bits & 0xffff) as usize * LENS_PARTS) >> 16;
    bench.rows(ROW_LENS, 0, count).iter().map(|row| [part(row[0]), part(row[0] >> 16)]).collect()
}

/// Largest |z| over tiles x lengths, over rings, over bands and over parts of a lens, from `rounds` times 131,072 candidates.
pub fn worst_z(bench: &mut Bench, kernel: &Kernel, flags: &[&'static str], steps: u32, rounds: u32) -> Verdict {
    let columns = FILM[0] / TILE;
    let tiles = (columns * (FILM[1] / TILE)) as usize;
    let rings = tiles * MAX_EDGES as usize;
    let bands = rings + RINGS.len() + 1;
    let lens = bands + 3 * (FILM[1] / TILE) as usize;
    let bins = lens + 2 * LENS_PARTS;
    let tile = |p: [f32; 2]| {
        let x = (p[0] as u32).min(FILM[0] - 1) / TILE;
        let y = (p[1] as u32).min(FILM[1] - 1) / TILE;
        (y * columns + x) as usize
    };
    let mut sum = vec![0.0f64; bins];
    let mut squares = vec![0.0f64; bins];
    let mut touched = vec![0usize; bins];
    let mut chains = 0usize;
    for seed in 1001..1001 + rounds {
        let (candidates, strategies) = bench.candidates(1 << 17, seed);
        let lit: Vec<u32> = (0..candidates.len() as u32).filter(|i| candidates[*i as usize].weight() > 0.0).collect();
        for (chunk_number, chunk) in lit.chunks(HALF as usize).enumerate() {
            let count = chunk.len() as u32;
            bench.fill(seed, &strategies, chunk);
            let keys = bench.keys(0, count);
            let before = bench.pixels(count);
            let lens_before = lens_parts(bench, count);
            // Pass indices of their own for every chunk: no random number is used twice.
            let first = seed * 1024 + chunk_number as u32 * 64;
            chains += if kernel.family == Family::Structural {
                for pass in first..first + steps {
                    let (uniform, _) = bench.cut_list(count, pass);
                    bench.passes(kernel, flags, uniform, pass..pass + 1);
                }
                chunk.len()
            } else {
                let (uniform, moved) = bench.list(kernel, count, Guides::Other);
                bench.passes(kernel, flags, uniform, first..first + steps);
                moved.len()
            };
            let after = bench.pixels(count);
            let lens_after = lens_parts(bench, count);
            let keys_after = bench.keys(0, count);
            for (i, &candidate) in chunk.iter().enumerate() {
                let w = candidates[candidate as usize].weight();
                let length = |key: TypeKey| (key.edges() as usize - 1) * tiles;
                let places = [
                    (length(keys[i]) + tile(before[i]), length(keys_after[i]) + tile(after[i])),
                    (rings + ring(before[i]), rings + ring(after[i])),
                    (bands + band(before[i], keys[i]), bands + band(after[i], keys_after[i])),
                    (lens + lens_before[i][0], lens + lens_after[i][0]),
                    (lens + LENS_PARTS + lens_before[i][1], lens + LENS_PARTS + lens_after[i][1]),
                ];
                for (from, to) in places.into_iter().filter(|(from, to)| from != to) {
                    for (bin, sign) in [(from, -1.0), (to, 1.0)] {
                        sum[bin] += sign * w;
                        squares[bin] += w * w;
                        touched[bin] += 1;
                    }
                }
            }
        }
    }
    let mut verdict = Verdict { chains, worst: 0.0, bins: 0, chi2: 0.0 };
    for bin in 0..bins {
        // The normal law needs a few hundred terms in a bin.
        if touched[bin] >= 300 {
            let z = sum[bin] / squares[bin].sqrt();
            verdict.worst = verdict.worst.max(z.abs());
            verdict.chi2 += z * z;
            verdict.bins += 1;
        }
    }
    verdict.chi2 /= verdict.bins.max(1) as f64;
    verdict
}
