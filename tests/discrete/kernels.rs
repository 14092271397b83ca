//! Transition kernels of the finite world as matrices, right ones and deliberately broken ones.

use super::world::{Guides, World, hash};
use emlt::ensemble::pool::{NodeRange, TypeKey};
use emlt::reference::guide::{StepShape, Symmetric, alpha};

/// Share of the Student-t density that a lattice point of 1 px^2 is given: the lattice sum stays below 1, and what
/// is missing counts as off the film. One constant for x and y, so it cancels.
const LATTICE_SHARE: f64 = 0.8;
/// Off-film pixels that the clamping twin moves to the border.
const MARGIN_PX: i32 = 8;

/// Ways to get the guided kernels wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Twin {
    Correct,
    ReverseLeftOut,
    ShapeOfX,
    AlphaOfX,
    AreaDropped,
    Redraw,
    Clamp,
    ReverseId,
    ReverseBacktracksEarlier,
    SignFixed,
}

/// One mutation for fixed guides and id: probabilities of accepted moves and of early failures (off the film).
#[derive(Clone)]
pub struct Moves {
    /// `accepted[x][y]`; staying is what is left.
    pub accepted: Vec<Vec<f64>>,
    pub failed: Vec<f64>,
    /// Largest |log R(x->y) + log R(y->x)| (METHOD.md 4.1, A1).
    pub antisymmetry: f64,
}

impl Moves {
    /// Metropolis-Hastings with proposal probabilities and the log densities that the code believes in.
    ///
    /// `propose(x, y)` is None if no such move exists, else (probability, forward log density, reverse log density).
    fn metropolis(world: &World, propose: impl Fn(usize, usize) -> Option<(f64, f64, f64)>) -> Self {
        let n = world.states.len();
        let (mut accepted, mut failed) = (vec![vec![0.0; n]; n], vec![0.0; n]);
        let mut log_ratios = vec![vec![0.0f64; n]; n];
        for x in 0..n {
            let mut proposed = 0.0;
            for y in 0..n {
                let Some((probability, forward, reverse)) = propose(x, y) else {
                    continue;
                };
                proposed += probability;
                let (from, to) = (world.states[x].weight, world.states[y].weight);
                let log_ratio = to.ln() - from.ln() + reverse - forward;
                // Out of a state without weight everything is accepted; into one nothing.
                let acceptance = if from == 0.0 { 1.0 } else { log_ratio.exp().min(1.0) };
                accepted[x][y] = probability * acceptance;
                log_ratios[x][y] = if from * to > 0.0 { log_ratio } else { 0.0 };
            }
            assert!(proposed <= 1.0 + 1e-12, "proposals sum to {proposed}");
            failed[x] = (1.0 - proposed).max(0.0);
        }
        let pairs = (0..n).flat_map(|x| (0..x).map(move |y| (x, y)));
        let sums = pairs.map(|(x, y)| (log_ratios[x][y] + log_ratios[y][x]).abs());
        Self { accepted, failed, antisymmetry: sums.fold(0.0, f64::max) }
    }

    /// One of several kernels, chosen with fixed probabilities.
    pub fn mix(parts: &[(f64, &Self)]) -> Self {
        let n = parts[0].1.failed.len();
        let sum = |of: &dyn Fn(&Self) -> f64| parts.iter().map(|(share, part)| share * of(part)).sum();
        Self {
            accepted: (0..n).map(|x| (0..n).map(|y| sum(&|m| m.accepted[x][y])).collect()).collect(),
            failed: (0..n).map(|x| sum(&|m| m.failed[x])).collect(),
            antisymmetry: parts.iter().map(|(_, part)| part.antisymmetry).fold(0.0, f64::max),
        }
    }

    /// Probability to move away from x, or to accept x again.
    pub fn acceptance(&self, x: usize) -> f64 {
        self.accepted[x].iter().sum()
    }

    /// The law after one mutation from `x`.
    pub fn row(&self, x: usize) -> Vec<f64> {
        let mut row = self.accepted[x].clone();
        row[x] += 1.0 - self.acceptance(x);
        row
    }

    /// The law after one mutation from `law`.
    pub fn apply(&self, law: &[f64]) -> Vec<f64> {
        let mut after = vec![0.0; law.len()];
        for (x, &mass) in law.iter().enumerate() {
            after.iter_mut().zip(self.row(x)).for_each(|(to, p)| *to += mass * p);
        }
        after
    }
}

/// All mutations of one chain: the guided lens step, a step along a difference of guides, a guided jump that changes
/// types, an independence move.
pub fn mutation(guides: &Guides, id: u32, twin: Twin) -> Moves {
    let (lens, along, jump) = (lens(guides, id, twin), along_difference(guides, id, twin), jump(guides, id, twin));
    Moves::mix(&[(0.25, &lens), (0.25, &along), (0.25, &jump), (0.25, &independence(guides.world))])
}

/// Differential evolution (METHOD.md 3.6 c) on the grid: the difference of the first two guides, its sign a coin. The
/// twin takes the sign as the id gives it; its ratio is that of the targets all the same.
fn along_difference(guides: &Guides, id: u32, twin: Twin) -> Moves {
    let world = guides.world;
    Moves::metropolis(world, |x, y| {
        let (from, to) = (&world.states[x], &world.states[y]);
        let [first, second, ..] = guides.chosen(guides.pool.node(from.key), id)[..] else {
            return None;
        };
        let step = difference(world.states[first].pixel, world.states[second].pixel);
        let plus = difference(to.pixel, from.pixel) == step;
        let minus = difference(from.pixel, to.pixel) == step;
        let probability = match twin {
            Twin::SignFixed => f64::from(u8::from(plus)),
            _ => 0.5 * f64::from(u8::from(plus)) + 0.5 * f64::from(u8::from(minus)),
        };
        (from.key == to.key && probability > 0.0).then_some((probability, 0.0, 0.0))
    })
}

/// Guided lens perturbation (METHOD.md 3.4) on the grid: keeps the type, steps by whole pixels.
pub fn lens(guides: &Guides, id: u32, twin: Twin) -> Moves {
    let world = guides.world;
    let n = world.states.len();
    let reverse_id = if twin == Twin::ReverseId { id.wrapping_add(1) } else { id };
    let forward: Vec<StepShape> = (0..n).map(|x| guides.shape(x, id)).collect();
    let reverse: Vec<StepShape> = (0..n).map(|y| guides.shape(y, reverse_id)).collect();
    let mass = |x: usize, d: [f64; 2]| LATTICE_SHARE * forward[x].log_density(d).exp();
    let on_film = |x: usize| (x / world.pixels() * world.pixels()..).take(world.pixels());
    let step = |x: usize, y: usize| difference(world.states[y].pixel, world.states[x].pixel);
    // Redrawing until on the film divides by this; the broken ratio does not know.
    let film_mass: Vec<f64> = (0..n)
        .map(|x| if twin == Twin::Redraw { on_film(x).map(|y| mass(x, step(x, y))).sum() } else { 1.0 })
        .collect();

    Moves::metropolis(world, |x, y| {
        if world.states[x].key != world.states[y].key {
            return None;
        }
        let d = step(x, y);
        let back = d.map(|component| -component);
        let mut probability = mass(x, d) / film_mass[x];
        if twin == Twin::Clamp {
            let off_film = clamped_onto(world, world.states[y].pixel);
            probability += off_film.map(|p| mass(x, difference(p, world.states[x].pixel))).sum::<f64>();
        }
        let (mut q_x, mut q_y) = (forward[x].log_density(d), reverse[y].log_density(back));
        match twin {
            Twin::ReverseLeftOut => q_y = 0.0,
            Twin::ShapeOfX => q_y = forward[x].log_density(back),
            Twin::AlphaOfX => q_y = shape_with_alpha_of(guides, x, y, id).log_density(back),
            Twin::AreaDropped => (q_x, q_y) = (q_x + forward[x].log_area(), q_y + reverse[y].log_area()),
            _ => {}
        }
        Some((probability, q_x, q_y))
    })
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Sigma_0 of y with alpha of x: half of the covariance taken from the wrong end.
fn shape_with_alpha_of(guides: &Guides, x: usize, y: usize, id: u32) -> StepShape {
    use emlt::ensemble::similarity::Similarity;
    let similarity = |state| Similarity::from_squared_distances(&guides.evidence(state, id).0);
    let (Some(at_x), Some(at_y)) = (similarity(x), similarity(y)) else {
        return guides.shape(y, id);
    };
    let settings = &guides.settings;
    let (pixel, guide_pixels) = (guides.world.states[y].pixel, guides.evidence(y, id).1);
    let sigma0 = Symmetric::about(pixel, &at_y.weights, &guide_pixels).capped(settings.widest_px);
    StepShape::new(sigma0, alpha(at_x.log_mean, settings), settings.floor_px)
}

/// The off-film pixels that clamping moves to `border`.
fn clamped_onto(world: &World, border: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let size = world.size_px.map(|side| side as i32);
    let clamp = move |p: [i32; 2]| [0, 1].map(|axis| p[axis].clamp(0, size[axis] - 1));
    let rows = -MARGIN_PX..size[1] + MARGIN_PX;
    let around = rows.flat_map(move |y| (-MARGIN_PX..size[0] + MARGIN_PX).map(move |x| [x, y]));
    let float = |p: [i32; 2]| p.map(f64::from);
    around.filter(move |&p| clamp(p) != p && float(clamp(p)) == border).map(float)
}

/// Guided jump (METHOD.md 3.6 f): any type, then a pixel near the guides that a look-up for THAT type returns. Type
/// and node change, so forward and reverse each need their own look-up, by the same rule.
fn jump(guides: &Guides, id: u32, twin: Twin) -> Moves {
    let world = guides.world;
    let density = |node: &dyn Fn(TypeKey) -> Option<NodeRange>| -> Vec<f64> {
        let one_of_the_types = 1.0 / world.types.len() as f64;
        let to = |y: usize| one_of_the_types * kernel_density(guides, node(world.states[y].key), y, id);
        (0..world.states.len()).map(to).collect()
    };
    let rule = |key| guides.pool.node(key);
    let earlier = |key: TypeKey| {
        let large = |node: &NodeRange| node.count >= 2;
        guides.pool.type_node(key).filter(large).or_else(|| guides.pool.length_node(key.edges()))
    };
    let forward = density(&rule);
    let reverse = if twin == Twin::ReverseBacktracksEarlier { density(&earlier) } else { forward.clone() };
    Moves::metropolis(world, |x, y| Some((forward[y], forward[y].ln(), reverse[x].ln())))
}

/// Density of a pixel near the guides: steps of fixed shape from each, one part in ten anywhere on the film.
fn kernel_density(guides: &Guides, node: Option<NodeRange>, y: usize, id: u32) -> f64 {
    let world = guides.world;
    let shape = StepShape { l11: 0.8, l21: 0.2, l22: 0.6 };
    let chosen = guides.chosen(node, id);
    let near = |&guide: &usize| {
        let d = difference(world.states[y].pixel, world.states[guide].pixel);
        LATTICE_SHARE * shape.log_density(d).exp() / chosen.len() as f64
    };
    let anywhere = 1.0 / world.pixels() as f64;
    match chosen.len() {
        0 => anywhere,
        _ => 0.9 * chosen.iter().map(near).sum::<f64>() + 0.1 * anywhere,
    }
}

/// Independence move (METHOD.md 2.1): proposals from a fixed law that is not the target.
pub fn independence(world: &World) -> Moves {
    let raw: Vec<f64> = (0..world.states.len()).map(|y| 1.0 + (hash(9, y as u64) % 5) as f64).collect();
    let sum: f64 = raw.iter().sum();
    Moves::metropolis(world, |x, y| {
        let density = |state: usize| raw[state] / sum;
        Some((density(y), density(y).ln(), density(x).ln()))
    })
}
