//! Candidates of the start as the device reports them, and means of what they weigh.

use super::pool::TypeKey;

/// Running mean of independent samples of b, with the scatter that gives its standard error.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    pub count: f64,
    pub sum: f64,
    pub sum_of_squares: f64,
}

impl Mean {
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.sum_of_squares += value * value;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        let variance = (self.sum_of_squares / self.count.max(1.0) - self.mean().powi(2)).max(0.0);
        (variance / (self.count - 1.0).max(1.0)).sqrt()
    }
}

/// One candidate as the device reports it.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Candidate {
    /// log(I / density), -1e30 where I = 0.
    pub log_weight: f32,
    pub pixel: [f32; 2],
    /// Rays that it took; in the upper half, where light may be path traced, 512 log(I / density of the path tracer) + 32768.
    rays_and_path_traced: u32,
    /// Of a candidate that carries light.
    pub(super) key: [u32; 4],
}

/// From the log of a weight to the weight; what is not finite counts as black.
pub(in crate::ensemble) fn weight(log_weight: f64) -> f64 {
    let w = log_weight.exp();
    if w.is_finite() { w } else { 0.0 }
}

impl Candidate {
    /// Type of a candidate that carries light.
    pub fn key(&self) -> Option<TypeKey> {
        TypeKey::from_words(self.key)
    }

    /// Rays that it took.
    pub fn rays(&self) -> f64 {
        f64::from(self.rays_and_path_traced & 0xffff)
    }

    /// What the same path would weigh as a sample of the path tracer's, of one that carries light.
    pub fn path_traced_weight(&self) -> f64 {
        ((f64::from(self.rays_and_path_traced >> 16) - 32768.0) / 512.0).exp()
    }

    /// I / density: a sample of b.
    pub fn weight(&self) -> f64 {
        weight(self.log_weight.into())
    }
}

/// Rays that candidates took, all together.
pub(super) fn rays(candidates: &[Candidate]) -> u64 {
    candidates.iter().map(|c| c.rays() as u64).sum()
}

/// Invocations that wait for the slowest among them: the lanes of a processor's vectors. GPUs have 32 and more.
const LOCKSTEP: usize = 8;

/// Per candidate, the rays of the slowest one among those that run in lockstep with it.
pub(super) fn waited_for(candidates: &[Candidate]) -> impl Iterator<Item = f64> + '_ {
    candidates.chunks(LOCKSTEP).flat_map(|group| {
        let slowest = group.iter().map(Candidate::rays).fold(0.0, f64::max);
        group.iter().map(move |_| slowest)
    })
}
