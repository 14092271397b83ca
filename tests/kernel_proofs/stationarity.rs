//! Weighted paired stationarity (METHOD.md 4.4 S1).
//!
//! X_0 is drawn from the bidirectional density with weight W = I / density, moved t steps to X_t by the kernel under test
//! with fixed guides that do not depend on X_0. For every kernel that leaves the target invariant,
//! E[W (h(X_t) - h(X_0))] = 0 exactly for every h: no reference and no exact samples are needed.

use crate::bench::{Bench, FILM, Guides, HALF, MAX_EDGES, SEED};
use emlt::ensemble::pool::TypeKey;
use emlt::gpu::layout::{ROW_KEY, ROW_LENS, ROW_PIXEL};
use emlt::kernels::{Family, Kernel};
use emlt::reference::rng;

/// Side of a tile in pixels.
const TILE: u32 = 4;

pub struct Verdict {
    /// How many there were.
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

const COLUMNS: u32 = FILM[0] / TILE;
const ROWS: u32 = FILM[1] / TILE;
const TILES: usize = (COLUMNS * ROWS) as usize;
// Bins: tiles by lengths, then rings, bands and the parts of a lens.
const FIRST_RING: usize = TILES * MAX_EDGES as usize;
const FIRST_BAND: usize = FIRST_RING + RINGS.len() + 1;
const FIRST_PART: usize = FIRST_BAND + 3 * ROWS as usize;
const BINS: usize = FIRST_PART + 2 * LENS_PARTS;

/// The rows of the chains by which a state is told.
pub const PLACE_ROWS: [usize; 3] = [ROW_KEY, ROW_PIXEL, ROW_LENS];

/// The bins that a state lies in, from those rows.
pub type Place = [usize; 5];

pub fn place([key, pixel, lens]: [[u32; 4]; 3]) -> Place {
    let key = TypeKey::from_words([key[0], key[1]]).unwrap();
    let p = [f32::from_bits(pixel[0]), f32::from_bits(pixel[1])];
    let [x, y] = [(p[0] as u32).min(FILM[0] - 1) / TILE, (p[1] as u32).min(FILM[1] - 1) / TILE];
    // Where there is no lens, all in one part.
    let part = |bits: u32| ((bits & 0xffff) as usize * LENS_PARTS) >> 16;
    [
        (key.edges() as usize - 1) * TILES + (y * COLUMNS + x) as usize,
        FIRST_RING + ring(p),
        FIRST_BAND + band(p, key),
        FIRST_PART + part(lens[0]),
        FIRST_PART + LENS_PARTS + part(lens[0] >> 16),
    ]
}

/// Sums of W (h(X_t) - h(X_0)) by bin.
pub struct Paired {
    sum: Vec<f64>,
    squares: Vec<f64>,
    touched: Vec<usize>,
    pub chains: usize,
}

impl Paired {
    pub fn new() -> Self {
        Self { sum: vec![0.0; BINS], squares: vec![0.0; BINS], touched: vec![0; BINS], chains: 0 }
    }

    pub fn add(&mut self, before: &Place, after: &Place, w: f64) {
        for (from, to) in before.iter().zip(after).filter(|(from, to)| from != to) {
            for (bin, sign) in [(*from, -1.0), (*to, 1.0)] {
                self.sum[bin] += sign * w;
                self.squares[bin] += w * w;
                self.touched[bin] += 1;
            }
        }
    }

    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict { chains: self.chains, worst: 0.0, bins: 0, chi2: 0.0 };
        // The normal law needs a few hundred terms in a bin.
        for bin in (0..BINS).filter(|bin| self.touched[*bin] >= 300) {
            let z = self.sum[bin] / self.squares[bin].sqrt();
            verdict.worst = verdict.worst.max(z.abs());
            verdict.chi2 += z * z;
            verdict.bins += 1;
        }
        verdict.chi2 /= verdict.bins.max(1) as f64;
        verdict
    }
}

fn places(bench: &mut Bench, count: u32) -> Vec<Place> {
    let [keys, pixels, lenses] = PLACE_ROWS.map(|row| bench.rows(row, 0, count));
    keys.iter().zip(&pixels).zip(&lenses).map(|((key, pixel), lens)| place([*key, *pixel, *lens])).collect()
}

/// Largest |z| over tiles x lengths, over rings, over bands and over parts of a lens, from `rounds` times 131,072 candidates,
/// after each of the numbers `steps` of steps of the same chains.
pub fn worst_z(bench: &mut Bench, kernel: &Kernel, flags: &[&'static str], steps: &[u32], rounds: u32) -> Vec<Verdict> {
    worst_z_of(bench, kernel, flags, steps, rounds, 0.0)
}

/// The same where candidates of a weight below `least` survive with a probability in its proportion, and count for `least`
/// then: fewer chains see as much.
pub fn worst_z_of(
    bench: &mut Bench,
    kernel: &Kernel,
    flags: &[&'static str],
    steps: &[u32],
    rounds: u32,
    least: f64,
) -> Vec<Verdict> {
    let mut paired: Vec<Paired> = steps.iter().map(|_| Paired::new()).collect();
    for seed in 1001..1001 + rounds {
        let (candidates, strategies) = bench.candidates(1 << 17, seed);
        // Paths that the kernel does not move say nothing.
        let features = bench.features;
        let survives = |i: &u32| {
            let key = candidates[*i as usize].key();
            if !key.is_some_and(|key| (kernel.applies)(key, features)) {
                return false;
            }
            let chance = rng::uniform(rng::random_words(SEED, *i, seed, 2)[0]);
            candidates[*i as usize].weight() > chance * least
        };
        let lit: Vec<u32> = (0..candidates.len() as u32).filter(survives).collect();
        for (chunk_number, chunk) in lit.chunks(HALF as usize).enumerate() {
            let count = chunk.len() as u32;
            bench.fill(seed, &strategies, chunk);
            let before = places(bench, count);
            // Pass indices of their own for every chunk: no random number is used twice.
            let first = seed * 1024 + chunk_number as u32 * 64;
            let structural = kernel.family == Family::Structural;
            let list = (!structural).then(|| bench.list(kernel, count, Guides::Other));
            let mut made = 0;
            for (steps, paired) in steps.iter().zip(&mut paired) {
                let passes = first + made..first + steps;
                made = *steps;
                match &list {
                    Some((uniform, _)) => bench.passes(kernel, flags, *uniform, passes),
                    None => passes.for_each(|pass| {
                        let (uniform, _) = bench.cut_list(count, pass);
                        bench.passes(kernel, flags, uniform, pass..pass + 1);
                    }),
                }
                paired.chains += chunk.len();
                for ((before, after), &candidate) in before.iter().zip(&places(bench, count)).zip(chunk) {
                    paired.add(before, after, candidates[candidate as usize].weight().max(least));
                }
            }
        }
    }
    paired.iter().map(Paired::verdict).collect()
}
