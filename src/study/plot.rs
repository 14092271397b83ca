//! Line plots, as SVG and as PNG at twice the size: the same drawing on two of plotters' backends.

use std::path::{Path, PathBuf};
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axes::{Axis, Scale};
use crate::film::file::write_whole;
use crate::film::png;
use crate::{Error, Result};

/// One line with its points.
#[derive(Debug, Clone)]
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Low and high end of the interval of each point, where known.
    pub bars: Vec<(f64, f64)>,
    pub style: Style,
}

/// How a line is told from others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Style {
    /// A colour of the palette.
    Coloured(usize),
    /// Black and thick.
    Main,
    /// Grey and without points, for what one compares with.
    Guide,
}

/// One pair of axes.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    pub x: (String, Scale),
    pub y: (String, Scale),
    pub series: Vec<Series>,
}

/// Colours that people with any kind of colour vision can tell apart (Okabe and Ito 2008).
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 60),
];
const GRID: RGBColor = RGBColor(225, 225, 225);
const INK: RGBColor = RGBColor(40, 40, 40);

/// The name under which the font is known; in an SVG it is whatever the reader takes for it.
const FONT: &str = "sans-serif";

/// Makes the font known to plotters. It is built in, so that plots are the same on systems without any.
pub fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Only a damaged font is refused.
        let _ = register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}

/// Text of a size in pixels, anchored as told.
pub fn text_style(size: f64, color: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    let style = TextStyle::from((FONT, size).into_font()).pos(Pos::new(h, v));
    TextStyle { color: color.to_backend_color(), ..style }
}

/// Width and height of one chart; height of the legend with one row, and of every further row.
const CHART: [i32; 2] = [420, 320];
const LEGEND: i32 = 32;
const LEGEND_ROW: i32 = 20;
/// Left and right of the legend.
const MARGIN: i32 = 12;

/// Writes `stem`.svg and `stem`.png with the charts in rows of `columns`, under one legend.
pub fn write(stem: &Path, charts: &[Chart], columns: usize) -> Result<[PathBuf; 2]> {
    register_fonts();
    let columns = columns.clamp(1, charts.len().max(1));
    let rows = charts.len().div_ceil(columns);
    let width = CHART[0] * columns as i32;
    let entries = entries(charts, width);
    let top = entries.last().map_or(0, |(.., (_, y))| y + LEGEND / 2);
    let size = [width, CHART[1] * rows as i32 + top];
    let layout = Layout { charts, columns, entries, top };
    let paths = ["svg", "png"].map(|extension| stem.with_extension(extension));
    let failed = |path: &Path, why: String| Error::runtime(format!("cannot write {}: {why}", path.display()));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (size[0] as u32, size[1] as u32)).into_drawing_area();
        layout.draw(&root, 1).map_err(|e| failed(&paths[0], e.to_string()))?;
        root.present().map_err(|e| failed(&paths[0], e.to_string()))?;
    }
    write_whole(&paths[0], svg.as_bytes())?;
    let [width, height] = size.map(|side| 2 * side as u32);
    let mut rgb = vec![255; 3 * (width * height) as usize];
    {
        let root = BitMapBackend::with_buffer(&mut rgb, (width, height)).into_drawing_area();
        layout.draw(&root, 2).map_err(|e| failed(&paths[1], e.to_string()))?;
        root.present().map_err(|e| failed(&paths[1], e.to_string()))?;
    }
    png::write(&paths[1], width, height, &rgb)?;
    Ok(paths)
}

type Drawn<DB> = std::result::Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Charts under a legend of height `top`.
struct Layout<'a> {
    charts: &'a [Chart],
    columns: usize,
    entries: Vec<Entry<'a>>,
    top: i32,
}

impl Layout<'_> {
    /// `unit` is the size of a unit of the layout in pixels.
    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>, unit: i32) -> Drawn<DB> {
        root.fill(&WHITE)?;
        legend(root, &self.entries, unit)?;
        for (number, chart) in self.charts.iter().enumerate() {
            let left = CHART[0] * (number % self.columns) as i32;
            let top = self.top + CHART[1] * (number / self.columns) as i32;
            Canvas { root, unit, left, top }.chart(chart)?;
        }
        Ok(())
    }
}

/// An entry of the legend: its name, how it is drawn, and where.
type Entry<'a> = (&'a str, Style, (i32, i32));

/// Every name once, in rows that fit the width.
fn entries(charts: &[Chart], width: i32) -> Vec<Entry<'_>> {
    let mut entries: Vec<Entry> = Vec::new();
    let (mut x, mut y) = (MARGIN, LEGEND / 2);
    for series in charts.iter().flat_map(|chart| &chart.series) {
        if entries.iter().any(|(name, ..)| *name == series.name) {
            continue;
        }
        let layout = (FONT, 13.0).into_font().layout_box(&series.name);
        let extent = 28 + layout.map_or(0, |(_, (width, _))| width);
        if x > MARGIN && x + extent > width - MARGIN {
            (x, y) = (MARGIN, y + LEGEND_ROW);
        }
        entries.push((&series.name, series.style, (x, y)));
        x += extent + 20;
    }
    entries
}

fn legend<DB: DrawingBackend>(root: &DrawingArea<DB, Shift>, entries: &[Entry], unit: i32) -> Drawn<DB> {
    let canvas = Canvas { root, unit, left: 0, top: 0 };
    for (name, style, (x, y)) in entries {
        canvas.line(&[(*x, *y), (x + 22, *y)], style.color(), style.width())?;
        if *style != Style::Guide {
            canvas.dot((x + 11, *y), *style)?;
        }
        canvas.text(name, (x + 28, *y), 13, INK, HPos::Left, VPos::Center)?;
    }
    Ok(())
}

impl Style {
    fn color(self) -> RGBColor {
        match self {
            Self::Coloured(n) => PALETTE[n % PALETTE.len()],
            Self::Main => BLACK,
            Self::Guide => RGBColor(150, 150, 150),
        }
    }

    /// Of its line, in units of the layout's half.
    fn width(self) -> u32 {
        match self {
            Self::Coloured(_) => 3,
            Self::Main => 5,
            Self::Guide => 2,
        }
    }
}

/// A place on the drawing, in units of the layout.
struct Canvas<'a, DB: DrawingBackend> {
    root: &'a DrawingArea<DB, Shift>,
    unit: i32,
    left: i32,
    top: i32,
}

impl<DB: DrawingBackend> Canvas<'_, DB> {
    fn at(&self, (x, y): (i32, i32)) -> (i32, i32) {
        ((self.left + x) * self.unit, (self.top + y) * self.unit)
    }

    /// `width` in halves of a unit.
    fn line(&self, points: &[(i32, i32)], color: RGBColor, width: u32) -> Drawn<DB> {
        let points: Vec<_> = points.iter().map(|p| self.at(*p)).collect();
        self.root.draw(&PathElement::new(points, color.stroke_width((width * self.unit as u32 / 2).max(1))))
    }

    fn dot(&self, point: (i32, i32), style: Style) -> Drawn<DB> {
        let radius = if style == Style::Main { 4 } else { 3 };
        self.root.draw(&Circle::new(self.at(point), radius * self.unit, style.color().filled()))
    }

    fn text(&self, text: &str, point: (i32, i32), size: i32, color: RGBColor, h: HPos, v: VPos) -> Drawn<DB> {
        let style = text_style(f64::from(size * self.unit), color, h, v);
        self.root.draw(&Text::new(text.to_string(), self.at(point), style))
    }

    fn chart(&self, chart: &Chart) -> Drawn<DB> {
        let frame = [62, 52, CHART[0] - 18, CHART[1] - 44];
        let [left, top, right, bottom] = frame;
        let points = || chart.series.iter().flat_map(|s| s.points.iter());
        let ends = chart.series.iter().flat_map(|s| s.bars.iter().flat_map(|(low, high)| [*low, *high]));
        let x = Axis::fit(chart.x.1, points().map(|p| p.0));
        let y = Axis::fit(chart.y.1, points().map(|p| p.1).chain(ends));
        let across = |value: f64| x.place(value).map(|p| left + (p * f64::from(right - left)).round() as i32);
        let up = |value: f64| y.place(value).map(|p| bottom - (p * f64::from(bottom - top)).round() as i32);
        for (value, label) in x.ticks() {
            if let Some(px) = across(value) {
                self.line(&[(px, top), (px, bottom)], GRID, 2)?;
                self.text(&label, (px, bottom + 6), 12, INK, HPos::Center, VPos::Top)?;
            }
        }
        for (value, label) in y.ticks() {
            if let Some(py) = up(value) {
                self.line(&[(left, py), (right, py)], GRID, 2)?;
                self.text(&label, (left - 6, py), 12, INK, HPos::Right, VPos::Center)?;
            }
        }
        self.line(&[(left, top), (left, bottom), (right, bottom)], INK, 2)?;
        self.text(&chart.title, (left, 8), 15, BLACK, HPos::Left, VPos::Top)?;
        self.text(&chart.y.0, (left, 32), 12, INK, HPos::Left, VPos::Top)?;
        self.text(&chart.x.0, ((left + right) / 2, bottom + 24), 12, INK, HPos::Center, VPos::Top)?;
        // What one compares with lies below.
        let is_guide = |series: &&Series| series.style == Style::Guide;
        let above = chart.series.iter().filter(|series| !is_guide(series));
        for series in chart.series.iter().filter(is_guide).chain(above) {
            for ((at, _), (low, high)) in series.points.iter().zip(&series.bars) {
                if let (Some(px), Some(low), Some(high)) = (across(*at), up(*low), up(*high)) {
                    self.line(&[(px, low), (px, high)], series.style.color(), 2)?;
                }
            }
            let placed: Vec<_> = series.points.iter().filter_map(|(a, b)| Some((across(*a)?, up(*b)?))).collect();
            self.line(&placed, series.style.color(), series.style.width())?;
            if series.style != Style::Guide {
                placed.iter().try_for_each(|point| self.dot(*point, series.style))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_are_written_in_both_forms() {
        let folder = tempfile::tempdir().unwrap();
        let series = |name: &str, style| Series {
            name: name.into(),
            points: vec![(1.0, 0.5), (10.0, 0.05), (100.0, f64::NAN)],
            bars: vec![(0.4, 0.6), (0.04, f64::INFINITY), (0.0, 0.0)],
            style,
        };
        let chart = Chart {
            title: "a & b".into(),
            x: ("seconds".into(), Scale::Log),
            y: ("relMSE".into(), Scale::Log),
            series: vec![series("emlt", Style::Coloured(0)), series("mean", Style::Main), series("1/n", Style::Guide)],
        };
        let empty = Chart { series: vec![], ..chart.clone() };
        let [svg, png] = write(&folder.path().join("p"), &[chart, empty], 2).unwrap();
        let text = std::fs::read_to_string(svg).unwrap();
        assert!(text.contains("a &amp; b") && text.contains("emlt") && text.trim_end().ends_with("</svg>"), "{text}");
        assert!(std::fs::metadata(png).unwrap().len() > 1000);
    }
}
