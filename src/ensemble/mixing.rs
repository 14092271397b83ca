//! How well chains mix (METHOD.md 5.10): how long paths wait for a move, how long log I is remembered, and whether groups
//! agree. Read once in each half-sweep, at a time fixed in advance; nothing here reaches the chains.

use super::agreement::Agreement;
use super::autocorrelation::Autocorrelation;
use super::groups::Groups;
use super::mix::HALF_SWEEP;
use super::pool::TypeKey;

/// Paths of a half whose log I is followed: their autocovariances scatter by little where there are so many.
const FOLLOWED: u32 = 512;
/// Share of its mutations that a path may wait without being spoken of: one that waits longer may wait until the render's
/// end, so how much light its place gets is decided by when the render ends and not by how likely the place is.
const LONG_WAIT: f64 = 0.5;
/// No wait is spoken of below: as long as this, one of a million paths waits where one proposal in eight is accepted.
const SHORT_WAIT: u64 = 100;

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
}

/// How well chains mix.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MixingStatistics {
    /// Mutations that each path has made.
    pub mutations: f64,
    /// The most of them in a row in which a path did not move, and the type of such a path, as in L S D E.
    pub longest_wait: u64,
    pub waiting_type: String,
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
    /// Paths of the ensemble.
    pub paths: u32,
}

impl MixingStatistics {
    /// What a user should know, and do about it.
    pub fn warnings(&self) -> Vec<String> {
        let mut list = Vec::new();
        let Self { mutations, longest_wait, waiting_type, groups, r_hat_limit, .. } = self;
        if let Some([log_i, edges]) = self.r_hat.filter(|r_hat| r_hat.iter().any(|r| *r > *r_hat_limit)) {
            list.push(format!(
                "the {groups} groups of paths do not agree: nested R-hat is {log_i:.3} for log I and {edges:.3} for lengths of paths, up to {r_hat_limit:.2} is agreement; they have not forgotten where they started, raise --spp and compare several seeds"
            ));
        }
        if *longest_wait >= SHORT_WAIT && *longest_wait as f64 > LONG_WAIT * mutations {
            list.push(format!(
                "a path {waiting_type} has not moved for {longest_wait} mutations, of about {mutations:.0} that each path makes: expect bright spots in its light, raise --spp until no wait is that long"
            ));
        }
        list
    }
}

impl Mixing {
    pub fn new(groups: Groups) -> Self {
        let [log_i, edges] = [(); 2].map(|()| Agreement::new(groups));
        Self { groups, memory: Autocorrelation::new(2), log_i, edges, waiting: None }
    }

    /// Adds what is seen of every path of a half.
    pub fn observe(&mut self, half: usize, paths: &[Seen]) {
        let followed = FOLLOWED.min(self.groups.half_paths());
        let place = |i: u32| (u64::from(i) * paths.len() as u64 / u64::from(followed)) as usize;
        let values: Vec<f32> = (0..followed).map(|i| paths[place(i)].log_i).collect();
        self.memory.observe(half, &values);
        self.log_i.observe(half, paths.iter().map(|seen| f64::from(seen.log_i)));
        self.edges.observe(half, paths.iter().map(|seen| f64::from(seen.key.edges())));
        for seen in paths {
            if self.waiting.is_none_or(|(longest, _)| seen.waited > longest) {
                self.waiting = Some((seen.waited, seen.key));
            }
        }
    }

    /// What all that comes to after `mutations` of each path, with the longest wait that the device has counted.
    pub fn statistics(&self, mutations: f64, longest_wait: u64) -> MixingStatistics {
        let memory = self.memory.memory();
        MixingStatistics {
            mutations,
            longest_wait,
            waiting_type: self.waiting.map_or(String::new(), |(_, key)| key.string()),
            memory: memory.and_then(|memory| memory.time).map(|time| time * f64::from(HALF_SWEEP)),
            effective: memory.map(|memory| memory.effective * f64::from(self.groups.paths())),
            groups: self.groups.count(),
            r_hat: self.log_i.r_hat().zip(self.edges.r_hat()).map(|(log_i, edges)| [log_i, edges]),
            r_hat_limit: self.log_i.limit(),
            paths: self.groups.paths(),
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
        mixing.statistics(800.0, if moves { 35 } else { 800 })
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
        assert!(
            notes.len() == 2 && notes[0].contains("do not agree") && notes[1].contains("800 mutations"),
            "{notes:?}"
        );
    }

    #[test]
    fn waits_are_long_or_short_against_the_render() {
        let of = |longest_wait, mutations| {
            MixingStatistics { longest_wait, mutations, ..Default::default() }.warnings().len()
        };
        assert_eq!((of(900, 2400.0), of(1300, 2400.0), of(90, 100.0), of(100, 100.0)), (0, 1, 0, 1));
    }
}
