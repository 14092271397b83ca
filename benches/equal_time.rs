//! Error at equal time: every method renders a scene for the same wall time with several seeds; the median relMSE per
//! pixel and on means of 4x4 pixels is printed, with what the methods did in that time.
//!
//!     cargo bench --bench equal_time -- --reference REF.exr [--scene scenes/ajar.glb] [--seconds 10] [--seeds 5]
//!
//! The image size is the reference's. A reference is a long render of the same scene, for example
//!     emlt render scenes/ajar.glb --size 160x120 --spp 8192 --seed 1001 -o ref.exr

use std::path::PathBuf;

use clap::Parser;
use emlt::film::{exr, metrics};
use emlt::methods::{Budget, Method, Settings, Silent, render};
use emlt::scene::import::import;

#[derive(Parser)]
struct Arguments {
    #[arg(long, default_value = "scenes/ajar.glb")]
    scene: PathBuf,
    #[arg(long)]
    reference: PathBuf,
    /// Rendering time of each image; seeding and compiling come on top and are listed
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    #[arg(long, default_value_t = 5)]
    seeds: u32,
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Method::Emlt, Method::Mlt, Method::Pt])]
    methods: Vec<Method>,
    /// Passed by cargo
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    if let Err(error) = run(&Arguments::parse()) {
        eprintln!("error: {error}");
        std::process::exit(i32::from(error.exit_status()));
    }
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
    let scene = import(&arguments.scene)?;
    let reference = exr::read(&arguments.reference)?
        .image("")
        .ok_or_else(|| emlt::Error::input(format!("{} has no channels R, G, B", arguments.reference.display())))?;
    println!(
        "{} at {}x{}, {} s of rendering, median of {} seeds",
        scene.name, reference.width, reference.height, arguments.seconds, arguments.seeds
    );
    println!(
        "method  relMSE px  relMSE 4x4    MSE px    mutations/px  CPU s  set-up s  acceptance and squared jump (px^2)"
    );
    for &method in &arguments.methods {
        let mut rows: Vec<[f64; 6]> = Vec::new();
        let mut kernels = String::new();
        for seed in 1..=arguments.seeds {
            let settings = Settings {
                method,
                width: reference.width,
                height: reference.height,
                budget: Budget::Seconds(arguments.seconds),
                seed,
                ..Settings::default()
            };
            let cpu = cpu_seconds();
            let outcome = render(&scene, &settings, &mut Silent)?;
            let errors = metrics::compare(&outcome.image, &reference, None)?;
            let s = &outcome.statistics;
            let pixels = f64::from(reference.width * reference.height);
            rows.push([
                errors.rel_mse,
                errors.rel_mse_blocks,
                errors.mse,
                s.samples as f64 / pixels,
                cpu_seconds() - cpu,
                s.setup_s + s.compile_s + s.seeding_s,
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
            "{:<7} {:>9.5} {:>11.5} {:>9.5} {:>13.1} {:>6.1} {:>9.1}  {kernels}",
            method.name(),
            column(0),
            column(1),
            column(2),
            column(3),
            column(4),
            column(5)
        );
    }
    Ok(())
}
