//! The bars at the edges, the panel at the side, and how the picture is shown.

use eframe::egui::{
    self, Button, CollapsingHeader, Color32, ComboBox, Frame, Grid, Panel, RichText, ScrollArea, Slider,
    SliderClamping, Ui,
};

use super::app::Viewer;
use super::canvas::Placement;
use super::overlay::{Layer, Values};
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
                let mut toggle = |shown: bool, name: &str, tip: &str| {
                    ui.add(Button::selectable(shown, name)).on_hover_text(tip).clicked()
                };
                let now = self.layer;
                let shows = |layer| now == Some(layer);
                if toggle(shows(Layer::Directions), "Directions", "where accepted mutations move (M)") {
                    self.toggle(Layer::Directions);
                }
                let accepted = matches!(now, Some(Layer::Acceptance(_)));
                if toggle(accepted, "Acceptance", "share of a kernel's proposals that is accepted (A)") {
                    self.toggle_acceptance();
                }
                if toggle(shows(Layer::OwnError), "Own error", "relative error as the image tells it (W)") {
                    self.toggle(Layer::OwnError);
                }
                if self.reference.is_some()
                    && toggle(shows(Layer::ReferenceError), "Error", "relative error to the reference (D)")
                {
                    self.toggle(Layer::ReferenceError);
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
                let gone = note.error && ui.small_button("Hide").clicked();
                // What went wrong is to be read in full.
                let label = if note.error {
                    egui::Label::new(RichText::new(&note.text).color(ERROR)).wrap()
                } else {
                    egui::Label::new(&note.text).truncate()
                };
                ui.add(label);
                if gone {
                    self.note = None;
                }
            });
        });
    }

    /// Zoom, pixel, and linear values there: of every picture, with what the overlay tells, and of the reference.
    fn under_the_cursor(&self) -> String {
        let zoom = format!("{:.0} %", 100.0 * self.placement.scale(self.parts.0, self.parts.1));
        let (width, height) = (self.settings.width, self.settings.height);
        let Some(hovered) = self.hovered else { return format!("{zoom}  {width} x {height}") };
        let [x, y] = hovered.pixel;
        let mut text = format!("{zoom}  ({x}, {y})");
        for slot in &self.slots {
            let picture = &slot.picture;
            let Some(image) = picture.image.as_ref() else { continue };
            // A preview has fewer pixels than the image that it stands for.
            let scaled = |at: u32, side: u32, of: u32| (u64::from(at) * u64::from(side) / u64::from(of)) as u32;
            let index = scaled(y, image.height, height) * image.width + scaled(x, image.width, width);
            let Some([r, g, b]) = image.pixels.get(index as usize) else { continue };
            if self.slots.len() > 1 {
                text += &format!("  {}", slot.settings.method.name());
            }
            text += &format!("  {r:.4} {g:.4} {b:.4}");
            let values = self.layer.and_then(|layer| Values::of(layer, picture, self.reference.as_deref()));
            if let Some(share) = values.and_then(|values| values.share(index as usize)) {
                text += &format!("  {:.1} %", 100.0 * share);
            }
        }
        let reference = self.reference.as_ref().filter(|_| self.comparable());
        if let Some([r, g, b]) = reference.and_then(|image| image.pixels.get((y * width + x) as usize)) {
            text += &format!("  reference  {r:.4} {g:.4} {b:.4}");
        }
        text
    }

    /// Everything else, under headers that fold.
    pub(super) fn side_panel(&mut self, ui: &mut Ui) {
        let panel = Panel::right("side").frame(bare(ui)).default_size(345.0).size_range(260.0..=560.0);
        panel.show(ui, |ui| {
            // Room for the bar beside what is scrolled.
            ui.spacing_mut().scroll.floating_allocated_width = 10.0;
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
        grid("display").show(ui, |ui| {
            let tone = &mut self.tone;
            let name = ui.label("exposure").on_hover_text("stops (E)").id;
            let exposure = Slider::new(&mut tone.exposure, -10.0..=10.0).step_by(0.1);
            ui.add(exposure.clamping(SliderClamping::Edits)).labelled_by(name);
            ui.end_row();
            let name = ui.label("offset").on_hover_text("added after the exposure (O)").id;
            let offset = Slider::new(&mut tone.offset, -1.0..=1.0).step_by(0.01);
            ui.add(offset.clamping(SliderClamping::Edits)).labelled_by(name);
            ui.end_row();
            ui.label("tone curve").on_hover_text("Shift+Right, Shift+Left");
            ui.horizontal(|ui| {
                for curve in Curve::ALL {
                    ui.selectable_value(&mut tone.curve, curve, curve.name());
                }
            });
            ui.end_row();
            ui.label("");
            ui.horizontal(|ui| {
                if ui.button("Normalise").on_hover_text("smallest value black, largest white (N)").clicked() {
                    self.normalise();
                }
                let reset = Button::new("Reset");
                if ui.add_enabled(self.tone != Tone::default(), reset).on_hover_text("R").clicked() {
                    self.tone = Tone::default();
                }
            });
            ui.end_row();
            self.overlay_choice(ui);
        });
    }

    /// What lies over the pictures, and how opaque: two rows of a grid.
    fn overlay_choice(&mut self, ui: &mut Ui) {
        let mut layers = vec![None, Some(Layer::Directions)];
        layers.extend(self.kernels_at_work().into_iter().map(|kernel| Some(Layer::Acceptance(kernel))));
        layers.push(Some(Layer::OwnError));
        layers.extend(self.reference.is_some().then_some(Some(Layer::ReferenceError)));
        let text = |layer: Option<Layer>| layer.map_or("none".into(), Layer::name);
        let name = ui.label("overlay").on_hover_text("M, A, W, D").id;
        let choice = ComboBox::from_id_salt("overlay").selected_text(text(self.layer)).width(200.0);
        let choice = choice.show_ui(ui, |ui| {
            for layer in layers {
                if ui.selectable_label(self.layer == layer, text(layer)).clicked() {
                    match layer {
                        Some(layer) => self.look_at(layer),
                        None => self.layer = None,
                    }
                }
            }
        });
        choice.response.labelled_by(name);
        ui.end_row();
        if let Some(layer) = self.layer {
            let name = ui.label("opacity").on_hover_text("of the overlay; the image shows through").id;
            ui.add(Slider::new(&mut self.shares[layer.kind()], 0.0..=1.0).step_by(0.05)).labelled_by(name);
            ui.end_row();
        }
    }
}

/// The grid of a section: names, all as wide in every section, and values.
pub fn grid(id: &str) -> Grid {
    Grid::new(id).num_columns(2).min_col_width(92.0).spacing([12.0, 4.0])
}

/// A panel without a ground of its own: the window is cleared in its colour. A pixel that egui fills costs some 50 ns on a
/// software device, where both branches of its shader are worked through, and clearing costs nothing.
fn bare(ui: &Ui) -> Frame {
    Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT)
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, contents);
}
