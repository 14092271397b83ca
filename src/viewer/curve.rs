//! The error over the time of rendering: as the image tells it, and against the reference.

use eframe::egui::{Color32, Ui};
use egui_plot::{GridInput, GridMark, Legend, Line, LineStyle, Plot, PlotPoints};

use super::app::Viewer;

/// One a picture.
const COLORS: [Color32; 2] = [Color32::from_rgb(255, 176, 66), Color32::from_rgb(96, 176, 255)];

impl Viewer {
    pub(super) fn error_curve(&self, ui: &mut Ui) {
        if self.reference.is_none() {
            ui.weak("Each image's own estimate. Drop a reference (.exr) into the window to compare with it.");
        } else if !self.comparable() {
            ui.weak("The reference has another size than the image.");
        }
        // Both axes are logarithmic: the error of independent samples falls along a straight line then.
        let log = |x: f64| x.max(1e-12).log10();
        let line = |name: String, color: Color32, points: &mut dyn Iterator<Item = [f64; 2]>| {
            let seen = points.filter(|[_, error]| *error > 0.0 && error.is_finite());
            let points: Vec<[f64; 2]> = seen.map(|point| point.map(log)).collect();
            Line::new(name, PlotPoints::from(points)).color(color).width(2.0)
        };
        let mut lines: Vec<Line> = Vec::new();
        for (slot, color) in self.slots.iter().zip(COLORS) {
            let name = slot.settings.method.name();
            let own = line(format!("{name}, own estimate"), color, &mut slot.own_errors.iter().copied());
            lines.push(own.style(LineStyle::dashed_loose()).width(1.5));
            if self.comparable() {
                let measured = slot.errors.iter().map(|e| [e.seconds, e.rel_mse]);
                lines.push(line(format!("{name} to the reference"), color, &mut { measured }));
            }
        }
        let power =
            |x: f64| if (0.01..10_000.0).contains(&10f64.powf(x)) { plain(10f64.powf(x)) } else { format!("1e{x:.0}") };
        if self.slots.iter().all(|slot| slot.errors.is_empty() && slot.own_errors.is_empty()) {
            ui.weak("None is known yet.");
            return;
        }
        Plot::new("error")
            .height(190.0)
            .legend(Legend::default())
            .allow_scroll(false)
            .allow_zoom(false)
            .allow_drag(false)
            .allow_boxed_zoom(false)
            .x_axis_label("seconds")
            .y_axis_label("relMSE")
            .x_grid_spacer(decades)
            .y_grid_spacer(decades)
            .x_axis_formatter(move |mark, _| power(mark.value))
            .y_axis_formatter(move |mark, _| power(mark.value))
            .show(ui, |plot| lines.into_iter().for_each(|line| plot.line(line)));
    }
}

/// Lines at 1, 2 and 5 of every decade, and finer ones between.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let mark = |decade: i32, digit: i32| {
        let step_size = match digit {
            1 => 1.0,
            2 | 5 => 0.3,
            _ => 0.1,
        };
        GridMark { value: f64::from(decade) + f64::from(digit).log10(), step_size }
    };
    // The plot may be far out while it has no points.
    let decades = low.floor().max(-40.0) as i32..=high.ceil().min(40.0) as i32;
    let marks = decades.flat_map(|decade| (1..=9).map(move |digit| mark(decade, digit)));
    marks.filter(|mark| mark.value >= low && mark.value <= high).collect()
}

/// With two digits that count.
fn plain(x: f64) -> String {
    let digits = (1.0 - x.log10().floor()).max(0.0) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_divided_at_2_and_5() {
        let marks = decades(GridInput { bounds: (-0.1, 1.05), base_step_size: 0.1 });
        let values: Vec<f64> = marks.iter().filter(|m| m.step_size > 0.2).map(|m| 10f64.powf(m.value)).collect();
        assert_eq!(values.len(), 4);
        assert!(values.iter().zip([1.0, 2.0, 5.0, 10.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{values:?}");
    }

    #[test]
    fn numbers_have_two_digits() {
        for (x, text) in [(0.012345, "0.012"), (1.0, "1.0"), (3.1623, "3.2"), (100.0, "100")] {
            assert_eq!(plain(x), text);
        }
    }
}
