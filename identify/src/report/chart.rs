//! One pair of axes with lines, dots and a band, as SVG to stand in a page.

use plotters::prelude::*;

/// How the points of a layer are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Line,
    /// A line that others may run over and leave visible.
    Broad,
    Dots,
    /// From zero to each value.
    Bars,
}

/// One curve or scatter; a point that is no number breaks a line.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub mark: Mark,
    pub colour: RGBColor,
    pub points: Vec<(f64, f64)>,
}

/// What is drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct Chart {
    /// Quantity and unit of the axes.
    pub x: String,
    pub y: String,
    pub layers: Vec<Layer>,
    /// Draws a band of this half width about zero.
    pub band: Option<f64>,
    /// Ordinates to show; those of all layers if there is none.
    pub range: Option<(f64, f64)>,
}

/// Colours that stay apart for the colour-blind.
pub(super) const BEFORE: RGBColor = RGBColor(213, 94, 0);
pub(super) const AFTER: RGBColor = RGBColor(0, 114, 178);
pub(super) const MEASURED: RGBColor = RGBColor(196, 200, 206);
const BAND: RGBColor = RGBColor(0, 158, 115);

/// Drawn at twice the size at which it is usually seen: coordinates are whole pixels.
const SIZE: (u32, u32) = (1120, 560);
const FONT: u32 = 24;

/// Why a figure could not be drawn.
pub(super) type ChartError = Box<dyn std::error::Error + Send + Sync>;

impl Chart {
    /// The figure as an `svg` element; empty if no layer has a point.
    pub fn svg(&self) -> Result<String, ChartError> {
        let Some(((x0, x1), (y0, y1))) = self.ranges() else {
            return Ok(String::new());
        };
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            let mut chart = ChartBuilder::on(&root)
                .margin(12)
                .margin_right(36)
                .x_label_area_size(80)
                .y_label_area_size(140)
                .build_cartesian_2d(x0..x1, y0..y1)?;
            chart
                .configure_mesh()
                .light_line_style(TRANSPARENT)
                .bold_line_style(BLACK.mix(0.1))
                .axis_style(BLACK.mix(0.4))
                .x_labels(8)
                .y_labels(7)
                .x_label_formatter(&|v| tick(*v, x1 - x0))
                .y_label_formatter(&|v| tick(*v, y1 - y0))
                .x_desc(&self.x)
                .y_desc(&self.y)
                .label_style(("sans-serif", FONT))
                .axis_desc_style(("sans-serif", FONT + 2))
                .draw()?;
            if let Some(band) = self.band {
                let corners = [(x0, -band), (x1, band)];
                chart.draw_series([Rectangle::new(corners, BAND.mix(0.2).filled())])?;
            }
            for layer in &self.layers {
                let width = if layer.mark == Mark::Broad { 12 } else { 3 };
                let solid = layer.colour.stroke_width(width);
                match layer.mark {
                    Mark::Line | Mark::Broad => {
                        for run in runs(&layer.points, (y0, y1)) {
                            chart.draw_series(LineSeries::new(run, solid))?;
                        }
                    }
                    Mark::Dots => {
                        let fill = layer.colour.mix(0.55).filled();
                        let dots = runs(&layer.points, (y0, y1)).into_iter().flatten();
                        chart.draw_series(dots.map(|at| Circle::new(at, 4, fill)))?;
                    }
                    Mark::Bars => {
                        let bars = runs(&layer.points, (y0, y1)).into_iter().flatten();
                        chart.draw_series(
                            bars.map(|(x, y)| PathElement::new([(x, 0.0), (x, y)], solid)),
                        )?;
                    }
                }
            }
            root.present()?;
        }
        Ok(text)
    }

    /// What the axes span: the points, and a little more.
    fn ranges(&self) -> Option<((f64, f64), (f64, f64))> {
        let points = self.layers.iter().flat_map(|layer| &layer.points);
        let points = points.filter(|(x, y)| x.is_finite() && y.is_finite());
        let (x, mut y) = points.fold((EMPTY, EMPTY), |(x, y), point| {
            (widened(x, point.0), widened(y, point.1))
        });
        if let Some(band) = self.band {
            y = widened(widened(y, -band), band);
        }
        let any = x.0 <= x.1;
        any.then(|| (x_margin(x), self.range.unwrap_or_else(|| with_margin(y))))
    }
}

const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn widened(range: (f64, f64), value: f64) -> (f64, f64) {
    (range.0.min(value), range.1.max(value))
}

fn with_margin((low, high): (f64, f64)) -> (f64, f64) {
    let size = low.abs().max(high.abs()).max(f64::MIN_POSITIVE.sqrt());
    let more = (0.06 * (high - low)).max(1e-9 * size);
    (low - more, high + more)
}

fn x_margin((low, high): (f64, f64)) -> (f64, f64) {
    let size = low.abs().max(high.abs()).max(f64::MIN_POSITIVE.sqrt());
    let more = (0.01 * (high - low)).max(1e-9 * size);
    (low - more, high + more)
}

/// Stretches without a break; what leaves the range runs along its edge.
fn runs(points: &[(f64, f64)], (low, high): (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let pieces = points.split(|(x, y)| !(x.is_finite() && y.is_finite()));
    let inside = |&(x, y): &(f64, f64)| (x, y.clamp(low, high));
    let pieces = pieces.filter(|piece| !piece.is_empty());
    pieces
        .map(|piece| piece.iter().map(inside).collect())
        .collect()
}

/// A number on an axis of this span: as many digits as tell neighbours apart.
fn tick(value: f64, span: f64) -> String {
    let step = (span / 8.0).log10().floor();
    if value.abs() < 1e-6 * span {
        return "0".into();
    }
    if !(-4.0..5.0).contains(&step) {
        return format!("{value:.1e}");
    }
    format!("{value:.precision$}", precision = (-step).max(0.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_tell_neighbours_apart() {
        assert_eq!(tick(0.30000000000000004, 1.0), "0.3");
        assert_eq!(tick(1e-18, 1.0), "0");
        assert_eq!(tick(-0.002, 0.01), "-0.002");
        assert_eq!(tick(25.0, 100.0), "25");
        assert_eq!(tick(2e-7, 1e-6), "2.0e-7");
    }

    #[test]
    fn a_break_parts_a_line_and_the_edge_holds_it() {
        let points = [(0.0, 0.0), (1.0, 9.0), (2.0, f64::NAN), (3.0, 1.0)];
        let expected = vec![vec![(0.0, 0.0), (1.0, 2.0)], vec![(3.0, 1.0)]];
        assert_eq!(runs(&points, (-2.0, 2.0)), expected);
    }

    #[test]
    fn nothing_and_constants_are_no_mistake() {
        assert_eq!(Chart::default().svg().unwrap(), "");
        let layer = Layer {
            mark: Mark::Line,
            colour: BEFORE,
            points: vec![(1.0, 0.0), (1.0, 0.0)],
        };
        let chart = Chart {
            x: "time <s>".into(),
            layers: vec![layer],
            ..Chart::default()
        };
        let svg = chart.svg().unwrap();
        assert!(
            svg.contains("time &lt;s&gt;") && !svg.contains("<s>"),
            "{svg}"
        );
    }
}
