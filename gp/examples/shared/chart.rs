//! Panels of lines, bands and points as one SVG file.
#![allow(dead_code, reason = "no example uses everything")]

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A curve or scatter with its place in the legend.
pub struct Layer {
    pub name: String,
    pub color: RGBColor,
    pub mark: Mark,
}

/// How the points of a layer are shown.
pub enum Mark {
    Line(Vec<(f64, f64)>),
    Thin(Vec<(f64, f64)>),
    Dashed(Vec<(f64, f64)>),
    /// A line through its own marks.
    Knots(Vec<(f64, f64)>),
    Dots(Vec<(f64, f64)>),
    /// `(x, lower, upper)`.
    Band(Vec<(f64, f64, f64)>),
}

pub const BLACK_INK: RGBColor = RGBColor(30, 30, 30);
pub const BLUE_INK: RGBColor = RGBColor(31, 110, 180);
pub const ORANGE: RGBColor = RGBColor(230, 120, 20);
pub const GREEN_INK: RGBColor = RGBColor(40, 140, 70);
pub const PURPLE: RGBColor = RGBColor(130, 80, 170);
pub const RED_INK: RGBColor = RGBColor(200, 45, 50);
pub const TEAL: RGBColor = RGBColor(0, 150, 150);
pub const BROWN: RGBColor = RGBColor(130, 90, 50);
pub const GREY: RGBColor = RGBColor(140, 140, 140);

/// A layer; an empty name keeps it out of the legend.
pub fn layer(name: &str, color: RGBColor, mark: Mark) -> Layer {
    Layer {
        name: name.into(),
        color,
        mark,
    }
}

/// One pair of axes.
pub struct Panel {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub layers: Vec<Layer>,
}

/// Label with unit, range (that of the data when none is given), scale.
#[derive(Clone, Default)]
pub struct Axis {
    pub label: String,
    pub range: Option<(f64, f64)>,
    pub logarithmic: bool,
}

impl Axis {
    pub fn new(label: &str) -> Self {
        Self {
            label: label.into(),
            ..Self::default()
        }
    }

    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    pub fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    fn place(&self, v: f64) -> f64 {
        if self.logarithmic {
            v.max(1e-300).log10()
        } else {
            v
        }
    }

    /// Range in drawn coordinates, a little wider than the values.
    fn span(&self, values: impl Iterator<Item = f64>) -> (f64, f64) {
        if let Some((low, high)) = self.range {
            return (self.place(low), self.place(high));
        }
        let (low, high) = values
            .map(|v| self.place(v))
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
        if low > high {
            return (0.0, 1.0);
        }
        let margin = 0.05 * (high - low).max(1e-9 * (1.0 + high.abs()));
        (low - margin, high + margin)
    }

    /// Places of the ticks between drawn coordinates.
    fn ticks(&self, low: f64, high: f64) -> Vec<f64> {
        let within = |v: &f64| (low - 1e-9..=high + 1e-9).contains(v);
        if self.logarithmic {
            let decades = low.floor() as i32..=high.ceil() as i32;
            let few = high - low < 3.0;
            let stride = 1 + ((high - low) / 8.0) as i32;
            let steps: &[f64] = if few { &[1.0, 2.0, 5.0] } else { &[1.0] };
            return decades
                .filter(|d| few || d % stride == 0)
                .flat_map(|d| steps.iter().map(move |s| f64::from(d) + s.log10()))
                .filter(within)
                .collect();
        }
        let coarse = (high - low) / 9.0;
        let power = 10f64.powf(coarse.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|s| s * power)
            .into_iter()
            .find(|s| *s >= coarse)
            .unwrap_or(coarse);
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        (first..=last).map(|k| k as f64 * step).collect()
    }

    fn ruler(&self, low: f64, high: f64) -> Ruler {
        Ruler {
            range: low..high,
            ticks: self.ticks(low, high),
        }
    }

    fn tick(&self, v: f64) -> String {
        let value = if self.logarithmic { 10f64.powf(v) } else { v };
        if self.logarithmic && !(0.9e-3..1.1e4).contains(&value) {
            return format!("1e{}", v.round());
        }
        let text = format!("{:.4}", if value.abs() < 5e-5 { 0.0 } else { value });
        text.trim_end_matches('0').trim_end_matches('.').into()
    }
}

/// A drawn coordinate with its ticks.
struct Ruler {
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Ranged for Ruler {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl Layer {
    fn points(&self) -> Vec<(f64, f64)> {
        match &self.mark {
            Mark::Line(p) | Mark::Thin(p) | Mark::Dashed(p) | Mark::Knots(p) | Mark::Dots(p) => {
                p.clone()
            }
            Mark::Band(b) => b.iter().flat_map(|&(x, l, h)| [(x, l), (x, h)]).collect(),
        }
    }
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Draw panels row by row into `path`, `columns` beside one another, each with its legend
/// to its right, where it hides nothing.
pub fn draw(path: &Path, columns: usize, panels: &[Panel]) -> Result<(), Failure> {
    let rows = panels.len().div_ceil(columns);
    let longest = panels
        .iter()
        .flat_map(|p| &p.layers)
        .map(|l| l.name.chars().count())
        .max()
        .unwrap_or(0) as u32;
    let legend = if longest > 0 { 36 + 7 * longest } else { 0 };
    let size = ((WIDTH + legend) * columns as u32, 340 * rows as u32);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        let (axes, beside) = area.split_horizontally(WIDTH);
        one(&axes, panel)?;
        name(&beside, panel)?;
    }
    root.present()?;
    Ok(())
}

/// Width of a panel without its legend, pixels.
const WIDTH: u32 = 460;

/// The parts of a curve between `y0` and `y1`.
fn clipped(curve: &[(f64, f64)], y0: f64, y1: f64) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut open = false;
    for pair in curve.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        // Shares of the segment at which it enters and leaves.
        let (mut from, mut to) = (0.0f64, 1.0f64);
        let rise = b.1 - a.1;
        if rise == 0.0 && !(y0..=y1).contains(&a.1) {
            to = -1.0;
        } else if rise != 0.0 {
            let (s, t) = ((y0 - a.1) / rise, (y1 - a.1) / rise);
            from = from.max(s.min(t));
            to = to.min(s.max(t));
        }
        if from > to || !rise.is_finite() {
            open = false;
            continue;
        }
        let at = |share: f64| (a.0 + share * (b.0 - a.0), a.1 + share * rise);
        match parts.last_mut() {
            Some(part) if open && from == 0.0 => part.push(at(to)),
            _ => parts.push(vec![at(from), at(to)]),
        }
        open = to == 1.0;
    }
    parts
}

fn one(area: &DrawingArea<SVGBackend<'_>, Shift>, panel: &Panel) -> Result<(), Failure> {
    let all: Vec<(f64, f64)> = panel.layers.iter().flat_map(Layer::points).collect();
    let (x0, x1) = panel.x.span(all.iter().map(|p| p.0));
    let (y0, y1) = panel.y.span(all.iter().map(|p| p.1));
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 16))
        .margin(10)
        .margin_right(18)
        .x_label_area_size(40)
        .y_label_area_size(62)
        .build_cartesian_2d(panel.x.ruler(x0, x1), panel.y.ruler(y0, y1))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_labels(24)
        .y_labels(24)
        .x_label_formatter(&|v| panel.x.tick(*v))
        .y_label_formatter(&|v| panel.y.tick(*v))
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
        .label_style(("sans-serif", 12))
        .axis_desc_style(("sans-serif", 14))
        .draw()?;
    for layer in &panel.layers {
        let place = |&(x, y): &(f64, f64)| (panel.x.place(x), panel.y.place(y));
        let placed: Vec<(f64, f64)> = layer.points().iter().map(place).collect();
        let lines = || clipped(&placed, y0, y1);
        let dots = |size: i32| {
            let inside = placed.iter().filter(|c| (y0..=y1).contains(&c.1));
            let ink = layer.color.filled();
            inside.map(move |&c| Circle::new(c, size, ink))
        };
        let solid = layer.color.stroke_width(2);
        if let Mark::Knots(_) = layer.mark {
            chart.draw_series(dots(3))?;
        }
        match &layer.mark {
            Mark::Line(_) | Mark::Knots(_) => {
                for part in lines() {
                    chart.draw_series(LineSeries::new(part, solid))?;
                }
            }
            Mark::Thin(_) => {
                let thin = layer.color.mix(0.55).stroke_width(1);
                for part in lines() {
                    chart.draw_series(LineSeries::new(part, thin))?;
                }
            }
            Mark::Dashed(_) => {
                for part in lines() {
                    chart.draw_series(DashedLineSeries::new(part, 6, 4, solid))?;
                }
            }
            Mark::Dots(_) => {
                chart.draw_series(dots(2))?;
            }
            Mark::Band(b) => {
                let low: Vec<(f64, f64)> = b.iter().map(|&(x, l, _)| (x, l)).collect();
                let high: Vec<(f64, f64)> = b.iter().rev().map(|&(x, _, h)| (x, h)).collect();
                let edge: Vec<(f64, f64)> = [low, high]
                    .concat()
                    .iter()
                    .map(|&(x, y)| (panel.x.place(x), panel.y.place(y).clamp(y0, y1)))
                    .collect();
                let fill = layer.color.mix(0.18).filled();
                chart.draw_series(std::iter::once(Polygon::new(edge, fill)))?;
            }
        }
    }
    Ok(())
}

/// The legend of a panel: a mark as in the panel, and its name.
fn name(area: &DrawingArea<SVGBackend<'_>, Shift>, panel: &Panel) -> Result<(), Failure> {
    let named = panel.layers.iter().filter(|l| !l.name.is_empty());
    for (i, layer) in named.enumerate() {
        let y = 40 + 18 * i as i32;
        let bar = |from: i32, to: i32, half: i32, strength: f64| {
            let ink = layer.color.mix(strength).filled();
            area.draw(&Rectangle::new([(from, y - half), (to, y + half)], ink))
        };
        match layer.mark {
            Mark::Band(_) => bar(0, 18, 4, 0.3)?,
            Mark::Dashed(_) => {
                bar(0, 6, 1, 1.0)?;
                bar(11, 17, 1, 1.0)?;
            }
            Mark::Dots(_) => area.draw(&Circle::new((9, y), 2, layer.color.filled()))?,
            Mark::Knots(_) => {
                bar(0, 18, 1, 1.0)?;
                area.draw(&Circle::new((9, y), 3, layer.color.filled()))?;
            }
            Mark::Line(_) | Mark::Thin(_) => bar(0, 18, 1, 1.0)?,
        }
        let text = ("sans-serif", 12).into_text_style(area);
        area.draw_text(&layer.name, &text, (24, y - 6))?;
    }
    Ok(())
}

/// The folder for figures: the first argument that is no option, or `target/figures`.
pub fn folder() -> Result<PathBuf, Failure> {
    let named = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let folder = named.map_or_else(|| PathBuf::from("target/figures"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::clipped;

    #[test]
    fn curves_end_at_the_axes() {
        let peak = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, 0.5)];
        let parts = clipped(&peak, 0.0, 1.0);
        let want = [
            vec![(0.0, 0.0), (0.5, 1.0)],
            vec![(1.5, 1.0), (2.0, 0.0), (3.0, 0.5)],
        ];
        assert_eq!(parts, want);
        assert!(clipped(&[(0.0, 3.0), (1.0, 3.0)], 0.0, 1.0).is_empty());
        assert!(clipped(&[(0.0, f64::NAN), (1.0, 0.0)], 0.0, 1.0).is_empty());
        assert_eq!(clipped(&[(0.0, -1.0), (1.0, 2.0)], 0.0, 1.0).len(), 1);
    }
}
