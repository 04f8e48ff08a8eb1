//! Forces that depend on multipliers: contact friction.
//!
//! `M a = Q(λ) + Aᵀλ`, `A a = b` is a nonlinear equation for `λ`:
//! `A M⁻¹ (Q(λ) + Aᵀλ) = b`. Newton's method solves it: linearised at `λₖ`, with
//! `Q′ = ∂Q/∂λ`,
//!
//! ```text
//! M a = Q(λₖ) − Q′ λₖ + (Aᵀ + Q′) λₖ₊₁,   A a = b
//! ```
//!
//! Friction is linear in `λ` on either side of zero, so two or three steps are enough. The
//! matrix `A M⁻¹ (Aᵀ + Q′)` becomes singular, and the contact has no motion or several
//! (Painlevé), where friction presses a body into its contact as hard as it is pushed out:
//! that is an error.

use super::{Machine, Motion, SolveError, States, Terms};

/// Newton steps at most.
const STEPS: usize = 40;
/// A change of the multipliers, relative to their size, that is none.
const SETTLED: f64 = 1e-10;

impl Machine {
    /// Whether a force depends on a multiplier.
    pub fn has_contact(&self) -> bool {
        !self.compiled.system.multiplier_slope.is_empty()
    }

    /// The motion at every state, with terms that `adjust` may change, sample by sample,
    /// before they are solved.
    pub(crate) fn motion_with(
        &self,
        states: &States,
        parameters: &[f64],
        adjust: impl Fn(usize, &mut Terms),
    ) -> Result<Vec<Motion>, SolveError> {
        let mut multipliers = vec![vec![0.0; states.len()]; self.constraint_count()];
        for _ in 0..STEPS {
            let motions = self
                .terms_at(states, parameters, &multipliers)
                .into_iter()
                .enumerate()
                .map(|(sample, mut terms)| {
                    adjust(sample, &mut terms);
                    let known: Vec<f64> = multipliers.iter().map(|column| column[sample]).collect();
                    Motion::of(terms, &known, sample)
                })
                .collect::<Result<Vec<Motion>, SolveError>>()?;
            if !self.has_contact() {
                return Ok(motions);
            }
            let mut unsettled = None;
            for (sample, motion) in motions.iter().enumerate() {
                let size = 1.0 + motion.multiplier.amax();
                for (column, &new) in multipliers.iter_mut().zip(motion.multiplier.iter()) {
                    if (new - column[sample]).abs() > SETTLED * size {
                        unsettled = Some(sample);
                    }
                    column[sample] = new;
                }
            }
            match unsettled {
                None => return Ok(motions),
                Some(_) => continue,
            }
        }
        // Which one it is: the last round's multipliers still move there.
        let terms = self.terms_at(states, parameters, &multipliers);
        let moves = |(sample, mut terms): (usize, Terms)| {
            adjust(sample, &mut terms);
            let known: Vec<f64> = multipliers.iter().map(|column| column[sample]).collect();
            let motion = Motion::of(terms, &known, sample).ok();
            let gap = motion.map(|m| {
                let pairs = m.multiplier.iter().zip(&known);
                pairs.fold(0.0_f64, |worst, (new, old)| worst.max((new - old).abs()))
            });
            gap.is_none_or(|gap| gap > SETTLED).then_some(sample)
        };
        let sample = terms.into_iter().enumerate().find_map(moves).unwrap_or(0);
        Err(SolveError::Unsettled { sample })
    }
}
