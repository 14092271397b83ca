//! Keys, as tev has them where tev has them.

use eframe::egui::{self, Key, Modifiers, ViewportCommand};

use super::app::Viewer;
use super::canvas::Placement;
use super::overlay::Layer;
use super::tone::{Curve, Tone};
use crate::methods::Method;

/// What the help window shows, by subject.
pub const HELP: &[(&str, &[(&str, &str)])] = &[
    (
        "Image",
        &[
            ("E / Shift+E", "exposure up and down by half a stop"),
            ("O / Shift+O", "offset up and down by 0.1"),
            ("N", "normalise: smallest value black, largest white"),
            ("R", "reset exposure, offset and tone curve"),
            ("Shift+Right / Left", "next and previous tone curve"),
            ("F, Ctrl+9", "fit the image into the window"),
            ("Ctrl+0", "actual size: a pixel is a pixel"),
            ("+ / \u{2212}, wheel", "zoom"),
            ("drag, H J K L", "move the image; a double click fits it"),
            ("Shift (held)", "the reference"),
        ],
    ),
    (
        "Over the image",
        &[
            ("M", "mutation-direction maps"),
            ("A / Shift+A", "acceptance of the next and previous kernel"),
            ("W", "relative error as the image tells it of itself"),
            ("D", "relative error to the reference"),
        ],
    ),
    (
        "Camera",
        &[
            ("right drag", "orbit"),
            ("middle drag", "sideways, up and down"),
            ("Shift+right drag", "the same"),
            ("Ctrl+wheel", "nearer and farther"),
            ("Ctrl+right drag", "the same"),
            ("Home", "back to where the file has it"),
        ],
    ),
    (
        "Rendering",
        &[
            ("Space", "pause and resume"),
            ("1 / 2 / 3", "emlt, mlt, pt"),
            ("F5, Ctrl+R", "read the scene again and restart"),
            ("Ctrl+S", "save an EXR with its PNG preview"),
            ("Ctrl+Shift+C", "copy the emlt render command line"),
            ("Ctrl+B", "show and hide the panels"),
            ("?", "this help"),
            ("Ctrl+Q", "quit"),
        ],
    ),
];

/// Points that a key moves the image.
const STEP: f32 = 60.0;

impl Viewer {
    /// Does what the keys say, unless a text field wants them.
    pub(super) fn keys(&mut self, ctx: &egui::Context) {
        if ctx.egui_wants_keyboard_input() {
            return;
        }
        // The one with more modifiers comes first: a shortcut is also met with Shift held.
        let pressed = |modifiers, key| ctx.input_mut(|i| i.consume_key(modifiers, key));
        let (plain, shift, command) = (Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND);
        if pressed(command | shift, Key::C) {
            self.copy_command_line(ctx);
        }
        if pressed(command, Key::S) {
            self.save();
        }
        if pressed(command, Key::R) || pressed(plain, Key::F5) {
            self.reload();
        }
        if pressed(command, Key::B) {
            self.panels = !self.panels;
        }
        if pressed(command, Key::Q) {
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
        if pressed(command, Key::Num0) {
            self.actual_size(ctx);
        }
        if pressed(command, Key::Num9) || pressed(plain, Key::F) {
            self.placement = Placement::FIT;
        }
        self.tone_keys(&pressed);
        for (key, x, y) in [(Key::H, 1.0, 0.0), (Key::L, -1.0, 0.0), (Key::K, 0.0, 1.0), (Key::J, 0.0, -1.0)] {
            if pressed(plain, key) {
                self.placement.zoom = Some(self.placement.scale(self.parts.0, self.parts.1));
                self.placement.offset += STEP * egui::Vec2::new(x, y);
            }
        }
        for (keys, factor) in [([Key::Plus, Key::Equals], 1.25), ([Key::Minus, Key::Minus], 0.8)] {
            if keys.into_iter().any(|key| pressed(plain, key)) {
                let (part, size) = self.parts;
                self.placement.zoom_at(part, size, part.center(), factor);
            }
        }
        for (key, layer) in [(Key::M, Layer::Directions), (Key::D, Layer::ReferenceError), (Key::W, Layer::OwnError)] {
            if pressed(plain, key) {
                self.toggle(layer);
            }
        }
        for (modifiers, forwards) in [(shift, false), (plain, true)] {
            if pressed(modifiers, Key::A) {
                self.next_acceptance(forwards);
            }
        }
        if pressed(plain, Key::Home) {
            self.camera_home();
        }
        if pressed(plain, Key::Space) {
            self.set_paused(!self.paused);
        }
        for (key, method) in [(Key::Num1, Method::Emlt), (Key::Num2, Method::Mlt), (Key::Num3, Method::Pt)] {
            if pressed(plain, key) {
                self.set_method(method);
            }
        }
        if pressed(plain, Key::Questionmark) || pressed(shift, Key::Slash) {
            self.help = !self.help;
        }
        if pressed(plain, Key::Escape) {
            self.help = false;
        }
    }

    fn tone_keys(&mut self, pressed: &dyn Fn(Modifiers, Key) -> bool) {
        let (plain, shift) = (Modifiers::NONE, Modifiers::SHIFT);
        let tone = &mut self.tone;
        for (modifiers, sign) in [(shift, -1.0), (plain, 1.0)] {
            if pressed(modifiers, Key::E) {
                tone.exposure += 0.5 * sign;
            }
            if pressed(modifiers, Key::O) {
                tone.offset += 0.1 * sign;
            }
        }
        let at = Curve::ALL.iter().position(|curve| *curve == tone.curve).unwrap_or(0);
        for (key, step) in [(Key::ArrowRight, 1), (Key::ArrowLeft, Curve::ALL.len() - 1)] {
            if pressed(shift, key) {
                tone.curve = Curve::ALL[(at + step) % Curve::ALL.len()];
            }
        }
        if pressed(plain, Key::R) {
            *tone = Tone::default();
        }
        if pressed(plain, Key::N) {
            self.normalise();
        }
    }

    /// The tone that shows the first picture's whole range.
    pub(super) fn normalise(&mut self) {
        if let Some(image) = self.slots.first().and_then(|slot| slot.picture.image.as_ref()) {
            self.tone = self.tone.normalising(&image.pixels);
        }
    }

    /// A pixel of the image is a pixel of the screen.
    pub(super) fn actual_size(&mut self, ctx: &egui::Context) {
        self.placement = Placement { zoom: Some(1.0 / ctx.pixels_per_point()), offset: egui::Vec2::ZERO };
    }

    /// The help window, while it is open.
    pub(super) fn help_window(&mut self, ctx: &egui::Context) {
        let window = egui::Window::new("Keys and mouse").open(&mut self.help).collapsible(false).resizable(false);
        window.show(ctx, |ui| {
            let table = |ui: &mut egui::Ui, (subject, rows): &(&str, &[(&str, &str)])| {
                ui.strong(*subject);
                egui::Grid::new(*subject).num_columns(2).min_col_width(150.0).spacing([12.0, 4.0]).show(ui, |ui| {
                    for (keys, what) in *rows {
                        ui.monospace(*keys);
                        ui.label(*what);
                        ui.end_row();
                    }
                });
                ui.add_space(8.0);
            };
            ui.horizontal_top(|ui| {
                for column in HELP.chunks(HELP.len().div_ceil(2)) {
                    ui.vertical(|ui| column.iter().for_each(|part| table(ui, part)));
                    ui.add_space(16.0);
                }
            });
        });
    }
}
