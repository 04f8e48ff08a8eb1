//! Part 1 of a step: what hits.

use super::step::{Stepping, put};
use super::view::View;
use crate::machine::{Simulated, SolveError};
use nalgebra::DVector;

/// A contact that approaches slower than this is pressed, not hit, m/s.
pub(super) const RESTING: f64 = 1e-6;

impl Stepping<'_> {
    /// The impulses of an impact, if there is one: contacts in `entered` hit, others arrive within `h` s.
    pub(super) fn struck(
        &mut self,
        view: &View,
        entered: &[bool],
        h: f64,
    ) -> Result<Option<DVector<f64>>, SolveError> {
        let contacts = &view.contacts;
        let floors = |bounce: f64| -> DVector<f64> {
            let floor = |i: usize| {
                let (approach, e) = (contacts.approach(i), contacts.restitution[i]);
                let bounces = bounce * e > 0.0 && entered[i] && approach < -RESTING;
                if bounces {
                    -bounce * e * approach
                } else {
                    -contacts.gap[i].max(0.0) / h
                }
            };
            DVector::from_fn(contacts.len(), |i, _| floor(i))
        };
        let floor = floors(1.0);
        let hit = |i: usize| contacts.approach(i) < floor[i] - RESTING;
        if !(0..contacts.len()).any(hit) {
            return Ok(None);
        }
        let nothing = DVector::zeros(3 * contacts.len());
        let before = &contacts.velocity;
        let hard = self.solve(view, before, &floor, nothing.clone());
        let gains = |impulse: &DVector<f64>| view.gains(impulse, before);
        if hard.as_ref().is_ok_and(|impulse| !gains(impulse)) {
            return hard.map(Some);
        }
        let soft = self.solve(view, before, &floors(0.0), nothing)?;
        Ok(Some(match hard {
            Ok(hard) => view.without_gain(soft, &hard, before),
            // Friction can hold what should bounce: in a steep wedge.
            Err(_) => soft,
        }))
    }

    /// What a state is behind an impact.
    pub(super) fn collide(&mut self, state: &mut Simulated, view: &View, impulse: &DVector<f64>) {
        put(&mut state.v, &(&view.velocity + &view.response * impulse));
        self.impulse += impulse;
    }
}
