//! Settings that restart the render.

use eframe::egui::{ComboBox, DragValue, Grid, Slider, SliderClamping, Ui};

use super::app::Viewer;
use super::command_line::mix_words;
use crate::ensemble::guidance::{Guidance, MOST_GUIDES};
use crate::ensemble::mix::Mix;
use crate::kernels::{self, Kernel};
use crate::methods::{Direct, MAX_SIDE, Method, default_mix};
use crate::scene::Features;

impl Viewer {
    /// What and how to render.
    pub(super) fn rendering(&mut self, ui: &mut Ui) {
        let mut changed = false;
        let chains = self.settings.method != Method::Pt;
        Grid::new("rendering").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
            ui.label("beside it");
            changed |= self.beside(ui);
            ui.end_row();
            ui.label("size");
            ui.horizontal(|ui| {
                let width = ui.add(DragValue::new(&mut self.settings.width).range(1..=MAX_SIDE).speed(1.0));
                ui.label("x");
                let height = ui.add(DragValue::new(&mut self.settings.height).range(1..=MAX_SIDE).speed(1.0));
                if width.changed() || height.changed() {
                    self.own_size = true;
                    changed = true;
                }
            });
            ui.end_row();
            ui.label("longest path");
            let depth = Slider::new(&mut self.settings.max_depth, 1..=31);
            changed |= ui.add(depth).on_hover_text("edges from camera to light (--max-depth)").changed();
            ui.end_row();
            ui.label("seed");
            changed |= ui.add(DragValue::new(&mut self.settings.seed).speed(0.1)).changed();
            ui.end_row();
            if chains {
                ui.label("ensemble");
                ComboBox::from_id_salt("ensemble").selected_text(self.settings.ensemble.to_string()).show_ui(
                    ui,
                    |ui| {
                        for paths in (10..=18).map(|n| 1u32 << n) {
                            let choice = ui.selectable_value(&mut self.settings.ensemble, paths, paths.to_string());
                            changed |= choice.changed();
                        }
                    },
                );
                ui.end_row();
                ui.label("direct light");
                ui.horizontal(|ui| {
                    for (direct, words) in [(Direct::Mcmc, "by the chains"), (Direct::Pt, "by pt")] {
                        changed |= ui.selectable_value(&mut self.settings.direct, direct, words).changed();
                    }
                });
                ui.end_row();
                ui.label("two stages");
                changed |= self.two_stage(ui);
                ui.end_row();
                if self.settings.method == Method::Emlt {
                    ui.label("guides");
                    let guides = Slider::new(&mut self.settings.guidance.guides, 1..=MOST_GUIDES);
                    changed |= ui.add(guides).on_hover_text("that a guided kernel looks at (--guides)").changed();
                    ui.end_row();
                    ui.label("guided steps");
                    changed |= self.alpha(ui);
                    ui.end_row();
                }
            }
        });
        if chains {
            changed |= self.mix(ui);
        }
        if changed {
            self.changed(ui.ctx());
        }
    }

    /// A second method, in equal time.
    fn beside(&mut self, ui: &mut Ui) -> bool {
        let mut changed = false;
        let text = self.second.map_or("nothing", Method::name);
        ComboBox::from_id_salt("beside").selected_text(text).show_ui(ui, |ui| {
            changed |= ui.selectable_value(&mut self.second, None, "nothing").changed();
            for method in [Method::Emlt, Method::Mlt, Method::Pt] {
                if method != self.settings.method {
                    changed |= ui.selectable_value(&mut self.second, Some(method), method.name()).changed();
                }
            }
        });
        changed
    }

    fn two_stage(&mut self, ui: &mut Ui) -> bool {
        let mut changed = false;
        ui.horizontal(|ui| {
            let mut on = self.settings.two_stage.is_some();
            if ui.checkbox(&mut on, "").on_hover_text("more samples for dark parts (--two-stage)").changed() {
                self.settings.two_stage = on.then_some(0.5);
                changed = true;
            }
            if let Some(gamma) = &mut self.settings.two_stage {
                changed |=
                    ui.add(Slider::new(gamma, 0.0..=1.0).step_by(0.05).clamping(SliderClamping::Edits)).changed();
            }
        });
        changed
    }

    /// The size of guided steps: by similarity, or the same for all.
    fn alpha(&mut self, ui: &mut Ui) -> bool {
        let usual = Guidance::default().alpha;
        let mut changed = false;
        ui.horizontal(|ui| {
            let mut same = self.settings.guidance.alpha != usual;
            if ui.checkbox(&mut same, "").on_hover_text("the same for all (--alpha)").changed() {
                self.settings.guidance.alpha = if same { [usual[1]; 2] } else { usual };
                changed = true;
            }
            if same {
                let mut alpha = self.settings.guidance.alpha[1];
                changed |=
                    ui.add(Slider::new(&mut alpha, 0.01..=1.0).step_by(0.01).clamping(SliderClamping::Edits)).changed();
                self.settings.guidance.alpha = [alpha; 2];
            } else {
                ui.weak("by similarity");
            }
        });
        changed
    }

    /// The weights of the kernels; the method's own mix until one is changed.
    fn mix(&mut self, ui: &mut Ui) -> bool {
        let features = self.scene.as_ref().map_or(Features::default(), |scene| scene.features);
        let usual = default_mix(self.settings.method);
        let now = self.settings.kernels.clone().unwrap_or_else(|| usual.clone());
        let mut weights: Vec<(&'static Kernel, f64)> = kernels::ALL
            .into_iter()
            .map(|kernel| (kernel, now.iter().find(|(k, _)| k.name == kernel.name).map_or(0.0, |(_, weight)| *weight)))
            .collect();
        let mut changed = false;
        ui.collapsing("Kernel mix", |ui| {
            Grid::new("mix").num_columns(2).spacing([12.0, 2.0]).show(ui, |ui| {
                for (kernel, weight) in &mut weights {
                    let useless = (kernel.useless)(features);
                    let hint = useless.map_or(kernel.about.to_string(), |why| format!("{}: {why}", kernel.about));
                    ui.label(kernel.name).on_hover_text(&hint);
                    let slider = Slider::new(weight, 0.0..=1.0).step_by(0.05).clamping(SliderClamping::Edits);
                    changed |= ui.add_enabled(useless.is_none(), slider).on_hover_text(hint).changed();
                    ui.end_row();
                }
            });
            if self.settings.kernels.is_some() && ui.button("The method's own mix").clicked() {
                self.settings.kernels = None;
                self.mix_error = None;
                self.changed(ui.ctx());
            }
        });
        if let Some(error) = &self.mix_error {
            ui.colored_label(ui.visuals().warn_fg_color, error);
        }
        if !changed {
            return false;
        }
        weights.retain(|(_, weight)| *weight > 0.0);
        // The same rules as on the command line; a mix that breaks them is not rendered.
        match Mix::parse(&mix_words(&weights)) {
            Ok(mix) => {
                self.settings.kernels = Some(mix);
                self.mix_error = None;
                true
            }
            Err(error) => {
                self.mix_error = Some(error.to_string());
                false
            }
        }
    }

    /// Which camera, and where it has been moved.
    pub(super) fn camera(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else {
            ui.weak("no scene yet");
            return;
        };
        let names: Vec<String> = scene.cameras.iter().map(|camera| camera.name.clone()).collect();
        let Some(orbit) = &self.orbit else { return };
        let (name, look) = (orbit.name().to_string(), orbit.look());
        let mut chosen = None;
        ui.horizontal(|ui| {
            ComboBox::from_id_salt("camera").selected_text(&name).show_ui(ui, |ui| {
                for (number, other) in names.iter().enumerate() {
                    if ui.selectable_label(*other == name, other).clicked() {
                        chosen = Some(number);
                    }
                }
            });
            let hint = "back to where the file has it (Home)";
            if look.is_some() && ui.button("Back").on_hover_text(hint).clicked() {
                self.camera_home();
            }
        });
        if let Some((eye, target)) = look {
            ui.monospace(format!("from {:.3} {:.3} {:.3}", eye.x, eye.y, eye.z));
            ui.monospace(format!("at   {:.3} {:.3} {:.3}", target.x, target.y, target.z));
        } else {
            ui.weak("right drag: orbit   middle drag: sideways   Ctrl+wheel: nearer");
        }
        if let Some(number) = chosen {
            self.choose_camera(number);
        }
    }
}
