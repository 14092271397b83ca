//! A finite world of paths: a few types on a grid of pixels, integer weights as target.

use emlt::ensemble::pool::{NodeRange, Pool, Tag, TypeKey};
use emlt::ensemble::similarity::{mean_squared_distance, similarity_median};
use emlt::reference::guide::{StepSettings, StepShape};

/// Scene units within which paths resemble each other.
const BANDWIDTH: f64 = 0.6;

/// A "path": all that selection, similarity and acceptance look at.
pub struct State {
    pub key: TypeKey,
    pub pixel: [f64; 2],
    /// From the light to the camera.
    pub vertices: Vec<[f32; 3]>,
    /// The target I, not normalised.
    pub weight: f64,
}

pub struct World {
    pub size_px: [usize; 2],
    pub types: Vec<TypeKey>,
    /// Type by type, row by row.
    pub states: Vec<State>,
}

/// A fixed scramble of small numbers.
pub fn hash(a: u64, b: u64) -> u64 {
    let mut z = (a + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (b + 1).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl World {
    pub fn new(size_px: [usize; 2], strings: &[&[Tag]]) -> Self {
        let types: Vec<TypeKey> = strings.iter().map(|tags| TypeKey::from_tags(tags)).collect();
        let states = types
            .iter()
            .zip(0..)
            .flat_map(|(&key, t)| {
                let pixels = (0..size_px[1]).flat_map(move |y| (0..size_px[0]).map(move |x| [x, y]));
                pixels.map(move |[x, y]| state(key, t, [x, y], size_px[0]))
            })
            .collect();
        Self { size_px, types, states }
    }

    /// Three types: two of one length, one of another; 36 states.
    pub fn large() -> Self {
        use Tag::{Diffuse as D, Reflection as R};
        Self::new([4, 3], &[&[D, D], &[R, D], &[D]])
    }

    /// Two types of one length, 8 states: for the joint chains of several paths.
    pub fn small() -> Self {
        use Tag::{Diffuse as D, Reflection as R};
        Self::new([4, 1], &[&[D], &[R]])
    }

    pub fn pixels(&self) -> usize {
        self.size_px[0] * self.size_px[1]
    }

    /// pi: the normalised target.
    pub fn target(&self) -> Vec<f64> {
        let sum: f64 = self.states.iter().map(|state| state.weight).sum();
        self.states.iter().map(|state| state.weight / sum).collect()
    }
}

fn state(key: TypeKey, t: u64, [x, y]: [usize; 2], width: usize) -> State {
    let scramble = hash(t, (x + 8 * y) as u64);
    // The right half lies deeper: similarity, and with it the covariance, changes at the edge.
    let depth = if 2 * x < width { 0.0 } else { 1.5 };
    let vertex = |j: u32| {
        let toward_camera = j as f32 / key.edges() as f32;
        let wobble = (hash(scramble, u64::from(j)) % 100) as f32 * 2e-3;
        [0.4 * x as f32 * toward_camera, 0.4 * y as f32 + wobble, depth * toward_camera + 0.1 * t as f32]
    };
    // A ridge across the film, another for each type; one state carries nothing at all.
    let ridge = if (x + y + t as usize).is_multiple_of(3) { 9 } else { 0 };
    let weight = if t == 0 && x == 1 && y == 1 { 0 } else { 1 + ridge + scramble % 7 };
    State { key, pixel: [x as f64, y as f64], vertices: (0..=key.edges()).map(vertex).collect(), weight: weight as f64 }
}

/// A frozen half: the pool, and what is computed from it.
pub struct Guides<'w> {
    pub world: &'w World,
    pub pool: Pool,
    /// State of each path index.
    states: Vec<usize>,
    pub settings: StepSettings,
    /// M.
    pub wanted: u32,
}

impl<'w> Guides<'w> {
    pub fn new(world: &'w World, states: &[usize], wanted: u32) -> Self {
        let keys: Vec<TypeKey> = states.iter().map(|&state| world.states[state].key).collect();
        let pool = Pool::build(&keys, 0);
        let position = |place: u32, vertex: usize| {
            let state = states[pool.order[place as usize] as usize];
            world.states[state].vertices[vertex].map(f64::from)
        };
        let median = similarity_median(&pool, position, BANDWIDTH as f32, wanted);
        let settings = StepSettings {
            alpha_low: 0.05,
            alpha_high: 0.5,
            tau: 1.0,
            similarity_median: median.map_or(0.0, f64::from),
            floor_px: 0.5,
            widest_px: 2.5,
        };
        Self { world, pool, states: states.to_vec(), settings, wanted }
    }

    /// States of the guides that `id` selects in a node.
    pub fn chosen(&self, node: Option<NodeRange>, id: u32) -> Vec<usize> {
        node.map_or(Vec::new(), |node| {
            let paths = self.pool.select(node, id, self.wanted);
            paths.map(|path| self.states[path as usize]).collect()
        })
    }

    /// What shapes the step from state `x`: d^2 and pixels of its guides.
    pub fn evidence(&self, x: usize, id: u32) -> (Vec<f64>, Vec<[f64; 2]>) {
        let path = &self.world.states[x];
        let position = |state: &State, j: usize| state.vertices[j].map(f64::from);
        let guides = self.chosen(self.pool.node(path.key), id);
        let squared = guides.iter().map(|&guide| {
            let guide = &self.world.states[guide];
            let v = |j| position(guide, j);
            mean_squared_distance(path.key.edges(), BANDWIDTH, |j| position(path, j), v)
        });
        let pixels = guides.iter().map(|&guide| self.world.states[guide].pixel);
        (squared.collect(), pixels.collect())
    }

    /// The shape of the guided step from state `x`.
    pub fn shape(&self, x: usize, id: u32) -> StepShape {
        let (squared, pixels) = self.evidence(x, id);
        StepShape::guided(self.world.states[x].pixel, &squared, &pixels, &self.settings)
    }
}

/// Halves of N = 3 to 6 guides: each type alone, one of each, one type missing, one path N times, and at random.
pub fn guide_sets(world: &World) -> Vec<Vec<usize>> {
    let pixels = world.pixels();
    let at = |t: usize, n: usize| t * pixels + hash(t as u64, n as u64) as usize % pixels;
    let mut sets =
        vec![vec![at(0, 0), at(1, 1), at(2, 2)], vec![at(0, 3), at(0, 4), at(2, 5), at(2, 6)], vec![at(1, 7); 5]];
    for t in 0..3 {
        sets.push((0..4).map(|n| at(t, n)).collect());
    }
    for n in 3..=6 {
        for round in 0..12 {
            let member = |i: u64| hash(100 + round, 10 * n + i) as usize % world.states.len();
            sets.push((0..n).map(member).collect());
        }
    }
    sets
}
