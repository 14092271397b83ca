//! Error against time and against mutations, for every method and scene.

use super::axes::Scale;
use super::folder::{Figures, Finished};
use super::plan::{Asked, Defaults, Kind, Run, SCENES};
use super::plot::{Chart, Series, Style};
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, at, first_at_or_below, slope};
use super::{Findings, Study};
use crate::Result;
use crate::methods::{Budget, Method};

pub const STUDY: Study = Study {
    name: "convergence",
    about: "error of pt, mlt and emlt against seconds and against mutations",
    defaults: Defaults { scenes: &SCENES, size: [96, 72], budget: Budget::Seconds(5.0), seeds: 2, reference_spp: 2048 },
    compares: true,
    runs,
    conclude,
};

const METHODS: [Method; 3] = [Method::Emlt, Method::Mlt, Method::Pt];
/// Slopes are fitted from this share of a run's samples on.
const FITTED: f64 = 1.0 / 32.0;

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    Ok(asked.runs(METHODS, |scene, method, seed| Run {
        kind: Kind::Curve,
        ..asked.run(scene, method.name(), method, seed)
    }))
}

type X = fn(&Figures) -> Option<f64>;

/// relMSE over seconds or samples per pixel, where it is above 0 (noise is subtracted).
fn curve(finished: &Finished, x: X) -> Vec<(f64, f64)> {
    let point = |f: &Figures| Some((x(f)?, f.rel_mse.filter(|e| *e > 0.0)?));
    finished.figures.iter().filter_map(point).collect()
}

/// Means of several curves, look by look, as long as all have one: of x, and geometric of y.
fn mean_curve(curves: &[Vec<(f64, f64)>]) -> Vec<(f64, f64)> {
    let length = curves.iter().map(Vec::len).min().unwrap_or(0);
    let n = curves.len() as f64;
    let mean = |look: usize| {
        let x = curves.iter().map(|curve| curve[look].0).sum::<f64>() / n;
        let y = curves.iter().map(|curve| curve[look].1.ln()).sum::<f64>() / n;
        (x, y.exp())
    };
    (0..length).map(mean).collect()
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    report.heading("Error");
    let seconds: X = Figures::seconds;
    let samples: X = |f| f.samples_per_pixel;
    let plots = [
        ("convergence-seconds", "seconds, start included", seconds),
        ("convergence-mutations", "mutations (pt: samples) per pixel", samples),
    ];
    let columns = findings.asked.scenes.len().min(3);
    for (name, label, x) in plots {
        let charts: Vec<Chart> = findings.asked.scenes.iter().map(|scene| chart(findings, scene, label, x)).collect();
        let caption = "Geometric means over the seeds; grey, what falls with one over the number of samples. Compiling, which \
                       is done once, is not counted.";
        report.plot(name, &charts, columns, caption)?;
    }

    report.heading("Slopes, and ratios to emlt");
    let mut table = Vec::new();
    let mut over_scenes: [[Vec<f64>; 2]; 2] = Default::default();
    for scene in &findings.asked.scenes {
        let curves = |method: Method, x: X| -> Vec<Vec<(f64, f64)>> {
            findings.of(Some(scene), method.name()).map(|finished| curve(finished, x)).collect()
        };
        let emlt = curves(Method::Emlt, seconds);
        for method in METHODS {
            let slopes: Vec<f64> =
                curves(method, samples).iter().map(|curve| slope(tail(curve)).unwrap_or(f64::NAN)).collect();
            let mut row = vec![scene.clone(), method.name().into(), Interval::of(&slopes).text(2)];
            let other = curves(method, seconds);
            let time: Vec<f64> = other.iter().zip(&emlt).map(|(o, e)| equal_time(o, e)).collect();
            let error: Vec<f64> = other.iter().zip(&emlt).map(|(o, e)| equal_error(o, e)).collect();
            if method == Method::Emlt {
                row.extend(["1".into(), "1".into()]);
            } else {
                row.extend([Interval::of_factors(&time).text(2), Interval::of_factors(&error).text(2)]);
                let place = &mut over_scenes[usize::from(method == Method::Pt)];
                place[0].extend(time);
                place[1].extend(error);
            }
            let last = findings.values(Some(scene), method.name(), |f| f.rel_mse);
            row.push(short(Interval::of_factors(&last).mean));
            table.push(row);
        }
    }
    let header = [
        "scene",
        "method",
        "slope over mutations",
        "relMSE over emlt's at equal time",
        "time over emlt's at equal error",
        "relMSE at the end",
    ];
    report.table("convergence", &header, &table)?;
    report.paragraph(&format!(
        "Slope: of log relMSE over log mutations, by least squares from 1/{:.0} of each run on; independent samples have -1. \
         Equal time: the end of the run that ended first. Equal error: the higher of the errors that both came down to. Ratios \
         above 1 speak for emlt. 95 % intervals over the seeds.",
        1.0 / FITTED
    ));
    if let Some(busy) = findings.busy() {
        report.paragraph(&busy);
    }
    for (name, [time, error]) in ["mlt", "pt"].into_iter().zip(over_scenes) {
        let finite =
            |values: Vec<f64>| Interval::of_factors(&values.into_iter().filter(|v| v.is_finite()).collect::<Vec<_>>());
        let [time, error] = [finite(time), finite(error)];
        let verdict = match Verdict::all_above_one(&[time]) {
            Verdict::Agrees => format!("emlt is below {name} at equal time"),
            Verdict::Disagrees => format!("emlt is above {name} at equal time"),
            Verdict::Undecided => format!("whether emlt is below {name} at equal time cannot be decided"),
        };
        report.paragraph(&format!(
            "Over these scenes and seeds {verdict}: relMSE of {name} over that of emlt is {}; the time that {name} takes for \
             equal error over that of emlt is {}.",
            time.text(2),
            error.text(2)
        ));
    }
    Ok(())
}

fn chart(findings: &Findings, scene: &str, label: &str, x: X) -> Chart {
    let mut series = Vec::new();
    for (number, method) in METHODS.into_iter().enumerate() {
        let curves: Vec<_> = findings.of(Some(scene), method.name()).map(|finished| curve(finished, x)).collect();
        let points = mean_curve(&curves);
        series.push(Series { name: method.name().into(), points, bars: vec![], style: Style::Coloured(number) });
    }
    // Through the last point of emlt.
    if let (Some(first), Some(last)) = (series[0].points.first(), series[0].points.last()) {
        let points = vec![(first.0, last.1 * last.0 / first.0), *last];
        series.push(Series { name: "1 / n".into(), points, bars: vec![], style: Style::Guide });
    }
    Chart { title: scene.into(), x: (label.into(), Scale::Log), y: ("relMSE".into(), Scale::Log), series }
}

/// The part of a curve that slopes are fitted to.
fn tail(curve: &[(f64, f64)]) -> &[(f64, f64)] {
    let end = curve.last().map_or(0.0, |p| p.0);
    let first = curve.iter().position(|p| p.0 >= FITTED * end).unwrap_or(0);
    &curve[first..]
}

/// relMSE of `other` over that of `emlt` when the first of them ends; NaN where one has none then.
fn equal_time(other: &[(f64, f64)], emlt: &[(f64, f64)]) -> f64 {
    let end = |curve: &[(f64, f64)]| curve.last().map_or(0.0, |p| p.0);
    let time = end(other).min(end(emlt));
    at(other, time).zip(at(emlt, time)).map_or(f64::NAN, |(other, emlt)| other / emlt)
}

/// Time of `other` over that of `emlt` until both have come down to the error that the worse of them ends with.
fn equal_error(other: &[(f64, f64)], emlt: &[(f64, f64)]) -> f64 {
    let least = |curve: &[(f64, f64)]| curve.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let error = least(other).max(least(emlt));
    let times = first_at_or_below(other, error).zip(first_at_or_below(emlt, error));
    times.map_or(f64::NAN, |(other, emlt)| other / emlt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_curves_that_are_shifted() {
        let points =
            |factor: f64, end: i32| (0..end).map(|n| 2f64.powi(n)).map(|t| (t, factor / t)).collect::<Vec<_>>();
        let (emlt, other) = (points(1.0, 8), points(3.0, 7));
        assert!((equal_time(&other, &emlt) - 3.0).abs() < 1e-9);
        assert!((equal_error(&other, &emlt) - 3.0).abs() < 1e-9);
        assert!(equal_time(&[], &emlt).is_nan() && equal_error(&other, &[]).is_nan());
        assert_eq!(tail(&emlt).len(), 6);
        assert!((slope(tail(&emlt)).unwrap() + 1.0).abs() < 1e-9);
        assert_eq!(mean_curve(&[emlt.clone(), points(4.0, 3)]).last(), Some(&(4.0, 0.5)));
    }
}
