//! The pictures: zoomed and panned to the pixel, side by side where there are two, with the value under the cursor.

use eframe::egui::{self, Align2, Color32, PointerButton, Pos2, Rect, Sense, Ui, Vec2};

use super::app::Viewer;
use super::legend::{lacking, legend, pixel_values, text};
use super::overlay::{Overlay, Values};
use super::screen::Screen;
use crate::methods::Stage;

/// Largest and smallest zoom, in points per pixel.
const ZOOM: std::ops::RangeInclusive<f32> = 0.02..=200.0;
/// Turn of the camera per point that the mouse is dragged, in radians.
const TURN: f64 = 0.006;
/// Distance to the target per point that the mouse is dragged, or the wheel turned, as a power of e.
const DOLLY: f64 = 0.005;

/// Where the image is in its part of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Points per pixel; none fits the image.
    pub zoom: Option<f32>,
    /// From the middle of the part to the middle of the image, in points.
    pub offset: Vec2,
}

impl Placement {
    pub const FIT: Self = Self { zoom: None, offset: Vec2::ZERO };

    /// Points per pixel in a part of the window.
    pub fn scale(&self, part: Rect, size: Vec2) -> f32 {
        self.zoom.unwrap_or_else(|| (part.width() / size.x).min(part.height() / size.y).max(*ZOOM.start()))
    }

    fn rect(&self, part: Rect, size: Vec2) -> Rect {
        Rect::from_center_size(part.center() + self.offset, size * self.scale(part, size))
    }

    /// Zooms by a factor around a point that stays where it is.
    pub fn zoom_at(&mut self, part: Rect, size: Vec2, point: Pos2, factor: f32) {
        let old = self.scale(part, size);
        let new = (old * factor).clamp(*ZOOM.start(), *ZOOM.end());
        let arm = point - (part.center() + self.offset);
        self.offset += arm * (1.0 - new / old);
        self.zoom = Some(new);
    }
}

/// What is under the cursor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hovered {
    pub pixel: [u32; 2],
}

impl Viewer {
    /// The central part of the window.
    pub(super) fn canvas(&mut self, ui: &mut Ui) {
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let size = Vec2::new(self.settings.width as f32, self.settings.height as f32);
        let count = self.slots.len().max(1);
        let width = response.rect.width() / count as f32;
        let part = |slot: usize| {
            let left = response.rect.left() + slot as f32 * width;
            Rect::from_min_max(Pos2::new(left, response.rect.top()), Pos2::new(left + width, response.rect.bottom()))
        };
        let part_of = |point: Pos2| (((point.x - response.rect.left()) / width).max(0.0) as usize).min(count - 1);
        self.parts = (part(0), size);
        self.navigate(ui, &response, part_of, part, size);
        let overlay = self.overlay(ui);
        let max_side = ui.ctx().input(|i| i.max_texture_side);
        for slot in 0..self.slots.len() {
            let (part, placement, tone) = (part(slot), self.placement, self.tone);
            let painter = painter.with_clip_rect(part.shrink(1.0));
            let rect = placement.rect(part, size);
            let reference = self.reference.as_deref();
            let of = &mut self.slots[slot];
            if let Some((colors, version)) = of.colors(tone, overlay, reference, max_side) {
                // Pixels are sharp where they are large, except those of a preview, which are no pixels of the image.
                let enlarged = placement.scale(part, size) * ui.ctx().pixels_per_point() >= 1.0;
                let smooth = of.picture.preview || !enlarged;
                let seen = rect.intersect(painter.clip_rect());
                if seen.is_positive() {
                    let uv = |point: Pos2| ((point - rect.min) / rect.size()).to_pos2();
                    let part = Rect::from_min_max(uv(seen.min), uv(seen.max));
                    painter.add(Screen { slot, colors, version, smooth, part }.shape(seen));
                }
            }
            if let Some(image) = self.slots[slot].picture.image.as_deref().filter(|_| !self.slots[slot].picture.preview)
            {
                let shown = if overlay.reference && self.comparable() { reference.unwrap_or(image) } else { image };
                pixel_values(&painter, shown, rect, rect.intersect(painter.clip_rect()));
            }
            self.captions(&painter, part, slot, overlay);
        }
        self.hovered = response.hover_pos().and_then(|point| {
            let slot = part_of(point);
            let at = (point - self.placement.rect(part(slot), size).min) / self.placement.scale(part(slot), size);
            let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < size.x && at.y < size.y;
            inside.then_some(Hovered { pixel: [at.x as u32, at.y as u32] })
        });
        if ui.ctx().input(|i| !i.raw.hovered_files.is_empty()) {
            painter.rect_filled(response.rect, 0.0, Color32::from_black_alpha(160));
            let words = "drop a scene (.glb, .gltf), a sky (.hdr, .exr) or a reference (.exr)";
            text(&painter, response.rect.center(), Align2::CENTER_CENTER, words, 20.0);
        }
    }

    /// What the mouse does: the left button moves the image, the right one the camera.
    fn navigate(
        &mut self,
        ui: &Ui,
        response: &egui::Response,
        part_of: impl Fn(Pos2) -> usize,
        part: impl Fn(usize) -> Rect,
        size: Vec2,
    ) {
        let ctx = ui.ctx();
        let (modifiers, scroll, pinch) = ctx.input(|i| (i.modifiers, i.smooth_scroll_delta(), i.zoom_delta()));
        let drag = response.drag_delta();
        if response.dragged_by(PointerButton::Primary) {
            self.placement.zoom = Some(self.placement.scale(part(0), size));
            self.placement.offset += drag;
        }
        if response.double_clicked_by(PointerButton::Primary) {
            self.placement = Placement::FIT;
        }
        if let Some(point) = response.hover_pos() {
            if scroll.y != 0.0 && !modifiers.command {
                self.placement.zoom_at(part(part_of(point)), size, point, (0.005 * scroll.y).exp());
            }
            // What the system makes of the wheel with Ctrl, or of two fingers.
            if pinch != 1.0 {
                self.move_camera(|orbit| orbit.dolly(f64::from(1.0 / pinch)));
                self.still_at = Some(ctx.input(|i| i.time) + 0.25);
            }
        }
        let (x, y) = (f64::from(drag.x), f64::from(drag.y));
        let sideways = response.dragged_by(PointerButton::Middle)
            || (response.dragged_by(PointerButton::Secondary) && modifiers.shift);
        if drag != Vec2::ZERO {
            let height = f64::from(size.y * self.placement.scale(part(0), size));
            if sideways {
                self.move_camera(|orbit| orbit.pan(-x / height, y / height));
            } else if response.dragged_by(PointerButton::Secondary) && modifiers.command {
                self.move_camera(|orbit| orbit.dolly((DOLLY * y).exp()));
            } else if response.dragged_by(PointerButton::Secondary) {
                self.move_camera(|orbit| orbit.turn(-TURN * x, TURN * y));
            }
        }
        let held = response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle);
        if !held && self.still_at.is_none_or(|at| ctx.input(|i| i.time) >= at) {
            self.still_at = None;
            self.camera_is_still();
        }
    }

    /// What is written over a picture.
    fn captions(&self, painter: &egui::Painter, part: Rect, slot: usize, overlay: Overlay) {
        let of = &self.slots[slot];
        let at = part.left_top() + Vec2::new(10.0, 10.0);
        if self.slots.len() > 1 {
            text(painter, at, Align2::LEFT_TOP, of.settings.method.name(), 16.0);
        }
        let status = match (of.progress, of.picture.preview || of.picture.image.is_none()) {
            (Some((stage, share)), true) if stage < Stage::Rendering => {
                Some(format!("{} {:.0} %", stage.name(), 100.0 * share))
            }
            (_, true) if self.scene.is_some() => Some("starting".into()),
            _ => None,
        };
        if let Some(status) = status {
            let what = if of.picture.preview { " \u{2013} preview by path tracing" } else { "" };
            text(painter, part.left_bottom() + Vec2::new(10.0, -10.0), Align2::LEFT_BOTTOM, &(status + what), 14.0);
        }
        let at = part.right_bottom() + Vec2::new(-10.0, -10.0);
        if let Some(layer) = overlay.layer.filter(|_| !of.picture.preview && !overlay.reference) {
            if Values::of(layer, &of.picture, self.reference.as_deref()).is_some() {
                legend(painter, at, layer);
            } else if of.picture.image.is_some() {
                text(painter, at, Align2::RIGHT_BOTTOM, &lacking(layer, of, self.comparable()), 14.0);
            }
        }
        if overlay.reference && self.comparable() {
            text(painter, part.right_top() + Vec2::new(-10.0, 10.0), Align2::RIGHT_TOP, "reference", 16.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zooming_keeps_the_point_under_the_cursor() {
        let part = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(400.0, 300.0));
        let size = Vec2::new(640.0, 480.0);
        let mut placement = Placement::FIT;
        let point = Pos2::new(77.0, 140.0);
        let pixel = |p: &Placement| (point - p.rect(part, size).min) / p.scale(part, size);
        let before = pixel(&placement);
        placement.zoom_at(part, size, point, 3.0);
        assert!((pixel(&placement) - before).length() < 1e-2);
        assert!((placement.zoom.unwrap() - 3.0 * 0.625).abs() < 1e-4);
    }
}
