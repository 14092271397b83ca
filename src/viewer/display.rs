//! The bars at the edges, the panel at the side, and how the picture is shown.

use eframe::egui::{
    self, Button, CollapsingHeader, Color32, Frame, Panel, RichText, ScrollArea, Slider, SliderClamping, Ui,
};

use super::app::Viewer;
use super::canvas::Placement;
use super::slot::ErrorMap;
use super::tone::{Curve, Tone};
use crate::methods::Method;

/// For sentences that say what went wrong.
const ERROR: Color32 = Color32::from_rgb(255, 140, 110);

impl Viewer {
    /// What is needed most often.
    pub(super) fn top_bar(&mut self, ui: &mut Ui) {
        Panel::top("top").frame(bare(ui)).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (number, method) in [Method::Emlt, Method::Mlt, Method::Pt].into_iter().enumerate() {
                    let selected = self.settings.method == method;
                    let hint = format!("render by {} (key {})", method.name(), number + 1);
                    if ui.selectable_label(selected, method.name()).on_hover_text(hint).clicked() {
                        self.set_method(method);
                    }
                }
                ui.separator();
                let words = if self.paused { "Resume" } else { "Pause" };
                if ui.button(words).on_hover_text("Space").clicked() {
                    self.set_paused(!self.paused);
                }
                if ui.button("Restart").on_hover_text("begin anew").clicked() {
                    self.restart();
                }
                if ui.button("Save").on_hover_text("EXR and PNG into the current folder (Ctrl+S)").clicked() {
                    self.save();
                }
                let hint = "the emlt render that makes this image (Ctrl+Shift+C)";
                if ui.button("Copy command").on_hover_text(hint).clicked() {
                    self.copy_command_line(ui.ctx());
                }
                ui.separator();
                let fits = self.placement.zoom.is_none();
                if ui.add(Button::selectable(fits, "Fit")).on_hover_text("F").clicked() {
                    self.placement = Placement::FIT;
                }
                if ui.button("1:1").on_hover_text("a pixel is a pixel (Ctrl+0)").clicked() {
                    self.actual_size(&ui.ctx().clone());
                }
                ui.separator();
                ui.toggle_value(&mut self.show_maps, "Maps").on_hover_text("mutation-direction maps (M)");
                let mut error_map = |of: ErrorMap, name: &str, tip: &str| {
                    let shown = self.show_error == Some(of);
                    if ui.add(Button::selectable(shown, name)).on_hover_text(tip).clicked() {
                        self.show_error = (!shown).then_some(of);
                    }
                };
                error_map(ErrorMap::Own, "Own error", "relative error as the image tells it (W)");
                if self.reference.is_some() {
                    error_map(ErrorMap::Reference, "Error", "relative error against the reference (D)");
                }
                ui.separator();
                ui.toggle_value(&mut self.panels, "Panels").on_hover_text("Ctrl+B");
                ui.toggle_value(&mut self.help, "Keys").on_hover_text("?");
            });
        });
    }

    /// The value under the cursor, and the last sentence.
    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        Panel::bottom("status").frame(bare(ui)).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.monospace(self.under_the_cursor());
                let Some(note) = &self.note else { return };
                ui.separator();
                let text = RichText::new(&note.text);
                let label = egui::Label::new(if note.error { text.color(ERROR) } else { text }).truncate();
                let gone = note.error && ui.small_button("\u{d7}").on_hover_text("hide this message").clicked();
                ui.add(label).on_hover_text(&note.text);
                if gone {
                    self.note = None;
                }
            });
        });
    }

    /// Pixel, linear value and, where there is one, the reference's.
    fn under_the_cursor(&self) -> String {
        let zoom = self.placement.scale(self.parts.0, self.parts.1);
        let Some(hovered) = self.hovered else {
            let (w, h) = (self.settings.width, self.settings.height);
            return format!("{w} x {h}  {:.0} %", 100.0 * zoom);
        };
        let [x, y] = hovered.pixel;
        let place = format!("({x}, {y})");
        let Some(picture) = self.slots.get(hovered.slot).map(|slot| &slot.picture) else { return place };
        let Some(image) = picture.image.as_ref() else { return place };
        // A preview has fewer pixels than the image that it stands for.
        let scaled = |at: u32, side: u32, of: u32| (u64::from(at) * u64::from(side) / u64::from(of)) as u32;
        let (px, py) = (scaled(x, image.width, self.settings.width), scaled(y, image.height, self.settings.height));
        let index = (py * image.width + px) as usize;
        let Some([r, g, b]) = image.pixels.get(index) else { return place };
        let mut text = format!("{place}  {r:.4} {g:.4} {b:.4}");
        if let Some([r, g, b]) = self.reference.as_ref().filter(|_| self.comparable()).and_then(|i| i.pixels.get(index))
        {
            text += &format!("  reference {r:.4} {g:.4} {b:.4}");
        }
        text
    }

    /// Everything else, under headers that fold.
    pub(super) fn side_panel(&mut self, ui: &mut Ui) {
        let panel = Panel::right("side").frame(bare(ui)).default_size(330.0).size_range(260.0..=560.0);
        panel.show(ui, |ui| {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                section(ui, "Display", |ui| self.display(ui));
                section(ui, "Rendering", |ui| self.rendering(ui));
                section(ui, "Camera", |ui| self.camera(ui));
                section(ui, "Statistics", |ui| self.statistics(ui));
                section(ui, "Error over time", |ui| self.error_curve(ui));
                section(ui, "Scene", |ui| self.scene_facts(ui));
            });
        });
    }

    fn display(&mut self, ui: &mut Ui) {
        let before = self.tone;
        let tone = &mut self.tone;
        ui.add(
            Slider::new(&mut tone.exposure, -10.0..=10.0)
                .step_by(0.1)
                .clamping(SliderClamping::Edits)
                .text("exposure, stops"),
        );
        ui.add(Slider::new(&mut tone.offset, -1.0..=1.0).step_by(0.01).clamping(SliderClamping::Edits).text("offset"));
        ui.horizontal(|ui| {
            for curve in Curve::ALL {
                ui.selectable_value(&mut self.tone.curve, curve, curve.name());
            }
            ui.separator();
            if ui.button("Normalise").clicked() {
                self.normalise();
            }
            if ui.add_enabled(before != Tone::default(), Button::new("Reset")).clicked() {
                self.tone = Tone::default();
            }
        });
        ui.horizontal(|ui| {
            ui.checkbox(&mut self.show_maps, "direction maps");
            ui.add_enabled(self.show_maps, Slider::new(&mut self.maps_share, 0.05..=1.0).show_value(false));
        });
        if self.show_maps && self.slots.iter().all(|slot| slot.settings.method == Method::Pt) {
            ui.weak("Path tracing makes no mutations: choose emlt or mlt.");
        }
    }
}

/// A panel without a ground of its own: the window is cleared in its colour. A pixel that egui fills costs some 50 ns on a
/// software device, where both branches of its shader are worked through, and clearing costs nothing.
fn bare(ui: &Ui) -> Frame {
    Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT)
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, contents);
}
