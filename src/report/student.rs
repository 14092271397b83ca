//! Student's t: tail probabilities and the limits of intervals.

/// P(|T| > t) with `dof` degrees of freedom: one minus the finite sums of Abramowitz and Stegun 26.7.3 and 26.7.4,
/// so right to about 1e-14 in absolute terms.
pub fn two_sided(t: f64, dof: u32) -> f64 {
    let theta = (t.abs() / f64::from(dof).sqrt()).atan();
    let (sin, cos2) = (theta.sin(), theta.cos().powi(2));
    let odd = dof % 2 == 1;
    // The terms' ratio is (2 i / (2 i + 1)) cos^2 for odd dof, ((2 i - 1) / 2 i) cos^2 for even dof.
    let (mut term, mut sum) = (if odd { theta.cos() } else { 1.0 }, 0.0);
    let terms = if odd { (dof - 1) / 2 } else { dof / 2 };
    for i in 1..=terms {
        sum += term;
        let n = f64::from(2 * i);
        term *= cos2 * if odd { n / (n + 1.0) } else { (n - 1.0) / n };
    }
    let inside = if odd { std::f64::consts::FRAC_2_PI * (theta + sin * sum) } else { sin * sum };
    (1.0 - inside).max(0.0)
}

/// The t that is exceeded on either side with probability `p`.
pub fn critical(p: f64, dof: u32) -> f64 {
    let (mut low, mut high) = (0.0, 1e9);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if two_sided(middle, dof) > p { low = middle } else { high = middle }
    }
    low
}

/// Degrees of freedom from which the law is taken for the normal one: limits at 95 % then agree to three digits.
const MANY: u32 = 1000;

/// [`critical`] for any number of degrees of freedom from 1 on: linear in its inverse between whole numbers, in which the
/// limit is nearly straight.
pub fn critical_between(p: f64, dof: f64) -> f64 {
    if dof >= f64::from(MANY) || dof.is_nan() {
        return critical(p, MANY);
    }
    let below = dof.max(1.0).floor();
    let [low, high] = [below as u32, below as u32 + 1].map(|n| critical(p, n));
    let share = (1.0 / below - 1.0 / dof.max(1.0)) * below * (below + 1.0);
    low + share * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (dof, p, t) in [
            (1, 0.05, 12.706),
            (2, 0.01, 9.925),
            (3, 0.001, 12.924),
            (10, 0.05, 2.228),
            (11, 0.001, 4.437),
            (30, 0.01, 2.750),
            // The normal law's, to three digits.
            (100_000, 0.05, 1.960),
            (100_001, 0.001, 3.291),
        ] {
            let found = critical(p, dof);
            assert!((found - t).abs() < 6e-4, "t of {dof} degrees at {p} is {found}, not {t}");
        }
        // Far out, where comparisons with many bins look: P(|T| > t) tends to 4 dof^((dof - 1) / 2) c t^-dof ...
        // for two degrees it is exactly 1 - t / sqrt(2 + t^2), near 1 / t^2.
        assert!((two_sided(1e4, 2) * 1e8 - 1.0).abs() < 1e-5);
        // For one degree (Cauchy's law) near 2 / (pi t).
        assert!((two_sided(1e8, 1) * 1e8 * std::f64::consts::FRAC_PI_2 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn limits_between_whole_numbers_are_between() {
        assert_eq!(critical_between(0.05, 7.0), critical(0.05, 7));
        let half = critical_between(0.05, 1.5);
        assert!(half < critical(0.05, 1) && half > critical(0.05, 2));
        // The density of 7.5 degrees integrated numerically elsewhere (Simpson's rule).
        assert!((critical_between(0.05, 7.5) - 2.333).abs() < 2e-3);
        assert!((critical_between(0.05, f64::INFINITY) - 1.96).abs() < 3e-3);
    }
}
