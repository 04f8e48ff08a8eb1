//! The figures of the page: residuals, predictions, whiteness.

use super::chart::{AFTER, BEFORE, Chart, ChartError, Layer, MEASURED, Mark};
use super::explain::{Variable, explaining, unexplained};
use super::stated_unit;
use crate::trace::{CoordinateSeries, Finding, Outcome, Prediction, Series};
use dynamics_codegen::Model;
use plotters::style::RGBColor;
use serde::Serialize;

/// A figure with what it shows.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Figure {
    pub caption: String,
    pub svg: String,
}

/// Draws the figures of an outcome.
pub(super) struct Figures<'a> {
    pub outcome: &'a Outcome,
    pub model: &'a Model,
}

/// Dots per scatter at most.
const DOTS: usize = 400;

impl<'a> Figures<'a> {
    fn series(&self) -> &'a Series {
        &self.outcome.details.series
    }

    fn unit(&self, name: &str) -> String {
        let mut positions = self.model.positions().into_iter();
        let found = positions.find(|c| c.name == name);
        stated_unit(&found.map_or(String::new(), |c| c.unit))
    }

    /// `[unit]` of the missing force in a coordinate.
    fn force_axis(&self, name: &str) -> String {
        format!("missing force, {name} [{}]", force_unit(&self.unit(name)))
    }

    /// Per coordinate, the missing force over time.
    pub fn over_time(&self) -> Result<Vec<Figure>, ChartError> {
        let series = self.series();
        let figure = |c: &CoordinateSeries| {
            let chart = Chart {
                x: "time [s]".into(),
                y: self.force_axis(&c.name),
                layers: vec![
                    line(BEFORE, broken(&series.t, &c.force_before)),
                    line(AFTER, broken(&series.t, &c.force_after)),
                ],
                ..Chart::default()
            };
            named(&c.name, &chart)
        };
        self.each(figure)
    }

    /// What one finding explains beside the others, against what it depends on; without one, the
    /// missing force that something explains best.
    pub fn explaining(&self, finding: Option<&Finding>) -> Result<Option<Figure>, ChartError> {
        let series = self.series();
        let view = match finding {
            Some(finding) => explaining(series, finding),
            None => unexplained(series),
        };
        let Some(view) = view else {
            return Ok(None);
        };
        let name = &view.coordinate.name;
        let (x, against) = self.axis(&view.variable);
        let stride = series.t.len().div_ceil(DOTS).max(1);
        let scatter = |colour, force: &[f64]| {
            let points = view.variable.values(series).iter().zip(force);
            Layer {
                mark: Mark::Dots,
                colour,
                points: points.map(|(&x, &y)| (x, y)).step_by(stride).collect(),
            }
        };
        let missing = scatter(BEFORE, view.missing);
        let law = view.law.as_deref().map(|law| scatter(AFTER, law));
        let chart = Chart {
            x,
            y: self.force_axis(name),
            layers: [missing].into_iter().chain(law).collect(),
            ..Chart::default()
        };
        let caption = match finding {
            Some(_) => format!("force in {name} that is missing without it, against {against}"),
            None => format!("missing force in {name} against {against}"),
        };
        let svg = chart.svg()?;
        Ok((!svg.is_empty()).then_some(Figure { caption, svg }))
    }

    /// Label of the axis with its unit, and the variable in words.
    fn axis(&self, variable: &Variable<'_>) -> (String, String) {
        let (words, unit) = match variable {
            Variable::Position(c) => {
                let unit = self.unit(&c.name);
                (format!("position of {}", c.name), unit)
            }
            Variable::Velocity(c) => {
                let unit = format!("{}/s", self.unit(&c.name));
                (format!("velocity of {}", c.name), unit)
            }
            Variable::Acceleration(c) => {
                let unit = format!("{}/s²", self.unit(&c.name));
                (format!("acceleration of {}", c.name), unit)
            }
            Variable::Input(index) => {
                let name = &self.series().inputs[*index].name;
                let input = self.model.inputs.iter().find(|u| u.name == *name);
                let unit = stated_unit(input.map_or("", |u| &u.unit));
                (format!("input {name}"), unit)
            }
        };
        (format!("{words} [{unit}]"), words)
    }

    /// Per coordinate, open-loop predictions and what was measured.
    pub fn predictions(&self) -> Result<Vec<Figure>, ChartError> {
        let t = &self.series().prediction_t;
        let figure = |c: &CoordinateSeries| {
            let along = |values: &[f64]| -> Vec<(f64, f64)> {
                t.iter().zip(values).map(|(&t, &q)| (t, q)).collect()
            };
            let predicted = &c.prediction;
            let chart = Chart {
                x: "time [s]".into(),
                y: format!("position, {} [{}]", c.name, self.unit(&c.name)),
                layers: vec![
                    Layer {
                        mark: Mark::Broad,
                        colour: MEASURED,
                        points: along(&predicted.measured),
                    },
                    line(BEFORE, along(&predicted.before)),
                    line(AFTER, along(&predicted.after)),
                ],
                range: around(predicted),
                ..Chart::default()
            };
            named(&c.name, &chart)
        };
        self.each(figure)
    }

    /// Per coordinate, autocorrelations of the whitened innovations.
    pub fn whiteness(&self) -> Result<Vec<Figure>, ChartError> {
        let series = self.series();
        let figure = |c: &CoordinateSeries| {
            let bars = |colour, values: &[f64], beside: f64| Layer {
                mark: Mark::Bars,
                colour,
                points: values
                    .iter()
                    .enumerate()
                    .map(|(l, &r)| ((l as f64 + 1.0 + beside) * series.lag_step, r))
                    .collect(),
            };
            let chart = Chart {
                x: "lag [s]".into(),
                y: format!("autocorrelation, {} [1]", c.name),
                layers: vec![
                    bars(BEFORE, &c.autocorrelation_before, -0.15),
                    bars(AFTER, &c.autocorrelation_after, 0.15),
                ],
                band: Some(series.white_band),
                range: None,
            };
            named(&c.name, &chart)
        };
        self.each(figure)
    }

    fn each(
        &self,
        figure: impl Fn(&CoordinateSeries) -> Result<Figure, ChartError>,
    ) -> Result<Vec<Figure>, ChartError> {
        let figures = self.series().coordinates.iter().map(figure);
        let drawn = |figure: &Result<Figure, ChartError>| !matches!(figure, Ok(figure) if figure.svg.is_empty());
        figures.filter(drawn).collect()
    }
}

pub(super) fn named(name: &str, chart: &Chart) -> Result<Figure, ChartError> {
    Ok(Figure {
        caption: name.to_string(),
        svg: chart.svg()?,
    })
}

pub(super) fn line(colour: RGBColor, points: Vec<(f64, f64)>) -> Layer {
    Layer {
        mark: Mark::Line,
        colour,
        points,
    }
}

/// A curve that is broken where the log has a gap.
pub(super) fn broken(t: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let usual = t.windows(2).map(|pair| pair[1] - pair[0]);
    let usual = usual.fold(f64::INFINITY, f64::min);
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(t.len());
    for (&t, &value) in t.iter().zip(values) {
        let gap = points.last().is_some_and(|last| t - last.0 > 5.0 * usual);
        if gap {
            points.push((t, f64::NAN));
        }
        points.push((t, value));
    }
    points
}

/// All curves, but no further from what was measured than it is wide: a prediction that
/// runs away must not squeeze the log into a line.
fn around(predicted: &Prediction) -> Option<(f64, f64)> {
    let span = |values: &[f64]| {
        let finite = values.iter().copied().filter(|q| q.is_finite());
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| {
            (low.min(q), high.max(q))
        })
    };
    let (low, high) = span(&predicted.measured);
    let width = high - low;
    let curves = [&predicted.before, &predicted.after].map(|values| span(values));
    let bottom = curves.iter().map(|c| c.0).fold(low, f64::min);
    let top = curves.iter().map(|c| c.1).fold(high, f64::max);
    let more = 0.05 * width;
    (width > 0.0).then(|| (bottom.max(low - width) - more, top.min(high + width) + more))
}

/// Unit of the generalised force of a coordinate: energy over its unit.
pub(super) fn force_unit(unit: &str) -> String {
    match unit {
        "m" => "N".into(),
        "rad" => "N·m".into(),
        unit => format!("J/{unit}"),
    }
}
