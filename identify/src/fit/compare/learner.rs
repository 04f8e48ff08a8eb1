//! The three semi-parametric models: what each learns from, and what it predicts.

use super::super::FitError;
use super::super::frame::{Frame, projector};
use super::along::{Along, Predicted};
use super::process::{Trained, train};
use super::{Process, Settings};
use crate::machine::{Machine, Motion};
use crate::trace::deviation;
use gp::{Functionals, GpError, Inputs, farthest_points};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rows of the joint covariance of GP² that training stays quick with, and bounds of the
/// number of points.
const ROWS: usize = 1200;
const POINTS: (usize, usize) = (100, 400);
/// Of a long log every few samples will do to choose from.
const CHOICE: usize = 20;
/// Outputs below this share of the largest are not magnified any further.
const SMALLEST: f64 = 1e-6;

/// Where a force shows nothing by itself, training begins at this share of its size.
const FAINT: f64 = 0.1;

/// What all models share: points and variables.
pub(super) struct Learner<'a> {
    pub train: &'a Along,
    /// Samples of the training log.
    pub points: Vec<usize>,
    pub variables: Vec<String>,
    coordinates: Vec<String>,
    /// Standardised variables at the points.
    here: Inputs,
    /// Standardised variables at every sample of the log that is judged by.
    there: Inputs,
    seed: u64,
    /// As in [`Settings`].
    pub clock: Option<fn() -> f64>,
}

/// How learnt functions become accelerations at a state, `n×k`.
type Map = Box<dyn Fn(&Motion) -> DMatrix<f64>>;

/// A trained model.
pub(super) struct Taught {
    pub processes: Vec<Process>,
    pub noise: BTreeMap<String, f64>,
    pub gain: f64,
    /// Learnt functions at every sample that is judged by, `k` each.
    learnt: Vec<DVector<f64>>,
    map: Map,
}

impl Taught {
    /// Accelerations to be added to those of the model; per coordinate, a value per sample.
    pub fn added(&self, asked: &Predicted) -> Result<Vec<Vec<f64>>, GpError> {
        let each: Vec<DVector<f64>> = (asked.motions.iter().zip(&self.learnt))
            .map(|(motion, learnt)| (self.map)(motion) * learnt)
            .collect();
        let n = asked.acceleration.len();
        Ok((0..n)
            .map(|i| each.iter().map(|a| a[i]).collect())
            .collect())
    }
}

impl<'a> Learner<'a> {
    pub fn new(
        machine: &Machine,
        train: &'a Along,
        test: &Along,
        settings: &Settings,
    ) -> Result<Self, FitError> {
        let model = &machine.compiled.model;
        let names = |prefix: &str, names: Vec<&String>| -> Vec<String> {
            names.iter().map(|name| format!("{prefix}{name}")).collect()
        };
        let coordinates: Vec<&String> = model.coordinates.iter().map(|c| &c.name).collect();
        let mut variables = names("q_", coordinates.clone());
        variables.extend(names("dq_", coordinates.clone()));
        variables.extend(names("u_", model.inputs.iter().map(|u| &u.name).collect()));
        // What stands still tells nothing.
        let own = columns(train);
        let pick =
            |values: &[f64]| -> Vec<f64> { train.inner.iter().map(|&k| values[k]).collect() };
        let scales: Vec<(f64, f64)> = own.iter().map(|c| scale(&pick(c))).collect();
        let moving: Vec<usize> = (0..own.len()).filter(|&i| scales[i].1 > 0.0).collect();
        if moving.is_empty() || train.inner.is_empty() || test.inner.is_empty() {
            return Err(FitError::Motionless);
        }
        let standard = |columns: &[&Vec<f64>], k: usize| -> Vec<f64> {
            let value = |&i: &usize| (columns[i][k] - scales[i].0) / scales[i].1;
            moving.iter().map(value).collect()
        };
        let n = coordinates.len().max(1);
        let wanted = settings
            .points
            .unwrap_or((ROWS / n).clamp(POINTS.0, POINTS.1));
        let stride = (train.inner.len() / (CHOICE * wanted.max(1))).max(1);
        let candidates: Vec<usize> = train.inner.iter().copied().step_by(stride).collect();
        let places: Vec<Vec<f64>> = candidates.iter().map(|&k| standard(&own, k)).collect();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(settings.seed);
        let first = random.random_range(0..candidates.len());
        let chosen = farthest_points(&Inputs::from_rows(&places)?, wanted, first)?;
        let here: Vec<Vec<f64>> = chosen.iter().map(|&i| places[i].clone()).collect();
        let others = columns(test);
        let there: Vec<Vec<f64>> = (0..test.len()).map(|k| standard(&others, k)).collect();
        Ok(Self {
            train,
            points: chosen.into_iter().map(|i| candidates[i]).collect(),
            coordinates: coordinates.into_iter().cloned().collect(),
            variables: moving.iter().map(|&i| variables[i].clone()).collect(),
            here: Inputs::from_rows(&here)?,
            there: Inputs::from_rows(&there)?,
            seed: settings.seed,
            clock: settings.clock,
        })
    }

    /// `a + g(x)` [4.28]: a process per coordinate on the residual acceleration.
    pub fn output_residual(&self, known: &Predicted) -> Result<Taught, GpError> {
        let n = self.coordinates.len();
        let observed: Vec<DVector<f64>> = (self.points.iter())
            .map(|&k| known.residual_at(k))
            .collect();
        self.apart(
            &observed,
            &self.coordinates,
            Box::new(move |_| DMatrix::identity(n, n)),
        )
    }

    /// `a + P J_u ε_u(x)` [4.37]: a process per direction that no multiplier reaches, on
    /// `ε_u = J_uᵀ M (a_measured − a) = J_uᵀ (M a_measured − Q)`.
    pub fn contact_invariant(&self, known: &Predicted) -> Result<Taught, GpError> {
        let matrices = self
            .points
            .iter()
            .map(|&k| &known.motions[k].terms.constraint_matrix);
        let frame = Frame::new(self.coordinates.len(), matrices);
        let observe = |&k: &usize| {
            let terms = &known.motions[k].terms;
            let basis = frame.at(&terms.constraint_matrix);
            basis.tr_mul(&(&terms.mass_matrix * known.residual_at(k)))
        };
        let observed: Vec<DVector<f64>> = self.points.iter().map(observe).collect();
        let names = frame.names(&self.coordinates);
        let map = move |motion: &Motion| {
            motion.factorisation.mobility() * frame.at(&motion.terms.constraint_matrix)
        };
        self.apart(&observed, &names, Box::new(map))
    }

    /// Independent processes, one per observed component.
    fn apart(
        &self,
        observed: &[DVector<f64>],
        names: &[String],
        map: Map,
    ) -> Result<Taught, GpError> {
        let scales = scales(observed, names.len());
        let data = Functionals::identity(&self.here, 1);
        let trained: Vec<Trained> = (0..names.len())
            .into_par_iter()
            .map(|i| {
                let y: Vec<f64> = observed.iter().map(|r| r[i] / scales[i]).collect();
                train(&data, &y, 1, None, self.seed)
            })
            .collect::<Result<_, GpError>>()?;
        let mut learnt = vec![DVector::zeros(names.len()); self.there.len()];
        let (mut processes, mut noise, mut gain) = (Vec::new(), BTreeMap::new(), 0.0);
        for (i, trained) in trained.iter().enumerate() {
            if trained.gain > 0.0 {
                let mean = trained.posterior.latent_mean(&self.there)?;
                for (learnt, mean) in learnt.iter_mut().zip(mean) {
                    learnt[i] = scales[i] * mean;
                }
            }
            gain += trained.gain.max(0.0);
            processes.extend(self.processes(trained, &names[i..=i], &scales[i..=i]));
            noise.insert(names[i].clone(), scales[i] * trained.noise[0]);
        }
        Ok(Taught {
            processes,
            noise,
            gain,
            learnt,
            map,
        })
    }

    /// `a + P f(x)` [5.6]: all forces at once, seen through the constrained dynamics.
    pub fn latent_force(&self, known: &Predicted) -> Result<Taught, GpError> {
        let n = self.coordinates.len();
        let residual = |&k: &usize| known.residual_at(k);
        let observed: Vec<DVector<f64>> = self.points.iter().map(residual).collect();
        let forces: Vec<DVector<f64>> = (self.points.iter().zip(&observed))
            .map(|(&k, r)| &known.motions[k].terms.mass_matrix * r)
            .collect();
        let (scale, force_scale) = (scales(&observed, n), scales(&forces, n));
        let mut data = Functionals::new(self.here.dims(), n);
        let mut y = Vec::new();
        for (i, (&k, residual)) in self.points.iter().zip(&observed).enumerate() {
            let mobility = known.motions[k].factorisation.mobility();
            let rows: Vec<f64> = mobility.transpose().iter().copied().collect();
            data.push(&self.here.point(i), &rows, &vec![0.0; n])?;
            y.extend(residual.iter().zip(&scale).map(|(r, s)| r / s));
        }
        let data = data
            .with_latent_scale(&force_scale)?
            .normalised(&vec![0.0; n], &scale)?;
        let start = self.start(known, &force_scale)?;
        let trained = train(&data, &y, n, Some(&start), self.seed)?;
        let learnt = if trained.gain > 0.0 {
            let mean = trained.posterior.latent_mean(&self.there)?;
            mean.chunks(n)
                .map(|f| DVector::from_fn(n, |i, _| force_scale[i] * f[i]))
                .collect()
        } else {
            vec![DVector::zeros(n); self.there.len()]
        };
        let noise = (self.coordinates.iter().zip(&trained.noise).zip(&scale))
            .map(|((name, sd), scale)| (name.clone(), sd * scale))
            .collect();
        Ok(Taught {
            processes: self.processes(&trained, &self.coordinates, &force_scale),
            noise,
            gain: trained.gain.max(0.0),
            learnt,
            map: Box::new(|motion| motion.factorisation.mobility()),
        })
    }

    /// Where training of GP² begins: kernels of the forces seen one by one, as if each
    /// measured itself. From anywhere else it often ends where a force without memory, white
    /// along the motion, explains everything.
    fn start(
        &self,
        known: &Predicted,
        force_scale: &[f64],
    ) -> Result<Vec<(Vec<f64>, f64)>, GpError> {
        let n = self.coordinates.len();
        let data = Functionals::identity(&self.here, 1);
        let free = |&k: &usize| {
            let terms = &known.motions[k].terms;
            projector(&terms.constraint_matrix) * &terms.mass_matrix * known.residual_at(k)
        };
        let forces: Vec<DVector<f64>> = self.points.iter().map(free).collect();
        let one = |i: usize| {
            let y: Vec<f64> = forces.iter().map(|f| f[i] / force_scale[i]).collect();
            let trained = train(&data, &y, 1, None, self.seed)?;
            let (lengths, sd) = trained.kernels[0].clone();
            Ok(match trained.gain > 0.0 {
                true => (lengths, sd),
                false => (vec![(data.dims() as f64).sqrt(); data.dims()], FAINT),
            })
        };
        (0..n).into_par_iter().map(one).collect()
    }

    fn processes(&self, trained: &Trained, names: &[String], scales: &[f64]) -> Vec<Process> {
        let of = |((lengths, sd), (name, scale)): (&(Vec<f64>, f64), (&String, &f64))| Process {
            of: name.clone(),
            learnt: trained.gain > 0.0,
            signal_sd: sd * scale,
            length_scales: (self.variables.iter().cloned())
                .zip(lengths.iter().copied())
                .collect(),
        };
        let named = names.iter().zip(scales);
        trained.kernels.iter().zip(named).map(of).collect()
    }
}

/// Everything a process may depend on, column by column.
fn columns(along: &Along) -> Vec<&Vec<f64>> {
    let groups = [&along.smooth.q, &along.smooth.v, &along.record.u];
    groups.into_iter().flatten().collect()
}

/// Mean and standard deviation; none for what stays within round-off.
fn scale(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let deviation = deviation(values);
    let still = deviation <= 1e-12 * (1.0 + mean.abs());
    (mean, if still { 0.0 } else { deviation })
}

/// Root mean squares of the components, none far below the largest.
fn scales(observed: &[DVector<f64>], width: usize) -> Vec<f64> {
    let rms: Vec<f64> = (0..width)
        .map(|i| {
            let squares: f64 = observed.iter().map(|r| r[i] * r[i]).sum();
            (squares / observed.len().max(1) as f64).sqrt()
        })
        .collect();
    let largest = rms.iter().fold(0.0_f64, |m, &x| m.max(x));
    // A model without any error has no scale.
    let least = if largest > 0.0 {
        SMALLEST * largest
    } else {
        1.0
    };
    rms.iter().map(|&x| x.max(least)).collect()
}
