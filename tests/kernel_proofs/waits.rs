//! How long paths wait for a move: the device's count against one from the states themselves.

use emlt::gpu::layout::{COUNTER_LONGEST_WAIT, COUNTER_WORDS, PassUniform, ROW_KEY, ROW_PIXEL, ROW_VERTICES};
use emlt::gpu::run::{Buffer, Dispatch};
use emlt::gpu::shader::Variant;
use emlt::kernels::{caustic, lens};

use crate::SPECULAR_SCENE;
use crate::bench::{Bench, COLUMNS, Guides, HALF, MAX_EDGES, SEED, context};
use crate::crossover::cross_once;

const PASSES: u32 = 8;

/// Type, pixel and vertices of every path: what a move changes, as words.
fn states(bench: &mut Bench) -> Vec<Vec<u32>> {
    let mut words = vec![Vec::new(); 2 * HALF as usize];
    let rows = [(ROW_PIXEL, 2), (ROW_KEY, 2)];
    for (row, count) in rows.into_iter().chain((0..2 * MAX_EDGES as usize).map(|i| (ROW_VERTICES + i, 3))) {
        for (path, row) in bench.rows(row, 0, 2 * HALF).iter().enumerate() {
            words[path].extend(&row[..count]);
        }
    }
    words
}

/// Counts one mutation of `moved` paths on the host, and compares every path of the device.
struct Watch {
    states: Vec<Vec<u32>>,
    waited: Vec<u32>,
    longest: u32,
}

impl Watch {
    fn new(bench: &mut Bench) -> Self {
        bench.run.clear(Buffer::Counters);
        Self { states: states(bench), waited: vec![0; 2 * HALF as usize], longest: 0 }
    }

    #[track_caller]
    fn check(&mut self, bench: &mut Bench, tried: &[u32], mutations: u32, what: &str) {
        let after = states(bench);
        let mut moved = 0;
        for &path in tried {
            let path = path as usize;
            let stays = self.states[path] == after[path];
            self.waited[path] = if stays { self.waited[path] + mutations } else { 0 };
            self.longest = self.longest.max(self.waited[path]);
            moved += usize::from(!stays);
        }
        self.states = after;
        let told: Vec<u32> = bench.rows(ROW_PIXEL, 0, 2 * HALF).iter().map(|row| row[3]).collect();
        assert!(told == self.waited, "{what}: the device has counted otherwise");
        let words: Vec<u32> = bench.run.read(Buffer::Counters, 0..4 * COUNTER_WORDS as u64).unwrap();
        assert_eq!(words[COUNTER_LONGEST_WAIT], self.longest, "{what}");
        println!("{what}: {moved} of {} paths moved, longest wait {}", tried.len(), self.longest);
    }
}

/// Perturbations from either side, exchanges, and rests; also `weigh`, which writes beside the count, leaves it alone.
#[test]
fn waits_are_counted_as_they_are() {
    let context = context();
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    bench.refresh();
    let mut watch = Watch::new(&mut bench);
    for pass in 1..=PASSES {
        for kernel in [&caustic::KERNEL, &lens::KERNEL] {
            let (uniform, paths) = bench.list(kernel, HALF, Guides::Other);
            bench.passes(kernel, &[], uniform, pass..pass + 1);
            watch.check(&mut bench, &paths, 1, kernel.name);
        }
        bench.refresh();
        if pass.is_multiple_of(4) {
            let paths = cross_once(&mut bench, 100 + pass);
            watch.check(&mut bench, &paths, 1, "crossover");
        }
        let paths: Vec<u32> = (0..1000 * pass).collect();
        bench.run.set_lists(&paths.iter().flat_map(|path| [*path, 0]).collect::<Vec<u32>>());
        let variant = Variant { pass: "rest", features: bench.features, max_edges: MAX_EDGES, flags: vec![] };
        let (entries, weight) = (paths.len() as u32, 3.0);
        let uniform =
            PassUniform { seed: SEED, stride: COLUMNS, group_paths: COLUMNS, entries, weight, ..Default::default() };
        bench.run.submit(&[Dispatch { variant, uniform }]).unwrap();
        watch.check(&mut bench, &paths, 3, "rest");
    }
    assert!(watch.longest > 3 * PASSES);
}
