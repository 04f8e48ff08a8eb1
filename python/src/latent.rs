//! A force that a model lacks, learnt from accelerations as a Gaussian process (GP²).

use crate::arrays::Rows;
use crate::error::{Error, unsolved};
use crate::model::Model;
use crate::place::{Array, fill};
use crate::terms::Equations;
use crate::wait::wait;
use gp::{
    Functionals, GaussPoint, GpError, Inputs, Kernel, LatentPrior, Layout, Posterior, Prediction,
    Problem, Quantity, Scaling, Training, farthest_points,
};
use identify::machine::{Motion, SolveError, States};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Bounds of length-scales, in units of the variable's standard deviation.
const LENGTHS: (f64, f64) = (0.05, 100.0);
/// Bounds of prior variances, in units of the residual's.
const VARIANCES: (f64, f64) = (1e-6, 1e3);
/// Bounds of noise variances, in units of the residual's.
const NOISE: (f64, f64) = (1e-8, 10.0);
/// Where noise starts.
const FIRST_NOISE: f64 = 0.1;
/// Outputs below this share of the largest are not magnified any further.
const SMALLEST: f64 = 1e-6;

/// Why nothing was learnt or predicted.
#[derive(Debug)]
enum Failure {
    Motion(SolveError),
    Process(GpError),
}

impl From<SolveError> for Failure {
    fn from(error: SolveError) -> Self {
        Self::Motion(error)
    }
}

impl From<GpError> for Failure {
    fn from(error: GpError) -> Self {
        Self::Process(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Motion(error) => unsolved(error),
            Failure::Process(error) => Error::new_err(error.to_string()),
        }
    }
}

/// A model at rows of `q`, `v` and `u`.
struct Subject {
    equations: Arc<Equations>,
    values: Vec<f64>,
    /// Which entries of a row the force depends on.
    columns: Vec<usize>,
}

impl Subject {
    /// The motions that the model demands, and the variables of the force, one row each.
    fn look(&self, rows: &[f64]) -> Result<(Vec<Motion>, Vec<Vec<f64>>), SolveError> {
        let (n, k) = (
            self.equations.coordinates.len(),
            self.equations.inputs.len(),
        );
        let rows: Vec<&[f64]> = rows.chunks(2 * n + k).collect();
        let columns = |range: std::ops::Range<usize>| -> Vec<Vec<f64>> {
            range
                .map(|i| rows.iter().map(|row| row[i]).collect())
                .collect()
        };
        let machine = self.equations.machine();
        let states = States {
            t: vec![0.0; rows.len()],
            q: columns(0..n),
            v: columns(n..2 * n),
            u: columns(2 * n..2 * n + k),
            ..States::default()
        };
        let states = machine.at_rest(&states, &self.values);
        let motions = machine.motion(&states, &self.values)?;
        let variables = |row: &&[f64]| self.columns.iter().map(|&i| row[i]).collect();
        Ok((motions, rows.iter().map(variables).collect()))
    }
}

/// What is asked of a state: a quantity of the motion, or the learnt force itself.
#[derive(Debug, Clone, Copy)]
enum Asked {
    Of(Quantity),
    Missing,
}

impl Asked {
    fn parse(name: &str) -> PyResult<Self> {
        Ok(match name {
            "acceleration" => Self::Of(Quantity::Acceleration),
            "multiplier" => Self::Of(Quantity::Multiplier),
            "constraint_force" => Self::Of(Quantity::ConstraintForce),
            "unconstrained_acceleration" => Self::Of(Quantity::UnconstrainedAcceleration),
            "missing_force" => Self::Missing,
            other => {
                let message = format!(
                    "`quantity` is \"acceleration\", \"missing_force\", \"multiplier\", \
                     \"constraint_force\" or \"unconstrained_acceleration\", not {other:?}"
                );
                return Err(Error::new_err(message));
            }
        })
    }

    /// Adds the rows of a state.
    fn push(self, of: &mut Functionals, x: &[f64], motion: &Motion) -> Result<(), GpError> {
        let terms = &motion.terms;
        let n = terms.force.len();
        match self {
            Self::Missing => {
                let one = |i: usize| if i.is_multiple_of(n + 1) { 1.0 } else { 0.0 };
                let rows: Vec<f64> = (0..n * n).map(one).collect();
                of.push(x, &rows, &vec![0.0; n])
            }
            Self::Of(quantity) => {
                let (mass, rows) = (&terms.mass_matrix, terms.constraint_matrix.transpose());
                let point = GaussPoint::new(
                    mass.as_slice(),
                    rows.as_slice(),
                    terms.constraint_bias.as_slice(),
                    terms.force.as_slice(),
                )?;
                let rows = point.rows(quantity, Layout::Force)?;
                of.push(x, &rows.h, &rows.mean)
            }
        }
    }
}

/// What was learnt.
#[pyclass(frozen, module = "dynamics._native")]
pub struct Learnt {
    subject: Arc<Subject>,
    process: Arc<Process>,
    /// Nats by which the model explains the points that it learnt from.
    #[pyo3(get)]
    log_evidence: f64,
    /// Standard deviation of the accelerations' noise, one per coordinate.
    #[pyo3(get)]
    noise: Vec<f64>,
    /// Standard deviation of the force before anything was learnt, one per coordinate.
    #[pyo3(get)]
    signal: Vec<f64>,
    /// Length-scales in the variables' units, one row per coordinate.
    #[pyo3(get)]
    lengths: Vec<Vec<f64>>,
}

/// A posterior with the units of what goes in and comes out.
struct Process {
    posterior: Posterior,
    inputs: Scaling,
    /// Size of the force along each coordinate.
    force: Vec<f64>,
}

/// Learns the force that a model lacks; `dynamics.gp` says what the arguments are.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn learn(
    py: Python<'_>,
    model: &Model,
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    names: Vec<String>,
    columns: Vec<usize>,
    points: usize,
    restarts: usize,
    seed: u64,
) -> PyResult<Learnt> {
    model.refuse_twist()?;
    let x = Rows::read(x, "X", &names)?;
    let y = Rows::read(y, "y", &model.equations.coordinates)?;
    if x.batch().len() != 1 || x.batch() != y.batch() || x.batch()[0] == 0 {
        let message =
            "`X` and `y` must have the same number of rows, one state each, and one at least";
        return Err(Error::new_err(message));
    }
    if points == 0 || columns.is_empty() || columns.iter().any(|&i| i >= names.len()) {
        let message = "`points` and `columns` must not be empty";
        return Err(Error::new_err(message));
    }
    let subject = Arc::new(Subject {
        equations: Arc::clone(&model.equations),
        values: model.values.clone(),
        columns,
    });
    let (x, y) = (x.values().to_vec(), y.values().to_vec());
    let work = move || teach(subject, &x, &y, (points, restarts, seed));
    Ok(wait(py, &Arc::new(AtomicBool::new(false)), work)??)
}

fn teach(
    subject: Arc<Subject>,
    x: &[f64],
    y: &[f64],
    (points, restarts, seed): (usize, usize, u64),
) -> Result<Learnt, Failure> {
    let (motions, variables) = subject.look(x)?;
    let n = subject.equations.coordinates.len();
    let raw = Inputs::from_rows(&variables)?;
    let inputs = Scaling::of_inputs(&raw)?;
    let scaled = inputs.inputs(&raw)?;
    let chosen = farthest_points(&scaled, points, 0)?;
    let residual = |&k: &usize| {
        let measured = motions[k].acceleration.iter().zip(&y[k * n..]);
        measured.map(|(a, y)| y - a).collect::<Vec<f64>>()
    };
    let residuals: Vec<Vec<f64>> = chosen.iter().map(residual).collect();
    let forces = chosen.iter().zip(&residuals).map(|(&k, residual)| {
        let mass = &motions[k].terms.mass_matrix;
        mass.row_iter()
            .map(|row| row.iter().zip(residual).map(|(m, a)| m * a).sum())
            .collect()
    });
    let force = sizes(&forces.collect::<Vec<Vec<f64>>>());
    let size = sizes(&residuals);
    let mut data = Functionals::new(scaled.dims(), n);
    for &k in &chosen {
        Asked::Of(Quantity::Acceleration).push(&mut data, &scaled.point(k), &motions[k])?;
    }
    let none = vec![0.0; n];
    let data = data.with_latent_scale(&force)?.normalised(&none, &size)?;
    let measured: Vec<f64> = chosen
        .iter()
        .flat_map(|&k| y[k * n..][..n].iter().zip(&size).map(|(y, s)| y / s))
        .collect();
    // In many dimensions points are far apart.
    let length = (scaled.dims() as f64).sqrt();
    let kernel = Kernel::squared_exponential(&vec![length; scaled.dims()], 1.0);
    let prior = LatentPrior::independent(vec![kernel; n]);
    let problem = Problem::new(
        gp::Model::new(prior, &vec![FIRST_NOISE; n])?,
        &data,
        &measured,
    );
    let fitted = Training::new(&problem)
        .bounds("*log_length*", LENGTHS.0.ln(), LENGTHS.1.ln())?
        .bounds("*log_variance*", VARIANCES.0.ln(), VARIANCES.1.ln())?
        .bounds("*log_noise*", NOISE.0.ln(), NOISE.1.ln())?
        .start_in("*log_length*", (0.5 * length).ln(), (2.0 * length).ln())?
        .restarts(restarts.max(1))
        .seed(seed)
        .run(&problem)?;
    let posterior = Posterior::new(&fitted.model, &data, &measured)?;
    // Independent terms: each has its length-scales, then its variance.
    let parameters = fitted.model.prior.params();
    let kernels: Vec<&[f64]> = parameters.chunks(scaled.dims() + 1).collect();
    let own = |kernel: &&[f64]| {
        let lengths = kernel.iter().zip(&inputs.scale);
        lengths.map(|(l, s)| l.exp() * s).collect()
    };
    let signals = kernels.iter().zip(&force);
    let noises = fitted.model.log_noise.iter().zip(&size);
    Ok(Learnt {
        log_evidence: -fitted.nll,
        noise: noises.map(|(v, s)| (0.5 * v).exp() * s).collect(),
        signal: signals
            .map(|(kernel, s)| (0.5 * kernel[scaled.dims()]).exp() * s)
            .collect(),
        lengths: kernels.iter().map(own).collect(),
        subject,
        process: Arc::new(Process {
            posterior,
            inputs,
            force,
        }),
    })
}

/// Root mean squares of the components, none far below the largest.
fn sizes(rows: &[Vec<f64>]) -> Vec<f64> {
    let width = rows.first().map_or(0, Vec::len);
    let rms: Vec<f64> = (0..width)
        .map(|i| {
            let squares: f64 = rows.iter().map(|row| row[i] * row[i]).sum();
            (squares / rows.len() as f64).sqrt()
        })
        .collect();
    let largest = rms.iter().fold(0.0_f64, |m, &x| m.max(x));
    // A model without any error has no scale.
    let least = match largest > 0.0 {
        true => SMALLEST * largest,
        false => 1.0,
    };
    rms.iter().map(|&x| x.max(least)).collect()
}

#[pymethods]
impl Learnt {
    /// Mean and standard deviation at rows of `q`, `v` and `u`.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        names: Vec<String>,
        quantity: &str,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let rows = Rows::read(x, "X", &names)?;
        let asked = Asked::parse(quantity)?;
        let [samples] = *rows.batch() else {
            return Err(Error::new_err("`X` must have one row per state"));
        };
        let model = &self.subject.equations.loaded.compiled.model;
        let width = match asked {
            Asked::Of(Quantity::Multiplier) => model.constraints.len(),
            _ => model.coordinates.len(),
        };
        let predicted = match samples * width {
            0 => None,
            _ => {
                let x = rows.values().to_vec();
                let (subject, process) = (Arc::clone(&self.subject), Arc::clone(&self.process));
                let work = move || process.predict(&subject, &x, asked);
                Some(wait(py, &Arc::new(AtomicBool::new(false)), work)??)
            }
        };
        let filled = |values: &dyn Fn(&Prediction) -> Vec<f64>| {
            fill(py, &[samples], &[width], |out, _| {
                if let Some(predicted) = &predicted {
                    out.copy_from_slice(&values(predicted));
                }
                Ok(())
            })
        };
        Ok((
            filled(&|p| p.mean.clone())?,
            filled(&|p| p.variance.iter().map(|v| v.sqrt()).collect())?,
        ))
    }
}

impl Process {
    fn predict(&self, subject: &Subject, x: &[f64], asked: Asked) -> Result<Prediction, Failure> {
        let (motions, variables) = subject.look(x)?;
        let scaled = self.inputs.inputs(&Inputs::from_rows(&variables)?)?;
        let mut at = Functionals::new(scaled.dims(), self.force.len());
        for (k, motion) in motions.iter().enumerate() {
            asked.push(&mut at, &scaled.point(k), motion)?;
        }
        Ok(self
            .posterior
            .predict(&at.with_latent_scale(&self.force)?)?)
    }
}
