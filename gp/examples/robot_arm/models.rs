//! The models of Fig. 5.10: what they know of a state, and what they predict.

use crate::Failure;
use crate::arm::{Arm, N, State, Vector, contact};
use crate::record::{NOISE, Sample, input};
use crate::training::{Effort, prior, trained};
use dynamics::constrained::Baumgarte;
use gp::{
    Functionals, GaussPoint, Inputs, Layout, Model, Posterior, Prediction, Quantity, Rows, Scaling,
};

/// Coordinates of the kernel input `(q, v, u)`.
pub const DIMS: usize = 3 * N;

/// A model of the acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One independent SE-GP per acceleration.
    Se,
    /// Intrinsic coregionalisation.
    Icm,
    /// Linear coregionalisation: SE, bias and linear part (thesis 5.24).
    Lmc,
    /// GP² on the unconstrained acceleration, zero mean (thesis 5.14).
    AccelerationPrior,
    /// GP² on the forces, zero mean (thesis 5.6): "S-GP".
    ForcePrior,
    /// GP² on the forces, mean `Q_C + Q_u + Q_D`: "S-GP + analytical mean".
    ForcePriorMean,
    /// The same mean, and a prior on the force at the tip: `Q_z = J^T f` (thesis 5.7).
    TipForceMean,
}

impl Kind {
    pub const ALL: [Self; 7] = [
        Self::Se,
        Self::Icm,
        Self::Lmc,
        Self::AccelerationPrior,
        Self::ForcePrior,
        Self::ForcePriorMean,
        Self::TipForceMean,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Se => "SE",
            Self::Icm => "ICM",
            Self::Lmc => "LMC",
            Self::AccelerationPrior => "GP², acceleration prior",
            Self::ForcePrior => "GP², force prior",
            Self::ForcePriorMean => "GP², analytical mean",
            Self::TipForceMean => "GP², mean, force at tip",
        }
    }

    /// Whether it knows nothing of the arm.
    pub fn is_baseline(self) -> bool {
        matches!(self, Self::Se | Self::Icm | Self::Lmc)
    }

    /// Whether it is a GP² with the analytical mean.
    pub fn has_mean(self) -> bool {
        matches!(self, Self::ForcePriorMean | Self::TipForceMean)
    }

    /// Baselines see normalised accelerations, GP² those in rad/s².
    fn outputs(self, y: &[f64]) -> gp::Result<Scaling> {
        if self.is_baseline() {
            Scaling::of_outputs(y, &channels(y.len() / N))
        } else {
            Ok(unit())
        }
    }

    /// Number of latent functions of a GP².
    fn latent(self) -> usize {
        match self {
            Self::TipForceMean => 3,
            _ => N,
        }
    }

    fn layout(self) -> Layout {
        match self {
            Self::AccelerationPrior => Layout::Acceleration,
            _ => Layout::Force,
        }
    }
}

/// A trained model.
pub struct Fit {
    pub kind: Kind,
    inputs: Scaling,
    outputs: Scaling,
    /// One of all outputs, or one per output.
    posteriors: Vec<Posterior>,
}

/// The kernel input of a state.
pub fn scaled(inputs: &Scaling, x: &State) -> Vec<f64> {
    input(x)
        .iter()
        .zip(inputs.shift.iter().zip(&inputs.scale))
        .map(|(x, (shift, scale))| (x - shift) / scale)
        .collect()
}

/// All that is known at a state; the arm's own friction is not used.
pub fn point(
    kind: Kind,
    arm: &Arm,
    x: &State,
    stabilisation: Option<&Baumgarte<f64>>,
) -> gp::Result<GaussPoint> {
    let terms = arm.terms(x);
    let constraint = contact(&terms, x);
    let b = stabilisation.map_or(constraint.b, |how| how.stabilise(&constraint));
    let known = match kind {
        Kind::ForcePriorMean | Kind::TipForceMean => arm.known_force(&terms, x),
        _ => Vector::zeros(),
    };
    // Symmetric, and one row: the order of storage does not matter.
    let (mass, a) = (terms.mass.as_slice(), constraint.a.as_slice());
    GaussPoint::new(mass, a, b.as_slice(), known.as_slice())
}

/// A quantity as a map of the latent functions.
fn rows(
    kind: Kind,
    arm: &Arm,
    x: &State,
    quantity: Quantity,
    stabilisation: Option<&Baumgarte<f64>>,
) -> gp::Result<Rows> {
    let mut rows = point(kind, arm, x, stabilisation)?.rows(quantity, kind.layout())?;
    if kind == Kind::TipForceMean {
        // Of generalised forces, which are `J^T f`.
        let jacobian = arm.terms(x).jacobian;
        let at_tip = |row: &[f64]| {
            let row = Vector::from_column_slice(row);
            [0, 1, 2].map(|k| (jacobian.row(k) * row)[0])
        };
        rows.h = rows.h.chunks(N).flat_map(at_tip).collect();
    }
    Ok(rows)
}

fn structured(
    kind: Kind,
    arm: &Arm,
    inputs: &Scaling,
    samples: &[Sample],
    quantity: Quantity,
) -> gp::Result<Functionals> {
    let mut out = Functionals::new(DIMS, kind.latent());
    for s in samples {
        let rows = rows(kind, arm, &s.x, quantity, None)?;
        out.push(&scaled(inputs, &s.x), &rows.h, &rows.mean)?;
    }
    Ok(out)
}

fn plain(inputs: &Scaling, samples: &[Sample], outputs: usize) -> gp::Result<Functionals> {
    let rows: Vec<Vec<f64>> = samples.iter().map(|s| scaled(inputs, &s.x)).collect();
    Ok(Functionals::identity(&Inputs::from_rows(&rows)?, outputs))
}

fn unit() -> Scaling {
    Scaling {
        shift: vec![0.0; N],
        scale: vec![1.0; N],
    }
}

/// The joint of every entry of accelerations, sample by sample.
pub fn channels(samples: usize) -> Vec<usize> {
    (0..samples).flat_map(|_| 0..N).collect()
}

/// Measured accelerations, sample by sample.
pub fn measured(samples: &[Sample]) -> Vec<f64> {
    samples.iter().flat_map(|s| s.measured).collect()
}

impl Fit {
    /// Train on all samples. `smaller` is the same model with fewer of them: its
    /// hyper-parameters are where the training of a large one begins.
    pub fn new(
        kind: Kind,
        arm: &Arm,
        inputs: &Scaling,
        samples: &[Sample],
        effort: Effort,
        smaller: Option<&Self>,
    ) -> Result<Self, Failure> {
        let y = measured(samples);
        let start = prior(kind, samples);
        let outputs = kind.outputs(&y)?;
        let y = outputs.outputs(&y, &channels(samples.len()))?;
        let noise: Vec<f64> = outputs.scale.iter().map(|s| (NOISE / s).powi(2)).collect();
        let smaller = |d: usize| smaller.map(|fit| &fit.posteriors[d]);
        let posteriors = if kind == Kind::Se {
            let data = plain(inputs, samples, 1)?;
            let one = |d: usize| {
                let y: Vec<f64> = y.iter().skip(d).step_by(N).copied().collect();
                trained(
                    kind,
                    Model::new(start.clone(), &noise[d..=d])?,
                    smaller(d),
                    &data,
                    &y,
                    effort,
                )
            };
            (0..N).map(one).collect::<gp::Result<Vec<_>>>()?
        } else {
            let data = if kind.is_baseline() {
                plain(inputs, samples, N)?
            } else {
                structured(kind, arm, inputs, samples, Quantity::Acceleration)?
            };
            let model = Model::new(start, &noise)?;
            vec![trained(kind, model, smaller(0), &data, &y, effort)?]
        };
        Ok(Self {
            kind,
            inputs: inputs.clone(),
            outputs,
            posteriors,
        })
    }

    /// A GP² with analytical mean that was trained elsewhere.
    pub fn given(inputs: &Scaling, posterior: Posterior) -> Self {
        Self {
            kind: Kind::ForcePriorMean,
            inputs: inputs.clone(),
            outputs: unit(),
            posteriors: vec![posterior],
        }
    }

    /// Mean and variance of a quantity; baselines know the acceleration alone.
    pub fn predict(
        &self,
        arm: &Arm,
        samples: &[Sample],
        quantity: Quantity,
    ) -> Result<Prediction, Failure> {
        if !self.kind.is_baseline() {
            let at = structured(self.kind, arm, &self.inputs, samples, quantity)?;
            return Ok(self.posteriors[0].predict(&at)?);
        }
        if quantity != Quantity::Acceleration {
            return Err(format!("{} predicts accelerations alone", self.kind.name()).into());
        }
        let raw = if self.kind == Kind::Se {
            let at = plain(&self.inputs, samples, 1)?;
            let each: gp::Result<Vec<Prediction>> =
                self.posteriors.iter().map(|p| p.predict(&at)).collect();
            let each = each?;
            let weave = |f: &dyn Fn(&Prediction) -> &[f64]| -> Vec<f64> {
                (0..samples.len())
                    .flat_map(|i| each.iter().map(move |p| (p, i)))
                    .map(|(p, i)| f(p)[i])
                    .collect()
            };
            Prediction {
                mean: weave(&|p| &p.mean),
                variance: weave(&|p| &p.variance),
            }
        } else {
            self.posteriors[0].predict(&plain(&self.inputs, samples, N)?)?
        };
        let channels = channels(samples.len());
        Ok(self.outputs.restore_prediction(&raw, &channels)?)
    }

    /// Mean acceleration alone: cheap, for scores.
    pub fn mean(&self, arm: &Arm, samples: &[Sample]) -> Result<Vec<f64>, Failure> {
        if !self.kind.is_baseline() {
            let at = structured(
                self.kind,
                arm,
                &self.inputs,
                samples,
                Quantity::Acceleration,
            )?;
            return Ok(self.posteriors[0].mean(&at)?);
        }
        let outputs = if self.kind == Kind::Se { 1 } else { N };
        let at = plain(&self.inputs, samples, outputs)?;
        let each: gp::Result<Vec<Vec<f64>>> = self.posteriors.iter().map(|p| p.mean(&at)).collect();
        let each = each?;
        let raw: Vec<f64> = if self.kind == Kind::Se {
            (0..samples.len())
                .flat_map(|i| each.iter().map(move |m| m[i]))
                .collect()
        } else {
            each.concat()
        };
        Ok(self.outputs.restore(&raw, &channels(samples.len()))?)
    }

    /// Mean acceleration at one state, with Baumgarte's `b̃` where the model has a
    /// constraint to stabilise.
    pub fn acceleration(
        &self,
        arm: &Arm,
        x: &State,
        stabilisation: Option<&Baumgarte<f64>>,
    ) -> Result<[f64; N], Failure> {
        let z = scaled(&self.inputs, x);
        let a = if self.kind.is_baseline() {
            let sample = Sample {
                t: 0.0,
                x: *x,
                measured: [0.0; N],
                differences: [0.0; N],
                truth: [0.0; N],
                lambda: 0.0,
            };
            self.mean(arm, &[sample])?
        } else {
            let rows = rows(self.kind, arm, x, Quantity::Acceleration, stabilisation)?;
            self.posteriors[0].mean_at(&z, &rows.h, &rows.mean)?
        };
        Ok(std::array::from_fn(|i| a[i]))
    }
}
