//! The figures: how fast, how good, by what.

use eframe::egui::{Align, Grid, Label, Layout, Response, RichText, Ui, Vec2, WidgetText};

use super::app::Viewer;
use super::display::grid;
use super::slot::Slot;
use crate::kernels;
use crate::methods::Method;
use crate::report::summary::{grouped, million_per_second, mixing_rows, peak_memory_bytes};

/// Between the rows and columns of figures.
const TIGHT: [f32; 2] = [12.0, 2.0];

impl Viewer {
    pub(super) fn statistics(&self, ui: &mut Ui) {
        let slots: Vec<&Slot> = self.slots.iter().collect();
        if slots.iter().all(|slot| slot.picture.image.is_none() || slot.picture.preview) {
            ui.weak("none before the first image");
        }
        for (number, slot) in slots.into_iter().enumerate().filter(|(_, slot)| !slot.picture.preview) {
            if slot.picture.image.is_some() {
                figures(ui, number, slot);
                kernel_table(ui, number, slot);
            }
        }
        grid("interface").spacing(TIGHT).show(ui, |ui| {
            let mut row = row(ui);
            if let Some(bytes) = peak_memory_bytes() {
                row("memory", format!("{:.0} MiB at its peak", bytes as f64 / f64::from(1 << 20)));
            }
            let pace = self.pace;
            row("interface", format!("{:.1} ms a frame, at most {:.0} ms", 1e3 * pace.work_s, 1e3 * pace.longest_s));
        });
    }

    /// What is in the scene, and what it needs.
    pub(super) fn scene_facts(&self, ui: &mut Ui) {
        let Some(scene) = &self.scene else {
            ui.weak("no scene yet");
            return;
        };
        grid("scene").spacing(TIGHT).show(ui, |ui| {
            let mut row = row(ui);
            row("file", scene.path.display().to_string());
            row("triangles", grouped(scene.triangles as u64));
            let on: Vec<&str> = scene.features.flags().iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect();
            row("features", if on.is_empty() { "diffuse only".into() } else { on.join(", ") });
            let useful = kernels::ALL.iter().filter(|k| (k.useless)(scene.features).is_none());
            row("usable", useful.map(|k| k.name).collect::<Vec<_>>().join(", "));
        });
        for warning in &scene.warnings {
            ui.colored_label(ui.visuals().warn_fg_color, warning);
        }
    }
}

/// Adds rows of a name and a value to a grid.
fn row(ui: &mut Ui) -> impl FnMut(&str, String) + '_ {
    |name, value| {
        ui.label(name);
        ui.add(Label::new(value).wrap());
        ui.end_row();
    }
}

/// A cell of a grid, aligned to the right. It has a width of its own: one that filled what there is would widen the panel
/// from frame to frame.
fn figure(ui: &mut Ui, text: impl Into<WidgetText>) -> Response {
    const SIZE: Vec2 = Vec2::new(58.0, 18.0);
    let cell = ui.allocate_ui_with_layout(SIZE, Layout::right_to_left(Align::Center), |ui| {
        ui.set_min_width(SIZE.x);
        ui.label(text)
    });
    cell.inner
}

fn figures(ui: &mut Ui, number: usize, slot: &Slot) {
    let s = &slot.picture.statistics;
    let method = slot.settings.method;
    ui.strong(method.name());
    grid(&format!("figures {number}")).spacing(TIGHT).show(ui, |ui| {
        let mut row = row(ui);
        let pixels = f64::from(slot.settings.width) * f64::from(slot.settings.height);
        let what = if method == Method::Pt { "samples" } else { "mutations" };
        row(what, format!("{} ({:.1} a pixel)", grouped(s.samples), s.samples as f64 / pixels));
        row("rate", million_per_second(s.samples, s.render_s));
        if s.path_traced_samples > 0 {
            row("path traced", format!("{:.1} samples a pixel", s.path_traced_samples as f64 / pixels));
        }
        row("rays", million_per_second(s.rays, s.seeding_s + s.render_s));
        if let Some((b, error)) = s.b {
            row("b", format!("{b:.5} \u{b1} {:.2} %", 100.0 * error / b));
        }
        if let Some(own) = &slot.picture.own {
            row("own error", format!("{:.1} % a pixel", 100.0 * own.relative));
        }
        if let Some(last) = slot.errors.last() {
            row("relMSE", format!("{:.4} a pixel, {:.4} of 4x4", last.rel_mse, last.rel_mse_blocks));
        }
        for (name, text) in s.mixing.iter().flat_map(mixing_rows) {
            row(name, text);
        }
        row("time", format!("{:.1} s, and {:.1} s to start", s.render_s, s.setup_s + s.compile_s + s.seeding_s));
        row("device", s.device.clone());
    });
    for note in &s.notes {
        ui.colored_label(ui.visuals().warn_fg_color, note);
    }
}

fn kernel_table(ui: &mut Ui, number: usize, slot: &Slot) {
    let kernels = &slot.picture.statistics.kernels;
    if kernels.is_empty() {
        return;
    }
    let total: u64 = kernels.iter().map(|k| k.mutations).sum();
    Grid::new(("kernels", number)).num_columns(5).striped(true).spacing(TIGHT).show(ui, |ui| {
        ui.strong("kernel");
        for (title, hint) in [
            ("share", "of all mutations"),
            ("accepted", "of its own mutations"),
            ("jump, px\u{b2}", "mean squared jump on the film"),
            ("million/s", "mutations, by the device's clock"),
        ] {
            figure(ui, RichText::new(title).strong()).on_hover_text(hint);
        }
        ui.end_row();
        for k in kernels {
            let percent = |part: u64, of: u64| 100.0 * part as f64 / of.max(1) as f64;
            ui.label(&k.name);
            figure(ui, format!("{:.1} %", percent(k.mutations, total)));
            figure(ui, format!("{:.1} %", percent(k.accepted, k.mutations)));
            figure(ui, format!("{:.1}", k.mean_squared_jump_px2));
            figure(ui, k.device_s.map_or("-".into(), |s| format!("{:.2}", k.mutations as f64 / s / 1e6)));
            ui.end_row();
        }
    });
}
