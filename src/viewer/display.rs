//! The bars at the edges, the panel at the side, and how the picture is shown.

use eframe::egui::{
    self, Button, CollapsingHeader, Color32, ComboBox, Frame, Panel, RichText, ScrollArea, Slider, SliderClamping, Ui,
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
        let values = self.layer.and_then(|layer| Values::of(layer, picture, self.reference.as_deref()));
        if let Some(share) = values.and_then(|values| values.share(index)) {
            text += &format!("  {:.1} %", 100.0 * share);
        }
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
        self.overlay_choice(ui);
    }

    /// What lies over the pictures, and how opaque.
    fn overlay_choice(&mut self, ui: &mut Ui) {
        let mut layers = vec![None, Some(Layer::Directions)];
        layers.extend(self.kernels_at_work().into_iter().map(|kernel| Some(Layer::Acceptance(kernel))));
        layers.push(Some(Layer::OwnError));
        layers.extend(self.reference.is_some().then_some(Some(Layer::ReferenceError)));
        let name = |layer: Option<Layer>| layer.map_or("nothing".into(), Layer::name);
        ui.horizontal(|ui| {
            let label = ui.label("over it").id;
            let choice = ComboBox::from_id_salt("overlay").selected_text(name(self.layer)).width(190.0);
            let choice = choice.show_ui(ui, |ui| {
                for layer in layers {
                    if ui.selectable_label(self.layer == layer, name(layer)).clicked() {
                        match layer {
                            Some(layer) => self.look_at(layer),
                            None => self.layer = None,
                        }
                    }
                }
            });
            choice.response.labelled_by(label);
        });
        if let Some(layer) = self.layer {
            let share = Slider::new(&mut self.shares[layer.kind()], 0.0..=1.0).show_value(false);
            ui.add(share.text("its share in what is seen"));
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
