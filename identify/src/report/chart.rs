//! One pair of axes with lines, dots and a band, as SVG to stand in a page.

use super::axis::{Axis, EM, width, wrapped};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

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
const WIDTH: u32 = 1120;
/// Between the axes, before titles of more than a line.
const PLOT_HEIGHT: u32 = 400;
const LINE_HEIGHT: u32 = 40;
const MARGIN: u32 = 12;
/// From the axis over its numbers to its title.
const NUMBERS_HEIGHT: u32 = 64;
const TICK: u32 = 10;
/// The library's size of a font over the size of its letters.
const FONT: f64 = 1.24 * EM;

/// Why a figure could not be drawn.
pub(super) type ChartError = Box<dyn std::error::Error + Send + Sync>;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Where things are: axes, their titles in lines, and the place left of the plot.
struct Layout {
    x: Axis,
    y: Axis,
    x_title: Vec<String>,
    y_title: Vec<String>,
    left: u32,
    right: u32,
}

impl Layout {
    fn new(chart: &Chart, x: (f64, f64), y: (f64, f64)) -> Self {
        let (x, y) = (Axis::new(x), Axis::new(y));
        let left = (y.widest() + 3.0 * f64::from(TICK)) as u32;
        let plot = f64::from(WIDTH - 3 * MARGIN) - f64::from(left);
        let x = x.within(plot);
        let across = f64::from(WIDTH - 2 * MARGIN);
        Self {
            x_title: wrapped(&x.title(&chart.x), across),
            y_title: wrapped(&y.title(&chart.y), across),
            // Numbers may stand at the very ends of their axis.
            left: left.max((x.widest() / 2.0) as u32),
            right: MARGIN + (x.widest() / 2.0) as u32,
            x,
            y,
        }
    }

    /// Height of the title of the ordinates, above the plot.
    fn above(&self) -> u32 {
        2 * MARGIN + LINE_HEIGHT * self.y_title.len() as u32
    }

    /// Height of the title of the abscissas, below their numbers.
    fn below(&self) -> u32 {
        MARGIN + LINE_HEIGHT * self.x_title.len() as u32
    }

    fn height(&self) -> u32 {
        self.above() + PLOT_HEIGHT + NUMBERS_HEIGHT + self.below()
    }

    fn titles(&self, root: &Area<'_>) -> Result<(), ChartError> {
        let middle = (MARGIN + self.left + WIDTH - self.right) / 2;
        let widest = self.x_title.iter().map(|line| width(line));
        let half = (widest.fold(0.0, f64::max) / 2.0) as u32;
        // Below the middle of the axis, as far as the figure's edges allow.
        let middle = middle.min(WIDTH - MARGIN - half).max(MARGIN + half);
        let top = self.height() - self.below();
        let sides = [
            (&self.y_title, MARGIN, MARGIN, HPos::Left),
            (&self.x_title, middle, top, HPos::Center),
        ];
        for (lines, x, top, side) in sides {
            let style = ("sans-serif", FONT).into_text_style(root);
            let style = style.pos(Pos::new(side, VPos::Top));
            for (line, text) in (0..).zip(lines) {
                let at = (x as i32, (top + LINE_HEIGHT * line) as i32);
                root.draw_text(text, &style, at)?;
            }
        }
        Ok(())
    }

    fn axes<'a, 'b>(&self, root: &'a Area<'b>) -> Result<Plot<'a, 'b>, ChartError> {
        let (x, y) = (self.x.span, self.y.span);
        let mut plot = ChartBuilder::on(root)
            .margin_left(MARGIN)
            .margin_right(self.right)
            .margin_top(self.above())
            .margin_bottom(self.below())
            .x_label_area_size(NUMBERS_HEIGHT)
            .y_label_area_size(self.left)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        plot.configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.1))
            .axis_style(BLACK.mix(0.4))
            .set_all_tick_mark_size(TICK)
            .x_labels(self.x.count)
            .y_labels(self.y.count)
            .x_label_formatter(&|v| self.x.label(*v))
            .y_label_formatter(&|v| self.y.label(*v))
            .label_style(("sans-serif", FONT))
            .draw()?;
        Ok(plot)
    }
}

impl Chart {
    /// The figure as an `svg` element; empty if no layer has a point.
    pub fn svg(&self) -> Result<String, ChartError> {
        let Some((x, y)) = self.ranges() else {
            return Ok(String::new());
        };
        let layout = Layout::new(self, x, y);
        let mut text = String::new();
        {
            let size = (WIDTH, layout.height());
            let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
            layout.titles(&root)?;
            let mut plot = layout.axes(&root)?;
            if let Some(band) = self.band.map(|band| layout.y.scaled(band)) {
                let (x0, x1) = layout.x.span;
                let corners = [(x0, -band), (x1, band)];
                plot.draw_series([Rectangle::new(corners, BAND.mix(0.2).filled())])?;
            }
            for layer in &self.layers {
                layer.draw(&mut plot, &layout)?;
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
        let y = || self.range.unwrap_or_else(|| with_margin(y, 0.06));
        any.then(|| (with_margin(x, 0.01), y()))
    }
}

impl Layer {
    fn draw(&self, plot: &mut Plot<'_, '_>, layout: &Layout) -> Result<(), ChartError> {
        let scale = |(x, y): &(f64, f64)| (layout.x.scaled(*x), layout.y.scaled(*y));
        let points: Vec<(f64, f64)> = self.points.iter().map(scale).collect();
        let runs = runs(&points, layout.y.span);
        let width = if self.mark == Mark::Broad { 12 } else { 3 };
        let solid = self.colour.stroke_width(width);
        match self.mark {
            Mark::Line | Mark::Broad => {
                for run in runs {
                    plot.draw_series(LineSeries::new(run, solid))?;
                }
            }
            Mark::Dots => {
                let fill = self.colour.mix(0.55).filled();
                let dots = runs.into_iter().flatten();
                plot.draw_series(dots.map(|at| Circle::new(at, 4, fill)))?;
            }
            Mark::Bars => {
                let bars = runs.into_iter().flatten();
                plot.draw_series(bars.map(|(x, y)| PathElement::new([(x, 0.0), (x, y)], solid)))?;
            }
        }
        Ok(())
    }
}

const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn widened(range: (f64, f64), value: f64) -> (f64, f64) {
    (range.0.min(value), range.1.max(value))
}

fn with_margin((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if size == 0.0 {
        return (-1.0, 1.0);
    }
    let more = (share * (high - low)).max(1e-10 * size);
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

#[cfg(test)]
mod tests {
    use super::*;

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
