//! The pipelines of a run: what its shaders are compiled for, besides the kernel.

use super::bootstrap::Given;
use super::groups::Groups;
use super::guidance::Guidance;
use super::mix::{HALF_SWEEP, Mix};
use super::path_traced::Direct;
use crate::gpu::layout::PassUniform;
use crate::gpu::shader::Variant;
use crate::kernels::Family;
use crate::scene::Features;

/// What the shaders of a run are compiled for, besides the kernel.
#[derive(Debug, Clone, Copy)]
pub struct Build {
    pub features: Features,
    /// Who renders easy light.
    pub direct: Direct,
    /// Whether there may be maps of where to look for light.
    pub sought: bool,
    /// What the start has found out.
    pub given: Given,
    pub max_edges: u32,
    pub maps: bool,
    /// Whether the chains' target is I / w.
    pub two_stage: bool,
    pub guidance: Guidance,
    pub seed: u32,
    pub groups: Groups,
}

impl Build {
    /// The pipeline of a pass that may splat directions.
    pub fn variant(&self, pass: &'static str, flags: &[&'static str]) -> Variant {
        let mut flags = flags.to_vec();
        if !["weigh", "gather", "crossover"].contains(&pass) {
            flags.extend(self.maps.then_some("maps"));
            flags.extend(self.two_stage.then_some("two_stage"));
        }
        if pass == "gather" || flags.contains(&"guided") {
            flags.extend(self.guidance.flags());
        }
        if ["independence", "weigh"].contains(&pass) {
            flags.extend(self.sought.then_some("sought"));
        }
        // The other passes keep types.
        if ["independence", "bidirectional", "subpath", "crossover"].contains(&pass) {
            flags.extend(self.direct.flag());
        }
        Variant { pass, features: self.features, max_edges: self.max_edges, flags }
    }

    /// All pipelines of a mix.
    pub fn variants(&self, mix: &Mix) -> Vec<Variant> {
        let mut variants: Vec<Variant> = mix.kernels().map(|k| self.variant(k.pass, k.flags)).collect();
        variants.push(self.variant("weigh", &[]));
        variants.push(self.variant("rest", &[]));
        if mix.kernels().any(|k| k.family == Family::Pair) {
            variants.push(self.variant("exchange", &[]));
        }
        if mix.guided() {
            variants.push(self.variant("gather", &[]));
        }
        variants
    }

    /// The fields that every pass of the run has alike.
    pub(super) fn uniform(&self) -> PassUniform {
        self.guidance.of_run(self.given.set(PassUniform {
            seed: self.seed,
            stride: self.groups.paths(),
            group_paths: self.groups.group_paths(),
            ..Default::default()
        }))
    }
}

/// Words of the lists that a run over `paths` paths needs: dispatch lists and nodes, or a batch of candidates.
pub fn list_words(paths: u32, bootstrap_batch: u32) -> u64 {
    // At worst every pass has lists of its own, two words a path of one half, and every path a node of its own, three words.
    let perturbation = u64::from(paths) * u64::from(HALF_SWEEP + 2);
    perturbation.max(3 * u64::from(bootstrap_batch.max(paths)))
}
