//! The table at the end of a render.

use std::fmt::{self, Display, Formatter};
use std::fs;
use std::path::PathBuf;

use super::statistics::{ErrorStatistics, KernelStatistics, Statistics};
use crate::ensemble::mixing::MixingStatistics;
use crate::ensemble::pool::abbreviated;
use crate::methods::Method;

/// Everything the table shows; print it with `{}` (several lines, each ended by a line feed).
pub struct Summary<'a> {
    pub method: Method,
    /// Pixels of the image.
    pub pixels: u64,
    pub statistics: &'a Statistics,
    /// The process's highest memory use so far, where the system tells: see [`peak_memory_bytes`].
    pub peak_memory_bytes: Option<u64>,
    /// What was written.
    pub files: &'a [PathBuf],
}

/// The highest resident memory of this process so far; none where the system does not say (it does on Linux).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

impl Display for Summary<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let s = self.statistics;
        let mut row = |name: &str, text: String| writeln!(f, "{name:<12}{text}");
        let software = if s.software_device { " (software: runs on the processor)" } else { "" };
        row("device", format!("{}{software}", s.device))?;
        let samples = if self.method == Method::Pt { "samples" } else { "mutations" };
        let per_pixel = s.samples as f64 / self.pixels as f64;
        let rate = million_per_second(s.samples, s.render_s);
        // Where all light is path traced, there are none.
        if s.samples > 0 || s.path_traced_samples == 0 {
            row(samples, format!("{} ({per_pixel:.2} per pixel), {rate}", grouped(s.samples)))?;
        }
        if s.path_traced_samples > 0 {
            let per_pixel = s.path_traced_samples as f64 / self.pixels as f64;
            let share =
                s.path_traced_light.map_or(String::new(), |share| format!("{:.1} % of the light by ", 100.0 * share));
            row(
                "path traced",
                format!("{share}{} samples ({per_pixel:.2} per pixel)", grouped(s.path_traced_samples)),
            )?;
        }
        row("rays", format!("{}, {}", grouped(s.rays), million_per_second(s.rays, s.seeding_s + s.render_s)))?;
        if let Some((b, standard_error)) = s.b {
            let part = if s.path_traced_samples > 0 { ", path-traced light not counted" } else { "" };
            row("b", format!("{b:.6} +- {:.2} %{part}", 100.0 * standard_error / b))?;
        }
        if let Some(error) = s.error {
            row("error", error_row(&error))?;
        }
        if let Some(worst) =
            s.types.iter().filter(|t| t.start.max(t.chains) >= 1e-3).max_by(|a, b| a.z().abs().total_cmp(&b.z().abs()))
        {
            let counted = s.types.iter().filter(|t| t.start.max(t.chains) >= 1e-3).count();
            let z = worst.z().abs();
            row(
                "types",
                format!(
                    "{counted} hold 0.1 % of the light or more; chains and start differ by {z:.1} standard errors at most ({})",
                    abbreviated(&worst.name)
                ),
            )?;
        }
        if let Some(mixing) = &s.mixing {
            for (name, text) in mixing_rows(mixing) {
                row(name, text)?;
            }
        }
        if let Some(integrity) = s.integrity {
            row("integrity", format!("{integrity:+.1e} (splatted luminance over mutations, minus 1)"))?;
        }
        if !s.kernels.is_empty() {
            row("non-finite", non_finite(&s.kernels))?;
        }
        row("host", format!("{:.1} % of the rendering time", 100.0 * s.host_share))?;
        let (setup, compile, seeding) = (s.setup_s, s.compile_s, s.seeding_s);
        row(
            "times",
            format!(
                "set-up {setup:.2} s, compiling {compile:.2} s, seeding {seeding:.2} s, rendering {:.2} s",
                s.render_s
            ),
        )?;
        if let Some(bytes) = self.peak_memory_bytes {
            row("memory", format!("{:.0} MiB at its peak", bytes as f64 / f64::from(1 << 20)))?;
        }
        if s.interrupted {
            row("interrupted", "the image is as it stood when the render was asked to stop".into())?;
        }
        for note in &s.notes {
            row("note", note.clone())?;
        }
        for file in self.files {
            row("written", file.display().to_string())?;
        }
        kernel_table(f, &s.kernels)
    }
}

/// The image's error in words.
fn error_row(error: &ErrorStatistics) -> String {
    let [low, high] = [-1.0, 1.0].map(|sign| error.film + sign * error.film_half_width);
    let by = match error.groups {
        0 => "by the scatter of samples".to_string(),
        groups => format!("by the scatter of {groups} groups"),
    };
    let [pixels, tiles] = [error.pixels, error.tiles].map(percent);
    format!("{pixels} a pixel, {tiles} of 8x8 tiles, {by}; film mean {:.6}, 95 % in {low:.6} to {high:.6}", error.film)
}

/// How well chains mix, in words.
pub fn mixing_rows(mixing: &MixingStatistics) -> Vec<(&'static str, String)> {
    let MixingStatistics { mutations, longest_wait, waiting_type, memory, effective, groups, r_hat, .. } = mixing;
    let mut rows = Vec::new();
    if let Some(effective) = effective {
        let each = effective / f64::from(mixing.paths.max(1));
        let memory = match memory {
            Some(memory) => format!("for {}", grouped(memory.round() as u64)),
            // What paths have shown of their memory, all of which they are too short to show.
            None => format!("for {} or more", grouped((mutations / each).round() as u64)),
        };
        rows.push((
            "mixing",
            format!(
                "log I is remembered {memory} mutations: {each:.1} effective samples a path, {} in all",
                grouped(effective.round() as u64)
            ),
        ));
    }
    if let Some([log_i, edges]) = r_hat {
        rows.push((
            "agreement",
            format!("nested R-hat of {groups} groups {log_i:.3} for log I, {edges:.3} for lengths of paths"),
        ));
    }
    rows.push((
        "waits",
        format!(
            "{} mutations at most without a move, of about {} that each path makes, by a path {waiting_type}; {:.2} % of the paths stand still",
            grouped(*longest_wait),
            grouped(mutations.round() as u64),
            100.0 * mixing.still
        ),
    ));
    rows
}

/// A share with two digits or more.
pub fn percent(share: f64) -> String {
    if share < 0.1 { format!("{:.2} %", 100.0 * share) } else { format!("{:.1} %", 100.0 * share) }
}

/// One line per kernel, columns aligned; nothing without kernels.
fn kernel_table(f: &mut Formatter<'_>, kernels: &[KernelStatistics]) -> fmt::Result {
    if kernels.is_empty() {
        return Ok(());
    }
    let width = kernels.iter().map(|k| k.name.chars().count()).max().unwrap_or(0).max("kernel".len());
    writeln!(
        f,
        "{:<width$}  {:>15}  {:>9}  {:>19}  {:>9}",
        "kernel", "mutations", "accepted", "mean sq. jump, px^2", "million/s"
    )?;
    for k in kernels {
        let accepted = match k.mutations {
            0 => "-".to_string(),
            n => format!("{:.2} %", 100.0 * k.accepted as f64 / n as f64),
        };
        let (mutations, jump) = (grouped(k.mutations), k.mean_squared_jump_px2);
        let rate = k.device_s.map_or("-".to_string(), |s| format!("{:.3}", k.mutations as f64 / s / 1e6));
        writeln!(f, "{:<width$}  {mutations:>15}  {accepted:>9}  {jump:>19.3}  {rate:>9}", k.name)?;
    }
    Ok(())
}

fn non_finite(kernels: &[KernelStatistics]) -> String {
    let guilty: Vec<String> = kernels
        .iter()
        .filter(|k| k.non_finite > 0)
        .map(|k| format!("{} in {}", grouped(k.non_finite), k.name))
        .collect();
    if guilty.is_empty() {
        return "0 proposals".into();
    }
    format!("proposals, all rejected: {}", guilty.join(", "))
}

/// A rate in words.
pub fn million_per_second(count: u64, seconds: f64) -> String {
    if seconds > 0.0 {
        format!("{:.3} million per second", count as f64 / seconds / 1e6)
    } else {
        "no time taken".into()
    }
}

/// With a comma between thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::type_shares::TypeStatistics;

    fn kernel(name: &str, accepted: u64, non_finite: u64) -> KernelStatistics {
        let name = name.into();
        let device_s = (accepted > 1_000_000).then_some(8.0);
        KernelStatistics { name, mutations: 10_000_000, accepted, non_finite, mean_squared_jump_px2: 12.5, device_s }
    }

    #[test]
    fn thousands_are_grouped() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1234567, "1,234,567")] {
            assert_eq!(grouped(number), text);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_used_memory() {
        assert!(peak_memory_bytes().unwrap() > 1 << 20);
    }

    #[test]
    fn the_table_of_a_metropolis_render() {
        let statistics = Statistics {
            device: "llvmpipe (LLVM 15.0.6, 256 bits), Vulkan".into(),
            software_device: true,
            samples: 20_000_000,
            path_traced_samples: 5_000_000,
            path_traced_light: Some(0.625),
            rays: 120_000_000,
            kernels: vec![kernel("bidirectional", 1_000_000, 0), kernel("lens", 4_200_000, 3)],
            b: Some((0.25, 0.001)),
            error: Some(ErrorStatistics {
                pixels: 0.213,
                tiles: 0.0321,
                film: 0.25,
                film_half_width: 0.002,
                film_error: 0.001,
                groups: 8,
            }),
            types: vec![TypeStatistics {
                name: "L S D E".into(),
                start: 0.04,
                start_error: 0.004,
                candidates: 400,
                chains: 0.034,
                chains_error: 0.003,
            }],
            mixing: Some(MixingStatistics {
                mutations: 1220.7,
                paths: 16384,
                longest_wait: 1034,
                waiting_type: "L S D E".into(),
                memory: Some(86.4),
                effective: Some(231_424.0),
                groups: 8,
                r_hat: Some([1.0034, 1.0009]),
                r_hat_limit: 1.02,
                still: 0.0012,
                pixels: 320_000,
            }),
            integrity: Some(-2.5e-7),
            setup_s: 0.1,
            compile_s: 3.25,
            seeding_s: 1.5,
            render_s: 40.0,
            host_share: 0.012,
            interrupted: true,
            notes: vec!["The glass is thin.".into()],
        };
        let files = [PathBuf::from("box.exr"), PathBuf::from("box.png")];
        let summary = Summary {
            method: Method::Emlt,
            pixels: 320_000,
            statistics: &statistics,
            peak_memory_bytes: Some(300 << 20),
            files: &files,
        };
        let expected = "\
device      llvmpipe (LLVM 15.0.6, 256 bits), Vulkan (software: runs on the processor)
mutations   20,000,000 (62.50 per pixel), 0.500 million per second
path traced 62.5 % of the light by 5,000,000 samples (15.62 per pixel)
rays        120,000,000, 2.892 million per second
b           0.250000 +- 0.40 %, path-traced light not counted
error       21.3 % a pixel, 3.21 % of 8x8 tiles, by the scatter of 8 groups; film mean 0.250000, 95 % in 0.248000 to 0.252000
types       1 hold 0.1 % of the light or more; chains and start differ by 1.2 standard errors at most (L S D E)
mixing      log I is remembered for 86 mutations: 14.1 effective samples a path, 231,424 in all
agreement   nested R-hat of 8 groups 1.003 for log I, 1.001 for lengths of paths
waits       1,034 mutations at most without a move, of about 1,221 that each path makes, by a path L S D E; 0.12 % of the paths stand still
integrity   -2.5e-7 (splatted luminance over mutations, minus 1)
non-finite  proposals, all rejected: 3 in lens
host        1.2 % of the rendering time
times       set-up 0.10 s, compiling 3.25 s, seeding 1.50 s, rendering 40.00 s
memory      300 MiB at its peak
interrupted the image is as it stood when the render was asked to stop
note        The glass is thin.
written     box.exr
written     box.png
kernel               mutations   accepted  mean sq. jump, px^2  million/s
bidirectional       10,000,000    10.00 %               12.500          -
lens                10,000,000    42.00 %               12.500      1.250
";
        assert_eq!(summary.to_string(), expected);
    }

    #[test]
    fn the_table_of_a_path_tracing_has_no_mutations() {
        let statistics = Statistics { device: "GPU".into(), samples: 640, rays: 5, ..Default::default() };
        let summary =
            Summary { method: Method::Pt, pixels: 64, statistics: &statistics, peak_memory_bytes: None, files: &[] };
        let expected = "\
device      GPU
samples     640 (10.00 per pixel), no time taken
rays        5, no time taken
host        0.0 % of the rendering time
times       set-up 0.00 s, compiling 0.00 s, seeding 0.00 s, rendering 0.00 s
";
        assert_eq!(summary.to_string(), expected);
    }
}
