//! CMA-ES within bounds, through `basin`, which is used nowhere else here.

use crate::studies::StudyError;
use basin::{
    BoundedCmaEs, BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError,
    Constraints, CostFunction, DenseMatrix, Executor, PopulationProgress,
};

/// Of the samples.
const SEED: u64 = 7;
/// Spread of the first samples, as a share of the range.
const SPREAD: f64 = 0.2;

/// A number that is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// What it is, with its unit.
    pub name: &'static str,
    /// Where the search begins.
    pub start: f64,
    /// Its least and largest value.
    pub within: [f64; 2],
}

impl Variable {
    fn share(&self, value: f64) -> f64 {
        (value - self.within[0]) / (self.within[1] - self.within[0])
    }

    fn value(&self, share: f64) -> f64 {
        self.within[0] + share * (self.within[1] - self.within[0])
    }
}

/// How long it looks.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Samples of a generation, 4 at least.
    pub samples: usize,
    /// Generations behind the first.
    pub generations: u64,
}

/// The least cost that was met.
#[derive(Debug, Clone, PartialEq)]
pub struct Least {
    /// A value for every variable.
    pub values: Vec<f64>,
    /// What they cost,
    pub cost: f64,
    /// and what the start did.
    pub began: f64,
    /// How often a cost was asked for.
    pub evaluations: u64,
}

/// Looks for the least cost. The same whenever it is asked for.
///
/// # Errors
/// Those of the cost, and [`StudyError::Bounds`] of a variable whose least value is above its largest.
pub fn least(
    variables: &[Variable],
    effort: Effort,
    cost: &dyn Fn(&[f64]) -> Result<f64, StudyError>,
) -> Result<Least, StudyError> {
    let start: Vec<f64> = variables.iter().map(|v| v.start).collect();
    let began = cost(&start)?;
    let objective = Objective {
        variables,
        cost,
        least: vec![0.0; variables.len()],
        most: vec![1.0; variables.len()],
    };
    let shares = variables.iter().map(|v| v.share(v.start)).collect();
    let solver = BoundedCmaEs::<Vec<f64>, DenseMatrix>::new(SEED, SPREAD);
    let progress = PopulationProgress::from_point(shares);
    let result = Executor::new(&objective, solver.with_lambda(effort.samples), progress)
        .max_iter(effort.generations)
        .run()
        .map_err(|error| match error {
            ConstraintSolveError::Evaluation(error) => error,
            other => StudyError::Bounds(other.to_string()),
        })?;
    Ok(Least {
        values: objective.values(result.best_param()),
        cost: result.best_cost(),
        began,
        evaluations: 1 + result.cost_evals(),
    })
}

/// The cost over shares of every variable's range, as the optimiser sees it.
struct Objective<'a> {
    variables: &'a [Variable],
    cost: &'a dyn Fn(&[f64]) -> Result<f64, StudyError>,
    least: Vec<f64>,
    most: Vec<f64>,
}

impl Objective<'_> {
    fn values(&self, shares: &[f64]) -> Vec<f64> {
        let both = self.variables.iter().zip(shares);
        both.map(|(variable, share)| variable.value(*share))
            .collect()
    }
}

impl Constraints for &Objective<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;
    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.least), Some(&self.most)))
    }
}

impl CostFunction for &Objective<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = StudyError;
    fn cost(&self, shares: &Vec<f64>) -> Result<f64, StudyError> {
        (self.cost)(&self.values(shares))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EFFORT: Effort = Effort {
        samples: 8,
        generations: 60,
    };

    fn variable(start: f64, within: [f64; 2]) -> Variable {
        Variable {
            name: "",
            start,
            within,
        }
    }

    /// A narrow valley across the axes, with units that are a thousand apart; then with its floor out of bounds.
    #[test]
    fn finds_the_floor_of_a_valley_and_the_best_bound() {
        let valley = |x: &[f64]| {
            let (a, b) = (x[0] - 3.0, 1e3 * (x[1] - 0.002));
            Ok((a - b).powi(2) * 100.0 + (a + b).powi(2) + 0.5)
        };
        let wide = [variable(0.0, [-10.0, 10.0]), variable(0.0, [-0.01, 0.01])];
        let found = least(&wide, EFFORT, &valley).unwrap();
        assert!((found.values[0] - 3.0).abs() < 1e-3, "{found:?}");
        assert!((found.values[1] - 0.002).abs() < 1e-6, "{found:?}");
        assert!(
            (found.cost - 0.5).abs() < 1e-5 && found.began > 100.0,
            "{found:?}"
        );
        assert_eq!(found, least(&wide, EFFORT, &valley).unwrap());
        let narrow = [variable(0.0, [-10.0, 1.0]), wide[1]];
        let found = least(&narrow, EFFORT, &valley).unwrap();
        assert!((found.values[0] - 1.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn an_error_of_the_cost_comes_back() {
        let failing = |_: &[f64]| Err(StudyError::Bounds("none".into()));
        let found = least(&[variable(0.0, [-1.0, 1.0])], EFFORT, &failing);
        assert_eq!(
            found.unwrap_err().to_string(),
            "the search has no region: none"
        );
    }
}
