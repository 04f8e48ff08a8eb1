//! GP2: Gaussian processes pushed through known, possibly constrained, linear maps.

mod chart;
mod contract;
mod data;
mod error;
mod evidence;
mod fitted;
mod functional;
mod gauss;
mod gram;
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
mod simd;
mod sparse;
mod sparse_gradient;
mod train;

pub use chart::{Atlas, Chart};
pub use data::{Scaling, farthest_points};
pub use error::{GpError, Result};
pub use evidence::{Evidence, Workspace, evidence, nll};
pub use fitted::{Fitted, Run};
pub use functional::Functionals;
pub use gauss::{
    CONSISTENCY_TOLERANCE, GaussPoint, Layout, PointTangent, Quantity, RANK_TOLERANCE, Rows,
};
pub use inputs::Inputs;
pub use kernel::{Ard, Cyclic, Kernel};
pub use latent::{LatentPrior, Mixing, Term};
pub use model::{Model, Structure, Tangent};
pub use optimise::{Algorithm, Progress, Reason};
pub use penalty::Penalty;
pub use posterior::{LatentSamples, Posterior, Prediction, prior_covariance, sample_prior};
pub use problem::Problem;
pub use save::{Saved, VERSION};
pub use sparse::SparsePosterior;
pub use sparse_gradient::sparse_evidence;
pub use train::Training;
