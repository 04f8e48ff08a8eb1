//! `dynamics eval`: the equations' terms and the motion at given states.

use crate::answer::{Answer, Quantity};
use crate::json::Text;
use crate::lines::{Line, Lines};
use crate::mistake::Mistake;
use crate::model::{Loaded, ModelArguments};
use crate::output;
use crate::state::State;
use clap::Args;
use dynamics_codegen::derive::Variable;
use dynamics_codegen::{Model, System, Tape};
use identify::machine::{Instruments, Machine, Motion, SensitivityTape, SolveError, States};
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

/// Arguments of `eval`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics eval models/pendulum2.model --states states.jsonl --json
  echo '{\"q\": {\"j1\": 0.1, \"j2\": 0}, \"u\": [1, 0]}' |
    dynamics eval models/pendulum2.model --states - --derivatives --json

Fields of an answer:
  M, bias, B, A, b     terms of the equation of motion (matrices as arrays of rows)
  a, lambda            accelerations and multipliers
  applied, Q           forces stated by the model at zero input; all forces together
  c, c_dot             what the constraints demand to be zero, and its rate (of a
                       nonholonomic constraint, which is itself a rate: c again)
  z_dot                rates of the internal states, by name (`z` in a state gives the
                       states themselves; without it they are as at the beginning)
  outputs              the model's outputs by name
  sensors              what the model's sensors show, by name, without noise
With --derivatives also da_dq, da_dv, da_du, da_dt (rows: coordinates; columns:
variables), da_dparameters (by name), and the same for lambda and for sensors.")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The states, one JSON object per line; `-` for standard input
    #[arg(long, value_name = "FILE.jsonl")]
    states: PathBuf,

    /// Add the derivatives of the accelerations and multipliers
    #[arg(long)]
    derivatives: bool,

    /// Print one JSON object per line instead of text for people
    #[arg(long)]
    json: bool,
}

/// States that are evaluated together.
const BATCH: usize = 1024;
/// Answers are kept in memory up to this size, then in a temporary file.
const SPOOL_BYTES: usize = 64 << 20;

/// Runs the command.
///
/// # Errors
/// If the model or a state is faulty. Of a file with a fault nothing is answered; of
/// standard input, nothing behind the batch with the fault.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load()?;
    let mut evaluator = Evaluator::new(&loaded, arguments.derivatives);
    let mut out = output::stdout();
    if arguments.states == Path::new("-") {
        let mut lines = Lines::stdin();
        while let Some(batch) = lines.batch(BATCH)? {
            evaluator.answer(&batch, arguments.json, &mut out)?;
            out.flush()?;
        }
    } else {
        let mut spool = tempfile::spooled_tempfile(SPOOL_BYTES);
        let mut lines = Lines::open(&arguments.states)?;
        while let Some(batch) = lines.batch(BATCH)? {
            evaluator.answer(&batch, arguments.json, &mut spool)?;
        }
        spool.rewind()?;
        std::io::copy(&mut spool, &mut out)?;
    }
    if evaluator.answered == 0 {
        let message = match arguments.states.to_str() {
            Some("-") => "standard input holds no state".to_string(),
            _ => format!("`{}` holds no state", arguments.states.display()),
        };
        output::warn(
            &Mistake::new(message).help("one JSON object per line: `{\"q\": [0.1, 0.2]}`"),
        );
    }
    Ok(out.flush()?)
}

struct Evaluator<'a> {
    model: &'a Model,
    nominal: &'a [f64],
    machine: Machine,
    outputs: Tape,
    instruments: Instruments,
    derivatives: Option<SensitivityTape>,
    answered: usize,
}

impl<'a> Evaluator<'a> {
    fn new(loaded: &'a Loaded, derivatives: bool) -> Self {
        let Loaded {
            compiled,
            parameters,
            ..
        } = loaded;
        let model = &compiled.model;
        let arguments = System::arguments(model);
        let mut values = compiled.system.outputs.clone();
        values.extend(&compiled.system.state_rates);
        let outputs = Tape::new(&model.graph, &values, &arguments);
        let mut machine = Machine::new(compiled.clone());
        let instruments = machine.instruments(&variables(model));
        let derivatives = derivatives.then(|| machine.sensitivity(&variables(model)));
        Self {
            model,
            nominal: parameters,
            machine,
            outputs,
            instruments,
            derivatives,
            answered: 0,
        }
    }

    fn answer(&mut self, batch: &[Line], json: bool, out: &mut impl Write) -> anyhow::Result<()> {
        let mut states = Vec::with_capacity(batch.len());
        for line in batch {
            let (state, warnings) = State::read(line.text(), self.model, self.nominal)?;
            warnings.iter().for_each(output::warn);
            states.push(state);
        }
        for (line, answer) in batch.iter().zip(self.evaluate(batch, &states)?) {
            if let Some(name) = answer.not_finite() {
                return Err(not_finite(line.text(), name).into());
            }
            self.answered += 1;
            if json {
                serde_json::to_writer(&mut *out, &answer)?;
                writeln!(out)?;
            } else {
                let title = format!("{}:{}", line.file, line.number);
                write!(out, "{}", answer.page(&title))?;
            }
        }
        Ok(())
    }

    /// One answer per state. States that share their parameters are evaluated together.
    fn evaluate(&self, batch: &[Line], states: &[State]) -> Result<Vec<Answer>, Mistake> {
        let mut answers: Vec<Option<Answer>> = vec![None; states.len()];
        for first in 0..states.len() {
            if answers[first].is_some() {
                continue;
            }
            let group: Vec<usize> = (first..states.len())
                .filter(|&i| states[i].parameters == states[first].parameters)
                .collect();
            let members: Vec<&State> = group.iter().map(|&i| &states[i]).collect();
            let evaluated = self.evaluate_group(&members).map_err(|error| {
                unsolved(error, self.model, |sample| batch[group[sample]].text())
            })?;
            for (index, answer) in group.into_iter().zip(evaluated) {
                answers[index] = Some(answer);
            }
        }
        Ok(answers.into_iter().flatten().collect())
    }

    fn evaluate_group(&self, group: &[&State]) -> Result<Vec<Answer>, SolveError> {
        let states = self.columns(group);
        let parameters = &group[0].parameters;
        let motions = self.machine.motion(&states, parameters)?;
        let derivatives = self
            .derivatives
            .as_ref()
            .map(|tape| tape.evaluate(&states, parameters, &motions));
        let mut answers: Vec<Answer> = motions.iter().map(terms).collect();
        for (sample, answer) in answers.iter_mut().enumerate() {
            self.add_memory(&states, sample, parameters, answer);
        }
        self.add_sensors(&states, &motions, parameters, &mut answers);
        if let (Some(derivatives), 1..) = (&derivatives, self.instruments.count()) {
            let slopes = self
                .instruments
                .slopes(&states, &motions, derivatives, parameters);
            for (answer, slopes) in answers.iter_mut().zip(slopes) {
                let rows = slopes.row_iter();
                let rows: Vec<Vec<f64>> = rows.map(|r| r.iter().copied().collect()).collect();
                self.add_derivatives("dsensors", &rows, answer);
            }
        }
        for (answer, (da, dlambda)) in answers.iter_mut().zip(derivatives.into_iter().flatten()) {
            let da: Vec<Vec<f64>> = da.row_iter().map(|r| r.iter().copied().collect()).collect();
            let dlambda: Vec<Vec<f64>> = dlambda
                .row_iter()
                .map(|r| r.iter().copied().collect())
                .collect();
            self.add_derivatives("da", &da, answer);
            self.add_derivatives("dlambda", &dlambda, answer);
        }
        Ok(answers)
    }

    /// The group in columns, with the internal states that are given or those at the
    /// beginning; delayed inputs have always been what they are.
    fn columns(&self, group: &[&State]) -> States {
        let plain = columns(self.model, group);
        let mut states = self.machine.at_rest(&plain, &group[0].parameters);
        for (sample, state) in group.iter().enumerate() {
            for (column, &z) in states.memory.z.iter_mut().zip(state.z.iter().flatten()) {
                column[sample] = z;
            }
        }
        states
    }

    /// Outputs and the rates of internal states.
    fn add_memory(&self, states: &States, sample: usize, parameters: &[f64], answer: &mut Answer) {
        if self.model.outputs.is_empty() && self.model.states.is_empty() {
            return;
        }
        let memory = &states.memory;
        let mut arguments = vec![states.t[sample]];
        for group in [&states.q, &states.v, &states.u, &memory.delayed, &memory.z] {
            arguments.extend(group.iter().map(|column| column[sample]));
        }
        arguments.extend(parameters);
        let mut values = self.outputs.evaluate(&arguments);
        let rates = values.split_off(self.model.outputs.len());
        if !rates.is_empty() {
            let names = self.model.states.iter().map(|z| z.name.clone());
            answer.push("z_dot", Quantity::Scalars(names.zip(rates).collect()));
        }
        if !values.is_empty() {
            let names = self.model.outputs.iter().map(|output| output.name.clone());
            answer.push("outputs", Quantity::Scalars(names.zip(values).collect()));
        }
    }

    /// What the sensors show, without noise.
    fn add_sensors(
        &self,
        states: &States,
        motions: &[Motion],
        parameters: &[f64],
        answers: &mut [Answer],
    ) {
        if self.instruments.count() == 0 {
            return;
        }
        let read = self.instruments.read(states, motions, parameters);
        for (sample, answer) in answers.iter_mut().enumerate() {
            let names = self.model.sensors.iter().map(|sensor| sensor.name.clone());
            let values = read.iter().map(|column| column[sample]);
            answer.push("sensors", Quantity::Scalars(names.zip(values).collect()));
        }
    }

    /// Cuts the columns of `jacobian`, in the order of [`variables`].
    fn add_derivatives(&self, of: &str, jacobian: &[Vec<f64>], answer: &mut Answer) {
        let (n, k) = (self.model.coordinates.len(), self.model.inputs.len());
        let p = self.model.parameters.len();
        let cut = |range: std::ops::Range<usize>| -> Vec<Vec<f64>> {
            jacobian
                .iter()
                .map(|row| row[range.clone()].to_vec())
                .collect()
        };
        let column = |at: usize| -> Vec<f64> { jacobian.iter().map(|row| row[at]).collect() };
        answer.push(format!("{of}_dq"), Quantity::Matrix(cut(0..n)));
        answer.push(format!("{of}_dv"), Quantity::Matrix(cut(n..2 * n)));
        answer.push(format!("{of}_du"), Quantity::Matrix(cut(2 * n..2 * n + k)));
        answer.push(format!("{of}_dt"), Quantity::Vector(column(2 * n + k + p)));
        let names = self.model.parameters.iter().map(|p| p.name.clone());
        let columns = names
            .enumerate()
            .map(|(i, name)| (name, column(2 * n + k + i)));
        let by_name = Quantity::Columns(columns.collect());
        answer.push(format!("{of}_dparameters"), by_name);
    }
}

fn variables(model: &Model) -> Vec<Variable> {
    let (n, k, p) = (
        model.coordinates.len(),
        model.inputs.len(),
        model.parameters.len(),
    );
    let mut variables: Vec<Variable> = (0..n).map(Variable::Position).collect();
    variables.extend((0..n).map(Variable::Velocity));
    variables.extend((0..k).map(Variable::Input));
    variables.extend((0..p).map(Variable::Parameter));
    variables.push(Variable::Time);
    variables
}

fn columns(model: &Model, group: &[&State]) -> States {
    let gather = |count: usize, of: &dyn Fn(&State, usize) -> f64| -> Vec<Vec<f64>> {
        (0..count)
            .map(|index| group.iter().map(|state| of(state, index)).collect())
            .collect()
    };
    let input = |state: &State, index: usize| state.u.as_ref().map_or(0.0, |u| u[index]);
    States {
        t: group.iter().map(|state| state.t).collect(),
        q: gather(model.positions().len(), &|state, i| state.q[i]),
        v: gather(model.coordinates.len(), &|state, i| state.v[i]),
        u: gather(model.inputs.len(), &input),
        ..States::default()
    }
}

fn terms(motion: &Motion) -> Answer {
    let terms = &motion.terms;
    // A macro, so that the linear algebra library stays out of this crate's interface.
    macro_rules! rows {
        ($matrix:expr) => {
            Quantity::Matrix(
                $matrix
                    .row_iter()
                    .map(|r| r.iter().copied().collect())
                    .collect(),
            )
        };
    }
    macro_rules! vector {
        ($vector:expr) => {
            Quantity::Vector($vector.iter().copied().collect())
        };
    }
    let mut answer = Answer::default();
    answer.push("M", rows!(terms.mass_matrix));
    answer.push("bias", vector!(terms.bias_force));
    answer.push("B", rows!(terms.input_matrix));
    answer.push("A", rows!(terms.constraint_matrix));
    answer.push("b", vector!(terms.constraint_bias));
    answer.push("a", vector!(motion.acceleration));
    answer.push("lambda", vector!(motion.multiplier));
    answer.push("applied", vector!(terms.applied_force));
    answer.push("Q", vector!(terms.force));
    answer.push("c", vector!(terms.constraint_residual));
    answer.push("c_dot", vector!(terms.constraint_rate));
    answer
}

/// A state at which the equation has no unique solution.
fn unsolved<'t>(error: SolveError, model: &Model, text: impl Fn(usize) -> Text<'t>) -> Mistake {
    let (message, help) = match error {
        SolveError::Singular { .. } => (
            "the mass matrix is singular here, and the constraints do not make up for it".into(),
            "give every coordinate some inertia",
        ),
        SolveError::Indefinite { coordinate, .. } => (
            format!(
                "the mass matrix is not positive definite here: a motion of `{}` has negative kinetic energy",
                model.coordinates[coordinate].name
            ),
            "correct the masses and inertias, or the signs in `kinetic`",
        ),
        SolveError::Inconsistent { miss, .. } => (
            format!(
                "the constraints contradict each other here (by {miss:.3e} on acceleration level)"
            ),
            "drop or correct one of the constraints",
        ),
        SolveError::Unsettled { .. } => (
            "the forces do not settle here: they depend on multipliers that find no balance".into(),
            "lower friction coefficients: with this much, the contact has no or several motions",
        ),
        SolveError::Pinched { .. } => (
            "no motion keeps the contacts out of all planes here".into(),
            "make room between planes that touch the same body from two sides",
        ),
        SolveError::NotFinite { .. } => (
            "the equation of motion is not finite here".into(),
            "look for a division by zero, or a root or logarithm of something negative",
        ),
    };
    let text = text(error.sample());
    text.mistake(0..text.text.trim_end().len(), "", message)
        .help(help)
}

fn not_finite(text: Text<'_>, name: &str) -> Mistake {
    text.mistake(
        0..text.text.trim_end().len(),
        "",
        format!("`{name}` is not finite here"),
    )
    .help("look for a division by zero, or a root or logarithm at the edge of its domain")
}
