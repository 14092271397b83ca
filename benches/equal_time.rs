//! Error at equal time: every method renders a scene for the same wall time with several seeds; the median relMSE per
//! pixel and on means of 4x4 pixels is printed, with what the methods did in that time.
//!
//!     cargo bench --bench equal_time -- [--scene ajar] [--seconds 10] [--seeds 5] [--image OTHER.exr ...]
//!     cargo bench --bench equal_time -- --spp 64 --methods emlt --kernels MIX --kernels OTHER_MIX
//!
//! The scene and the reference are those of tests/references; the reference's own noise is subtracted. Another
//! renderer's images of the same scene and size are compared in the same way.

mod shared;

use std::path::{Path, PathBuf};

use clap::Parser;
use emlt::ensemble::mix::Mix;
use emlt::film::{Image, exr, metrics};
use emlt::methods::{Budget, Method, Settings, Silent, default_candidates, default_direct, default_two_stage, render};
use emlt::scene::import::import;

#[derive(Parser)]
struct Arguments {
    /// Name of a scene that has a reference
    #[arg(long, default_value = "ajar")]
    scene: String,
    /// Images of other renderers
    #[arg(long, num_args = 1..)]
    image: Vec<PathBuf>,
    /// Time of each image with the chains' start; set-up and compiling come on top and are listed
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Instead of a time: mutations or samples per pixel, for comparisons on a machine with other work
    #[arg(long)]
    spp: Option<u32>,
    #[arg(long, default_value_t = 5)]
    seeds: u32,
    /// A mix of kernels NAME=WEIGHT,... for the methods that have one, instead of the default; several are compared
    #[arg(long)]
    kernels: Vec<String>,
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Method::Emlt, Method::Mlt, Method::Pt])]
    methods: Vec<Method>,
}

fn main() {
    shared::main(run);
}

/// Processor seconds of this process so far (clock ticks of 1/100 s, as on all Linux systems).
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| after_name.get(i).and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn run(arguments: &Arguments) -> emlt::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scene = import(&root.join("scenes").join(&arguments.scene).with_extension("glb"))?;
    let file = root.join("tests/references").join(&arguments.scene).with_extension("exr");
    let reference = layer(&file, "")?;
    let noise = layer(&file, "Variance.")?;
    let compare = |image: &Image| metrics::compare(image, &reference, Some(&noise));
    println!(
        "{} at {}x{}, {}, median of {} seeds",
        scene.name,
        reference.width,
        reference.height,
        arguments.spp.map_or(format!("{} s with the start", arguments.seconds), |n| format!("{n} per pixel")),
        arguments.seeds
    );
    println!(
        "method  relMSE px  relMSE 4x4    MSE px    mutations/px   million/s  CPU s  set-up s  acceptance and squared jump (px^2)"
    );
    let mixes: Vec<_> = match arguments.kernels.len() {
        0 => vec![None],
        _ => arguments.kernels.iter().map(|mix| Mix::parse(mix).map(Some)).collect::<emlt::Result<_>>()?,
    };
    for (&method, mix) in arguments.methods.iter().flat_map(|method| mixes.iter().map(move |mix| (method, mix))) {
        let mut rows: Vec<[f64; 7]> = Vec::new();
        let mut kernels = String::new();
        for seed in 1..=arguments.seeds {
            let [width, height] = [reference.width, reference.height];
            let budget = arguments.spp.map_or(Budget::Seconds(arguments.seconds), Budget::SamplesPerPixel);
            let settings = Settings {
                method,
                width,
                height,
                budget,
                seed,
                two_stage: default_two_stage(method),
                direct: default_direct(method, mix.is_some()),
                candidates: default_candidates(true, budget, [width, height]),
                kernels: mix.clone(),
                ..Settings::default()
            };
            let cpu = cpu_seconds();
            let outcome = render(&scene, &settings, &mut Silent)?;
            let errors = compare(&outcome.image)?;
            let s = &outcome.statistics;
            let pixels = f64::from(reference.width * reference.height);
            rows.push([
                errors.rel_mse,
                errors.rel_mse_blocks,
                errors.mse,
                s.samples as f64 / pixels,
                cpu_seconds() - cpu,
                s.setup_s + s.compile_s + s.seeding_s,
                1e-6 * s.samples as f64 / s.render_s,
            ]);
            kernels = s
                .kernels
                .iter()
                .map(|k| {
                    let accepted = 100.0 * k.accepted as f64 / k.mutations.max(1) as f64;
                    format!("{} {accepted:.1} % {:.1}", k.name, k.mean_squared_jump_px2)
                })
                .collect::<Vec<_>>()
                .join(", ");
        }
        let column = |i: usize| median(rows.iter().map(|r| r[i]).collect());
        println!(
            "{:<7} {:>9.5} {:>11.5} {:>9.5} {:>13.1} {:>11.3} {:>6.1} {:>9.1}  {kernels}",
            method.name(),
            column(0),
            column(1),
            column(2),
            column(3),
            column(6),
            column(4),
            column(5)
        );
    }
    if !arguments.image.is_empty() {
        let errors = arguments.image.iter().map(|file| compare(&layer(file, "")?)).collect::<emlt::Result<Vec<_>>>()?;
        let column = |f: fn(&metrics::Errors) -> f64| median(errors.iter().map(f).collect());
        println!(
            "{:<7} {:>9.5} {:>11.5} {:>9.5}",
            "images",
            column(|e| e.rel_mse),
            column(|e| e.rel_mse_blocks),
            column(|e| e.mse)
        );
    }
    Ok(())
}

/// Channels `prefix`R, G, B of an EXR.
fn layer(file: &Path, prefix: &str) -> emlt::Result<Image> {
    exr::read(file)?
        .image(prefix)
        .ok_or_else(|| emlt::Error::input(format!("{} has no channels {prefix}R, G, B", file.display())))
}
