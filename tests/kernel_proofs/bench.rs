//! A device with a scene, start paths in both halves, and single kernels run over one half.

use std::path::Path;
use std::rc::Rc;

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, Bootstrap, CANDIDATE_PASS, CANDIDATES, Candidate, Given, Start};
use emlt::ensemble::cuts::CutList;
use emlt::ensemble::groups::Groups;
use emlt::ensemble::guidance::Guidance;
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::pool::{Pool, TypeKey};
use emlt::ensemble::strategies::Strategies;
use emlt::ensemble::subpaths::PlanList;
use emlt::ensemble::sweep::list_words;
use emlt::gpu::context::Context;
use emlt::gpu::layout::{
    COUNTER_WORDS, NO_TRIANGLE, PUNCTUAL, PassUniform, ROW_KEY, ROW_PIXEL, ROW_VERTICES, chain_rows, row_guide,
};
use emlt::gpu::run::{Buffer, Dispatch, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::gpu::shader::Variant;
use emlt::kernels::{self, Family, Kernel, camera_sweep_end};
use emlt::reference::rng;
use emlt::scene::{Features, Scene, import::import};
use rayon::prelude::*;

pub const FILM: [u32; 2] = [64, 48];
pub const MAX_EDGES: u32 = 8;
/// Of the kernels' random numbers.
pub const SEED: u32 = 77;
/// Paths in the ensemble: the first HALF move, the second guide.
pub const PATHS: u32 = 1 << 17;
pub const HALF: u32 = PATHS / 2;
/// Columns of the chains: behind the paths, HALF more in which to keep where paths came from.
pub const COLUMNS: u32 = PATHS + HALF;

/// Whose pool guides the moving half: the other half's, or (wrongly) its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guides {
    Other,
    Own,
}

/// What a probing pass records per entry.
pub struct Record {
    pub log_ratio: f32,
    pub possible: bool,
}

/// Candidates with their strategies.
type Starts = (Vec<Candidate>, Vec<[u32; 2]>);

pub struct Bench<'a> {
    pub run: Run<'a>,
    /// Whether the device is the processor.
    pub software: bool,
    pub data: SceneData,
    /// What `list` and `cut_list` have put on the device last.
    pub lists: Vec<u32>,
    pub features: Features,
    pub bootstrap: Bootstrap,
    pub guides: Pool,
    starts: Option<Rc<Starts>>,
}

pub fn context() -> Context {
    Context::open(None).unwrap_or_else(|e| panic!("{e}"))
}

impl<'a> Bench<'a> {
    /// Fills both halves with start paths of `scene` (a file under tests/scenes).
    pub fn new(context: &'a Context, scene: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(scene);
        Self::of(context, &import(&path).unwrap_or_else(|e| panic!("{e}")))
    }

    pub fn of(context: &'a Context, scene: &Scene) -> Self {
        let camera = scene.camera(None).unwrap();
        let data = SceneData::new(scene, camera, FILM[0], FILM[1]).unwrap();
        let features = Features::of(scene).seen_by(scene, camera);
        let sizes = Sizes {
            chains: 16 * chain_rows(MAX_EDGES) as u64 * u64::from(COLUMNS),
            lists: 4 * list_words(PATHS, BATCH),
            output: BATCH_BYTES.max(16 * u64::from(PATHS)),
            counters: 4 * COUNTER_WORDS as u64,
        };
        let mut run = Run::new(context, &data, sizes).unwrap();
        let bootstrap = start(features, 1).run(&mut run).unwrap().unwrap();
        let mut bench = Self {
            run,
            software: context.software,
            data,
            lists: vec![],
            features,
            bootstrap,
            guides: Pool::default(),
            starts: None,
        };
        bench.guides = bench.pool(HALF, HALF);
        bench
    }

    /// Rows of the chains one after another, for the first `count` paths.
    pub fn rows_of(&mut self, rows: &[usize], count: u32) -> Vec<[u32; 4]> {
        let ranges: Vec<_> = rows
            .iter()
            .map(|row| {
                let start = 16 * *row as u64 * u64::from(COLUMNS);
                start..start + 16 * u64::from(count)
            })
            .collect();
        self.run.read_ranges(Buffer::Chains, &ranges).unwrap()
    }

    /// All of the first `count` paths, to be put back.
    pub fn kept(&mut self, count: u32) -> Vec<[u32; 4]> {
        self.rows_of(&Vec::from_iter(0..row_guide(MAX_EDGES)), count)
    }

    pub fn put_back(&mut self, kept: &[[u32; 4]], count: u32) {
        for (row, kept) in kept.chunks_exact(count as usize).enumerate() {
            self.run.set_chains(16 * row as u64 * u64::from(COLUMNS), bytemuck::cast_slice(kept));
        }
    }

    /// A row of the chains, for `count` paths from `first` on.
    pub fn rows(&mut self, row: usize, first: u32, count: u32) -> Vec<[u32; 4]> {
        let start = 16 * (row as u64 * u64::from(COLUMNS) + u64::from(first));
        self.run.read(Buffer::Chains, start..start + 16 * u64::from(count)).unwrap()
    }

    pub fn pixels(&mut self, count: u32) -> Vec<[f32; 2]> {
        self.rows(ROW_PIXEL, 0, count).iter().map(|r| [f32::from_bits(r[0]), f32::from_bits(r[1])]).collect()
    }

    pub fn keys(&mut self, first: u32, count: u32) -> Vec<TypeKey> {
        self.rows(ROW_KEY, first, count).iter().map(|r| TypeKey::from_words([r[0], r[1]]).unwrap()).collect()
    }

    /// Which of the first half's paths `kernel` would have to end at a point, a spot or a direction, which nothing hits.
    pub fn ends_at_a_dirac(&mut self, kernel: &Kernel) -> Vec<bool> {
        let is_dirac = |[code, u, ..]: &[u32; 4]| {
            (PUNCTUAL..NO_TRIANGLE).contains(code) || (*code == NO_TRIANGLE && f32::from_bits(*u) > 0.0)
        };
        let ends = |key: &TypeKey| kernel.family == Family::CameraSide && camera_sweep_end(*key) == 0;
        let lights = self.rows(ROW_VERTICES, 0, HALF);
        self.keys(0, HALF).iter().zip(&lights).map(|(key, light)| ends(key) && is_dirac(light)).collect()
    }

    fn pool(&mut self, first: u32, count: u32) -> Pool {
        Pool::build(&self.keys(first, count), first)
    }

    /// Brings what kernels on the camera's side leave stale up to date, for the first HALF paths.
    pub fn refresh(&mut self) {
        let entries: Vec<u32> = (0..HALF).flat_map(|path| [path, 0]).collect();
        self.run.set_lists(&entries);
        let variant = Variant { pass: "weigh", features: self.features, max_edges: MAX_EDGES, flags: vec![] };
        let uniform = PassUniform { stride: COLUMNS, entries: HALF, ..Default::default() };
        self.run.submit(&[Dispatch { variant, uniform }]).unwrap();
    }

    /// Keeps the first HALF paths where a probing pass finds the way back to them.
    pub fn keep_origins(&mut self) {
        let kept = self.kept(HALF);
        for (row, kept) in kept.chunks_exact(HALF as usize).enumerate() {
            self.run.set_chains(16 * (row as u64 * u64::from(COLUMNS) + u64::from(PATHS)), bytemuck::cast_slice(kept));
        }
    }

    /// Sets the dispatch list of `kernel` over the first `count` paths; returns what the dispatches need.
    pub fn list(&mut self, kernel: &Kernel, count: u32, guides: Guides) -> (PassUniform, Vec<u32>) {
        let features = self.features;
        let moving = self.pool(0, count);
        let guides = if guides == Guides::Own { &moving } else { &self.guides };
        let list = moving.dispatch_list(|key| (kernel.applies)(key, features), guides);
        let mut words: Vec<u32> = list.entries.iter().flatten().copied().collect();
        let nodes_offset = words.len() as u32;
        words.extend(list.nodes.iter().flat_map(|[offset, count]| [*offset, *count, (-8f32).to_bits()]));
        // Guides are read from their rows in the pool's order, which the pass `gather` makes.
        let guides_first = guides.order.iter().copied().min().unwrap_or(0);
        let order: Vec<u32> = guides.order.iter().flat_map(|&path| [path, 0]).collect();
        self.gather(&order, guides_first);
        self.run.set_lists(&words);
        self.lists = words;
        let uniform = PassUniform {
            seed: SEED,
            stride: COLUMNS,
            entries: list.entries.len() as u32,
            nodes_offset,
            guides_first,
            origins: PATHS,
            group_paths: COLUMNS,
            ..Guidance::default().of_run(PassUniform::default())
        };
        (uniform, list.entries.iter().map(|e| e[0]).collect())
    }

    /// Sets the list of a bidirectional pass over the first `count` paths.
    pub fn cut_list(&mut self, count: u32, pass_index: u32) -> (PassUniform, CutList) {
        // In parts, which processors share; the list is that of the whole.
        let size = count.div_ceil(8).max(1);
        let keys = self.keys(0, count);
        let parts: Vec<Pool> = keys
            .par_chunks(size as usize)
            .zip(0..count.div_ceil(size))
            .map(|(keys, i)| Pool::build(keys, i * size))
            .collect();
        let groups: Vec<_> = parts.iter().map(|part| (part, &self.guides, HALF)).collect();
        let random = |path, dimension| rng::random_words(SEED, path, pass_index, dimension);
        let list = CutList::draw(&groups, random, 1..=MAX_EDGES);
        self.run.set_lists(&list.words);
        self.lists = list.words.clone();
        (self.cut_uniform(list.entries.len()), list)
    }

    /// Sets the list of a structural pass over the first `count` paths; returns what the dispatch needs, and its paths.
    pub fn structural_list(&mut self, kernel: &Kernel, count: u32, pass_index: u32) -> (PassUniform, Vec<u32>) {
        let paths: Vec<u32> = if kernel.pass == "subpath" {
            self.plan_list(kernel, count, pass_index).entries.iter().map(|entry| entry.path).collect()
        } else {
            self.cut_list(count, pass_index).1.entries.iter().map(|entry| entry.path).collect()
        };
        (self.cut_uniform(paths.len()), paths)
    }

    /// Sets the list of a subpath pass over the first `count` paths.
    pub fn plan_list(&mut self, kernel: &Kernel, count: u32, pass_index: u32) -> PlanList {
        let moving = self.pool(0, count);
        let random = |path, dimension| rng::random_words(SEED, path, pass_index, dimension);
        let list = PlanList::draw(kernel, self.features, &[(&moving, &self.guides, HALF)], random);
        self.run.set_lists(&list.words);
        self.lists = list.words.clone();
        list
    }

    pub fn cut_uniform(&self, entries: usize) -> PassUniform {
        PassUniform {
            seed: SEED,
            stride: COLUMNS,
            group_paths: COLUMNS,
            origins: PATHS,
            entries: entries as u32,
            ..Guidance::default().of_run(PassUniform::default())
        }
    }

    /// Publishes the second half as guides.
    pub fn publish_guides(&mut self) {
        let order: Vec<u32> = self.guides.order.iter().flat_map(|&path| [path, 0]).collect();
        self.gather(&order, HALF);
    }

    fn gather(&mut self, order: &[u32], guides_first: u32) {
        self.run.set_lists(order);
        let uniform =
            PassUniform { stride: COLUMNS, entries: order.len() as u32 / 2, guides_first, ..Default::default() };
        let variant = Variant { pass: "gather", features: self.features, max_edges: MAX_EDGES, flags: vec![] };
        self.run.submit(&[Dispatch { variant, uniform }]).unwrap();
    }

    /// Runs `kernel` with further flags once per pass index.
    pub fn passes(
        &mut self,
        kernel: &Kernel,
        more: &[&'static str],
        uniform: PassUniform,
        indices: std::ops::Range<u32>,
    ) {
        let flags = kernel.flags.iter().chain(more).copied().collect();
        let variant = Variant { pass: kernel.pass, features: self.features, max_edges: MAX_EDGES, flags };
        let dispatches: Vec<Dispatch> = indices
            .map(|pass_index| Dispatch { variant: variant.clone(), uniform: PassUniform { pass_index, ..uniform } })
            .collect();
        self.run.submit(&dispatches).unwrap();
    }

    /// The records of the last probing pass.
    pub fn records(&mut self, count: u32) -> Vec<[f32; 4]> {
        self.run.read(Buffer::Output, 0..16 * u64::from(count)).unwrap()
    }

    pub fn lens_records(&mut self, count: u32) -> Vec<Record> {
        let rows = self.records(count);
        rows.iter().map(|r| Record { log_ratio: r[0], possible: r[3] > -1e29 }).collect()
    }

    /// Fresh candidates with their strategies: X_0 drawn from the bidirectional density, not resampled.
    pub fn candidates(&mut self, count: u32, seed: u32) -> Starts {
        let strategies = self.bootstrap.strategies.clone();
        self.candidates_by(&strategies, count, seed)
    }

    /// The same by other strategies.
    pub fn candidates_by(&mut self, strategies: &Strategies, count: u32, seed: u32) -> (Vec<Candidate>, Vec<[u32; 2]>) {
        start(self.features, seed)
            .candidates(&mut self.run, strategies, Given::default(), count, CANDIDATE_PASS)
            .unwrap()
    }

    /// Fills the first half with candidates that `kernel` applies to, over and over.
    pub fn fill_with(&mut self, kernel: &Kernel) {
        let starts = self.starts();
        let (candidates, strategies) = &*starts;
        let chosen = moved_by(kernel, candidates, self.features);
        assert!(chosen.len() >= STARTS, "{} applies to {} candidates", kernel.name, chosen.len());
        let chosen: Vec<u32> = chosen.iter().copied().cycle().take(HALF as usize).collect();
        self.fill(STARTS_SEED, strategies, &chosen);
    }

    /// The kernels that move paths of this scene: those that the renderer would not leave out, and that apply to enough
    /// candidates.
    pub fn usable(&mut self) -> Vec<&'static Kernel> {
        let features = self.features;
        let starts = self.starts();
        let is_usable = |kernel: &&Kernel| {
            (kernel.useless)(features).is_none() && moved_by(kernel, &starts.0, features).len() >= STARTS
        };
        kernels::ALL.into_iter().filter(is_usable).collect()
    }

    /// Makes the candidates that paths of single kernels are made from, so many.
    pub fn make_starts(&mut self, count: u32) {
        self.starts = Some(Rc::new(self.candidates(count, STARTS_SEED)));
    }

    fn starts(&mut self) -> Rc<Starts> {
        if self.starts.is_none() {
            self.make_starts(1 << 17);
        }
        self.starts.clone().unwrap()
    }

    /// Puts candidates of `seed` into the first chains.
    pub fn fill(&mut self, seed: u32, strategies: &[[u32; 2]], chosen: &[u32]) {
        start(self.features, seed).fill(&mut self.run, Given::default(), strategies, chosen).unwrap();
    }
}

/// The fewest candidates that paths of a kernel are made from, and their seed.
const STARTS: usize = 300;
const STARTS_SEED: u32 = 3001;

/// Candidates that carry light and that `kernel` applies to.
fn moved_by(kernel: &Kernel, candidates: &[Candidate], features: Features) -> Vec<u32> {
    let applies = |c: &Candidate| c.weight() > 0.0 && c.key().is_some_and(|key| (kernel.applies)(key, features));
    (0..candidates.len() as u32).filter(|i| applies(&candidates[*i as usize])).collect()
}

fn start(features: Features, seed: u32) -> Start {
    Start {
        features,
        direct: Direct::Mcmc,
        maps_row: None,
        max_edges: MAX_EDGES,
        two_stage: None,
        candidates: CANDIDATES,
        seed,
        groups: Groups::new(PATHS, 1),
        stride: COLUMNS,
        film: FILM,
    }
}
