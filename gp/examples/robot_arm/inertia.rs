//! Mass and centre of gravity of the last link, estimated together with the
//! hyper-parameters of GP², and by an analytical model without friction (Fig. 5.12).

use crate::Failure;
use crate::arm::{Arm, N, State};
use crate::models::{DIMS, Effort, Fit, Kind, force_prior, measured, point, scaled, training};
use crate::record::{NOISE, Sample};
use gp::{
    Atlas, Functionals, Kernel, LatentPrior, Layout, Model, PointTangent, Posterior, Problem,
    Quantity, Scaling, Structure, Tangent,
};
use std::sync::Mutex;

/// Where the estimates start: mass (kg), centre of gravity (m).
pub const START: [f64; 4] = [2.5, 0.05, 0.05, -0.05];

/// The measured accelerations as functions of the last link's parameters.
struct EndLink<'a> {
    arm: &'a Arm,
    inputs: &'a Scaling,
    samples: &'a [Sample],
    /// Every parameter that the optimiser tried.
    tried: Mutex<Vec<[f64; 4]>>,
}

/// The optimiser works in kg and dm, so that all four are of order one.
const UNIT: [f64; 4] = [1.0, 0.1, 0.1, 0.1];

fn array(theta: &[f64]) -> [f64; 4] {
    std::array::from_fn(|i| theta[i] * UNIT[i])
}

fn known_point(arm: &Arm, x: &State) -> gp::Result<gp::GaussPoint> {
    point(Kind::ForcePriorMean, arm, x, None)
}

impl Structure for EndLink<'_> {
    fn n_theta(&self) -> usize {
        4
    }

    fn functionals(&self, theta: &[f64]) -> gp::Result<Functionals> {
        let mut tried = self
            .tried
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        tried.push(array(theta));
        drop(tried);
        let arm = self.arm.known(array(theta));
        let mut out = Functionals::new(DIMS, N);
        for s in self.samples {
            let rows = known_point(&arm, &s.x)?.rows(Quantity::Acceleration, Layout::Force)?;
            out.push(&scaled(self.inputs, &s.x), &rows.h, &rows.mean)?;
        }
        Ok(out)
    }

    fn tangents(&self, theta: &[f64]) -> gp::Result<Vec<Tangent>> {
        let arm = self.arm.known(array(theta));
        let mut out = vec![Tangent::default(); theta.len()];
        for s in self.samples {
            let point = known_point(&arm, &s.x)?;
            let slopes = arm.slopes(&s.x).into_iter().zip(UNIT);
            for (out, (slope, unit)) in out.iter_mut().zip(slopes) {
                let tangent = PointTangent {
                    mass: slope.mass.iter().map(|v| v * unit).collect(),
                    known: slope.bias.iter().map(|v| v * unit).collect(),
                    ..PointTangent::zero(N, 1)
                };
                let t = point.tangent(&tangent, Quantity::Acceleration, Layout::Force)?;
                out.rows.extend(t.rows);
                out.mean.extend(t.mean);
            }
        }
        Ok(out)
    }
}

/// Result of an estimation.
pub struct Estimate {
    pub theta: [f64; 4],
    /// What the optimiser tried, evaluation by evaluation.
    pub tried: Vec<[f64; 4]>,
    /// The GP² at these parameters; none for the analytical model.
    pub fit: Option<Fit>,
}

/// Estimate from samples, with forces of GP² or without any unknown force.
pub fn estimate(
    arm: &Arm,
    inputs: &Scaling,
    samples: &[Sample],
    effort: Effort,
    structured: bool,
) -> Result<Estimate, Failure> {
    let structure = EndLink {
        arm,
        inputs,
        samples,
        tried: Mutex::default(),
    };
    let prior = if structured {
        force_prior()
    } else {
        // Forces so small that the evidence is a sum of squares.
        let none = Kernel::squared_exponential(&[1.0; DIMS], 1e-12);
        LatentPrior::independent(vec![none; N])
    };
    let y = measured(samples);
    let model = Model::new(prior, &[NOISE * NOISE; N])?;
    let problem = Problem::new(model, &structure, &y).with_theta(
        &std::array::from_fn::<_, 4, _>(|i| START[i] / UNIT[i]),
        Atlas::free(4),
    );
    let mut training = training(&problem, effort.iterations)?.bounds("theta[0]", 1.5, 3.0)?;
    for i in 1..4 {
        training = training.bounds(&format!("theta[{i}]"), -1.0, 1.0)?;
    }
    if !structured {
        training = training.fix("term*")?;
    }
    let fitted = training.run(&problem)?;
    let fit = if structured {
        let posterior = Posterior::new(&fitted.model, &structure.functionals(&fitted.theta)?, &y)?;
        Some(Fit::given(inputs, posterior))
    } else {
        None
    };
    let tried = structure.tried.into_inner();
    Ok(Estimate {
        theta: array(&fitted.theta),
        tried: tried.unwrap_or_else(std::sync::PoisonError::into_inner),
        fit,
    })
}
