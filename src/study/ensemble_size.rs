//! The supplement's section 2: how the error depends on the size of the ensemble.

use super::axes::Scale;
use super::plan::{Asked, Defaults, Run, SCENES};
use super::plot::{Chart, Series, Style};
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, mean};
use super::{Findings, Study};
use crate::Result;
use crate::methods::{Budget, Method};

pub const STUDY: Study = Study {
    name: "ensemble-size",
    about: "error by the number of paths in the ensemble, at equal numbers of mutations",
    // 64 mutations per pixel of this film are one whole sweep of the largest ensemble, and so many of the others.
    defaults: Defaults {
        scenes: &SCENES,
        size: [160, 128],
        budget: Budget::SamplesPerPixel(64),
        seeds: 2,
        reference_spp: 384,
    },
    compares: true,
    runs,
    conclude,
};

const SIZES: [u32; 8] = [1024, 2048, 4096, 8192, 16384, 32768, 65536, 131_072];
/// Where the supplement finds the minimum, and what counts as near it.
const BEST: u32 = 16384;
const NEAR: std::ops::RangeInclusive<u32> = 8192..=32768;

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    Ok(asked.runs(SIZES, |scene, paths, seed| {
        let mut run = asked.run(scene, paths.to_string(), Method::Emlt, seed);
        run.settings.ensemble = paths;
        // One complementary ensemble, as in the supplement: groups would divide it.
        run.settings.groups = 1;
        run
    }))
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scenes = &findings.asked.scenes;
    let normalised =
        |scene: &str, paths: u32| findings.values(Some(scene), &paths.to_string(), |f| Some(f.mse? / f.luminance?));
    let curve = |scene: &str| SIZES.map(|paths| mean(&normalised(scene, paths)));
    let curves: Vec<[f64; SIZES.len()]> = scenes.iter().map(|scene| curve(scene)).collect();
    let average: Vec<f64> = (0..SIZES.len()).map(|i| mean(&curves.iter().map(|c| c[i]).collect::<Vec<_>>())).collect();
    let points = |values: &[f64]| SIZES.iter().map(|s| f64::from(*s)).zip(values.iter().copied()).collect::<Vec<_>>();
    let mut series: Vec<Series> = scenes
        .iter()
        .zip(&curves)
        .enumerate()
        .map(|(n, (scene, curve))| Series {
            name: scene.clone(),
            points: points(curve),
            bars: vec![],
            style: Style::Coloured(n),
        })
        .collect();
    series.push(Series { name: "average".into(), points: points(&average), bars: vec![], style: Style::Main });
    let chart = Chart {
        title: "Error by ensemble size".into(),
        x: ("paths in the ensemble".into(), Scale::Log2),
        y: ("MSE over mean luminance".into(), Scale::Log),
        series,
    };
    report.heading("Error by ensemble size");
    let caption = "MSE over the scene's mean luminance (in units of radiance, as in the supplement), means over the seeds; \
                   black, their average over the scenes.";
    report.plot("ensemble-size", &[chart], 1, caption)?;

    // Against the supplement's best, seed by seed and scene by scene.
    let everything = |paths: u32| {
        scenes
            .iter()
            .flat_map(|scene| findings.values(Some(scene), &paths.to_string(), |f| f.mse))
            .collect::<Vec<f64>>()
    };
    let ratios: Vec<Interval> = SIZES.iter().map(|n| Interval::of_ratio(&everything(*n), &everything(BEST))).collect();
    let [width, height] = findings.asked.size.map(f64::from);
    let mut table = Vec::new();
    for (i, paths) in SIZES.iter().enumerate() {
        let made = findings.values(None, &paths.to_string(), |f| f.samples_per_pixel);
        let mut row = vec![paths.to_string(), format!("{:.1}", mean(&made) * width * height / f64::from(*paths))];
        row.extend(curves.iter().map(|curve| short(curve[i])));
        row.extend([short(average[i]), if *paths == BEST { "1".into() } else { ratios[i].text(3) }]);
        table.push(row);
    }
    let against = format!("MSE over that of {BEST}");
    let mut header = vec!["paths", "mutations per path"];
    header.extend(scenes.iter().map(String::as_str));
    header.extend(["average", &against]);
    report.table("ensemble-size", &header, &table)?;
    let far: Vec<Interval> = SIZES.iter().zip(&ratios).filter(|(n, _)| !NEAR.contains(*n)).map(|(_, r)| *r).collect();
    let lowest = |values: &[f64]| {
        let best = values.iter().enumerate().filter(|(_, v)| v.is_finite()).min_by(|a, b| a.1.total_cmp(b.1));
        best.map_or("nowhere".into(), |(i, _)| SIZES[i].to_string())
    };
    let geometric: Vec<f64> = ratios.iter().map(|ratio| ratio.mean).collect();
    report.claim(
        "The minimal MSE occurs at 16384 paths.",
        Verdict::all_above_one(&far),
        &format!(
            "The average is lowest at {}, the geometric mean over scenes and seeds at {}. The last column of the table has \
             the ratio to {BEST} with its 95 % interval over all pairs of scene and seed. It agrees where every size outside \
             of {} to {} is wholly above 1, and does not where one is wholly below. More pixels \
             leave more mutations to each path, which favours larger ensembles.",
            lowest(&average),
            lowest(&geometric),
            NEAR.start(),
            NEAR.end()
        ),
    );
    Ok(())
}
