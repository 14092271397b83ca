//! A render's error against time, as a table that any program reads (`--log`).
//!
//! The file is written anew at every row and put in place at once, so that whatever ends the render leaves a whole table.

use std::path::PathBuf;

use crate::Result;
use crate::film::file::write_whole;
use crate::film::{Image, flip, metrics};
use crate::methods::Outcome;

/// Columns: seconds of rendering and with set-up; mutations (or samples) a pixel; the image's own error a pixel and of 8x8
/// tiles; b with its standard error; and against the reference MSE, relMSE, relMSE of 4x4 means, and FLIP. What is not
/// known is left empty.
const HEADER: &str = "render_s,total_s,samples_per_pixel,estimated_error,estimated_tile_error,b,b_standard_error,mse,rel_mse,rel_mse_4x4,flip";

/// The table on its way.
pub struct ErrorLog {
    path: PathBuf,
    reference: Option<Image>,
    text: String,
    /// Of the last row.
    samples: Option<u64>,
}

impl ErrorLog {
    /// Leaves a table without rows in the file.
    pub fn new(path: PathBuf, reference: Option<Image>) -> Result<Self> {
        let log = Self { path, reference, text: format!("{HEADER}\n"), samples: None };
        write_whole(&log.path, log.text.as_bytes())?;
        Ok(log)
    }

    /// Adds a row; none where nothing was rendered since the last one.
    pub fn row(&mut self, outcome: &Outcome) -> Result<()> {
        let Outcome { image, statistics: s, .. } = outcome;
        // Where all light is path traced, there are no others.
        let samples = if s.samples > 0 { s.samples } else { s.path_traced_samples };
        if self.samples.replace(samples) == Some(samples) {
            return Ok(());
        }
        let pixels = f64::from(image.width) * f64::from(image.height);
        let total = s.setup_s + s.compile_s + s.seeding_s + s.render_s;
        let mut fields = vec![Some(s.render_s), Some(total), Some(samples as f64 / pixels)];
        fields.extend([s.error.map(|e| e.pixels), s.error.map(|e| e.tiles)]);
        fields.extend([s.b.map(|b| b.0), s.b.map(|b| b.1)]);
        let errors = match &self.reference {
            Some(reference) => {
                let errors = metrics::compare(image, reference, None)?;
                let flip = flip::mean_flip(image, reference)?;
                [errors.mse, errors.rel_mse, errors.rel_mse_blocks, flip].map(Some)
            }
            None => [None; 4],
        };
        fields.extend(errors);
        // Six digits, whatever the size.
        let fields: Vec<String> = fields.iter().map(|f| f.map_or(String::new(), |v| format!("{v:.5e}"))).collect();
        self.text.push_str(&fields.join(","));
        self.text.push('\n');
        write_whole(&self.path, self.text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::statistics::{ErrorStatistics, Statistics};

    fn outcome(samples: u64) -> Outcome {
        let error = ErrorStatistics {
            pixels: 0.25,
            tiles: 0.125,
            film: 1.0,
            film_half_width: 0.02,
            film_error: 0.01,
            groups: 8,
        };
        let statistics = Statistics {
            samples,
            render_s: 2.0,
            setup_s: 0.5,
            b: Some((1.0, 0.01)),
            error: Some(error),
            ..Default::default()
        };
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [0.5; 3]] };
        Outcome { image, channels: vec![], uncertainty: None, statistics }
    }

    #[test]
    fn rows_are_whole_and_not_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let reference = Image { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] };
        let mut log = ErrorLog::new(path.clone(), Some(reference)).unwrap();
        let read = || std::fs::read_to_string(&path).unwrap();
        assert_eq!(read(), format!("{HEADER}\n"));
        for samples in [10, 20, 20] {
            log.row(&outcome(samples)).unwrap();
        }
        let text = read();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.split(',').count() == 11), "{text}");
        let numbers: Vec<f64> = lines[2].split(',').map(|field| field.parse().unwrap()).collect();
        assert_eq!(numbers[..9], [2.0, 2.5, 10.0, 0.25, 0.125, 1.0, 0.01, 0.125, 0.123762]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_not_known_is_left_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut log = ErrorLog::new(path.clone(), None).unwrap();
        let mut outcome = outcome(4);
        (outcome.statistics.b, outcome.statistics.error) = (None, None);
        log.row(&outcome).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().ends_with("\n2.00000e0,2.50000e0,2.00000e0,,,,,,,,\n"));
    }
}
