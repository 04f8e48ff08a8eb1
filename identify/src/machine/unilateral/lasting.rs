//! Part 2 of a step: forces and contact forces that last.

use super::step::{Stepping, put};
use super::terms::ContactTerms;
use super::view::View;
use crate::machine::rollout::remembered;
use crate::machine::{Simulated, SolveError};
use nalgebra::DVector;

impl Stepping<'_> {
    /// The rest of a step of `h` s; the time and the inputs in its middle.
    pub(super) fn press(
        &mut self,
        state: &mut Simulated,
        view: &View,
        h: f64,
        (middle, input): (f64, &[Vec<f64>]),
    ) -> Result<(), SolveError> {
        // What is inside is moved out without a velocity.
        let floor = view.contacts.gap.map(|gap| -gap.max(0.0) / h);
        let free = &view.contacts.velocity + view.contact_acceleration() * (h / 2.0);
        let guess = &self.pressed / 2.0;
        let impulse = self.solve(view, &free, &floor, guess)?;
        let halfway = &view.velocity + &view.motion.acceleration * (h / 2.0);
        let halfway = halfway + &view.response * &impulse;
        let mut half = state.clone();
        self.move_by(&mut half.q, &(&view.velocity + &halfway), h / 4.0);
        put(&mut half.v, &halfway);
        let rates = self.free.rates(&view.states);
        half.z = remembered(&state.z, [(&state.z, &rates); 2], h / 2.0);

        let there = self.view(&half, middle, input)?;
        let free = &view.velocity + &there.motion.acceleration * h;
        let moved = &there.contacts.jacobian * (&free - &halfway);
        // At the end `J` has turned on by half of the step: `J̇ v = −b`.
        let turned = &there.contacts.bias * (-h / 2.0);
        let free_contacts = &there.contacts.velocity + moved + turned;
        let impulse = self.held(
            &there,
            &view.contacts,
            &free_contacts,
            (&floor, impulse * 2.0),
        )?;
        let velocity = free + &there.response * &impulse;
        self.move_by(&mut state.q, &(&view.velocity + &velocity), h / 2.0);
        put(&mut state.v, &velocity);
        let rates = self.free.rates(&there.states);
        state.z = remembered(&state.z, [(&half.z, &rates); 2], h);
        self.impulse += &impulse;
        self.pressed = impulse;
        Ok(())
    }

    /// Impulses over a step in which contacts that moved as in `before` would move with `free`, and may
    /// move with `floor` along their normals on the mean.
    fn held(
        &mut self,
        there: &View,
        before: &ContactTerms,
        free: &DVector<f64>,
        (floor, guess): (&DVector<f64>, DVector<f64>),
    ) -> Result<DVector<f64>, SolveError> {
        // What approached faster than that does not come back.
        let end = |i: usize| floor[i] - (before.approach(i) - floor[i]).max(0.0);
        let end = DVector::from_fn(floor.len(), |i, _| end(i));
        let impulse = self.solve(there, free, &end, guess)?;
        let mean = (free + &before.velocity) / 2.0;
        if !there.gains(&impulse, &mean) {
            return Ok(impulse);
        }
        let both = DVector::from_fn(floor.len(), |i, _| end[i] + before.approach(i));
        let soft = self.solve(there, &(&mean * 2.0), &both, impulse.clone())?;
        Ok(there.without_gain(soft, &impulse, &mean))
    }
}
