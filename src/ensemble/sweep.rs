//! Half-sweeps: one half of the ensemble moves while the other is frozen and guides it (METHOD.md 3.1, 3.7), in all groups
//! at once.
//!
//! A half-sweep is first structural mutations of every path, then a fixed number of passes in which types do not change
//! and the dispatch lists are sorted by type. Paths that no kernel applies to rest with their weight (C6a). It can be made in
//! smaller steps, which change nothing but when the host hears of them.

mod chores;
mod crossover;
mod halves;
mod tallies;

use std::collections::VecDeque;
use std::time::Instant;

use super::bootstrap::{Bootstrap, Mean};
pub use super::build::{Build, list_words};
use super::cuts::CutList;
use super::groups::Group;
use super::mix::Mix;
use super::mixing::Mixing;
use super::subpaths::PlanList;
use super::type_shares::TypeShares;
use super::work::Work;
use crate::Result;
use crate::gpu::layout::{COUNTER_WORDS, PassUniform};
use crate::gpu::run::{Dispatch, PASS_SLOTS, Run};
use crate::kernels::Family;
use crate::reference::rng;
use chores::Chores;
use tallies::Tally;

/// The independence kernel's number in every mix.
const INDEPENDENCE: usize = 0;

/// First word of a kernel's counters, by its number.
fn counters_of(kernel: usize) -> u32 {
    (kernel * COUNTER_WORDS) as u32
}

/// Where a half-sweep stands between its steps.
enum Phase {
    /// So many structural mutations of every path are made.
    Structural(u32),
    /// Perturbations that the device has not been given yet, in order.
    Perturbing(VecDeque<Dispatch>),
}

/// The ensemble in motion.
pub struct Ensemble {
    build: Build,
    mix: Mix,
    bootstrap: Bootstrap,
    /// The groups of either half, in the order of their paths.
    halves: [Vec<Group>; 2],
    /// Which half moves next.
    moving: usize,
    phase: Phase,
    /// Global pass counter; keys every random number together with the path index.
    pass_index: u32,
    /// One a kernel of the mix, and one of paths that no kernel applied to.
    tallies: Vec<Tally>,
    rest: Tally,
    /// b and the integral of the target: their samples of the start, and every proposal of the independence kernel.
    b: Mean,
    target: Mean,
    types: TypeShares,
    mixing: Mixing,
    /// Host work that waits until the device has perturbations to make.
    chores: Chores,
}

impl Ensemble {
    /// Takes over chains that the bootstrap filled.
    pub fn new(run: &mut Run, build: Build, mix: Mix, bootstrap: Bootstrap) -> Result<Self> {
        run.set_strategies(&bootstrap.strategies.log_table());
        if let Some(weights) = &bootstrap.pixel_weights {
            run.set_pixel_weights(build.max_edges, weights.table());
        }
        let Bootstrap { b, target, .. } = bootstrap;
        let types = bootstrap.types.clone();
        let tallies = vec![Tally::default(); mix.kernels().len()];
        let mut ensemble = Self {
            build,
            mix,
            bootstrap,
            halves: Default::default(),
            moving: 0,
            phase: Phase::Structural(0),
            pass_index: 0,
            tallies,
            rest: Tally::default(),
            b,
            target,
            types,
            mixing: Mixing::new(build.groups),
            chores: Chores::default(),
        };
        for half in 0..2 {
            ensemble.regroup(run, half, false)?;
            ensemble.freeze(run, half)?;
        }
        Ok(ensemble)
    }

    /// Mutations so far; each put weight 1 on the film.
    pub fn mutations(&self) -> u64 {
        self.rest.mutations + self.tallies.iter().map(|t| t.mutations).sum::<u64>()
    }

    /// Whether no half-sweep is under way: then, and only then, every mutation counted is on the film.
    pub fn is_whole(&self) -> bool {
        matches!(self.phase, Phase::Structural(0))
    }

    /// Whether the next step perturbs, and so can be cut.
    pub fn perturbs(&self) -> bool {
        matches!(self.phase, Phase::Perturbing(_))
    }

    /// A part of a half-sweep: one structural mutation of every path, or at most so many dispatches of perturbations. The
    /// last part swaps the halves' parts.
    pub fn step(&mut self, run: &mut Run, dispatches: usize) -> Result<()> {
        let half = self.moving;
        match &mut self.phase {
            Phase::Structural(made) => {
                let number = *made;
                let kernel = self.structural_kernel(number);
                if let Some(kernel) = kernel {
                    self.structural(run, half, kernel, number)?;
                }
                self.phase = if self.structural_kernel(number + 1).is_some() {
                    Phase::Structural(number + 1)
                } else {
                    Phase::Perturbing(self.perturbations(run, half))
                };
            }
            Phase::Perturbing(waiting) => {
                let now: Vec<Dispatch> = waiting.drain(..dispatches.clamp(1, PASS_SLOTS).min(waiting.len())).collect();
                let last = waiting.is_empty();
                run.submit_timed(&now)?;
                if last {
                    let start = Instant::now();
                    self.do_chores(half);
                    // The device works meanwhile, and for longer.
                    run.device_time += start.elapsed();
                    self.freeze(run, half)?;
                    self.tally(run)?;
                    let nodes = self.halves[half].iter().flat_map(|group| &group.pool.types);
                    self.types.count_chains(nodes.map(|node| (node.key, node.range.count)));
                    self.moving = 1 - half;
                    self.phase = Phase::Structural(0);
                }
            }
        }
        Ok(())
    }

    /// The kernel that makes structural mutation `number` of a half-sweep.
    fn structural_kernel(&self, number: u32) -> Option<usize> {
        let mut passes =
            (0..self.tallies.len()).flat_map(|kernel| (0..self.mix.structural_passes(kernel)).map(move |_| kernel));
        passes.nth(number as usize)
    }

    fn structural(&mut self, run: &mut Run, half: usize, kernel: usize, number: u32) -> Result<()> {
        if kernel == INDEPENDENCE {
            self.independence(run, half)?;
        } else if self.mix.family(kernel) == Family::Pair {
            self.crossover(run, half, kernel)?;
        } else {
            self.drawn(run, half, kernel)?;
        }
        let samples = self.regroup(run, half, kernel == INDEPENDENCE)?;
        if kernel == INDEPENDENCE {
            self.chores.samples.extend(samples);
            if number == 0 {
                self.chores.seen = self.look(run, half)?;
            }
        }
        Ok(())
    }

    /// The independence mutation: log w of every path, then the proposals, sorted by what they draw.
    fn independence(&mut self, run: &mut Run, half: usize) -> Result<()> {
        let half_paths = self.build.groups.half_paths();
        let entries = match self.chores.drawn.take() {
            Some((pass_index, entries)) if pass_index == self.pass_index => entries,
            _ => self.draw_strategies(half),
        };
        run.set_lists(bytemuck::cast_slice(&entries));
        let uniform = PassUniform {
            pass_index: self.pass_index,
            entries: half_paths,
            counters_offset: counters_of(INDEPENDENCE),
            ..self.build.uniform()
        };
        let dispatches =
            ["weigh", "independence"].map(|pass| Dispatch { variant: self.build.variant(pass, &[]), uniform });
        self.tallies[INDEPENDENCE].mutations += u64::from(half_paths);
        self.pass_index += 1;
        run.submit_timed(&dispatches)
    }

    /// Mutations that the host draws a cut or a plan for, sorted by it; paths without one rest.
    fn drawn(&mut self, run: &mut Run, half: usize, kernel: usize) -> Result<()> {
        let kernel_of = self.mix.kernels().nth(kernel).expect("structural kernels are of the mix");
        let groups = (0..).zip(&self.halves[half]).zip(&self.halves[1 - half]);
        let groups: Vec<_> =
            groups.map(|((group, x), y)| (&x.pool, &y.pool, self.build.groups.first(1 - half, group))).collect();
        let random = |path, dimension| rng::random_words(self.build.seed, path, self.pass_index, dimension);
        let (words, moved, resting, resting_offset) = if kernel_of.pass == "subpath" {
            let PlanList { words, entries, resting, resting_offset } =
                PlanList::draw(kernel_of, self.build.features, &groups, random);
            (words, entries.len(), resting, resting_offset)
        } else {
            let CutList { words, entries, resting, resting_offset } =
                CutList::draw(&groups, random, self.build.direct.min_edges()..=self.build.max_edges);
            (words, entries.len(), resting, resting_offset)
        };
        run.set_lists(&words);
        let base =
            PassUniform { pass_index: self.pass_index, counters_offset: counters_of(kernel), ..self.build.uniform() };
        let dispatches = [
            (kernel_of.pass, kernel_of.flags, PassUniform { entries: moved as u32, ..base }),
            ("rest", &[][..], PassUniform { entries: resting, entries_offset: resting_offset, weight: 1.0, ..base }),
        ];
        let dispatches: Vec<Dispatch> = dispatches
            .into_iter()
            .filter(|(_, _, uniform)| uniform.entries > 0)
            .map(|(pass, flags, uniform)| Dispatch { variant: self.build.variant(pass, flags), uniform })
            .collect();
        // A mutation without a cut or a plan is one that fails at once.
        self.tallies[kernel].mutations += u64::from(self.build.groups.half_paths());
        self.pass_index += 1;
        run.submit_timed(&dispatches)
    }

    /// The type-keeping passes; their lists go to the device at once.
    fn perturbations(&mut self, run: &Run, half: usize) -> VecDeque<Dispatch> {
        let work = Work::new(&self.halves[half], &self.halves[1 - half], &self.mix, self.build.features);
        run.set_lists(&work.words);
        let base = PassUniform {
            nodes_offset: work.nodes_offset,
            guides_first: self.build.groups.first_of_half(1 - half),
            ..self.build.uniform()
        };
        let kernels: Vec<_> = self.mix.kernels().collect();
        let mut dispatches = VecDeque::new();
        for pass in &work.passes {
            for &(kernel, list) in pass {
                dispatches.push_back(Dispatch {
                    variant: self.build.variant(kernels[kernel].pass, kernels[kernel].flags),
                    uniform: PassUniform {
                        pass_index: self.pass_index,
                        entries: list.count,
                        entries_offset: list.offset,
                        counters_offset: counters_of(kernel),
                        ..base
                    },
                });
                self.tallies[kernel].mutations += u64::from(list.count);
            }
            self.pass_index += 1;
        }
        if work.idle.count > 0 {
            dispatches.push_back(Dispatch {
                variant: self.build.variant("rest", &[]),
                uniform: PassUniform {
                    pass_index: self.pass_index,
                    entries: work.idle.count,
                    entries_offset: work.idle.offset,
                    weight: self.mix.perturbation_passes() as f32,
                    counters_offset: counters_of(self.tallies.len()),
                    ..base
                },
            });
            self.rest.mutations += u64::from(work.idle.count) * u64::from(self.mix.perturbation_passes());
        }
        self.pass_index += 1;
        dispatches
    }

    /// b and its standard error, from the candidates and all independent proposals since.
    pub fn b(&self) -> (f64, f64) {
        (self.b.mean(), self.b.standard_error())
    }

    /// The integral of the chains' target, by which the film is scaled (METHOD.md 1.4).
    pub fn target(&self) -> f64 {
        self.target.mean()
    }

    /// Its standard error.
    pub fn target_error(&self) -> f64 {
        self.target.standard_error()
    }

    /// w by number of the pixel: what a mutation there counts on the film.
    pub fn pixel_weight(&self, pixel: usize) -> f64 {
        self.bootstrap.pixel_weights.as_ref().map_or(1.0, |weights| weights.of_pixel(pixel as u32))
    }

    /// How the target is shared among types of paths: by the start, and by the chains so far.
    pub fn types(&self) -> &TypeShares {
        &self.types
    }
}
