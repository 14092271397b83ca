//! How light is shared among types of paths: as the start's candidates have it, and as the chains have it.
//!
//! Both estimate the same shares. Where they differ by more than their errors, or where the start's own error is large,
//! the image has not converged in that type: Metropolis renders lose such light without a trace in the picture.

use std::collections::{BTreeMap, HashMap};

use super::path_traced::PathTraced;
use super::pool::{TypeKey, abbreviated};

/// Batches of half-sweeps whose scatter gives the chains' error.
const BATCHES: usize = 16;
/// Types below this share are not spoken of.
const LEAST_SHARE: f64 = 0.005;
/// Deviation in standard errors, and relative standard error of the start, from which a type has not converged.
const WORST_Z: f64 = 4.0;
const WORST_ERROR: f64 = 0.3;
/// Types of fewer candidates are as good as not found.
const FEWEST_CANDIDATES: u64 = 10;

/// Share of one type string in the target, estimated twice.
#[derive(Debug, Clone, PartialEq)]
pub struct TypeStatistics {
    /// As in L S D E.
    pub name: String,
    /// By the start's candidates, with its standard error, and how many of them carry it.
    pub start: f64,
    pub start_error: f64,
    pub candidates: u64,
    /// By the chains, averaged over half-sweeps, with the standard error of batch means and that of the start's draw of so
    /// many chains, which slow types keep.
    pub chains: f64,
    pub chains_error: f64,
}

impl TypeStatistics {
    /// Difference of the two estimates in standard errors.
    pub fn z(&self) -> f64 {
        (self.chains - self.start) / self.start_error.hypot(self.chains_error).max(1e-12)
    }

    fn warning(&self) -> Option<String> {
        if self.start.max(self.chains) < LEAST_SHARE {
            return None;
        }
        let (name, candidates) = (abbreviated(&self.name), self.candidates);
        let [start, error, chains] = [self.start, self.start_error, self.chains].map(|share| 100.0 * share);
        if self.z().abs() > WORST_Z {
            return Some(format!(
                "paths {name} hold {chains:.2} % of the chains but {start:.2} +- {error:.2} % of the light: they have not converged, raise --spp, or the weights of the kernels that change types (independence and bidirectional ones, by --kernels), and compare several seeds"
            ));
        }
        (self.start_error > WORST_ERROR * self.start).then(|| {
            format!(
                "paths {name} hold {start:.2} +- {error:.2} % of the light by {candidates} of the start's candidates: they have not converged, compare several seeds, or make such light easier to find with larger lights"
            )
        })
    }
}

/// What a user should know of types that have not converged, the worst first.
///
/// Light through glass or water that is seen through glass or water, L S D S E, is found only by paths that hit the lamp by
/// chance: from a lamp of millimetres, by none. Nothing then tells of it but its kin, paths that are scattered once more
/// and can be made by connecting, L S D D S E: where these hold light, so does what is missing. What is `path_traced` is not
/// the start's to find.
pub fn warnings(types: &[TypeStatistics], path_traced: PathTraced) -> Vec<String> {
    let candidates = |name: &str| types.iter().find(|t| t.name == name).map_or(0, |t| t.candidates);
    let mut list: Vec<String> = Vec::new();
    for kin in types.iter().filter(|t| t.start.max(t.chains) > LEAST_SHARE) {
        let name = kin.name.replacen("D D", "D", 1);
        let found = candidates(&name);
        let [short, kin_short] = [&name, &kin.name].map(|name| abbreviated(name));
        if name != kin.name
            && !connects(&name)
            && found < FEWEST_CANDIDATES
            && !TypeKey::from_string(&name).is_some_and(|key| path_traced.has(key))
            && !list.iter().any(|w| w.contains(&short))
        {
            let share = 100.0 * kin.start.max(kin.chains);
            list.push(format!(
                "paths {short} have not converged: only hitting a light by chance finds them, which {found} of the start's candidates did, while paths {kin_short} hold {share:.1} % of the light; expect their light to be missing, or enlarge the light"
            ));
        }
    }
    list.extend(types.iter().filter_map(TypeStatistics::warning));
    list
}

/// Whether two neighbours on a path of this type can be connected, so that it need not hit the light by chance.
fn connects(name: &str) -> bool {
    let vertices: Vec<&str> = name.split(' ').collect();
    vertices.windows(2).any(|pair| !pair.contains(&"S"))
}

/// Sums of one type.
#[derive(Debug, Clone, Default)]
struct Sums {
    weight: f64,
    weight2: f64,
    candidates: u64,
    /// Share of the chains summed over the half-sweeps of each batch.
    batches: [f64; BATCHES],
}

/// Sums over candidates and half-sweeps, by type string.
#[derive(Debug, Clone, Default)]
pub struct TypeShares {
    types: BTreeMap<String, Sums>,
    /// Half-sweeps a batch, those of the open batch, and full batches.
    length: u32,
    open: u32,
    full: usize,
    /// Chains of both halves.
    paths: f64,
}

impl TypeShares {
    /// From the candidates' type keys (as words) and weights in the target; those of weight 0 count for nothing.
    pub fn of_start(candidates: impl Iterator<Item = ([u32; 4], f64)>) -> Self {
        let mut keys: HashMap<[u32; 4], Sums> = HashMap::new();
        for (key, weight) in candidates.filter(|(_, weight)| *weight > 0.0) {
            let sums = keys.entry(key).or_default();
            sums.weight += weight;
            sums.weight2 += weight * weight;
            sums.candidates += 1;
        }
        let mut types: BTreeMap<String, Sums> = BTreeMap::new();
        // In the order of the keys: sums must not depend on the map's.
        let mut keys: Vec<_> = keys.into_iter().collect();
        keys.sort_by_key(|(key, _)| *key);
        for (key, sums) in keys {
            if let Some(key) = TypeKey::from_words(key) {
                let all = types.entry(key.string()).or_default();
                all.weight += sums.weight;
                all.weight2 += sums.weight2;
                all.candidates += sums.candidates;
            }
        }
        Self { types, length: 1, open: 0, full: 0, paths: 0.0 }
    }

    /// Counts one half after its half-sweep: paths by type.
    pub fn count_chains(&mut self, paths: impl Iterator<Item = (TypeKey, u32)>) {
        let mut counts: BTreeMap<String, f64> = BTreeMap::new();
        for (key, count) in paths {
            *counts.entry(key.string()).or_default() += f64::from(count);
        }
        let all: f64 = counts.values().sum();
        self.paths = 2.0 * all;
        for (name, count) in counts {
            self.types.entry(name).or_default().batches[self.full] += count / all;
        }
        self.open += 1;
        if self.open == self.length {
            self.open = 0;
            self.full += 1;
        }
        if self.full == BATCHES {
            // Batches of twice the length from here on.
            self.full = BATCHES / 2;
            self.length *= 2;
            for sums in self.types.values_mut() {
                let merged =
                    |i: usize| if i < BATCHES / 2 { sums.batches[2 * i] + sums.batches[2 * i + 1] } else { 0.0 };
                sums.batches = std::array::from_fn(merged);
            }
        }
    }

    /// Every type, the largest share first.
    pub fn statistics(&self) -> Vec<TypeStatistics> {
        let total: f64 = self.types.values().map(|sums| sums.weight).sum();
        let sweeps = f64::from(self.length) * self.full as f64 + f64::from(self.open);
        let mut list: Vec<TypeStatistics> = self
            .types
            .iter()
            .map(|(name, sums)| {
                let start = sums.weight / total.max(1e-300);
                let chains = sums.batches.iter().sum::<f64>() / sweeps.max(1.0);
                let full = sums.batches[..self.full].iter().map(|sum| sum / f64::from(self.length));
                let n = self.full as f64;
                let scatter = full.map(|mean| (mean - chains).powi(2)).sum::<f64>();
                let batches = if n > 1.0 { (scatter / (n * (n - 1.0))).sqrt() } else { 0.0 };
                let likely = start.max(chains);
                let draw = (likely * (1.0 - likely) / self.paths.max(1.0)).sqrt();
                TypeStatistics {
                    name: name.clone(),
                    start,
                    // Of a ratio: each weight counts for its type, and against it in the total.
                    start_error: (sums.weight2 * (1.0 - start)).sqrt() / total.max(1e-300),
                    candidates: sums.candidates,
                    chains,
                    chains_error: batches.hypot(draw),
                }
            })
            .collect();
        list.sort_by(|a, b| b.start.max(b.chains).total_cmp(&a.start.max(a.chains)));
        list
    }
}

#[cfg(test)]
mod tests {
    use super::super::pool::Tag::{Diffuse as D, Transmission as T};
    use super::*;

    const DIRECT: &[super::super::pool::Tag] = &[D];
    const CAUSTIC: &[super::super::pool::Tag] = &[T, D];

    fn shares(weights: &[(&[super::super::pool::Tag], f64)]) -> TypeShares {
        TypeShares::of_start(weights.iter().map(|(tags, weight)| (TypeKey::from_tags(tags).words(), *weight)))
    }

    #[test]
    fn shares_of_the_start_and_of_the_chains() {
        let mut shares = shares(&[(DIRECT, 1.0), (DIRECT, 2.0), (CAUSTIC, 1.0), (CAUSTIC, 0.0)]);
        for _ in 0..37 {
            shares.count_chains([(TypeKey::from_tags(DIRECT), 3), (TypeKey::from_tags(CAUSTIC), 1)].into_iter());
        }
        let list = shares.statistics();
        assert_eq!(list.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(), ["L D E", "L S D E"]);
        assert!((list[0].start - 0.75).abs() < 1e-12 && (list[0].chains - 0.75).abs() < 1e-12, "{list:?}");
        assert!((list[0].chains_error - (0.1875f64 / 8.0).sqrt()).abs() < 1e-12 && list[1].candidates == 1);
        assert!((list[1].start_error - (0.75f64).sqrt() / 4.0).abs() < 1e-12);
    }

    #[test]
    fn batches_scatter_as_their_means_do() {
        let mut shares = shares(&[(DIRECT, 1.0)]);
        // Half-sweeps that take turns: every batch of an even length has the same mean.
        for n in 0..64u32 {
            let direct = if n.is_multiple_of(2) { 3 } else { 1 };
            shares.count_chains(
                [(TypeKey::from_tags(DIRECT), direct), (TypeKey::from_tags(CAUSTIC), 4 - direct)].into_iter(),
            );
        }
        let list = shares.statistics();
        let draw = (0.25f64 / 8.0).sqrt();
        assert!((list[1].chains - 0.5).abs() < 1e-12 && (list[1].chains_error - draw).abs() < 1e-12, "{list:?}");
        // From single half-sweeps the error is that of fair coins.
        let mut few = TypeShares { length: 1, ..Default::default() };
        for n in 0..8u32 {
            few.count_chains([(TypeKey::from_tags(if n < 4 { DIRECT } else { CAUSTIC }), 1)].into_iter());
        }
        assert!((few.statistics()[0].chains_error - (0.25f64 / 7.0 + 0.25 / 2.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_has_not_converged_is_said() {
        let good = TypeStatistics {
            name: "L S D E".into(),
            start: 0.04,
            start_error: 0.002,
            candidates: 4000,
            chains: 0.041,
            chains_error: 0.001,
        };
        assert_eq!(good.warning(), None);
        let lost = TypeStatistics { chains: 0.001, ..good.clone() };
        let words = "paths L S D E hold 0.10 % of the chains but 4.00 +- 0.20 % of the light: they have not converged";
        assert!(lost.warning().unwrap().starts_with(words), "{:?}", lost.warning());
        let rare = TypeStatistics { start_error: 0.02, candidates: 7, ..good.clone() };
        assert!(rare.warning().unwrap().contains("by 7 of the start's candidates: they have not converged"));
        assert_eq!(TypeStatistics { start: 1e-3, start_error: 1e-3, chains: 0.0, ..good }.warning(), None);
    }

    #[test]
    fn what_only_chance_can_find_is_missed_where_its_kin_holds_light() {
        let of = |name: &str, share, candidates| TypeStatistics {
            name: name.into(),
            start: share,
            start_error: 0.01 * share,
            candidates,
            chains: share,
            chains_error: 0.01 * share,
        };
        let kin = of("L S D D S E", 0.04, 6000);
        let warnings = |types: &[TypeStatistics]| warnings(types, PathTraced::default());
        let warned = warnings(std::slice::from_ref(&kin));
        assert!(warned.len() == 1 && warned[0].starts_with("paths L S D S E have not converged: only"), "{warned:?}");
        assert_eq!(super::warnings(std::slice::from_ref(&kin), PathTraced::EVERYTHING), Vec::<String>::new());
        assert_eq!(warnings(&[kin.clone(), of("L S D S E", 0.4, 5000)]), Vec::<String>::new());
        assert_eq!(warnings(&[of("L S D D S E", 0.001, 6000)]), Vec::<String>::new());
        // What can be connected is found without luck.
        assert_eq!(warnings(&[of("L D D S E", 0.04, 6000), of("L S D D E", 0.04, 6000)]), Vec::<String>::new());
    }
}
