//! Derivatives of a motion by parameters, positions and velocities.

use super::memory::{SlopeTapes, columns_with_slopes};
use super::{Factorisation, Machine, Motion, States};
use dynamics_codegen::derive::{Sensitivity, Variable};
use dynamics_codegen::{Column, Compiled, System, Tape};
use nalgebra::DMatrix;

/// `∂[R; S]/∂s` on a tape; with the factorisation it gives `∂a/∂s` and `∂λ/∂s`.
#[derive(Debug, Clone)]
pub struct SensitivityTape {
    tape: Tape,
    /// Where its outputs stand: `rows` of one variable after those of the other. All others are nothing everywhere,
    /// which most are of what acts in one joint.
    occupied: Vec<usize>,
    rows: usize,
    /// Whether a derivative contains a state.
    reads_states: bool,
    /// How states follow the variables; `None` if there are none.
    pub(super) slopes: Option<SlopeTapes>,
    variables: usize,
}

impl Machine {
    /// Derivatives of the motion by `variables`, to be evaluated along states.
    pub fn sensitivity(&mut self, variables: &[Variable]) -> SensitivityTape {
        let Compiled { model, system, .. } = &mut self.compiled;
        let sensitivity = Sensitivity::new(model, system, variables);
        let mut arguments = System::arguments(model);
        arguments.extend(&sensitivity.acceleration);
        arguments.extend(&sensitivity.multiplier);
        let rows = sensitivity.acceleration.len() + sensitivity.multiplier.len();
        let outputs: Vec<_> = sensitivity.columns.iter().flatten().copied().collect();
        let is_something = |place: &usize| !model.graph.is_zero(outputs[*place]);
        let occupied: Vec<usize> = (0..outputs.len()).filter(is_something).collect();
        let outputs: Vec<_> = occupied.iter().map(|&place| outputs[place]).collect();
        let mut past = System::arguments(model);
        past.extend(&sensitivity.delay_rates);
        past.extend(sensitivity.memory.iter().map(|slope| slope.symbol));
        arguments.extend(&past[System::arguments(model).len()..]);
        let slopes =
            (!model.states.is_empty()).then(|| SlopeTapes::new(model, &sensitivity, &past));
        let read = model.graph.symbols_in(&outputs);
        let reads_states = model.states.iter().any(|z| read.contains(&z.symbol));
        SensitivityTape {
            reads_states: reads_states || !sensitivity.memory.is_empty(),
            tape: Tape::new(&model.graph, &outputs, &arguments),
            occupied,
            rows,
            slopes,
            variables: variables.len(),
        }
    }
}

impl SensitivityTape {
    /// How many variables it has derivatives by.
    pub fn variable_count(&self) -> usize {
        self.variables
    }

    /// Whether it matters which states it is evaluated with.
    pub fn reads_states(&self) -> bool {
        self.reads_states
    }

    /// `∂a/∂s` (`n × variables`) and `∂λ/∂s` (`m × variables`) at every state. By a
    /// parameter, what it does through delayed inputs and states is in them as far as
    /// `states.memory` says so ([`Machine::trail`]).
    ///
    /// # Panics
    /// If the machine remembers and `states.memory` is empty: see
    /// [`Machine::remember`] and [`Machine::at_rest`].
    pub fn evaluate(
        &self,
        states: &States,
        parameters: &[f64],
        motions: &[Motion],
    ) -> Vec<(DMatrix<f64>, DMatrix<f64>)> {
        let (n, m) = motions.first().map_or((0, 0), |motion| {
            (motion.acceleration.len(), motion.multiplier.len())
        });
        let accelerations = (0..n).map(|i| motions.iter().map(|m| m.acceleration[i]).collect());
        let multipliers = (0..m).map(|k| motions.iter().map(|m| m.multiplier[k]).collect());
        let solved: Vec<Vec<f64>> = accelerations.chain(multipliers).collect();
        let values = self.entries(states, parameters, &solved);
        let each = motions.iter().enumerate();
        // Multiplications by each way, in units of n.
        let is_sparse = self.occupied.len() + (n + m) * n < self.variables * n;
        each.map(|(sample, Motion { factorisation, .. })| match is_sparse {
            true => self.by_units(factorisation, (n, m), |entry| -values[entry][sample]),
            false => {
                let mut all = DMatrix::zeros(n + m, self.variables);
                for (&place, values) in self.occupied.iter().zip(&values) {
                    all[place] = -values[sample];
                }
                let [force, bias] = [(0, n), (n, m)].map(|(from, count)| all.rows(from, count));
                factorisation.solve(force.into_owned(), &bias.into_owned())
            }
        })
        .collect()
    }

    /// Sums of what a unit in each row comes to: where there are few entries in each column, that is less work than a
    /// solution of its own for each.
    fn by_units(
        &self,
        factorisation: &Factorisation,
        (n, m): (usize, usize),
        entry: impl Fn(usize) -> f64,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let (accelerations, multipliers) = factorisation.solve(
            DMatrix::identity(n, n + m),
            &DMatrix::from_fn(m, n + m, |row, unit| f64::from(u8::from(unit == n + row))),
        );
        let [mut acceleration, mut multiplier] =
            [n, m].map(|count| DMatrix::zeros(count, self.variables));
        for (index, place) in self.occupied.iter().enumerate() {
            let (variable, unit, size) = (place / self.rows, place % self.rows, entry(index));
            for (sums, units, count) in [
                (&mut acceleration, &accelerations, n),
                (&mut multiplier, &multipliers, m),
            ] {
                let sums = &mut sums.as_mut_slice()[variable * count..][..count];
                let of_unit = &units.as_slice()[unit * count..][..count];
                let pairs = sums.iter_mut().zip(of_unit);
                pairs.for_each(|(sum, of_unit)| *sum += size * of_unit);
            }
        }
        (acceleration, multiplier)
    }

    /// `∂[R; S]/∂s` at every state where `solved` are accelerations and multipliers, one
    /// column each: one column per variable and row, the rows of a variable together; `None` where a row does not
    /// depend on a variable. The mass matrix need not be regular.
    pub fn residuals(
        &self,
        states: &States,
        parameters: &[f64],
        solved: &[Vec<f64>],
    ) -> Vec<Option<Vec<f64>>> {
        let mut residuals = vec![None; self.rows * self.variables];
        let entries = self.entries(states, parameters, solved);
        for (&place, entry) in self.occupied.iter().zip(entries) {
            residuals[place] = Some(entry);
        }
        residuals
    }

    /// `∂(M a − Q)/∂s` at every state, where these are the `accelerations`, one column each, and constraints exert
    /// nothing: per variable and coordinate a value per state.
    pub fn forces(
        &self,
        states: &States,
        parameters: &[f64],
        accelerations: &[Vec<f64>],
    ) -> Vec<Vec<Vec<f64>>> {
        let nothing = vec![0.0; states.len()];
        let mut solved = accelerations.to_vec();
        solved.resize(self.rows, nothing.clone());
        let mut rows = self.residuals(states, parameters, &solved);
        let of_variable = rows.chunks_mut(self.rows).map(|rows| {
            let forces = rows[..accelerations.len()].iter_mut();
            forces.map(|row| row.take().unwrap_or_else(|| nothing.clone()))
        });
        of_variable.map(Iterator::collect).collect()
    }

    /// Residuals of the rows that depend on variables, as [`Self::occupied`] counts them.
    fn entries(&self, states: &States, parameters: &[f64], solved: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = self.slopes.as_ref().map_or(0, |slopes| slopes.states.len());
        let past = columns_with_slopes(states, parameters, count);
        let own = past.len() - states.memory.delay_rate.len() - count;
        let mut columns = past[..own].to_vec();
        columns.extend(solved.iter().map(|column| Column::Each(column)));
        columns.extend(&past[own..]);
        self.tape.evaluate_all(&columns, states.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_codegen::{Library, compile};

    /// Three joints whose third follows the first, with more parameters than entries in their columns.
    const ARM: &str = "
        model arm; coordinate a: rad; coordinate b: rad; coordinate c: rad; input a: N*m;
        parameter k: N*m/rad = 2; parameter d: N*m*s = 0.3; parameter e: N*m*s = 0.1;
        parameter f: N*m*s = 0.2; parameter g: kg*m^2 = 0.4; parameter h: N*m = 0.1; parameter i: kg*m^2 = 0.02;
        parameter r: 1 = 0.5; parameter w: rad/s = 0.1;
        body upper { frame: rotate_z(a); mass: 2; center: (0.2, 0, 0); inertia: diag(0.02, 0.02, 0.02); }
        body lower { frame: upper * translate(0.4, 0, 0) * rotate_z(b); mass: 1;
                     center: (0.15, 0, 0); inertia: diag(0.01, 0.01, 0.01); }
        body wheel { mass: 1; inertia: diag(i, i, i); frame: rotate_z(c); }
        constraint follows: c == r * a;
        gravity (0, -9.81, 0);
        force a = input(a) - d * dot(a) - h * tanh(dot(a) / w);
        force b = -k * b - e * dot(b) - g * dot(b) * abs(dot(b));
        force c = -f * dot(c);";

    /// Many columns with few entries each, against one solution for each.
    #[test]
    fn columns_at_once_are_those_that_each_has_alone() {
        let mut machine = Machine::new(compile("arm", ARM, &Library::empty()).unwrap());
        let values = machine.nominal_parameters();
        let states = States {
            t: vec![0.0, 0.1],
            q: vec![vec![0.3, 0.4], vec![-0.5, 0.2], vec![0.15, 0.2]],
            v: vec![vec![1.0, -0.4], vec![0.6, 2.0], vec![0.5, -0.2]],
            u: vec![vec![3.0, -1.0]],
            ..States::default()
        };
        let motions = machine.motion(&states, &values).unwrap();
        let variables: Vec<Variable> = (0..values.len()).map(Variable::Parameter).collect();
        let together = machine.sensitivity(&variables);
        let sparse = together.occupied.len() + 4 * 3 < together.variables * 3;
        assert!(sparse, "{}", together.occupied.len());
        let together = together.evaluate(&states, &values, &motions);
        for (column, variable) in variables.iter().enumerate() {
            let alone = machine.sensitivity(&[*variable]);
            let alone = alone.evaluate(&states, &values, &motions);
            for (all, one) in together.iter().zip(&alone) {
                let missed = [
                    (all.0.column(column) - one.0.column(0)).amax() / (1.0 + one.0.amax()),
                    (all.1.column(column) - one.1.column(0)).amax() / (1.0 + one.1.amax()),
                ];
                assert!(
                    one.0.amax() > 0.0 && missed.iter().all(|m| *m < 1e-12),
                    "{variable:?} {missed:?}"
                );
            }
        }
    }
}
