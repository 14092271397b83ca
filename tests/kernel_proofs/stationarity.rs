//! Weighted paired stationarity (METHOD.md 4.4 S1).
//!
//! X_0 is drawn from the bidirectional density with weight W = I / density, moved t steps to X_t by the kernel under test
//! with fixed guides that do not depend on X_0. For every kernel that leaves the target invariant,
//! E[W (h(X_t) - h(X_0))] = 0 exactly for every h: no reference and no exact samples are needed.

use std::collections::HashSet;

use crate::bench::{Bench, FILM, Guides, HALF, MAX_EDGES, SEED};
use emlt::ensemble::bootstrap::Candidate;
use emlt::ensemble::pool::TypeKey;
use emlt::ensemble::strategies::Strategies;
use emlt::gpu::layout::{ROW_KEY, ROW_LENS, ROW_PIXEL};
use emlt::kernels::{Family, Kernel};
use emlt::reference::rng;
use rayon::prelude::*;

/// Side of a tile in pixels.
const TILE: u32 = 4;

pub struct Verdict {
    /// How many there were.
    pub chains: usize,
    pub worst: f64,
    /// What that bin is of, in words.
    pub worst_bin: String,
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
    /// Of all chains with a weight: the sum of its square, and their number.
    weights: [f64; 2],
    pub chains: usize,
}

impl Paired {
    pub fn new() -> Self {
        Self { sum: vec![0.0; BINS], squares: vec![0.0; BINS], touched: vec![0; BINS], weights: [0.0; 2], chains: 0 }
    }

    pub fn add(&mut self, before: &Place, after: &Place, w: f64) {
        self.weights[0] += w * w;
        self.weights[1] += f64::from(w > 0.0);
        for (from, to) in before.iter().zip(after).filter(|(from, to)| from != to) {
            for (bin, sign) in [(*from, -1.0), (*to, 1.0)] {
                self.sum[bin] += sign * w;
                self.squares[bin] += w * w;
                self.touched[bin] += 1;
            }
        }
    }

    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict { chains: self.chains, worst: 0.0, worst_bin: String::new(), bins: 0, chi2: 0.0 };
        let mean_square = self.weights[0] / self.weights[1].max(1.0);
        // The normal law needs a few hundred terms in a bin, and not only light ones: where a lamp has dark texels, the few
        // heavy chains that come there from bright ones make up for hundreds that leave.
        let counts = |bin: &usize| self.touched[*bin] >= 300 && self.squares[*bin] >= 30.0 * mean_square;
        for bin in (0..BINS).filter(counts) {
            let z = self.sum[bin] / self.squares[bin].sqrt();
            if z.abs() > verdict.worst {
                verdict.worst = z.abs();
                verdict.worst_bin = format!(
                    "z {z:.2} in bin {bin} ({} edges where it is a tile), {} chains, sum of squares {:.1} times the mean square",
                    bin / TILES + 1,
                    self.touched[bin],
                    self.squares[bin] / mean_square
                );
            }
            verdict.chi2 += z * z;
            verdict.bins += 1;
        }
        verdict.chi2 /= verdict.bins.max(1) as f64;
        verdict
    }
}

fn places(bench: &mut Bench, count: u32) -> Vec<Place> {
    let rows = bench.rows_of(&PLACE_ROWS, count);
    let n = count as usize;
    (0..n).into_par_iter().map(|i| place([rows[i], rows[n + i], rows[2 * n + i]])).collect()
}

/// How many chains are moved, and when they are looked at.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    /// Numbers of steps after which the same chains are looked at, in order, and at least how many of them: no more the
    /// later. All are of types that the kernel applies to.
    pub looks: &'a [(u32, usize)],
    /// Candidates of a smaller weight survive with a probability in its proportion, and count for so much then: fewer
    /// chains see as much.
    pub least: f64,
}

/// A kernel with further flags.
pub type Moved<'a> = (&'a Kernel, &'a [&'static str]);

/// Seeds of the candidates from which strategies are adapted, and of the first round of those that count.
const PILOT_SEEDS: [u32; 2] = [901, 902];
const FIRST_SEED: u32 = 1001;
/// The most candidates of a round.
const MOST_CANDIDATES: f64 = (1 << 22) as f64;

/// Where X_0 of kernels that apply to the same types come from. A chain of another type would rest and add nothing, so the
/// strategies are those that find these types best; whatever they are, W is the weight by what they are.
struct Source {
    strategies: Strategies,
    /// Share of the candidates that carry light and are of those types.
    share: f64,
}

impl Source {
    fn new(bench: &mut Bench, applies: impl Fn(&Candidate) -> bool) -> Self {
        let even = bench.bootstrap.strategies.clone();
        let mut source = Self { strategies: even.clone(), share: 0.0 };
        // Many more where hardly any path is of these types.
        let (few, _) = bench.candidates_by(&source.strategies, 1 << 15, PILOT_SEEDS[0]);
        let count = if few.iter().filter(|candidate| applies(candidate)).count() < 150 { 1 << 20 } else { 1 << 17 };
        for seed in PILOT_SEEDS {
            let (candidates, by) = bench.candidates_by(&source.strategies, count, seed);
            let pilot = candidates.iter().zip(&by).map(|(candidate, by)| {
                let weight = if applies(candidate) { candidate.weight() } else { 0.0 };
                (*by, weight, candidate.rays())
            });
            let found = candidates.iter().filter(|candidate| applies(candidate)).count();
            assert!(found >= 300, "the kernel applies to {found} candidates");
            source.share = found as f64 / candidates.len() as f64;
            source.strategies = source.strategies.adapted(pilot, &even);
        }
        source
    }
}

/// What becomes of every kernel's chains by the plan, at each look; they all begin with the same ones, so kernels have to
/// apply to the same types.
pub fn verdicts(bench: &mut Bench, moved: &[Moved], plan: Plan) -> Vec<Vec<Verdict>> {
    let Plan { looks, least } = plan;
    let chains = looks[0].1;
    let features = bench.features;
    let structural = moved[0].0.family == Family::Structural;
    let apply = |key| moved.iter().all(|(kernel, _)| (kernel.applies)(key, features));
    let applies = |c: &Candidate| c.key().is_some_and(apply);
    let mut source = Source::new(bench, |c| applies(c) && c.weight() > 0.0);
    let mut paired: Vec<Vec<Paired>> = moved.iter().map(|_| looks.iter().map(|_| Paired::new()).collect()).collect();
    let mut done = 0;
    for seed in FIRST_SEED.. {
        // One chunk of nearly all the columns there are, as the share is known.
        let wanted = ((chains - done) as f64).min(0.96 * f64::from(HALF));
        let count = (wanted / source.share).clamp(1024.0, MOST_CANDIDATES) as u32;
        let (candidates, by) = bench.candidates_by(&source.strategies, count, seed);
        let survives = |i: &u32| {
            let chance = rng::uniform(rng::random_words(SEED, *i, seed, 2)[0]);
            let candidate = &candidates[*i as usize];
            applies(candidate) && candidate.weight() > chance * least
        };
        let chosen: Vec<u32> = (0..count).into_par_iter().filter(survives).collect();
        source.share = chosen.len().max(1) as f64 / f64::from(count);
        // Candidates come by strategy: those of a round count all or none.
        for (chunk_number, chunk) in chosen.chunks(HALF as usize).enumerate() {
            let count = chunk.len() as u32;
            bench.fill(seed, &by, chunk);
            let before = places(bench, count);
            let kept = (moved.len() > 1).then(|| bench.kept(count));
            let list = (!structural).then(|| bench.list(moved[0].0, count, Guides::Other).0);
            // Pass indices of their own for every chunk: no random number is used twice.
            let first = seed * 1024 + chunk_number as u32 * 64;
            for (n, ((kernel, flags), paired)) in moved.iter().zip(&mut paired).enumerate() {
                if let Some(kept) = kept.as_ref().filter(|_| n > 0) {
                    bench.put_back(kept, count);
                }
                let mut made = 0;
                for ((steps, _), paired) in looks.iter().zip(paired).filter(|((_, wanted), _)| done < *wanted) {
                    let passes = first + made..first + steps;
                    made = *steps;
                    match list {
                        Some(uniform) => bench.passes(kernel, flags, uniform, passes),
                        None => passes.for_each(|pass| {
                            let (uniform, _) = bench.structural_list(kernel, count, pass);
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
        let tenths = [done, done + chosen.len()].map(|n| 10 * n / chains);
        if chains > LONG && tenths[0] != tenths[1] {
            println!("{} and its like: {} of {chains} chains", moved[0].0.name, done + chosen.len());
        }
        done += chosen.len();
        if done >= chains {
            break;
        }
    }
    paired.iter().map(|looks| looks.iter().map(Paired::verdict).collect()).collect()
}

/// Whoever waits for more chains than these is told how far they are.
const LONG: usize = 2_000_000;

/// The kernels in groups that apply to the same types, among those that the first pilot finds.
pub fn alike<'a>(bench: &mut Bench, kernels: &[&'a Kernel]) -> Vec<Vec<&'a Kernel>> {
    let features = bench.features;
    let (candidates, _) = bench.candidates(1 << 17, PILOT_SEEDS[0]);
    let keys: HashSet<TypeKey> = candidates.iter().filter_map(Candidate::key).collect();
    let mut groups: Vec<Vec<&Kernel>> = Vec::new();
    for kernel in kernels {
        let like = |group: &&mut Vec<&Kernel>| {
            keys.iter().all(|key| (kernel.applies)(*key, features) == (group[0].applies)(*key, features))
        };
        match groups.iter_mut().find(like) {
            Some(group) => group.push(kernel),
            None => groups.push(vec![kernel]),
        }
    }
    groups
}
