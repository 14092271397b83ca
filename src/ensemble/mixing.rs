//! How well chains mix (METHOD.md 5.10): how long paths wait for a move, how long log I is remembered, and whether groups
//! agree. Read once in each half-sweep, at a time fixed in advance; nothing here reaches the chains.

use super::agreement::Agreement;
use super::autocorrelation::Autocorrelation;
use super::groups::Groups;
use super::mix::HALF_SWEEP;
use super::pool::{TypeKey, abbreviated};

/// Paths of a half whose log I is followed: their autocovariances scatter by little where there are so many.
const FOLLOWED: u32 = 512;
/// A wait is spoken of that alone puts so many times the film's mean luminance on one pixel: one that stands out.
const BRIGHT: f64 = 10.0;
/// No wait is spoken of below: so long waits one of a million paths of which one proposal in eight is accepted.
const SHORT_WAIT: f64 = 100.0;
/// A path stands still that has not moved for so much of the render: it may wait for its end, and its light is what the
/// start has made it. So many of the paths may.
const STILL: f64 = 0.5;
const FEW: f64 = 0.01;

/// What is seen of one path.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub key: TypeKey,
    pub log_i: f32,
    /// Mutations since it last moved.
    pub waited: u32,
}

/// What has been seen of the chains.
#[derive(Debug, Clone)]
pub struct Mixing {
    groups: Groups,
    memory: Autocorrelation,
    log_i: Agreement,
    edges: Agreement,
    /// The longest wait seen, with the type of its path: a path that waits keeps its type.
    waiting: Option<(u32, TypeKey)>,
    /// How long every path had waited when last seen.
    waits: Vec<u32>,
}

/// How well chains mix.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MixingStatistics {
    /// Mutations that each path has made.
    pub mutations: f64,
    /// The most of them in a row in which a path did not move, and the type of such a path, as in L S D E.
    pub longest_wait: u64,
    pub waiting_type: String,
    /// Share of the paths that, when last seen, had not moved for half of their mutations.
    pub still: f64,
    /// Integrated autocorrelation time of log I in mutations; none where the render is too short to tell.
    pub memory: Option<f64>,
    /// Effective samples of log I by all paths, as if paths did not know of each other; none where log I is the same for all.
    pub effective: Option<f64>,
    /// Groups that are compared.
    pub groups: u32,
    /// Nested R-hat of log I and of the number of edges; none with one group.
    pub r_hat: Option<[f64; 2]>,
    /// Up to where groups agree.
    pub r_hat_limit: f64,
    /// Paths of the ensemble, and pixels of the film.
    pub paths: u32,
    pub pixels: u64,
}

impl MixingStatistics {
    /// What the longest wait has put on its pixel, in mean luminances of the film.
    fn brightness(&self) -> f64 {
        self.longest_wait as f64 * self.pixels as f64 / (self.mutations * f64::from(self.paths)).max(1.0)
    }

    /// What a user should know, and do about it.
    pub fn warnings(&self) -> Vec<String> {
        let mut list = Vec::new();
        let Self { mutations, longest_wait, waiting_type, groups, r_hat_limit, .. } = self;
        if let Some([log_i, edges]) = self.r_hat.filter(|r_hat| r_hat.iter().any(|r| *r > *r_hat_limit)) {
            list.push(format!(
                "the {groups} groups of paths do not agree: nested R-hat is {log_i:.3} for log I and {edges:.3} for lengths of paths, up to {r_hat_limit:.2} is agreement; they have not forgotten where they started, raise --spp and compare several seeds"
            ));
        }
        let brightness = self.brightness();
        if *longest_wait as f64 >= SHORT_WAIT && brightness > BRIGHT {
            list.push(format!(
                "a path {waiting_type} has not moved for {longest_wait} mutations, which alone put {brightness:.0} times the film's mean luminance on one pixel: expect bright spots, raise --spp or give kernels that move such paths more weight by --kernels"
            ));
        }
        if *mutations >= SHORT_WAIT && self.still > FEW {
            list.push(format!(
                "{:.1} % of the paths have not moved for half of the {mutations:.0} mutations that each made: what they carry is as the start has left it, raise --spp or give other kernels more weight by --kernels",
                100.0 * self.still
            ));
        }
        list
    }
}

impl Mixing {
    pub fn new(groups: Groups) -> Self {
        let [log_i, edges] = [(); 2].map(|()| Agreement::new(groups));
        Self {
            groups,
            memory: Autocorrelation::new(2),
            log_i,
            edges,
            waiting: None,
            waits: vec![0; groups.paths() as usize],
        }
    }

    /// Adds what is seen of every path of a half.
    pub fn observe(&mut self, half: usize, paths: &[Seen]) {
        let followed = FOLLOWED.min(self.groups.half_paths());
        let place = |i: u32| (u64::from(i) * paths.len() as u64 / u64::from(followed)) as usize;
        let values: Vec<f32> = (0..followed).map(|i| paths[place(i)].log_i).collect();
        self.memory.observe(half, &values);
        rayon::join(
            || self.log_i.observe(half, paths.iter().map(|seen| f64::from(seen.log_i))),
            || self.edges.observe(half, paths.iter().map(|seen| f64::from(seen.key.edges()))),
        );
        let waits = &mut self.waits[self.groups.first_of_half(half) as usize..];
        for (wait, seen) in waits.iter_mut().zip(paths) {
            *wait = seen.waited;
            if self.waiting.is_none_or(|(longest, _)| seen.waited > longest) {
                self.waiting = Some((seen.waited, seen.key));
            }
        }
    }

    /// What all that comes to after `mutations` of each path, with the longest wait that the device has counted.
    pub fn statistics(&self, mutations: f64, longest_wait: u64, pixels: u64) -> MixingStatistics {
        let memory = self.memory.memory();
        let still = self.waits.iter().filter(|wait| f64::from(**wait) > STILL * mutations).count();
        MixingStatistics {
            mutations,
            longest_wait,
            waiting_type: self.waiting.map_or(String::new(), |(_, key)| abbreviated(&key.string())),
            memory: memory.and_then(|memory| memory.time).map(|time| time * f64::from(HALF_SWEEP)),
            effective: memory.map(|memory| memory.effective * f64::from(self.groups.paths())),
            groups: self.groups.count(),
            r_hat: self.log_i.r_hat().zip(self.edges.r_hat()).map(|(log_i, edges)| [log_i, edges]),
            r_hat_limit: self.log_i.limit(),
            still: still as f64 / self.waits.len().max(1) as f64,
            paths: self.groups.paths(),
            pixels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pool::Tag::{Diffuse as D, Transmission as T};
    use super::*;

    const KEYS: [&[super::super::pool::Tag]; 2] = [&[D], &[T, D]];

    /// Paths of 8 groups whose log I is drawn anew at every look, or once: then groups are shifted against each other.
    fn seen(half: usize, look: u32, moves: bool) -> Vec<Seen> {
        let of = |path: u32| {
            let random = crate::reference::rng::random_words(3, path, if moves { look } else { 0 }, half as u32);
            let group = if moves { 0.0 } else { (path / 128) as f32 };
            let waited = if moves { random[1] % 30 } else { 20 * look + 1 };
            let key = TypeKey::from_tags(KEYS[(path % 2) as usize]);
            Seen { key, log_i: (random[0] >> 8) as f32 / 16_777_216.0 + 0.5 * group, waited }
        };
        (0..1024).map(of).collect()
    }

    fn mixing(moves: bool) -> MixingStatistics {
        let mut mixing = Mixing::new(Groups::new(2048, 8));
        for look in 0..40 {
            (0..2).for_each(|half| mixing.observe(half, &seen(half, look, moves)));
        }
        mixing.statistics(800.0, if moves { 35 } else { 800 }, 20_480)
    }

    #[test]
    fn good_chains_are_told_from_bad_ones() {
        let good = mixing(true);
        assert_eq!((good.memory.map(|m| m < 25.0), good.warnings()), (Some(true), vec![]));
        assert!(good.effective.unwrap() > 0.8 * 40.0 * 2048.0, "{good:?}");
        let bad = mixing(false);
        assert_eq!(bad.memory, None);
        assert!((bad.effective.unwrap() / 2048.0 - 1.0).abs() < 0.02, "{bad:?}");
        assert_eq!(bad.waiting_type, "L D E");
        let notes = bad.warnings();
        let said = |i: usize, words: &str| notes[i].contains(words);
        // 800 waits of 2048 * 800 mutations on 20,480 pixels.
        assert!(notes.len() == 2 && said(0, "do not agree") && said(1, "100.0 % of the paths"), "{notes:?}");
        let bright = MixingStatistics { pixels: 40_960, ..bad };
        assert!(bright.warnings()[1].contains("800 mutations, which alone put 20 times"), "{:?}", bright.warnings());
    }

    #[test]
    fn waits_are_bright_or_not_and_short_ones_never() {
        let of = |longest_wait, mutations, pixels| {
            let statistics = MixingStatistics { longest_wait, mutations, pixels, paths: 100, ..Default::default() };
            statistics.warnings().len()
        };
        assert_eq!((of(900, 2400.0, 2000), of(1300, 2400.0, 2000), of(90, 100.0, 2000)), (0, 1, 0));
    }
}
