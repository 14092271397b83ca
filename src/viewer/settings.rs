//! Settings that restart the render.

use eframe::egui::{ComboBox, DragValue, Grid, Id, Slider, SliderClamping, Ui};

use super::app::Viewer;
use super::command_line::mix_words;
use super::display::grid;
use crate::ensemble::guidance::{Guidance, MOST_GUIDES};
use crate::ensemble::mix::Mix;
use crate::ensemble::pool::MAX_EDGES;
use crate::kernels::{self, Kernel};
use crate::methods::{Direct, MAX_SIDE, Method, default_mix};
use crate::scene::Features;

/// A row of a grid: a name, and what it names, which is given the name's id.
fn setting(ui: &mut Ui, name: &str, hint: &str, contents: impl FnOnce(&mut Ui, Id) -> bool) -> bool {
    let id = ui.label(name).on_hover_text(hint).id;
    let changed = contents(ui, id);
    ui.end_row();
    changed
}

impl Viewer {
    /// What and how to render.
    pub(super) fn rendering(&mut self, ui: &mut Ui) {
        let mut changed = false;
        let chains = self.settings.method != Method::Pt;
        grid("rendering").show(ui, |ui| {
            let hint = "renders side by side with the first, in equal time";
            changed |= setting(ui, "second method", hint, |ui, name| self.beside(ui, name));
            changed |= setting(ui, "size", "pixels (--size)", |ui, name| self.size(ui, name));
            let settings = &mut self.settings;
            changed |= setting(ui, "longest path", "edges from camera to light (--max-depth)", |ui, name| {
                ui.add(Slider::new(&mut settings.max_depth, 1..=MAX_EDGES)).labelled_by(name).changed()
            });
            changed |= setting(ui, "seed", "another one is an independent image (--seed)", |ui, name| {
                ui.add(DragValue::new(&mut settings.seed).speed(0.1)).labelled_by(name).changed()
            });
            if !chains {
                return;
            }
            changed |= setting(ui, "ensemble", "paths that move together (--ensemble)", |ui, name| {
                let mut changed = false;
                let choice = ComboBox::from_id_salt("ensemble").selected_text(settings.ensemble.to_string());
                let choice = choice.show_ui(ui, |ui| {
                    for paths in (10..=18).map(|n| 1u32 << n) {
                        changed |= ui.selectable_value(&mut settings.ensemble, paths, paths.to_string()).changed();
                    }
                });
                choice.response.labelled_by(name);
                changed
            });
            changed |= setting(ui, "direct light", "who renders it (--direct)", |ui, _| {
                let mut changed = false;
                ui.horizontal(|ui| {
                    for (direct, words) in
                        [(Direct::Mcmc, "chains"), (Direct::Pt, "path traced"), (Direct::Auto, "auto")]
                    {
                        changed |= ui.selectable_value(&mut settings.direct, direct, words).changed();
                    }
                });
                changed
            });
            changed |= setting(ui, "two stages", "more samples for dark parts (--two-stage)", |ui, name| {
                self.two_stage(ui, name)
            });
            if self.settings.method == Method::Emlt {
                changed |= setting(ui, "guides", "that a guided kernel looks at (--guides)", |ui, name| {
                    let guides = Slider::new(&mut self.settings.guidance.guides, 1..=MOST_GUIDES);
                    ui.add(guides).labelled_by(name).changed()
                });
                let hint = "size of guided steps in spreads of the guides (--alpha)";
                changed |= setting(ui, "guided steps", hint, |ui, name| self.alpha(ui, name));
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
    fn beside(&mut self, ui: &mut Ui, name: Id) -> bool {
        let mut changed = false;
        let text = self.second.map_or("none", Method::name);
        let choice = ComboBox::from_id_salt("beside").selected_text(text).show_ui(ui, |ui| {
            changed |= ui.selectable_value(&mut self.second, None, "none").changed();
            for method in [Method::Emlt, Method::Mlt, Method::Pt] {
                if method != self.settings.method {
                    changed |= ui.selectable_value(&mut self.second, Some(method), method.name()).changed();
                }
            }
        });
        choice.response.labelled_by(name);
        changed
    }

    fn size(&mut self, ui: &mut Ui, name: Id) -> bool {
        let mut changed = false;
        ui.horizontal(|ui| {
            let side = |n| DragValue::new(n).range(1..=MAX_SIDE).speed(1.0);
            changed |= ui.add(side(&mut self.settings.width)).labelled_by(name).changed();
            let by = ui.label("\u{d7}").id;
            changed |= ui.add(side(&mut self.settings.height)).labelled_by(by).changed();
        });
        self.own_size |= changed;
        changed
    }

    fn two_stage(&mut self, ui: &mut Ui, name: Id) -> bool {
        let mut changed = false;
        ui.horizontal(|ui| {
            let mut on = self.settings.two_stage.is_some();
            let words = if on { "" } else { "off" };
            if ui.checkbox(&mut on, words).labelled_by(name).changed() {
                self.settings.two_stage = on.then_some(0.5);
                changed = true;
            }
            if let Some(gamma) = &mut self.settings.two_stage {
                let slider = Slider::new(gamma, 0.0..=1.0).step_by(0.05).clamping(SliderClamping::Edits);
                changed |= ui.add(slider).labelled_by(name).changed();
            }
        });
        changed
    }

    /// The size of guided steps: by similarity, or the same for all.
    fn alpha(&mut self, ui: &mut Ui, name: Id) -> bool {
        let usual = Guidance::default().alpha;
        let mut changed = false;
        ui.horizontal(|ui| {
            let mut same = self.settings.guidance.alpha != usual;
            let words = if same { "" } else { "by similarity" };
            if ui.checkbox(&mut same, words).labelled_by(name).changed() {
                self.settings.guidance.alpha = if same { [usual[1]; 2] } else { usual };
                changed = true;
            }
            if same {
                let mut alpha = self.settings.guidance.alpha[1];
                let slider = Slider::new(&mut alpha, 0.01..=1.0).step_by(0.01).clamping(SliderClamping::Edits);
                changed |= ui.add(slider).labelled_by(name).changed();
                self.settings.guidance.alpha = [alpha; 2];
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
                    let name = ui.label(kernel.name).on_hover_text(&hint).id;
                    let slider = Slider::new(weight, 0.0..=1.0).step_by(0.05).clamping(SliderClamping::Edits);
                    changed |=
                        ui.add_enabled(useless.is_none(), slider).labelled_by(name).on_hover_text(hint).changed();
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
            let label = ui.label("of the file").id;
            let choice = ComboBox::from_id_salt("camera").selected_text(&name).show_ui(ui, |ui| {
                for (number, other) in names.iter().enumerate() {
                    if ui.selectable_label(*other == name, other).clicked() {
                        chosen = Some(number);
                    }
                }
            });
            choice.response.labelled_by(label);
            let hint = "back to where the file has it (Home)";
            if look.is_some() && ui.button("Back").on_hover_text(hint).clicked() {
                self.camera_home();
            }
        });
        if let Some((eye, target)) = look {
            ui.monospace(format!("from {:.3} {:.3} {:.3}", eye.x, eye.y, eye.z));
            ui.monospace(format!("at   {:.3} {:.3} {:.3}", target.x, target.y, target.z));
        } else {
            ui.weak("Right drag: orbit. Middle drag: sideways. Ctrl+wheel: nearer.");
        }
        if let Some(number) = chosen {
            self.choose_camera(number);
        }
    }
}
