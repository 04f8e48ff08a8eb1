//! GP²: Gaussian processes pushed through known, possibly constrained, linear maps.
//!
//! Rigid bodies under constraints `A a = b` accelerate by `a = L b + P Q̄`
//! (Gauss' principle; thesis 3.38–3.43). A Gaussian process on what is unknown
//! of the forces `Q̄`, pushed through `P`, predicts accelerations that obey the
//! constraint exactly, from few data, and with them every other quantity of the
//! dynamics (thesis chapter 5). This crate is told matrices and means
//! ([`Functionals`]); it knows no robot.
//!
//! # From known physics to a predicted constraint force
//!
//! A bead on the slope `z = x/2` with unknown viscous friction: thirty lines.
//!
//! ```
//! use gp::*;
//!
//! const G: f64 = 9.81;
//! let point = |_v: f64| {
//!     let mass = [1.0, 0.0, 0.0, 1.0]; // M, row-major
//!     let slope = [0.5, -1.0]; // A a = b with b = 0
//!     GaussPoint::new(&mass, &slope, &[0.0], &[0.0, -G]) // Q_K: gravity alone
//! };
//! // Measured accelerations at some speeds; the truth brakes with -0.8 v along the slope.
//! let speeds: Vec<f64> = (0..12).map(|i| -2.0 + 0.36 * i as f64).collect();
//! let mut data = Functionals::new(1, 2);
//! let mut y = Vec::new();
//! for &v in &speeds {
//!     let rows = point(v)?.rows(Quantity::Acceleration, Layout::Force)?;
//!     data.push(&[v], &rows.h, &rows.mean)?;
//!     let along = -G / 5f64.sqrt() - 0.8 * v; // acceleration along (2, 1)/√5
//!     y.extend([along * 2.0 / 5f64.sqrt(), along / 5f64.sqrt()]);
//! }
//! // One squared-exponential kernel shared by both latent forces, noise sd 1e-3.
//! let prior = LatentPrior::shared(2, Kernel::squared_exponential(&[1.0], 1.0));
//! let problem = Problem::new(Model::new(prior, &[1e-6; 2])?, &data, &y);
//! let fitted = Training::new(&problem)
//!     .bounds("*log_length*", 0.5f64.ln(), 20f64.ln())?
//!     .bounds("*log_variance", 0.1f64.ln(), 100f64.ln())?
//!     .fix("log_noise*")?
//!     .run(&problem)?;
//! let posterior = Posterior::new(&fitted.model, &data, &y)?;
//! // Predict acceleration and multiplier at a speed between the data.
//! let ask = |quantity| -> Result<Prediction> {
//!     let rows = point(0.5)?.rows(quantity, Layout::Force)?;
//!     let mut at = Functionals::new(1, 2);
//!     at.push(&[0.5], &rows.h, &rows.mean)?;
//!     posterior.predict(&at)
//! };
//! let a = ask(Quantity::Acceleration)?;
//! assert!((0.5 * a.mean[0] - a.mean[1]).abs() < 1e-12, "A a = b");
//! assert!((a.mean[0] - (-G / 5f64.sqrt() - 0.4) * 2.0 / 5f64.sqrt()).abs() < 0.01);
//! // The slope carries the bead: λ is negative, since A points downwards. Friction
//! // acts along the slope, so the prior's guess across it is all that is uncertain.
//! let lambda = ask(Quantity::Multiplier)?;
//! let (low, high) = lambda.band95();
//! assert!(low[0] < -0.8 * G && -0.8 * G < high[0]);
//! # Ok::<(), GpError>(())
//! ```
//!
//! # Map
//!
//! | step | items |
//! |---|---|
//! | what is known about a state | [`GaussPoint`], [`Quantity`], [`Layout`], [`Functionals`] |
//! | priors | [`Kernel`], [`LatentPrior`] (independent, shared, ICM, LMC), [`Model`] |
//! | evidence and exact gradient | [`evidence`](fn@evidence), [`nll`], [`Workspace`] |
//! | training | [`Problem`], [`Training`], [`Structure`] with [`Atlas`] for physical parameters, [`Penalty`] for MAP |
//! | prediction | [`Posterior`], [`SparsePosterior`], [`LatentSamples`] |
//! | data | [`farthest_points`], [`greedy_points`], [`Scaling`], [`Inputs`] |
//! | files | [`Saved`]; [`SavedSparse`] without the data |
//!
//! # Invariants
//!
//! - Dense factorisations go through `faer`, sequentially; restarts, blocks of
//!   covariance and blocks of test points go in parallel through `rayon`, in an
//!   order of summation that does not depend on the number of threads.
//! - `basin` is used in `optimise/lbfgs.rs` alone.
//! - Nothing of size `(nN)²` exists per hyper-parameter: an evaluation holds two
//!   such matrices in all.
//! - Jitter is reported ([`Evidence::jitter`]), never silent.
//! - All random choices come from a seed.

mod chart;
mod contract;
mod data;
mod envelope;
mod error;
mod evidence;
mod fitted;
mod functional;
mod gauss;
mod gram;
mod inducing;
mod inputs;
mod kernel;
mod latent;
mod linalg;
mod model;
mod optimise;
mod penalty;
mod posterior;
mod problem;
mod save;
mod save_sparse;
mod simd;
mod sparse;
mod sparse_gradient;
mod train;

pub use chart::{Atlas, Chart};
pub use data::{Scaling, farthest_points};
pub use envelope::VERSION;
pub use error::{GpError, Result};
pub use evidence::{Evidence, Workspace, evidence, nll};
pub use fitted::{Fitted, Run};
pub use functional::Functionals;
pub use gauss::{
    CONSISTENCY_TOLERANCE, GaussPoint, Layout, PIVOT_TOLERANCE, PointTangent, Quantity,
    RANK_TOLERANCE, Rows, SYMMETRY_TOLERANCE,
};
pub use inducing::greedy_points;
pub use inputs::Inputs;
pub use kernel::{Ard, Cyclic, Kernel};
pub use latent::{LatentPrior, Mixing, Term};
pub use model::{Model, Structure, Tangent};
pub use optimise::{Algorithm, Progress, Reason};
pub use penalty::Penalty;
pub use posterior::{LatentSamples, Posterior, Prediction, prior_covariance, sample_prior};
pub use problem::Problem;
pub use save::Saved;
pub use save_sparse::SavedSparse;
pub use sparse::SparsePosterior;
pub use sparse_gradient::sparse_evidence;
pub use train::Training;
