//! Gauss–Newton on the forces: strengths and shapes together.

use super::balance::Balance;
use super::equations::Equations;
use crate::machine::SolveError;
use crate::regression::Gram;
use crate::trace::dictionary::Dictionary;
use nalgebra::DMatrix;

/// Parameters where the forces are explained best.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    /// Of the dictionary, all.
    pub values: Vec<f64>,
    /// Of the candidates' parameters, in their order.
    pub covariance: DMatrix<f64>,
    /// Half the squares that are left, of what is believed of parameters, too.
    pub left: f64,
}

/// Steps at most.
const STEPS: usize = 30;
/// Damping of the steps that are tried one after the other.
const DAMPING: [f64; 5] = [1e-8, 1e-4, 1e-2, 1e-1, 1.0];
/// Nats; a smaller improvement ends the iteration.
const SMALL_IMPROVEMENT: f64 = 0.05;

/// Moves the parameters of `accepted` from `values` to where they explain most.
///
/// # Errors
/// If a state's equation has no solution along the curve.
pub(super) fn settle(
    dictionary: &Dictionary,
    balance: &Balance,
    equations: &Equations,
    accepted: &[usize],
    values: Vec<f64>,
) -> Result<Settled, SolveError> {
    let parameters = dictionary.parameters_of(accepted);
    let mut here = At::new(dictionary, balance, equations, accepted, values)?;
    'steps: for _ in 0..STEPS {
        for damping in DAMPING {
            let there = here.step(dictionary, &parameters, damping);
            let Ok(there) = At::new(dictionary, balance, equations, accepted, there) else {
                continue;
            };
            let improvement = here.left - there.left;
            if improvement > 0.0 {
                here = there;
                if improvement < SMALL_IMPROVEMENT {
                    break 'steps;
                }
                continue 'steps;
            }
        }
        break;
    }
    let all: Vec<usize> = (0..parameters.len()).collect();
    Ok(Settled {
        covariance: here.gram.fit(&all).covariance,
        values: here.values,
        left: here.left,
    })
}

/// The linear equations at some values.
struct At {
    values: Vec<f64>,
    gram: Gram,
    left: f64,
}

impl At {
    fn new(
        dictionary: &Dictionary,
        balance: &Balance,
        equations: &Equations,
        accepted: &[usize],
        values: Vec<f64>,
    ) -> Result<Self, SolveError> {
        let focus = dictionary.focus(accepted);
        let own = focus.values(&values);
        let missing = balance.missing(&focus.machine, &own)?;
        let states = balance.remembered(&focus.machine, &own)?;
        let columns = balance.added(&states, &focus.by_parameter, &own);
        let gram = equations.alike(&missing, &columns).gram();
        let beliefs = dictionary.beliefs(&dictionary.parameters_of(accepted), &values);
        let gram = gram.believing(&beliefs);
        Ok(Self {
            left: 0.5 * gram.data_misfit(),
            gram,
            values,
        })
    }

    /// The place that the linear equations lead to; what would leave its bounds stays at them,
    /// and the others make up for it.
    fn step(&self, dictionary: &Dictionary, parameters: &[usize], damping: f64) -> Vec<f64> {
        let model = &dictionary.machine.compiled.model;
        let mut values = self.values.clone();
        let mut free: Vec<usize> = (0..parameters.len()).collect();
        loop {
            let held: Vec<(usize, f64)> = (0..parameters.len())
                .filter(|i| !free.contains(i))
                .map(|i| (i, values[parameters[i]] - self.values[parameters[i]]))
                .map(|(i, step)| (i, -step))
                .collect();
            let fit = self
                .gram
                .with_data_shifted(&held)
                .damped_fit(&free, damping);
            let mut stopped = None;
            for (position, &i) in free.iter().enumerate() {
                let (index, old) = (parameters[i], self.values[parameters[i]]);
                let bounds = &model.parameters[index];
                let mut new = old + fit.coefficients[position];
                // Quantities that are positive by nature change by a factor at most.
                if bounds.lower > 0.0 {
                    new = new.clamp(old / 2.0, old * 2.0);
                }
                values[index] = new.clamp(bounds.lower, bounds.upper);
                if new < bounds.lower || new > bounds.upper {
                    stopped = Some(position);
                }
            }
            match stopped {
                Some(position) => drop(free.remove(position)),
                None => return values,
            }
        }
    }
}
