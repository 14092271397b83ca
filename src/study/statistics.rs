//! Scatter between seeds, ratios, slopes.
//!
//! Seeds are independent, so means over them have Student's t. Errors spread over factors, so they are compared by their
//! logarithms, seed by seed: renders of one seed share the start's candidates, and with them a part of their error.

use crate::report::student::critical;

/// A mean with its 95 % interval; unbounded where there are fewer than two values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    pub mean: f64,
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// Of independent values; one that is not finite leaves nothing known.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        if values.len() < 2 || !mean.is_finite() {
            return Self { mean, low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let half = critical(0.05, values.len() as u32 - 1) * (variance / n).sqrt();
        Self { mean, low: mean - half, high: mean + half }
    }

    /// The geometric mean of a over b, pair by pair; a pair of which one is not above 0 leaves nothing known.
    pub fn of_ratio(a: &[f64], b: &[f64]) -> Self {
        let logs: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.ln() - b.ln()).collect();
        Self::of(&logs).exp()
    }

    /// The geometric mean.
    pub fn of_factors(values: &[f64]) -> Self {
        Self::of(&values.iter().map(|v| v.ln()).collect::<Vec<_>>()).exp()
    }

    fn exp(self) -> Self {
        Self { mean: self.mean.exp(), low: self.low.exp(), high: self.high.exp() }
    }

    /// Wholly above the value.
    pub fn above(&self, value: f64) -> bool {
        self.low > value
    }

    /// Wholly below the value.
    pub fn below(&self, value: f64) -> bool {
        self.high < value
    }

    /// As text, with `digits` after the point.
    pub fn text(&self, digits: usize) -> String {
        if !self.mean.is_finite() {
            "not known".into()
        } else if self.low.is_finite() && self.high.is_finite() {
            format!("{:.digits$} ({:.digits$} to {:.digits$})", self.mean, self.low, self.high)
        } else {
            format!("{:.digits$} (scatter not known)", self.mean)
        }
    }
}

/// Mean of the values that are finite; NaN without any.
pub fn mean(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    finite.iter().sum::<f64>() / finite.len() as f64
}

/// Slope of log y over log x by least squares; none with fewer than three points.
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
    if logs.len() < 3 {
        return None;
    }
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let xy: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    let xx: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    (xx > 0.0).then(|| xy / xx)
}

/// y at `x` between the points of a curve, straight in logarithms; none outside it.
pub fn at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    points.windows(2).find(|pair| pair[0].0 <= x && x <= pair[1].0).map(|pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        if x1 <= x0 {
            return y1;
        }
        let share = (x / x0).ln() / (x1 / x0).ln();
        (y0.ln() + share * (y1.ln() - y0.ln())).exp()
    })
}

/// The first x at which the curve's running minimum comes down to `y`; none where it never does, or begins below it.
pub fn first_at_or_below(points: &[(f64, f64)], y: f64) -> Option<f64> {
    points.windows(2).find(|pair| pair[0].1 > y && pair[1].1 <= y).map(|pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let share = (y / y0).ln() / (y1 / y0).ln();
        (x0.ln() + share * (x1.ln() - x0.ln())).exp()
    })
}

/// Pearson's correlation; NaN where one side does not vary.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    covariance(a, b) / (covariance(a, a) * covariance(b, b)).sqrt()
}

/// Mean product of what deviates from the means.
pub fn covariance(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_students_law() {
        // t of 2 degrees is 4.3027; standard error 1 / sqrt(3).
        let interval = Interval::of(&[1.0, 2.0, 3.0]);
        assert!((interval.high - 2.0 - 4.3027 / 3f64.sqrt()).abs() < 1e-3, "{interval:?}");
        assert!(interval.above(-0.5) && !interval.above(0.0) && interval.below(4.5));
        for unknown in [Interval::of(&[1.0]), Interval::of(&[1.0, f64::NAN, 1.0]), Interval::of(&[])] {
            assert!(!unknown.above(-1e9) && !unknown.below(1e9));
        }
        let ratio = Interval::of_ratio(&[2.0, 8.0], &[1.0, 1.0]);
        assert!((ratio.mean - 4.0).abs() < 1e-12 && !ratio.above(1.0));
        assert!(!Interval::of_ratio(&[2.0, -8.0], &[1.0, 1.0]).above(0.0));
    }

    #[test]
    fn curves_are_straight_in_logarithms() {
        let curve = [(1.0, 8.0), (2.0, 4.0), (4.0, 2.0), (8.0, 1.0)];
        assert!((slope(&curve).unwrap() + 1.0).abs() < 1e-12);
        assert_eq!(slope(&curve[..2]), None);
        assert!((at(&curve, 8f64.sqrt()).unwrap() - 8f64.sqrt()).abs() < 1e-12);
        assert_eq!(at(&curve, 9.0), None);
        assert!((first_at_or_below(&curve, 3.0).unwrap() - 8.0 / 3.0).abs() < 1e-12);
        assert_eq!((first_at_or_below(&curve, 0.5), first_at_or_below(&curve, 9.0)), (None, None));
        assert!((correlation(&[1.0, 2.0, 4.0], &[-2.0, -4.0, -8.0]) + 1.0).abs() < 1e-12);
    }
}
