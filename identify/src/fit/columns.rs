//! The columns of the regression: inertial ones, and groups of what a model often lacks.

use super::extended::Extended;
use super::groups::{Group, Shape};
use super::{FitError, Source};
use crate::machine::{Machine, States};
use dynamics_codegen::derive::{InertialRegressor, STANDARD};
use dynamics_codegen::{Column, System, Tape};
use nalgebra::DMatrix;

/// Believed relative error of stated inertias (one standard deviation).
const TOLERANCE: f64 = 0.3;
/// A speed over which an effect changes is this share of the fastest motion: the sign of dry
/// friction.
const SMOOTH: f64 = 0.01;

/// All columns: ten per body, then those of the groups.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    pub inertial: usize,
    pub bodies: Vec<String>,
    pub stated: Vec<f64>,
    /// Per body, its centre of mass as stated, m.
    pub centers: Vec<[f64; 3]>,
    /// Standard deviation believed of each inertial correction.
    pub prior: Vec<f64>,
    pub groups: Vec<Group>,
    tape: Tape,
    extended: Extended,
    coordinates: usize,
}

impl Columns {
    /// Of a machine with values of its parameters, whose model stands in a text.
    pub fn new(
        machine: &mut Machine,
        parameters: &[f64],
        source: &Source<'_>,
    ) -> Result<Self, FitError> {
        let model = &mut machine.compiled.model;
        let regressor =
            InertialRegressor::new(model).map_err(|error| FitError::Tree(error.to_string()))?;
        let n = model.coordinates.len();
        let mut values = vec![0.0; model.graph.symbol_count()];
        for (p, &value) in model.parameters.iter().zip(parameters) {
            values[p.symbol.index()] = value;
        }
        let (mut stated, mut prior, mut centers) = (Vec::new(), Vec::new(), Vec::new());
        let (mut bodies, mut outputs) = (Vec::new(), Vec::new());
        for (index, (&body, own)) in regressor.bodies.iter().zip(&regressor.stated).enumerate() {
            let own = model.graph.evaluate(own, &values);
            // A frame without mass has nothing to correct.
            if own[0] <= 0.0 {
                continue;
            }
            let radius = ((own[4] + own[5] + own[6]) / own[0]).max(1e-12).sqrt();
            let size = |k: usize| match k {
                0 => own[0],
                1..=3 => own[0] * radius,
                _ => own[0] * radius * radius,
            };
            prior.extend((0..STANDARD.len()).map(|k| TOLERANCE * size(k)));
            centers.push([1, 2, 3].map(|k| own[k] / own[0]));
            stated.extend(&own);
            bodies.push(model.bodies[body].name.clone());
            let first = index * STANDARD.len();
            outputs.extend(
                regressor.columns[first..first + STANDARD.len()]
                    .iter()
                    .flatten(),
            );
        }
        let mut arguments = System::arguments(model);
        arguments.extend(&regressor.acceleration);
        let tape = Tape::new(&model.graph, &outputs, &arguments);
        let known = (&bodies[..], stated.len());
        let (extended, groups) = Extended::new(source, model, parameters, known)?;
        Ok(Self {
            inertial: stated.len(),
            groups,
            extended,
            bodies,
            stated,
            centers,
            prior,
            tape,
            coordinates: n,
        })
    }

    /// Per column, what its coefficient is not below: friction brakes and a rotor has an inertia, as
    /// the bounds of effects say, and what the model states of these may be taken away, no more. A
    /// constant force, and a correction of an inertia, has either sign.
    pub fn lower(&self) -> Vec<f64> {
        let mut lower = vec![f64::NEG_INFINITY; self.count()];
        for group in self.groups.iter().filter(|group| group.load.is_none()) {
            for (column, coefficient) in group.columns.clone().zip(&group.coefficients) {
                lower[column] = coefficient.lower - coefficient.stated;
            }
        }
        lower
    }

    /// The value of each shape of a group on a log whose coordinates move so fast at most: what is
    /// stated, or a share of that within its bounds.
    pub fn shapes<'a>(
        group: &'a Group,
        fastest: &[f64],
    ) -> impl Iterator<Item = (&'a Shape, f64)> + use<'a> {
        let speed: f64 = group.places.iter().map(|&i| fastest[i]).sum();
        // With the digits that it is written into a model with.
        let own = format!("{:.1e}", SMOOTH * speed).parse().unwrap_or(speed);
        group.shapes.iter().map(move |shape| {
            let (low, high) = shape.bounds;
            (shape, shape.stated.unwrap_or(f64::clamp(own, low, high)))
        })
    }

    /// How many columns there are.
    pub fn count(&self) -> usize {
        let ends = self.groups.iter().map(|group| group.columns.end);
        ends.fold(self.inertial, usize::max)
    }

    /// Every column at every sample: per column, per coordinate, a value per sample, with
    /// accelerations `a`; `fastest` is the fastest motion per coordinate of the log that is
    /// learnt from.
    pub fn along(
        &self,
        machine: &Machine,
        states: &States,
        parameters: &[f64],
        a: &[Vec<f64>],
        fastest: &[f64],
    ) -> Vec<Vec<Vec<f64>>> {
        let n = self.coordinates;
        let known = [&states.q, &states.v, &states.u].into_iter().flatten();
        let mut inputs: Vec<Column<'_>> = std::iter::once(&states.t)
            .chain(known)
            .map(|column| Column::Each(column))
            .collect();
        // Memory does not enter the inertial columns.
        let model = &machine.compiled.model;
        inputs.extend((0..model.delays.len() + model.states.len()).map(|_| Column::Same(0.0)));
        inputs.extend(parameters.iter().map(|&p| Column::Same(p)));
        inputs.extend(a.iter().map(|column| Column::Each(column)));
        let flat = self.tape.evaluate_all(&inputs, states.len());
        let mut columns: Vec<Vec<Vec<f64>>> = flat.chunks(n.max(1)).map(<[_]>::to_vec).collect();
        let shapes = self.groups.iter().flat_map(|g| Self::shapes(g, fastest));
        let shapes: Vec<(usize, f64)> = shapes.map(|(shape, v)| (shape.index, v)).collect();
        columns.extend(self.extended.columns(states, a, &shapes));
        columns
    }

    /// How many combinations of inertial parameters show in any motion at all.
    pub fn structural_rank(&self, machine: &Machine, parameters: &[f64]) -> usize {
        if self.inertial == 0 {
            return 0;
        }
        let n = self.coordinates;
        let samples = 2 * self.inertial + 20;
        // Low-discrepancy states: a rank needs no chance.
        let mut next = Weyl(0.5);
        let model = &machine.compiled.model;
        let count = 1 + 2 * n + model.inputs.len() + model.delays.len() + model.states.len();
        let mut columns: Vec<Vec<f64>> = (0..count)
            .map(|_| (0..samples).map(|_| 4.0 * next.next() - 2.0).collect())
            .collect();
        columns.extend(parameters.iter().map(|&p| vec![p; samples]));
        columns.extend((0..n).map(|_| (0..samples).map(|_| 10.0 * next.next() - 5.0).collect()));
        let inputs: Vec<Column<'_>> = columns.iter().map(|c| Column::Each(c)).collect();
        let inputs = &inputs[..self.tape.input_count().min(inputs.len())];
        let flat = self.tape.evaluate_all(inputs, samples);
        let scaled = DMatrix::from_fn(n * samples, self.inertial, |row, column| {
            flat[column * n + row % n][row / n] * self.prior[column]
        });
        let values = (scaled.transpose() * &scaled).symmetric_eigenvalues();
        let largest = values.max();
        values.iter().filter(|&&x| x > 1e-12 * largest).count()
    }
}

/// `x ← x + golden ratio mod 1`, with a slow drift so that dimensions differ.
struct Weyl(f64);

impl Weyl {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.618_033_988_749_894_8 + 0.1 * self.0 * self.0).fract();
        self.0
    }
}
