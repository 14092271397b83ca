//! The step of the guided lens perturbation (METHOD.md 3.4, variant V2; our design). Twin of
//! `shaders/kernels/guided_lens.wesl`.
//!
//! The covariance of a step on the film comes from the pixels of guides that resemble the path; its size from how
//! much they do. Sampling and density go through one Cholesky factor, so that they cannot disagree.

use crate::ensemble::similarity::Similarity;
use std::f64::consts::PI;

/// Degrees of freedom of the Student-t step.
pub const NU: f64 = 4.0;

/// What the shape of a step depends on besides the path and its guides: constants, and functions of the frozen half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    pub alpha_low: f64,
    pub alpha_high: f64,
    /// Width of the sigmoid, in units of S.
    pub tau: f64,
    /// S_0: the centre of the sigmoid.
    pub similarity_median: f64,
    /// Floor of the step's standard deviation.
    pub floor_px: f64,
    /// Cap on the root of the guides' covariance trace.
    pub widest_px: f64,
}

/// A symmetric 2x2 matrix (a, b; b, c).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Symmetric {
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

impl Symmetric {
    fn scaled(self, s: f64) -> Self {
        Self { a: s * self.a, b: s * self.b, c: s * self.c }
    }

    /// Sigma_0 = SUM w_i (p_i - p)(p_i - p)^T, about the path's own pixel and not about the mean.
    pub fn about(pixel: [f64; 2], weights: &[f64], guide_pixels: &[[f64; 2]]) -> Self {
        let mut sum = Self::default();
        for (weight, guide) in weights.iter().zip(guide_pixels) {
            let e = [guide[0] - pixel[0], guide[1] - pixel[1]];
            sum.a += weight * e[0] * e[0];
            sum.b += weight * e[0] * e[1];
            sum.c += weight * e[1] * e[1];
        }
        sum
    }

    /// Scaled down to trace `widest_px`^2 if it is larger. Before the floor is added (METHOD.md C12).
    pub fn capped(self, widest_px: f64) -> Self {
        let trace = self.a + self.c;
        if trace > widest_px * widest_px { self.scaled(widest_px * widest_px / trace) } else { self }
    }
}

/// alpha: low where the guides do not resemble the path, high where they do.
pub fn alpha(log_mean_similarity: f64, settings: &StepSettings) -> f64 {
    let StepSettings { alpha_low, alpha_high, tau, similarity_median, .. } = *settings;
    let argument = (log_mean_similarity - similarity_median) / tau;
    alpha_low + (alpha_high - alpha_low) / (1.0 + (-argument).exp())
}

/// Cholesky factor L of the covariance of a step, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepShape {
    pub l11: f64,
    pub l21: f64,
    pub l22: f64,
}

impl StepShape {
    /// L with L L^T = alpha^2 Sigma_0 + floor^2 Id.
    ///
    /// The determinant is summed from terms that cannot be negative: never below floor^4, singular guides included.
    pub fn new(sigma0: Symmetric, alpha: f64, floor_px: f64) -> Self {
        let s = sigma0.scaled(alpha * alpha);
        let floor2 = floor_px * floor_px;
        let determinant = (s.a * s.c - s.b * s.b).max(0.0) + floor2 * (s.a + s.c) + floor2 * floor2;
        let l11 = (s.a + floor2).sqrt();
        Self { l11, l21: s.b / l11, l22: determinant.sqrt() / l11 }
    }

    /// The shape for a path at `pixel`, with the squared distance d^2 and the pixel of each of its guides.
    ///
    /// No guides: the floor alone, an isotropic step, the same for x and y since their sets are of one size.
    pub fn guided(
        pixel: [f64; 2],
        squared_distances: &[f64],
        guide_pixels: &[[f64; 2]],
        settings: &StepSettings,
    ) -> Self {
        let Some(similarity) = Similarity::from_squared_distances(squared_distances) else {
            return Self::new(Symmetric::default(), 0.0, settings.floor_px);
        };
        let sigma0 = Symmetric::about(pixel, &similarity.weights, guide_pixels);
        let alpha = alpha(similarity.log_mean, settings);
        Self::new(sigma0.capped(settings.widest_px), alpha, settings.floor_px)
    }

    /// A bivariate Student-t step L z sqrt(nu / chi2) from two standard normals and two uniforms in (0, 1].
    pub fn step(&self, z: [f64; 2], u: [f64; 2]) -> [f64; 2] {
        let chi2 = -2.0 * (u[0] * u[1]).ln();
        let scale = (NU / chi2).sqrt();
        [scale * self.l11 * z[0], scale * (self.l21 * z[0] + self.l22 * z[1])]
    }

    /// |L^-1 d|^2 by forward substitution.
    pub fn squared_length(&self, d: [f64; 2]) -> f64 {
        let y0 = d[0] / self.l11;
        let y1 = (d[1] - self.l21 * y0) / self.l22;
        y0 * y0 + y1 * y1
    }

    /// ln |Sigma|^(1/2).
    pub fn log_area(&self) -> f64 {
        (self.l11 * self.l22).ln()
    }

    /// Log density of [`Self::step`] per px^2.
    pub fn log_density(&self, d: [f64; 2]) -> f64 {
        let tail = 0.5 * (NU + 2.0) * (self.squared_length(d) / NU).ln_1p();
        -self.log_area() - (2.0 * PI).ln() - tail
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: StepSettings = StepSettings {
        alpha_low: 0.05,
        alpha_high: 0.5,
        tau: 1.0,
        similarity_median: -1.0,
        floor_px: 0.5,
        widest_px: 40.0,
    };
    const SHAPE: StepShape = StepShape { l11: 1.3, l21: -0.9, l22: 0.4 };

    /// Upper 1e-6 point of chi-square (Wilson and Hilferty's approximation).
    fn chi2_limit(freedom: f64) -> f64 {
        let spread = 2.0 / (9.0 * freedom);
        freedom * (1.0 - spread + 4.753 * spread.sqrt()).powi(3)
    }

    /// Steps of `SHAPE` from a fixed seed (SplitMix64, Box and Muller).
    fn steps(count: usize) -> impl Iterator<Item = [f64; 2]> {
        let mut state = 0u64;
        let mut uniform = move || {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-53) + 2f64.powi(-54)
        };
        (0..count).map(move |_| {
            let (radius, phi) = ((-2.0 * uniform().ln()).sqrt(), 2.0 * PI * uniform());
            SHAPE.step([radius * phi.cos(), radius * phi.sin()], [uniform(), uniform()])
        })
    }

    /// Chi-square of a million steps against the density integrated over cells of 0.3 px, far steps in one last
    /// cell. Error probability 1e-6 over seeds; the seed is fixed.
    #[test]
    fn steps_have_the_stated_density() {
        const CELLS: usize = 20;
        const COUNT: usize = 1_000_000;
        let side = 0.3;
        let cell = |x: f64| ((x / side).floor() + CELLS as f64 / 2.0) as isize;
        let mut observed = vec![0.0; CELLS * CELLS + 1];
        for d in steps(COUNT) {
            let at = [cell(d[0]), cell(d[1])].map(usize::try_from);
            let inside = |n: usize| n < CELLS;
            match at {
                [Ok(i), Ok(j)] if inside(i) && inside(j) => observed[i * CELLS + j] += 1.0,
                _ => observed[CELLS * CELLS] += 1.0,
            }
        }
        let mut expected = vec![0.0; CELLS * CELLS + 1];
        const FINE: usize = 16;
        for i in 0..CELLS * FINE {
            for j in 0..CELLS * FINE {
                let h = side / FINE as f64;
                let d = [i, j].map(|n| (n as f64 + 0.5) * h - side * CELLS as f64 / 2.0);
                let mass = SHAPE.log_density(d).exp() * h * h * COUNT as f64;
                expected[i / FINE * CELLS + j / FINE] += mass;
            }
        }
        expected[CELLS * CELLS] = COUNT as f64 - expected.iter().sum::<f64>();
        // Cells that expect fewer than ten steps go with the far ones.
        let (mut chi2, mut freedom, mut rest) = (0.0, 0.0, (0.0, 0.0));
        for (n, (o, e)) in observed.iter().zip(&expected).enumerate() {
            if *e < 10.0 || n == CELLS * CELLS {
                rest = (rest.0 + o, rest.1 + e);
            } else {
                chi2 += (o - e) * (o - e) / e;
                freedom += 1.0;
            }
        }
        chi2 += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
        assert!(freedom > 200.0 && chi2 < chi2_limit(freedom), "chi2 {chi2:.0} of {freedom}");
        // A density that is 2 % too high must be seen by the same statistic.
        let off: f64 = observed
            .iter()
            .zip(&expected)
            .filter(|&(_, e)| *e >= 10.0)
            .map(|(o, e)| (o - 1.02 * e).powi(2) / (1.02 * e))
            .sum();
        assert!(off > chi2_limit(freedom), "chi2 of the wrong density {off:.0}");
    }

    /// The tail, which cells cannot see: for nu = 4, (1 + |L^-1 d|^2 / 4)^-2 is uniform. 100 bins, error
    /// probability 1e-6.
    #[test]
    fn squared_lengths_follow_their_closed_form() {
        const COUNT: usize = 1_000_000;
        let mut bins = [0.0f64; 100];
        for d in steps(COUNT) {
            let uniform = (1.0 + SHAPE.squared_length(d) / NU).powi(-2);
            bins[((uniform * 100.0) as usize).min(99)] += 1.0;
        }
        let mean = COUNT as f64 / 100.0;
        let chi2: f64 = bins.iter().map(|o| (o - mean) * (o - mean) / mean).sum();
        assert!(chi2 < chi2_limit(99.0), "chi2 {chi2:.0} of 99");
    }

    #[test]
    fn density_integrates_to_one() {
        // d = L r (cos, sin) with r = tan: a million px are reached. Midpoint rule in both.
        const N: usize = 400;
        let mut sum = 0.0;
        for i in 0..N {
            let angle = (i as f64 + 0.5) / N as f64 * PI / 2.0;
            let (r, dr) = (angle.tan(), PI / 2.0 / N as f64 / angle.cos().powi(2));
            for j in 0..N {
                let phi = (j as f64 + 0.5) / N as f64 * 2.0 * PI;
                let d = [r * phi.cos(), r * phi.sin()];
                sum += SHAPE.log_density(d).exp() * r * dr * 2.0 * PI / N as f64;
            }
        }
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    }

    #[test]
    fn factor_times_its_transpose_is_the_covariance() {
        let sigma0 = Symmetric { a: 7.0, b: -3.0, c: 2.0 };
        let (alpha, floor) = (0.4, 0.3);
        let StepShape { l11, l21, l22 } = StepShape::new(sigma0, alpha, floor);
        let sigma = sigma0.scaled(alpha * alpha);
        assert!((l11 * l11 - sigma.a - floor * floor).abs() < 1e-14);
        assert!((l11 * l21 - sigma.b).abs() < 1e-14);
        assert!((l21 * l21 + l22 * l22 - sigma.c - floor * floor).abs() < 1e-14);
    }

    #[test]
    fn singular_guides_leave_the_determinant_at_the_floor_or_above() {
        // One guide, guides on a line with rounding that makes the determinant negative, and none but the path's own.
        let on_a_line = Symmetric { a: 1e6, b: 1e6 * (1.0 + 1e-15), c: 1e6 };
        for sigma0 in [
            Symmetric::about([3.0, 4.0], &[1.0], &[[800.0, -20.0]]),
            Symmetric::about([3.0, 4.0], &[0.5, 0.5], &[[3.0, 4.0]; 2]),
            on_a_line,
        ] {
            for floor in [0.25, 0.5] {
                let shape = StepShape::new(sigma0.capped(40.0), 0.5, floor);
                let determinant = (2.0 * shape.log_area()).exp();
                assert!(determinant >= floor.powi(4) * (1.0 - 1e-12), "{determinant}");
                assert!(shape.log_density([5.0, -5.0]).is_finite());
            }
        }
    }

    #[test]
    fn cap_acts_on_the_guides_and_not_on_the_floor() {
        let wide = Symmetric { a: 300.0, b: 100.0, c: 100.0 };
        let capped = wide.capped(10.0);
        assert!((capped.a + capped.c - 100.0).abs() < 1e-12);
        assert!((capped.b / capped.a - wide.b / wide.a).abs() < 1e-15);
        assert_eq!(wide.capped(30.0), wide);
        assert_eq!(Symmetric::default().capped(10.0), Symmetric::default());
        let shape = StepShape::new(Symmetric::default().capped(1e-3), 0.5, 0.5);
        assert_eq!((shape.l11, shape.l22), (0.5, 0.5));
    }

    #[test]
    fn alpha_runs_from_low_to_high() {
        assert!((alpha(-1.0, &SETTINGS) - 0.275).abs() < 1e-15);
        assert!((alpha(-1e6, &SETTINGS) - 0.05).abs() < 1e-15);
        assert!((alpha(1e6, &SETTINGS) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn no_guides_give_an_isotropic_step_at_the_floor() {
        let shape = StepShape::guided([1.0, 2.0], &[], &[], &SETTINGS);
        assert_eq!((shape.l11, shape.l21, shape.l22), (0.5, 0.0, 0.5));
    }
}
