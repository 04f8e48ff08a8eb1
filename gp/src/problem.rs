//! What is to be trained, and its objective.

use crate::chart::Atlas;
use crate::error::{Result, shape};
use crate::evidence::{Workspace, evidence};
use crate::functional::Functionals;
use crate::inputs::Inputs;
use crate::model::{Model, Structure};
use crate::sparse_gradient::sparse_evidence;

/// What is to be trained: a model, a structure, and measurements of it.
pub struct Problem<'a> {
    /// Prior and noise; the values are the given starting point.
    pub model: Model,
    /// What the measurements are functionals of.
    pub structure: &'a dyn Structure,
    /// Measurements, one per row of the structure's functionals.
    pub y: &'a [f64],
    /// Starting values of the model parameters `θ` (empty when there are none).
    pub theta: Vec<f64>,
    /// Parametrisation of `θ`.
    pub atlas: Atlas,
    /// Inducing inputs: train on the variational bound instead of the exact evidence.
    pub inducing: Option<Inputs>,
}

impl<'a> Problem<'a> {
    /// A problem without model parameters.
    pub fn new(model: Model, structure: &'a dyn Structure, y: &'a [f64]) -> Self {
        Self {
            model,
            structure,
            y,
            theta: Vec::new(),
            atlas: Atlas::default(),
            inducing: None,
        }
    }

    /// With model parameters that start at `theta`, parametrised by `atlas`.
    pub fn with_theta(mut self, theta: &[f64], atlas: Atlas) -> Self {
        self.theta = theta.to_vec();
        self.atlas = atlas;
        self
    }

    /// Train on the variational bound through these inducing inputs: for many points.
    pub fn through(mut self, inducing: Inputs) -> Self {
        self.inducing = Some(inducing);
        self
    }

    /// Names of everything the optimiser moves: those of the model, then `theta[i]`
    /// (the unconstrained coordinates of the charts).
    pub fn names(&self) -> Vec<String> {
        let mut out = self.model.param_names();
        out.extend((0..self.theta.len()).map(|i| format!("theta[{i}]")));
        out
    }

    /// The structure, the charts and the starting values agree on the number of `θ`.
    fn check_theta(&self) -> Result<()> {
        let n = self.structure.n_theta();
        if self.theta.len() != n {
            return Err(shape(
                "starting values θ of the problem",
                format!("{n} (model parameters of the structure)"),
                self.theta.len(),
            ));
        }
        if self.atlas.n_theta() != n {
            return Err(shape("parameters of the charts", n, self.atlas.n_theta()));
        }
        Ok(())
    }

    pub(crate) fn point(&self) -> Result<Vec<f64>> {
        self.check_theta()?;
        let mut z = self.model.params();
        z.extend(self.atlas.inverse(&self.theta)?);
        Ok(z)
    }

    pub(crate) fn split(&self, z: &[f64]) -> Result<(Model, Vec<f64>)> {
        let (params, phi) = z.split_at(self.model.n_params());
        let mut model = self.model.clone();
        model.set_params(params)?;
        Ok((model, self.atlas.forward(phi)?))
    }

    /// Negative log evidence and its gradient in everything of [`Problem::names`].
    pub fn objective(&self, z: &[f64], work: &mut Workspace) -> Result<(f64, Vec<f64>)> {
        if z.len() != self.model.n_params() + self.theta.len() {
            return Err(shape("point to evaluate", self.names().len(), z.len()));
        }
        self.check_theta()?;
        self.objective_at(z, None, work)
    }

    /// The functionals when no model parameter can change them.
    pub(crate) fn constant(&self) -> Result<Option<Functionals>> {
        if self.theta.is_empty() {
            Ok(Some(self.structure.functionals(&[])?))
        } else {
            Ok(None)
        }
    }

    pub(crate) fn objective_at(
        &self,
        z: &[f64],
        constant: Option<&Functionals>,
        work: &mut Workspace,
    ) -> Result<(f64, Vec<f64>)> {
        let (model, theta) = self.split(z)?;
        let made;
        let (f, tangents) = match constant {
            Some(f) => (f, Vec::new()),
            None => {
                made = self.structure.functionals(&theta)?;
                (&made, self.structure.tangents(&theta)?)
            }
        };
        if tangents.len() != theta.len() {
            return Err(shape(
                "tangents of the structure",
                theta.len(),
                tangents.len(),
            ));
        }
        let e = match &self.inducing {
            None => evidence(&model, f, self.y, &tangents, work)?,
            Some(z) => sparse_evidence(&model, f, self.y, z, &tangents)?,
        };
        let mut gradient = e.gradient;
        gradient.extend(
            self.atlas
                .pull_back(&z[self.model.n_params()..], &e.theta)?,
        );
        Ok((e.nll, gradient))
    }
}
