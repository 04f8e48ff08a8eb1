//! The columns of the regression: inertial ones, and groups of what a model often lacks.

use super::{FitError, Inertia};
use crate::machine::{Machine, States};
use dynamics_codegen::derive::{InertialRegressor, STANDARD};
use dynamics_codegen::{Column, System, Tape};
use nalgebra::DMatrix;
use std::ops::Range;

/// Believed relative error of stated inertias (one standard deviation).
const TOLERANCE: f64 = 0.3;
/// Coulomb friction is `tanh(v/v_s)` with `v_s` this share of the fastest motion.
const SMOOTH: f64 = 0.01;

/// The term that may push either way.
const CONSTANT: &str = "constant_force";

/// Columns that come and go together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub term: &'static str,
    pub on: Vec<String>,
    pub names: Vec<&'static str>,
    pub columns: Range<usize>,
    /// The coordinates' indices.
    places: Vec<usize>,
}

/// All columns: ten per body, then those of the groups.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    pub inertial: usize,
    pub bodies: Vec<String>,
    pub stated: Vec<f64>,
    /// Standard deviation believed of each inertial correction.
    pub prior: Vec<f64>,
    pub groups: Vec<Group>,
    tape: Tape,
    coordinates: usize,
}

impl Columns {
    pub fn new(
        machine: &mut Machine,
        parameters: &[f64],
        inertia: Inertia,
    ) -> Result<Self, FitError> {
        let model = &mut machine.compiled.model;
        let regressor =
            InertialRegressor::new(model).map_err(|error| FitError::Tree(error.to_string()))?;
        let n = model.coordinates.len();
        let mut values = vec![0.0; model.graph.symbol_count()];
        for (p, &value) in model.parameters.iter().zip(parameters) {
            values[p.symbol.index()] = value;
        }
        let (mut stated, mut prior, mut bodies, mut outputs) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (index, (&body, own)) in regressor.bodies.iter().zip(&regressor.stated).enumerate() {
            let own = model.graph.evaluate(own, &values);
            // A frame without mass has nothing to correct.
            if inertia == Inertia::Fixed || own[0] <= 0.0 {
                continue;
            }
            let radius = ((own[4] + own[5] + own[6]) / own[0]).max(1e-12).sqrt();
            let size = |k: usize| match k {
                0 => own[0],
                1..=3 => own[0] * radius,
                _ => own[0] * radius * radius,
            };
            prior.extend((0..STANDARD.len()).map(|k| TOLERANCE * size(k)));
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
        let names: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
        Ok(Self {
            inertial: stated.len(),
            groups: groups(&names, stated.len()),
            bodies,
            stated,
            prior,
            tape,
            coordinates: n,
        })
    }

    /// Per column, whether its coefficient is zero or more by its nature: friction brakes, a
    /// rotor and what two joints share have an inertia. A constant force, and a correction of an
    /// inertia, has either sign.
    pub fn signed(&self) -> Vec<bool> {
        let mut signed = vec![false; self.count()];
        for group in self.groups.iter().filter(|group| group.term != CONSTANT) {
            signed[group.columns.clone()].fill(true);
        }
        signed
    }

    /// How many columns there are.
    pub fn count(&self) -> usize {
        self.groups
            .last()
            .map_or(self.inertial, |group| group.columns.end)
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
        for group in &self.groups {
            columns.extend(group.evaluate(&states.v, a, fastest, n));
        }
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

/// What a model often lacks, at every place.
fn groups(names: &[String], first: usize) -> Vec<Group> {
    let mut groups = Vec::new();
    let mut next = first;
    let mut push = |term, places: Vec<usize>, parts: Vec<&'static str>| {
        groups.push(Group {
            term,
            on: places.iter().map(|&i| names[i].clone()).collect(),
            columns: next..next + parts.len(),
            names: parts,
            places,
        });
        next = groups
            .last()
            .map_or(next, |group: &Group| group.columns.end);
    };
    for i in 0..names.len() {
        push("friction", vec![i], vec!["coulomb", "viscous"]);
        push("armature", vec![i], vec!["inertia"]);
        push(CONSTANT, vec![i], vec!["force"]);
    }
    for i in 0..names.len() {
        for j in i + 1..names.len() {
            push(
                "joint_coupling",
                vec![i, j],
                vec!["coulomb", "inertia", "viscous"],
            );
        }
    }
    groups
}

impl Group {
    fn evaluate(
        &self,
        v: &[Vec<f64>],
        a: &[Vec<f64>],
        fastest: &[f64],
        n: usize,
    ) -> Vec<Vec<Vec<f64>>> {
        let samples = v.first().map_or(0, Vec::len);
        let zeros = vec![vec![0.0; samples]; n];
        let sign = |rate: &[f64], fastest: f64| -> Vec<f64> {
            let smooth = (SMOOTH * fastest).max(f64::MIN_POSITIVE);
            rate.iter().map(|v| (v / smooth).tanh()).collect()
        };
        let i = self.places[0];
        let one = |values: Vec<f64>| {
            let mut column = zeros.clone();
            column[i] = values;
            column
        };
        match (self.term, self.places.get(1)) {
            ("friction", _) => vec![one(sign(&v[i], fastest[i])), one(v[i].clone())],
            ("armature", _) => vec![one(a[i].clone())],
            (CONSTANT, _) => vec![one(vec![1.0; samples])],
            (_, Some(&j)) => {
                // What turns with both: friction and inertia of a part that moves by
                // q_i + q_j, beyond what each joint has by itself.
                let cross = |x: &[Vec<f64>]| {
                    let mut column = zeros.clone();
                    column[i].clone_from(&x[j]);
                    column[j].clone_from(&x[i]);
                    column
                };
                let both: Vec<f64> = v[i].iter().zip(&v[j]).map(|(x, y)| x + y).collect();
                let rub = sign(&both, fastest[i] + fastest[j]);
                let mut friction = zeros.clone();
                friction[i].clone_from(&rub);
                friction[j] = rub;
                vec![friction, cross(a), cross(v)]
            }
            _ => Vec::new(),
        }
    }
}
