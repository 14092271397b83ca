//! Axes of plots: ranges, ticks and their labels.

/// How values are laid along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    Linear,
    /// Linear over whole numbers.
    Count,
    Log,
    /// Logarithmic, with ticks at powers of 2 and labels that write them out.
    Log2,
}

/// One axis, fitted to its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub scale: Scale,
    low: f64,
    high: f64,
}

impl Axis {
    /// Holds all values that can be shown: finite, and above 0 on logarithmic scales. Without any it shows 1 to 10.
    pub fn fit(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let shown = values.filter(|v| v.is_finite() && (matches!(scale, Scale::Linear | Scale::Count) || *v > 0.0));
        let (mut low, mut high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        match scale {
            Scale::Linear | Scale::Count => {
                low = low.min(0.0);
                high = if high > low { high + 0.05 * (high - low) } else { low + 1.0 };
            }
            Scale::Log | Scale::Log2 => {
                // At least a factor of two, and a little room at the ends.
                let middle = (low * high).sqrt();
                (low, high) = (low.min(middle / 1.5), high.max(middle * 1.5));
                let room = (high / low).powf(0.04);
                (low, high) = (low / room, high * room);
            }
        }
        Self { scale, low, high }
    }

    /// Where a value lies, 0 to 1; none outside.
    pub fn place(&self, value: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear | Scale::Count => (value - self.low) / (self.high - self.low),
            Scale::Log | Scale::Log2 => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        // A little beyond the ends is rounding.
        (-1e-9..=1.0 + 1e-9).contains(&share).then_some(share.clamp(0.0, 1.0))
    }

    /// Ticks with their labels; an empty label is a tick alone.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear | Scale::Count => {
                let least = if self.scale == Scale::Count { 1.0 } else { 0.0 };
                let raw = f64::max((self.high - self.low) / 5.0, least);
                let power = 10f64.powf(raw.log10().floor());
                let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw).unwrap_or(raw);
                let first = (self.low / step).ceil() as i64;
                let last = (self.high / step).floor() as i64;
                (first..=last).map(|n| n as f64 * step).map(|v| (v, number(v, step))).collect()
            }
            Scale::Log2 => {
                let (first, last) = (self.low.log2().ceil() as i32, self.high.log2().floor() as i32);
                (first..=last).map(|n| 2f64.powi(n)).map(|v| (v, number(v, v.min(1.0)))).collect()
            }
            Scale::Log => self.decades(),
        }
    }

    /// 1, 2 and 5 of every power of ten, all labelled where there are few powers, else the ones alone.
    fn decades(&self) -> Vec<(f64, String)> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let few = (self.high / self.low).log10() < 2.2;
        let mut ticks = Vec::new();
        for power in first..=last {
            for digit in [1, 2, 5] {
                let value = f64::from(digit) * 10f64.powi(power);
                if (self.low..=self.high).contains(&value) {
                    let label = if few || digit == 1 { number(value, value) } else { String::new() };
                    ticks.push((value, label));
                }
            }
        }
        ticks
    }
}

/// With as many digits as steps of `step` need; very large and very small ones as powers.
fn number(value: f64, step: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:e}");
    }
    let digits = (-step.abs().log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |axis: &Axis| axis.ticks().into_iter().map(|(_, label)| label).collect::<Vec<_>>();
        let linear = Axis::fit(Scale::Linear, [0.3, 1.9].into_iter());
        assert_eq!(labels(&linear), ["0.0", "0.5", "1.0", "1.5"].map(|l| if l == "0.0" { "0" } else { l }));
        let log = Axis::fit(Scale::Log, [0.02, 0.5].into_iter());
        assert_eq!(labels(&log), ["0.02", "0.05", "0.1", "0.2", "0.5"]);
        let wide = Axis::fit(Scale::Log, [0.01, 30.0].into_iter());
        assert_eq!(labels(&wide).iter().filter(|l| !l.is_empty()).count(), 4);
        let count = Axis::fit(Scale::Count, [1.0, 2.0].into_iter());
        assert_eq!(labels(&count), ["0", "1", "2"]);
        let powers = Axis::fit(Scale::Log2, [1024.0, 4096.0].into_iter());
        assert_eq!(labels(&powers), ["1024", "2048", "4096"]);
        for axis in [linear, count, log, wide, powers] {
            assert!(axis.ticks().iter().all(|(value, _)| axis.place(*value).is_some()));
            assert_eq!(axis.place(f64::NAN), None);
        }
    }

    #[test]
    fn hopeless_values_still_give_an_axis() {
        for scale in [Scale::Linear, Scale::Count, Scale::Log, Scale::Log2] {
            for values in [vec![], vec![f64::NAN], vec![0.0], vec![-1.0, f64::INFINITY], vec![3.0]] {
                assert!(!Axis::fit(scale, values.iter().copied()).ticks().is_empty(), "{scale:?} {values:?}");
            }
        }
    }
}
