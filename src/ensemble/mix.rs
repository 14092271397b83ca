//! Which kernels run, how often, and in which order: fixed before the run, blind to the states (METHOD.md 3.7, C6).

use crate::kernels::{self, Family, Kernel, independence};
use crate::scene::Features;
use crate::{Error, Result};

use super::pool::TypeKey;

/// Mutations of every path from one sweep of its half to the next.
pub const HALF_SWEEP: u32 = 20;

/// Kernels with their weights.
///
/// The weight of a structural kernel is its share of all mutations, in whole passes of the [`HALF_SWEEP`] and at least
/// one; a pass over both halves moves a path in either half's sweep and counts as two. The rest of the passes perturb: a
/// path is moved by the kernels that apply to its type, in proportion to their weights.
#[derive(Debug, Clone)]
pub struct Mix {
    kernels: Vec<(&'static Kernel, f64)>,
}

impl Mix {
    /// The kernels of `weights` that paths of such a scene can use; weights 0 leave a kernel out.
    pub fn new(weights: &[(&'static Kernel, f64)], features: Features) -> Self {
        let useful = |(kernel, weight): &&(&'static Kernel, f64)| *weight > 0.0 && (kernel.useless)(features).is_none();
        let mut kernels: Vec<_> = weights.iter().filter(useful).copied().collect();
        // The first counters are the independence kernel's.
        kernels.sort_by_key(|(kernel, _)| kernel.name != independence::KERNEL.name);
        Self { kernels }
    }

    /// Parses NAME=WEIGHT,... as given on the command line.
    pub fn parse(text: &str) -> Result<Vec<(&'static Kernel, f64)>> {
        let names = || kernels::ALL.map(|k| k.name).join(", ");
        let mut weights: Vec<(&'static Kernel, f64)> = Vec::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (name, weight) = part
                .split_once('=')
                .ok_or_else(|| Error::input(format!("'{part}' is no kernel with its weight: write NAME=WEIGHT,...")))?;
            let kernel = kernels::ALL
                .into_iter()
                .find(|kernel| kernel.name == name.trim())
                .ok_or_else(|| Error::input(format!("no kernel is called '{name}': choose from {}", names())))?;
            let weight: f64 = weight.trim().parse().unwrap_or(f64::NAN);
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(Error::input(format!("the weight of {name} is no number from 0 on: write {name}=0.5")));
            }
            if weights.iter().any(|(known, _)| known.name == kernel.name) {
                return Err(Error::input(format!("{name} is given twice: name every kernel once")));
            }
            weights.push((kernel, weight));
        }
        if !weights.iter().any(|(kernel, weight)| kernel.name == independence::KERNEL.name && *weight > 0.0) {
            return Err(Error::input(
                "the mix lacks the independence kernel, without which some paths are never reached: add independence=0.05",
            ));
        }
        let structural = weights.iter().filter(|(kernel, _)| !kernel.family.keeps_types());
        let share: f64 = structural.map(|(_, weight)| weight).sum();
        if share > 0.95 {
            return Err(Error::input(format!(
                "the kernels that may change a path's type take {share} of all mutations: leave at least 0.05 to the others"
            )));
        }
        Ok(weights)
    }

    /// Every kernel, the independence kernel first.
    pub fn kernels(&self) -> impl ExactSizeIterator<Item = &'static Kernel> + '_ {
        self.kernels.iter().map(|(kernel, _)| *kernel)
    }

    /// Whether any kernel reads the complementary ensemble.
    pub fn guided(&self) -> bool {
        self.kernels().any(|k| k.guided)
    }

    /// The family of kernel number `index`.
    pub fn family(&self, index: usize) -> Family {
        self.kernels[index].0.family
    }

    /// Passes of a half-sweep that belong to kernel number `index`, a structural one.
    pub fn structural_passes(&self, index: usize) -> u32 {
        let (kernel, weight) = self.kernels[index];
        if kernel.family.keeps_types() {
            return 0;
        }
        ((weight * f64::from(HALF_SWEEP)).round() as u32 / self.mutations_a_pass(index)).max(1)
    }

    /// How many of a path's mutations between two of its half's sweeps one pass of a structural kernel stands for.
    fn mutations_a_pass(&self, index: usize) -> u32 {
        if self.family(index) == Family::Pair { 2 } else { 1 }
    }

    /// Passes of a half-sweep that perturb.
    pub fn perturbation_passes(&self) -> u32 {
        let mutations = |i| self.structural_passes(i) * self.mutations_a_pass(i);
        let structural: u32 = (0..self.kernels.len()).map(mutations).sum();
        HALF_SWEEP.saturating_sub(structural)
    }

    /// Which kernel (by number) perturbs paths of type `key` in each pass; empty where none applies. Kernels take turns
    /// in proportion to their weights; those on the light's side come first.
    pub fn rota(&self, key: TypeKey, features: Features) -> Vec<usize> {
        let applies = |(i, (kernel, _)): &(usize, &(&Kernel, f64))| {
            kernel.family.keeps_types() && (kernel.applies)(key, features) && self.kernels[*i].1 > 0.0
        };
        let candidates: Vec<(usize, f64)> =
            self.kernels.iter().enumerate().filter(applies).map(|(i, (_, weight))| (i, *weight)).collect();
        let total: f64 = candidates.iter().map(|(_, weight)| weight).sum();
        let mut credit = vec![0.0; candidates.len()];
        let mut rota: Vec<usize> = (0..if candidates.is_empty() { 0 } else { self.perturbation_passes() })
            .map(|_| {
                credit.iter_mut().zip(&candidates).for_each(|(c, (_, weight))| *c += weight / total);
                let next = (0..credit.len()).max_by(|a, b| credit[*a].total_cmp(&credit[*b]).then(b.cmp(a)));
                let next = next.expect("there are candidates");
                credit[next] -= 1.0;
                candidates[next].0
            })
            .collect();
        rota.sort_by_key(|i| self.kernels[*i].0.family);
        rota
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{Diffuse as D, Transmission as T};
    use crate::kernels::{caustic, crossover, guided_lens, lens, multi_chain};

    fn mirrors() -> Features {
        Features { mirror: true, glass: true, ..Features::default() }
    }

    fn mix(features: Features) -> Mix {
        let weights = [
            (&lens::KERNEL, 0.3),
            (&guided_lens::KERNEL, 0.6),
            (&multi_chain::KERNEL, 0.3),
            (&caustic::KERNEL, 0.3),
            (&independence::KERNEL, 0.1),
        ];
        Mix::new(&weights, features)
    }

    #[test]
    fn a_rota_follows_the_weights_of_what_applies() {
        let mix = mix(mirrors());
        let name = |i: &usize| mix.kernels[*i].0.name;
        let passes = mix.perturbation_passes() as usize;
        let rota = |tags| mix.rota(TypeKey::from_tags(tags), mirrors());
        let lens_type = rota(&[D, D]);
        assert_eq!(lens_type.len(), passes);
        let guided = lens_type.iter().filter(|i| name(i) == "guided-lens").count();
        assert!(guided.abs_diff(2 * passes / 3) <= 1, "{guided} of {passes}");
        let caustic_type = rota(&[T, D]);
        assert_eq!(name(&caustic_type[0]), "caustic");
        assert_eq!(name(&caustic_type[passes - 1]), "multi-chain");
        assert_eq!(caustic_type.iter().filter(|i| name(i) == "caustic").count(), passes.div_ceil(2));
    }

    #[test]
    fn kernels_without_use_are_left_out() {
        let names: Vec<&str> = mix(Features::default()).kernels().map(|k| k.name).collect();
        assert_eq!(names, ["independence", "lens", "guided-lens"]);
        assert_eq!(mix(Features::default()).structural_passes(0), 2);
    }

    /// A crossover moves the other half too: one pass in either half's sweep is two mutations of every path.
    #[test]
    fn a_pass_over_both_halves_counts_twice() {
        for (weight, passes) in [(0.01, 1), (0.1, 1), (0.2, 2)] {
            let weights = [(&independence::KERNEL, 0.1), (&crossover::KERNEL, weight), (&lens::KERNEL, 1.0)];
            let mix = Mix::new(&weights, mirrors());
            assert_eq!((mix.structural_passes(1), mix.perturbation_passes()), (passes, HALF_SWEEP - 2 - 2 * passes));
            assert!(!mix.rota(TypeKey::from_tags(&[D, D]), mirrors()).contains(&1));
        }
    }

    #[test]
    fn a_mix_is_parsed_or_refused_in_words() {
        let weights = Mix::parse("independence=0.1, lens=1").unwrap();
        assert_eq!(
            weights.iter().map(|(k, w)| (k.name, *w)).collect::<Vec<_>>(),
            [("independence", 0.1), ("lens", 1.0)]
        );
        for bad in [
            "",
            "lens=1",
            "independence",
            "independence=x",
            "independence=-1",
            "independence=1",
            "independence=0.1,lenz=1",
        ] {
            assert!(Mix::parse(bad).is_err(), "{bad}");
        }
        assert!(Mix::parse("independence=0.1,lens=1,lens=2").is_err());
    }
}
