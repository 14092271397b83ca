//! Paths on a device, over which single passes run.

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, Bootstrap, CANDIDATE_PASS, Candidate, Given, Start};
use emlt::ensemble::groups::Groups;
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::pool::TypeKey;
use emlt::ensemble::sweep::list_words;
use emlt::gpu::context::Context;
use emlt::gpu::layout::{COUNTER_WORDS, PassUniform, ROW_KEY, ROW_LENS, chain_rows};
use emlt::gpu::run::{Buffer, Dispatch, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::gpu::shader::Variant;
use emlt::scene::{Features, Scene};

pub struct Bench<'a> {
    pub run: Run<'a>,
    pub start: Start,
    pub bootstrap: Bootstrap,
}

impl<'a> Bench<'a> {
    /// `paths` start paths of `scene` with at most `max_edges` edges, as one group.
    pub fn new(context: &'a Context, scene: &Scene, film: [u32; 2], max_edges: u32, paths: u32) -> Self {
        let data = SceneData::new(scene, scene.camera(None).unwrap(), film[0], film[1]).unwrap();
        let sizes = Sizes {
            chains: 16 * chain_rows(max_edges) as u64 * u64::from(paths),
            lists: 4 * list_words(paths, BATCH),
            output: BATCH_BYTES,
            counters: 4 * COUNTER_WORDS as u64,
        };
        let mut run = Run::new(context, &data, sizes).unwrap();
        let start = Start {
            features: Features::of(scene),
            direct: Direct::Mcmc,
            maps_row: None,
            max_edges,
            two_stage: None,
            candidates: 1 << 16,
            seed: 1,
            groups: Groups::new(paths, 1),
            stride: paths,
            film,
        };
        let bootstrap = start.run(&mut run).unwrap().unwrap();
        run.clear(Buffer::Output);
        run.clear(Buffer::Counters);
        Self { run, start, bootstrap }
    }

    /// What passes over `entries` of the list have in common; the whole ensemble is one layer of the film.
    pub fn uniform(&self, entries: usize) -> PassUniform {
        let stride = self.start.stride;
        PassUniform { seed: 7, stride, group_paths: stride, entries: entries as u32, ..Default::default() }
    }

    pub fn pass(&mut self, pass: &'static str, flags: &[&'static str], uniform: PassUniform) {
        let Start { features, max_edges, .. } = self.start;
        let variant = Variant { pass, features, max_edges, flags: flags.to_vec() };
        self.run.submit(&[Dispatch { variant, uniform }]).unwrap();
    }

    /// A list of two words a path: the path and `second`.
    pub fn list(&mut self, paths: &[u32], second: u32, more: &[u32]) {
        let words: Vec<u32> = paths.iter().flat_map(|path| [*path, second]).chain(more.iter().copied()).collect();
        self.run.set_lists(&words);
    }

    /// A row of the chains, for all paths.
    pub fn row(&mut self, row: usize) -> Vec<[u32; 4]> {
        let size = 16 * u64::from(self.start.stride);
        self.run.read(Buffer::Chains, row as u64 * size..(row as u64 + 1) * size).unwrap()
    }

    pub fn set_row(&mut self, row: usize, rows: &[[u32; 4]]) {
        self.run.set_chains(16 * row as u64 * u64::from(self.start.stride), bytemuck::cast_slice(rows));
    }

    pub fn keys(&mut self) -> Vec<TypeKey> {
        let (rows, lens) = (self.row(ROW_KEY), self.row(ROW_LENS));
        let key = |(row, lens): (&[u32; 4], &[u32; 4])| TypeKey::from_words([row[0], row[1], lens[2], lens[3]]);
        rows.iter().zip(&lens).map(|rows| key(rows).unwrap()).collect()
    }

    /// Candidates with their strategies, which [`Start::fill`] takes.
    pub fn candidates(&mut self, count: u32) -> (Vec<Candidate>, Vec<[u32; 2]>) {
        let strategies = self.bootstrap.strategies.clone();
        self.start.candidates(&mut self.run, &strategies, Given::default(), count, CANDIDATE_PASS).unwrap()
    }

    /// Rows of four numbers of the output buffer.
    pub fn records(&mut self, count: usize) -> Vec<[f32; 4]> {
        self.run.read(Buffer::Output, 0..16 * count as u64).unwrap()
    }
}
