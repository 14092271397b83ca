//! What the colours of an overlay mean, and words over the picture.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Stroke, StrokeKind, Vec2};

use super::overlay::{Layer, UNKNOWN, heat};
use super::slot::Slot;
use crate::film::Image;
use crate::film::png::direction_color;
use crate::methods::Method;

/// Light text on a dark ground, so that it is legible over any picture.
pub fn text(painter: &egui::Painter, at: Pos2, anchor: Align2, words: &str, size: f32) {
    let galley = painter.layout_no_wrap(words.into(), FontId::proportional(size), Color32::from_gray(235));
    let rect = anchor.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 4.0, Color32::from_black_alpha(170));
    painter.galley(rect.min, galley, Color32::WHITE);
}

/// The legend of a layer, with its lower right corner at `corner`.
pub fn legend(painter: &egui::Painter, corner: Pos2, layer: Layer) {
    let percent = |shares: &[f32]| {
        let row = |share: &f32| (heat(*share), format!("{:.0} %", 100.0 * share));
        shares.iter().map(row).collect::<Vec<_>>()
    };
    const SHARES: [f32; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];
    let unknown = |words: &str| (UNKNOWN, words.to_string());
    let (title, rows) = match layer {
        Layer::Directions => {
            let colors = [
                ([1.0, 0.0], "sideways"),
                ([0.0, 1.0], "up and down"),
                ([1.0, 1.0], "both alike"),
                ([0.0, 0.0], "none accepted"),
            ];
            let row = |([h, v], words): ([f32; 2], &str)| {
                let [r, g, b] = direction_color(h, v);
                (Color32::from_rgb(r, g, b), words.to_string())
            };
            ("accepted moves".into(), colors.map(row).to_vec())
        }
        Layer::Acceptance(kernel) => {
            (format!("accepted of {kernel}"), [percent(&SHARES), vec![unknown("none proposed")]].concat())
        }
        Layer::OwnError => {
            ("relative error, own estimate".into(), [capped(percent(&SHARES)), vec![unknown("not known")]].concat())
        }
        Layer::ReferenceError => ("relative error to the reference".into(), capped(percent(&SHARES))),
    };
    table(painter, corner, &title, &rows);
}

/// The first row stands for all that is larger too.
fn capped(mut rows: Vec<(Color32, String)>) -> Vec<(Color32, String)> {
    if let Some((_, words)) = rows.first_mut() {
        words.push_str(" and more");
    }
    rows
}

/// Points per pixel from which on its values are written into it.
const LEGIBLE: f32 = 64.0;

/// The values of every pixel in its place, where pixels are large enough: `rect` is the image's, `seen` the part of it
/// that is.
pub fn pixel_values(painter: &egui::Painter, image: &Image, rect: Rect, seen: Rect) {
    let side = rect.width() / image.width as f32;
    if side < LEGIBLE || !seen.is_positive() {
        return;
    }
    let pixel = |at: f32, from: f32, count: u32| (((at - from) / side) as u32).min(count - 1);
    let columns = pixel(seen.left(), rect.left(), image.width)..=pixel(seen.right(), rect.left(), image.width);
    for y in pixel(seen.top(), rect.top(), image.height)..=pixel(seen.bottom(), rect.top(), image.height) {
        for x in columns.clone() {
            let middle = rect.min + side * Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let values = image.pixels[(y * image.width + x) as usize];
            painter.rect_filled(
                Rect::from_center_size(middle, Vec2::new(56.0, 48.0)),
                4.0,
                Color32::from_black_alpha(150),
            );
            let colors = [[255, 150, 150], [150, 235, 150], [165, 185, 255]];
            for ((value, [r, g, b]), line) in values.into_iter().zip(colors).zip([-14.0, 0.0, 14.0]) {
                let words = if value.abs() < 1e4 { format!("{value:.4}") } else { format!("{value:.1e}") };
                let at = middle + Vec2::new(0.0, line);
                painter.text(at, Align2::CENTER_CENTER, words, FontId::monospace(11.0), Color32::from_rgb(r, g, b));
            }
        }
    }
}

/// Why a picture has nothing to show of a layer.
pub fn lacking(layer: Layer, slot: &Slot, comparable: bool) -> String {
    let method = slot.settings.method;
    match layer {
        Layer::Directions | Layer::Acceptance(_) if method == Method::Pt => "pt makes no mutations".into(),
        Layer::Acceptance(kernel) if slot.picture.acceptance.is_some() => format!("{} has no {kernel}", method.name()),
        Layer::Acceptance(_) if slot.picture.maps.is_some() && slot.picture.own.is_some() => {
            "acceptance needs a smaller image on this device".into()
        }
        Layer::ReferenceError if !comparable => "no reference of this size".into(),
        _ => format!("{}: not known yet", layer.name()),
    }
}

fn table(painter: &egui::Painter, corner: Pos2, title: &str, rows: &[(Color32, String)]) {
    const ROW: f32 = 18.0;
    const MARGIN: f32 = 8.0;
    const PATCH: f32 = 22.0;
    let lay =
        |words: &str, gray| painter.layout_no_wrap(words.into(), FontId::proportional(13.0), Color32::from_gray(gray));
    let title = lay(title, 235);
    let rows: Vec<_> = rows.iter().map(|(color, words)| (*color, lay(words, 215))).collect();
    let widest = rows.iter().map(|(_, words)| PATCH + words.size().x).fold(title.size().x, f32::max);
    let size = Vec2::new(widest + 2.0 * MARGIN, ROW * (rows.len() + 1) as f32 + 10.0);
    let rect = Align2::RIGHT_BOTTOM.anchor_size(corner, size);
    painter.rect_filled(rect, 4.0, Color32::from_black_alpha(190));
    let at = |row: usize| rect.min + Vec2::new(MARGIN, 5.0 + ROW * (row as f32 + 0.5));
    let centred = |left: Pos2, size: Vec2| left - Vec2::new(0.0, 0.5 * size.y);
    painter.galley(centred(at(0), title.size()), title, Color32::WHITE);
    for (row, (color, words)) in rows.into_iter().enumerate() {
        let middle = at(row + 1);
        let patch = Rect::from_center_size(middle + Vec2::new(7.0, 0.0), Vec2::splat(12.0));
        painter.rect_filled(patch, 2.0, color);
        painter.rect_stroke(patch, 2.0, Stroke::new(1.0, Color32::from_gray(110)), StrokeKind::Outside);
        painter.galley(centred(middle + Vec2::new(PATCH, 0.0), words.size()), words, Color32::WHITE);
    }
}
