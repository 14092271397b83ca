//! The supplement's section 4: mutations a second by the number of threads.
//!
//! Mesa's software driver reads LP_NUM_THREADS when it is loaded, so every run is an `emlt render` in a process of its own,
//! whose figures are read from its image's header.

use std::env;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::available_parallelism;

use super::axes::Scale;
use super::folder::Figures;
use super::plan::{Asked, Defaults, Kind, Run};
use super::plot::{Chart, Series, Style};
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, mean};
use super::work::SceneFile;
use super::{Findings, Study};
use crate::film::exr::{self, Attribute};
use crate::gpu::context::Context;
use crate::methods::{Budget, Method};
use crate::{Error, Result};

pub const STUDY: Study = Study {
    name: "threads",
    about: "mutations (pt: samples) a second by the number of the software driver's threads",
    defaults: Defaults {
        scenes: &["cornell"],
        size: [160, 120],
        budget: Budget::Seconds(5.0),
        seeds: 3,
        reference_spp: 0,
    },
    compares: false,
    runs,
    conclude,
};

const METHODS: [Method; 3] = [Method::Pt, Method::Mlt, Method::Emlt];
/// The least share of the speed that perfect scaling has which still counts as linear.
const LINEAR: f64 = 0.9;

/// One to as many as there are processors: all of a few, powers of two of many.
fn counts() -> Vec<u32> {
    let most = available_parallelism().map_or(1, |n| n.get() as u32);
    let mut counts: Vec<u32> = (1..=most).filter(|n| most <= 8 || n.is_power_of_two()).collect();
    if counts.last() != Some(&most) {
        counts.push(most);
    }
    counts
}

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    let scene = asked.only_scene(STUDY.name)?;
    let mut runs = Vec::new();
    for seed in &asked.seeds {
        for threads in counts() {
            let run = |method: Method| {
                let variant = format!("{} on {threads}", method.name());
                Run { kind: Kind::Threads(threads), ..asked.run(scene, variant, method, *seed) }
            };
            runs.extend(METHODS.map(run));
        }
    }
    Ok(runs)
}

/// Refuses devices that LP_NUM_THREADS says nothing to.
pub fn check(context: &Context) -> Result<()> {
    if context.software && context.description.contains("llvmpipe") {
        return Ok(());
    }
    Err(Error::input(format!(
        "study threads is about Mesa's software driver, and the device is {}: choose it with --device llvmpipe",
        context.description
    )))
}

/// Renders in a process whose driver has so many threads.
pub fn measure(file: &SceneFile, run: &Run, threads: u32, folder: &Path) -> Result<Figures> {
    let s = &run.settings;
    let image = folder.join("threads.exr");
    let program = env::current_exe().map_err(|e| Error::runtime(format!("cannot find this program again: {e}")))?;
    let mut command = Command::new(program);
    command.env("LP_NUM_THREADS", threads.to_string()).arg("render").arg(&file.path).arg("-o").arg(&image);
    command.args(["--quiet", "--method", s.method.name(), "--size", &format!("{}x{}", s.width, s.height)]);
    command.args(["--seed", &s.seed.to_string()]);
    match s.budget {
        Budget::SamplesPerPixel(n) => command.args(["--spp", &n.to_string()]),
        Budget::Seconds(seconds) => command.args(["--time", &seconds.to_string()]),
    };
    if let Some(sky) = &file.sky {
        command.arg("--env").arg(sky);
    }
    if let Some(device) = &s.device {
        command.arg("--device").arg(device);
    }
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|e| Error::runtime(format!("cannot start this program again: {e}")))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let why = said.lines().find_map(|line| line.strip_prefix("error: ")).unwrap_or("it ended without a word");
        return Err(Error::runtime(why));
    }
    let read = exr::read(&image)?;
    for left in [&image, &image.with_extension("png")] {
        let _ = fs::remove_file(left);
    }
    let number = |name: &str| match read.attribute(name) {
        Some(Attribute::Number(number)) => Some(*number),
        _ => None,
    };
    let samples = number("mutations").or_else(|| number("samples"));
    let per_pixel = samples.map(|n| n / (f64::from(s.width) * f64::from(s.height)));
    Ok(Figures { samples, samples_per_pixel: per_pixel, render_s: number("seconds"), ..Figures::default() })
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let counts = counts();
    let most = *counts.last().expect("at least one thread");
    let rates = |method: Method, n: u32| findings.values(None, &format!("{} on {n}", method.name()), |f| f.rate());
    let mut table = Vec::new();
    let mut series = Vec::new();
    for (number, method) in METHODS.into_iter().enumerate() {
        let mut line =
            Series { name: method.name().into(), points: vec![], bars: vec![], style: Style::Coloured(number) };
        for n in &counts {
            let rate = Interval::of(&rates(method, *n).iter().map(|r| 1e-6 * r).collect::<Vec<_>>());
            let speedup = Interval::of_ratio(&rates(method, *n), &rates(method, 1));
            line.points.push((f64::from(*n), rate.mean));
            // No speed is below 0.
            line.bars.push((rate.low.max(0.0), rate.high));
            let told = if *n == 1 { "1".into() } else { speedup.text(2) };
            let share = format!("{:.0} %", 100.0 * speedup.mean / f64::from(*n));
            table.push(vec![method.name().into(), n.to_string(), short(rate.mean), told, share]);
        }
        series.push(line);
    }
    report.heading(&format!("Speed on {}", findings.asked.only_scene(STUDY.name)?));
    for method in METHODS {
        let one = 1e-6 * mean(&rates(method, 1));
        let points = [1, most].map(|n| (f64::from(n), one * f64::from(n))).to_vec();
        series.push(Series { name: "linear".into(), points, bars: vec![], style: Style::Guide });
    }
    let chart = Chart {
        title: "Speed by threads".into(),
        x: ("threads of the driver (LP_NUM_THREADS)".into(), Scale::Count),
        y: ("million mutations (pt: samples) a second".into(), Scale::Linear),
        series,
    };
    report.plot(
        "threads",
        &[chart],
        1,
        "Means over the seeds with 95 % intervals; grey, one thread's speed multiplied.",
    )?;
    let header = ["method", "threads", "million a second", "speed-up", "of perfect scaling"];
    report.table("threads", &header, &table)?;
    let share = |method| {
        let perfect: Vec<f64> = rates(method, 1).iter().map(|rate| rate * f64::from(most)).collect();
        Interval::of_ratio(&rates(method, most), &perfect)
    };
    let [pt, emlt] = [share(Method::Pt), share(Method::Emlt)];
    let busy = findings.busy();
    let verdict = match most {
        1 => Verdict::Undecided,
        _ if busy.is_some() => Verdict::Undecided,
        _ if emlt.above(LINEAR) => Verdict::Agrees,
        _ if emlt.below(LINEAR) => Verdict::Disagrees,
        _ => Verdict::Undecided,
    };
    report.claim(
        "Performance scales linearly with the number of threads.",
        verdict,
        &format!(
            "On {most} threads emlt has {} of perfect scaling, pt {} (1 is perfect; with 95 % intervals over the seeds). It \
             agrees where emlt's interval is above {LINEAR}, and does not where it is below. Only rendering is timed, not \
             the start. Other work on the machine takes from the higher counts first; where it had some, nothing is decided. {}",
            emlt.text(2),
            pt.text(2),
            busy.unwrap_or_default()
        ),
    );
    Ok(())
}
