//! The page of a study: what was run on what, figures, and whether the supplement's claims hold here.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use super::panels::{self, Panel};
use super::plan::budget_name;
use super::plot::{self, Chart};
use super::statistics::Interval;
use super::{Findings, Study};
use crate::Result;
use crate::film::file::write_whole;
use crate::gpu::context::Context;

/// What is noted of the machine while a study runs.
pub struct Journal {
    device: String,
    software: bool,
    /// Load average before, and after.
    load: [Option<f64>; 2],
    began: SystemTime,
    /// Runs made now, and of all.
    made: [usize; 2],
}

impl Journal {
    pub fn new(context: &Context, load: Option<f64>) -> Self {
        let device = context.description.clone();
        Self { device, software: context.software, load: [load, None], began: SystemTime::now(), made: [0, 0] }
    }

    pub fn ended(&mut self, load: Option<f64>, made: usize, of: usize) {
        self.load[1] = load;
        self.made = [made, of];
    }
}

/// Whether a claim of the supplement holds here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Agrees,
    Disagrees,
    /// The scatter of the seeds allows either.
    Undecided,
}

impl Verdict {
    /// Of a comparison that agrees where all of `ratios` are wholly above 1, and disagrees where one is wholly below.
    pub fn all_above_one(ratios: &[Interval]) -> Self {
        if ratios.iter().any(|ratio| ratio.below(1.0)) {
            Self::Disagrees
        } else if !ratios.is_empty() && ratios.iter().all(|ratio| ratio.above(1.0)) {
            Self::Agrees
        } else {
            Self::Undecided
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Agrees => "This study agrees.",
            Self::Disagrees => "This study does not agree.",
            Self::Undecided => "These runs cannot decide it.",
        }
    }
}

/// The page on its way, and the files beside it.
pub struct Report {
    folder: PathBuf,
    text: String,
    /// Sentences for whoever waits at the keyboard.
    said: Vec<String>,
}

impl Report {
    /// Begins with what was run.
    pub fn new(study: &Study, findings: &Findings, journal: Journal) -> Result<Self> {
        let asked = &findings.asked;
        let mut report = Self { folder: asked.out.clone(), text: String::new(), said: Vec::new() };
        let [width, height] = asked.size;
        let load = |load: Option<f64>| load.map_or("not known".into(), |load| format!("{load:.2}"));
        let loads = findings
            .runs
            .iter()
            .flat_map(|f| &f.figures)
            .filter_map(|f| f.load)
            .fold(None, |most, load| Some(f64::max(load, most.unwrap_or(0.0))));
        let kind = if journal.software { ", software: runs on the processor" } else { "" };
        let cores = std::thread::available_parallelism().map_or("unknown".into(), |n| n.to_string());
        let seeds: Vec<String> = asked.seeds.iter().map(u32::to_string).collect();
        let [made, of] = journal.made;
        let rows = [
            ("command", format!("`{}`", asked.command_line.replace('`', "'"))),
            ("date", format!("{} to {} (UTC)", date(journal.began), date(SystemTime::now()))),
            ("emlt", env!("CARGO_PKG_VERSION").to_string()),
            ("device and driver", format!("{}{kind}", journal.device)),
            ("system", format!("{} {}, {cores} processors", std::env::consts::OS, std::env::consts::ARCH)),
            (
                "load average",
                format!(
                    "{} at the start, {} at the end, {} at most during the runs (this program's own work counts too)",
                    load(journal.load[0]),
                    load(journal.load[1]),
                    load(loads)
                ),
            ),
            ("film", format!("{width}x{height}, {} unless a table says otherwise", budget_name(asked.budget))),
            ("seeds", seeds.join(", ")),
            ("runs", format!("{of}, of which {made} were made now and the others kept from before")),
        ];
        let _ = writeln!(report.text, "# {}: {}\n", study.name, study.about);
        report.page_table(&["", ""], &rows.map(|(name, value)| vec![name.into(), value]));
        if !findings.references.is_empty() {
            report.heading("What images are compared with");
            let row = |r: &super::Reference| {
                vec![r.scene.clone(), r.source.clone(), format!("{:.2} %", 100.0 * r.own_error())]
            };
            let rows: Vec<_> = findings.references.iter().map(row).collect();
            report.page_table(&["scene", "reference", "its own noise (root of relMSE)"], &rows);
            report.paragraph(
                "That noise is subtracted from every MSE and relMSE, but not from FLIP. What a reference by this \
                 program has missed, the images compared with it may miss too.",
            );
        }
        Ok(report)
    }

    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.text, "## {text}\n");
    }

    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.text, "{text}\n");
    }

    fn page_table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        let line = |cells: &[String]| {
            format!("| {} |\n", cells.iter().map(|c| c.replace('|', "/")).collect::<Vec<_>>().join(" | "))
        };
        self.text.push_str(&line(&header.iter().map(|h| (*h).to_string()).collect::<Vec<_>>()));
        self.text.push_str(&line(&vec!["---".into(); header.len()]));
        rows.iter().for_each(|row| self.text.push_str(&line(row)));
        self.text.push('\n');
    }

    /// A table on the page, and with its name as a file.
    pub fn table(&mut self, name: &str, header: &[&str], rows: &[Vec<String>]) -> Result<()> {
        self.page_table(header, rows);
        let line = |cells: &[String]| cells.iter().map(|c| quoted(c)).collect::<Vec<_>>().join(",") + "\n";
        let mut text = header.join(",") + "\n";
        rows.iter().for_each(|row| text.push_str(&line(row)));
        write_whole(&self.folder.join(format!("{name}.csv")), text.as_bytes())?;
        self.paragraph(&format!("Numbers: [{name}.csv]({name}.csv); every run: [runs.csv](runs.csv)."));
        Ok(())
    }

    /// A plot with its caption; columns of charts side by side.
    pub fn plot(&mut self, name: &str, charts: &[Chart], columns: usize, caption: &str) -> Result<()> {
        plot::write(&self.folder.join(name), charts, columns)?;
        self.figure(name, caption, &format!(" ([SVG]({name}.svg))"));
        Ok(())
    }

    /// Pictures with a caption.
    pub fn pictures(&mut self, name: &str, rows: &[Vec<Panel>], caption: &str) -> Result<()> {
        panels::write(&self.folder.join(name).with_extension("png"), rows)?;
        self.figure(name, caption, "");
        Ok(())
    }

    fn figure(&mut self, name: &str, caption: &str, also: &str) {
        let _ = writeln!(self.text, "![{name}]({name}.png)\n\n{caption}{also}\n");
    }

    /// What the supplement says, whether it holds here, and by what figures and rule.
    pub fn claim(&mut self, claim: &str, verdict: Verdict, why: &str) {
        self.heading("Does it agree with the supplement?");
        let _ = writeln!(self.text, "> {claim}\n\n**{}** {why}\n", verdict.words());
        self.said.push(format!("\"{claim}\" {}", verdict.words()));
    }

    /// Writes the page and says where it is.
    pub fn write(mut self) -> Result<Vec<String>> {
        let path = self.folder.join("report.md");
        write_whole(&path, format!("{}\n", self.text.trim_end()).as_bytes())?;
        self.said.push(format!("report: {}", path.display()));
        if let Ok(entries) = fs::read_dir(&self.folder) {
            let names = entries.filter_map(|e| e.ok().map(|e| e.file_name().to_string_lossy().into_owned()));
            let mut names: Vec<String> = names.filter(|n| n.ends_with(".svg") || n.ends_with(".png")).collect();
            names.sort();
            self.said.push(format!("plots and pictures: {}", names.join(", ")));
        }
        Ok(self.said)
    }
}

/// As a field of a CSV file.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// In four digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let digits = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

/// Year, month, day, hour and minute of a time, in UTC and the Gregorian calendar.
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, minutes) = (seconds / 86_400, seconds % 86_400 / 60);
    let leap = |year: u64| year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400);
    let (mut year, mut day) = (1970, days);
    while day >= 365 + u64::from(leap(year)) {
        day -= 365 + u64::from(leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while day >= lengths[month] {
        day -= lengths[month];
        month += 1;
    }
    format!("{year}-{:02}-{:02} {:02}:{:02}", month + 1, day + 1, minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_are_right() {
        let at = |seconds: u64| date(UNIX_EPOCH + Duration::from_secs(seconds));
        for (seconds, text) in [
            (0, "1970-01-01 00:00"),
            (951_782_399, "2000-02-28 23:59"),
            (951_782_400, "2000-02-29 00:00"),
            (951_868_800, "2000-03-01 00:00"),
            (1_795_756_147, "2026-11-27 05:09"),
            (4_107_542_399, "2100-02-28 23:59"),
            (4_107_542_400, "2100-03-01 00:00"),
        ] {
            assert_eq!(at(seconds), text);
        }
    }

    #[test]
    fn verdicts_need_the_whole_interval() {
        let interval = |low, high| Interval { mean: 0.5 * (low + high), low, high };
        let [above, about, below] = [interval(1.01, 1.2), interval(0.9, 1.1), interval(0.8, 0.99)];
        assert_eq!(Verdict::all_above_one(&[above, above]), Verdict::Agrees);
        assert_eq!(Verdict::all_above_one(&[above, about]), Verdict::Undecided);
        assert_eq!(Verdict::all_above_one(&[above, about, below]), Verdict::Disagrees);
        assert_eq!(Verdict::all_above_one(&[Interval::of(&[2.0])]), Verdict::Undecided);
        assert_eq!(Verdict::all_above_one(&[]), Verdict::Undecided);
    }

    #[test]
    fn numbers_and_fields() {
        assert_eq!([0.0, 0.012_345, 1.5, 123.456, 4e-7].map(short), ["0", "0.01235", "1.500", "123.5", "4.000e-7"]);
        assert_eq!([quoted("a b"), quoted("a,\"b\"")], ["a b", "\"a,\"\"b\"\"\""]);
    }
}
