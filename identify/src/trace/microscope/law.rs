//! A force as a function of some variables: which, and how.

use super::correlation;
use super::features::{Feature, Features, deviation};
use crate::regression::BLOCKS;
use gp::{
    Functionals, GpError, Inputs, Kernel, LatentPrior, Model, Posterior, Problem, Saved, Training,
    farthest_points,
};

/// Samples that a process is conditioned on, and as many that it is checked at, about.
const POINTS: usize = 160;
/// Nats within which the smaller set of variables is taken.
const TIE: f64 = 3.0;
/// Bounds of length-scales in units of the variable's standard deviation.
const LENGTHS: (f64, f64) = (0.05, 30.0);

/// Why no law could be found.
#[derive(Debug, thiserror::Error)]
pub(in super::super) enum LawError {
    #[error("the unexplained force cannot be learnt: {0}")]
    Process(#[from] GpError),
}

/// A force as a Gaussian process over some variables.
pub(super) struct Law {
    /// Which of the features.
    pub variables: Vec<usize>,
    /// Of the kernel, in units of the variables' standard deviations.
    pub length_scales: Vec<f64>,
    /// Sets that were tried, with their evidence, best first.
    pub tried: Vec<(Vec<usize>, f64)>,
    /// Share of the variance explained in runs of the log that were not fitted.
    pub explained: f64,
    /// The process as `gp` saves it; its inputs are the variables in their units, divided by
    /// the standard deviations that stand there.
    pub saved: String,
    posterior: Posterior,
    scales: Vec<(f64, f64)>,
    force_scale: f64,
}

impl Law {
    /// The set of variables of largest evidence for the force on a coordinate.
    pub fn find(
        coordinate: usize,
        features: &Features,
        force: &[f64],
        seed: u64,
    ) -> Result<Self, LawError> {
        let scales: Vec<(f64, f64)> = features.columns.iter().map(|c| scale(c)).collect();
        let force_scale = deviation(force).max(f64::MIN_POSITIVE);
        let samples = spread(features, &scales, force.len())?;
        // Run by run of the log: samples beside each other foretell what lasts, whatever it depends on.
        let is_fitted = |&k: &usize| (k * BLOCKS / force.len()).is_multiple_of(2);
        let (fitted, checked): (Vec<usize>, Vec<usize>) = samples.into_iter().partition(is_fitted);
        let attempt = |variables: Vec<usize>| {
            attempt(
                &variables,
                features,
                &scales,
                (force, force_scale),
                &fitted,
                seed,
            )
            .map(|(posterior, lengths, evidence)| (variables, posterior, lengths, evidence))
        };
        let sets = sets(coordinate, features, &scales);
        let mut tried = sets
            .into_iter()
            .map(attempt)
            .collect::<Result<Vec<_>, _>>()?;
        tried.sort_by(|a, b| b.3.total_cmp(&a.3));
        let evidence: Vec<(Vec<usize>, f64)> = tried
            .iter()
            .map(|(set, _, _, e)| (set.clone(), *e))
            .collect();
        let best = evidence.first().map_or(f64::NEG_INFINITY, |e| e.1);
        let chosen = (0..tried.len())
            .filter(|&i| tried[i].3 > best - TIE)
            .min_by_key(|&i| tried[i].0.len())
            .unwrap_or(0);
        let (variables, posterior, length_scales, _) = tried.swap_remove(chosen);
        let saved = Saved::new(
            posterior.model().clone(),
            Vec::new(),
            posterior.data().clone(),
            posterior.y().to_vec(),
        );
        let mut law = Self {
            saved: saved.to_json()?,
            variables,
            length_scales,
            tried: evidence,
            explained: 0.0,
            posterior,
            scales,
            force_scale,
        };
        let predicted = law.at(features, &checked)?;
        let true_ones: Vec<f64> = checked.iter().map(|&k| force[k]).collect();
        let misses: Vec<f64> = predicted
            .iter()
            .zip(&true_ones)
            .map(|(p, f)| p - f)
            .collect();
        law.explained =
            1.0 - (deviation(&misses) / deviation(&true_ones).max(f64::MIN_POSITIVE)).powi(2);
        Ok(law)
    }

    /// The force along a motion.
    pub fn along(&self, features: &Features) -> Result<Vec<f64>, LawError> {
        let all: Vec<usize> = (0..features.columns[0].len()).collect();
        self.at(features, &all)
    }

    fn at(&self, features: &Features, samples: &[usize]) -> Result<Vec<f64>, LawError> {
        let place = |&k: &usize| standardised(&self.variables, features, &self.scales, k);
        self.ask(&samples.iter().map(place).collect::<Vec<_>>())
    }

    fn ask(&self, places: &[Vec<f64>]) -> Result<Vec<f64>, LawError> {
        let mean = self.posterior.latent_mean(&Inputs::from_rows(places)?)?;
        Ok(mean.into_iter().map(|f| f * self.force_scale).collect())
    }

    /// Correlation of the law with minus itself at opposite velocities, at its data.
    pub fn oddness(&self, features: &Features) -> Result<f64, LawError> {
        let here: Vec<Vec<f64>> = {
            let inputs = self.posterior.data().inputs();
            (0..inputs.len()).map(|i| inputs.point(i)).collect()
        };
        let turned = |place: &Vec<f64>| -> Vec<f64> {
            let pairs = place.iter().zip(&self.variables);
            pairs
                .map(|(&x, &variable)| match features.kinds[variable] {
                    Feature::Velocity(_) | Feature::Past(..) => {
                        let (mean, deviation) = self.scales[variable];
                        -x - 2.0 * mean / deviation
                    }
                    Feature::Position(_) | Feature::Input(_) => x,
                })
                .collect()
        };
        let there: Vec<Vec<f64>> = here.iter().map(turned).collect();
        let opposite: Vec<f64> = self.ask(&there)?.iter().map(|f| -f).collect();
        Ok(correlation(&self.ask(&here)?, &opposite))
    }
}

/// Mean and standard deviation; a column that stands still has none.
fn scale(column: &[f64]) -> (f64, f64) {
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    (mean, deviation(column))
}

fn standardised(
    variables: &[usize],
    features: &Features,
    scales: &[(f64, f64)],
    sample: usize,
) -> Vec<f64> {
    let values = features.at(sample, variables).into_iter().zip(variables);
    values
        .map(|(x, &variable)| (x - scales[variable].0) / scales[variable].1)
        .collect()
}

/// Samples that lie far from each other in all variables that move.
fn spread(
    features: &Features,
    scales: &[(f64, f64)],
    samples: usize,
) -> Result<Vec<usize>, LawError> {
    let moving: Vec<usize> = (0..scales.len()).filter(|&i| scales[i].1 > 0.0).collect();
    // Of a long log every few samples will do to choose from.
    let stride = samples.div_ceil(20 * POINTS).max(1);
    let candidates: Vec<usize> = (0..samples).step_by(stride).collect();
    let place = |&k: &usize| standardised(&moving, features, scales, k);
    let rows: Vec<Vec<f64>> = candidates.iter().map(place).collect();
    let chosen = farthest_points(&Inputs::from_rows(&rows)?, 2 * POINTS, 0)?;
    Ok(chosen.into_iter().map(|i| candidates[i]).collect())
}

/// Sets of variables to try: those of the coordinate, those of each other one, all.
fn sets(coordinate: usize, features: &Features, scales: &[(f64, f64)]) -> Vec<Vec<usize>> {
    let of = |wanted: &dyn Fn(&Feature) -> bool| -> Vec<usize> {
        let kinds = features.kinds.iter().enumerate();
        let all = kinds.filter(|(i, kind)| scales[*i].1 > 0.0 && wanted(kind));
        all.map(|(i, _)| i).collect()
    };
    let j = coordinate;
    let position = of(&|f| matches!(f, Feature::Position(i) if *i == j));
    let velocity = of(&|f| matches!(f, Feature::Velocity(i) if *i == j));
    let pasts = of(&|f| matches!(f, Feature::Past(i, _) if *i == j));
    let positions = of(&|f| matches!(f, Feature::Position(_)));
    let velocities = of(&|f| matches!(f, Feature::Velocity(_)));
    let inputs = of(&|f| matches!(f, Feature::Input(_)));
    let both = |a: &[usize], b: &[usize]| [a, b].concat();
    let mut sets = vec![
        position.clone(),
        velocity.clone(),
        both(&position, &velocity),
        both(&velocity, &pasts),
        both(&both(&position, &velocity), &pasts),
        positions.clone(),
        velocities.clone(),
        both(&positions, &velocities),
        inputs.clone(),
        both(&velocity, &inputs),
        both(&both(&positions, &velocities), &inputs),
    ];
    for &past in &pasts {
        sets.push(vec![past]);
        sets.push(both(&velocity, &[past]));
        sets.push(both(&both(&position, &velocity), &[past]));
    }
    let others = (0..features.kinds.len()).filter_map(|i| match features.kinds[i] {
        Feature::Velocity(other) if other != j => Some(other),
        _ => None,
    });
    for other in others {
        sets.push(of(
            &|f| matches!(f, Feature::Position(i) | Feature::Velocity(i) if *i == other),
        ));
    }
    for set in &mut sets {
        set.sort_unstable();
        set.dedup();
    }
    sets.retain(|set| !set.is_empty());
    sets.sort();
    sets.dedup();
    sets
}

type Fitted = (Posterior, Vec<f64>, f64);

/// A process over `variables`, its length-scales, and its evidence less its price.
fn attempt(
    variables: &[usize],
    features: &Features,
    scales: &[(f64, f64)],
    (force, force_scale): (&[f64], f64),
    samples: &[usize],
    seed: u64,
) -> Result<Fitted, LawError> {
    let mut data = Functionals::new(variables.len(), 1);
    for &k in samples {
        data.push(
            &standardised(variables, features, scales, k),
            &[1.0],
            &[0.0],
        )?;
    }
    let y: Vec<f64> = samples.iter().map(|&k| force[k] / force_scale).collect();
    let kernel = Kernel::squared_exponential(&vec![1.0; variables.len()], 1.0);
    let prior = LatentPrior::shared(1, kernel);
    let problem = Problem::new(Model::new(prior, &[0.1])?, &data, &y);
    let fitted = Training::new(&problem)
        .bounds("*log_length*", LENGTHS.0.ln(), LENGTHS.1.ln())?
        .start_in("*log_length*", 0.3f64.ln(), 3f64.ln())?
        .bounds("*log_noise*", 1e-6f64.ln(), 10f64.ln())?
        .restarts(2)
        .seed(seed)
        .run(&problem)?;
    let names = fitted.model.param_names();
    let values = fitted.model.params();
    let lengths = names
        .iter()
        .zip(&values)
        .filter(|(name, _)| name.contains("log_length"));
    let lengths: Vec<f64> = lengths.map(|(_, value)| value.exp()).collect();
    let price = 0.5 * names.len() as f64 * (samples.len() as f64).ln();
    let posterior = Posterior::new(&fitted.model, &data, &y)?;
    Ok((posterior, lengths, -fitted.nll - price))
}
