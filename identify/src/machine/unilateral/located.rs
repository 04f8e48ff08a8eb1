//! Impacts at their instants.
//!
//! From where a step begins the gap after `τ` seconds of free motion (RK4) is a function of `τ`. Its first zero
//! is found to round-off of the time, the motion goes there in a step of its own, and what is reached then hits. So
//! an impact is as exact as the free motion before it: a ball's to the last digits.
//!
//! Where contacts press, no motion is free, and steps are as without this. The same holds where a contact
//! would hit a second time within a step: the last of a ball's bounces, infinitely many of them.

use super::impact::RESTING;
use super::projection::INSIDE;
use super::step::{Drive, Stepping};
use super::view::View;
use crate::machine::{Simulated, SolveError};
use nalgebra::DVector;

/// A step is looked at in so many places: two crossings between neighbours go unseen.
const PLACES: usize = 8;
/// Contacts that would follow within this time hit together, s.
const TOGETHER: f64 = 1e-9;
/// Attempts to narrow a zero down, at most: enough to halve the bracket down to one number.
const ATTEMPTS: usize = 200;

/// A contact hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// When, s.
    pub t: f64,
    /// Which contact, by its index.
    pub contact: usize,
    /// How fast it came, m/s, below zero.
    pub approach: f64,
    /// What the plane gave, N s: along its two axes, then its normal.
    pub impulse: [f64; 3],
}

/// What free motion comes to within a step.
enum Next {
    /// No plane.
    Nothing,
    /// A plane that a contact rests on, or has just left.
    Pressing,
    /// A plane after so many seconds, and the contact that reaches it.
    Hits(f64, usize),
}

impl Stepping<'_> {
    /// One step of `h` s from `t` on, with a stop at every impact on the way.
    pub(super) fn step_to_impacts(
        &mut self,
        state: &mut Simulated,
        (mut t, h): (f64, f64),
        drive: &Drive<'_>,
    ) -> Result<(), SolveError> {
        let end = t + h;
        let mut hit = vec![false; self.machine.contact_count()];
        loop {
            let left = (t, end - t);
            let view = self.projected(state, t, &drive.at(t))?;
            match self.next(state, &view, left, drive)? {
                Next::Nothing => return self.fly(state, left, drive),
                Next::Hits(after, contact) if !hit[contact] => {
                    self.fly(state, (t, after), drive)?;
                    t += after;
                    self.hit(state, (t, contact), drive)?;
                    hit[contact] = true;
                }
                Next::Pressing | Next::Hits(..) => return self.resolved_step(state, left, drive),
            }
        }
    }

    /// What free motion from a state comes to.
    fn next(
        &self,
        state: &Simulated,
        view: &View,
        (t, h): (f64, f64),
        drive: &Drive<'_>,
    ) -> Result<Next, SolveError> {
        let gaps = |after: f64| -> Result<DVector<f64>, SolveError> {
            let (mut there, input) = (state.clone(), drive.at(t + after));
            self.free
                .advance(&mut there, &[t], after, &drive.at(t), &input)?;
            let states = self.free.states(&there, vec![t + after], input);
            Ok(self.machine.contact_terms(&states, self.parameters)[0]
                .gap
                .clone())
        };
        let contacts = 0..view.contacts.len();
        let rests = |i: usize| {
            let stays = view.contacts.gap[i] <= INSIDE && view.contacts.approach(i) > -RESTING;
            stays || self.pressed[3 * i + 2] > 0.0
        };
        let (mut near, mut before) = (0.0, view.contacts.gap.clone());
        for place in 1..=PLACES {
            let far = h * place as f64 / PLACES as f64;
            let behind = gaps(far)?;
            let crossed: Vec<usize> = contacts.clone().filter(|&i| behind[i] < 0.0).collect();
            if near == 0.0 && crossed.iter().any(|&i| rests(i)) {
                return Ok(Next::Pressing);
            }
            let mut first = Next::Nothing;
            for contact in crossed {
                let gap = |after: f64| Ok(gaps(after)?[contact]);
                let ends = [(near, before[contact]), (far, behind[contact])];
                let after = root(gap, ends, f64::EPSILON * (t.abs() + h))?;
                let sooner = !matches!(first, Next::Hits(least, _) if least <= after);
                first = if sooner {
                    Next::Hits(after, contact)
                } else {
                    first
                };
            }
            if let Next::Hits(..) = first {
                return Ok(first);
            }
            (near, before) = (far, behind);
        }
        Ok(Next::Nothing)
    }

    /// `contact` hits at `t`, and what touches with it.
    fn hit(
        &mut self,
        state: &mut Simulated,
        (t, contact): (f64, usize),
        drive: &Drive<'_>,
    ) -> Result<(), SolveError> {
        let mut view = self.view(state, t, &drive.at(t))?;
        let reached = |i: usize| i == contact || view.contacts.gap[i] <= INSIDE;
        let reached: Vec<bool> = (0..view.contacts.len()).map(reached).collect();
        let closed = (0..reached.len()).filter(|&i| reached[i]);
        // What is left of their gaps is round-off.
        closed.for_each(|i| view.contacts.gap[i] = 0.0);
        let Some(impulse) = self.struck(&view, &reached, TOGETHER)? else {
            return Ok(());
        };
        self.collide(state, &view, &impulse);
        let pushed = (0..reached.len()).filter(|i| impulse[3 * i + 2] > 0.0);
        self.impacts.extend(pushed.map(|contact| Impact {
            t,
            contact,
            approach: view.contacts.approach(contact),
            impulse: [0, 1, 2].map(|k| impulse[3 * contact + k]),
        }));
        Ok(())
    }
}

/// Where a function falls through zero between two places, with its values there; to `resolution`. By
/// false position (Illinois), with a bisection at every third attempt.
fn root(
    mut f: impl FnMut(f64) -> Result<f64, SolveError>,
    [(mut near, mut above), (mut far, mut below)]: [(f64, f64); 2],
    resolution: f64,
) -> Result<f64, SolveError> {
    if above <= 0.0 {
        return Ok(near);
    }
    let mut retained = 0_i32;
    for attempt in 1..=ATTEMPTS {
        if far - near <= resolution {
            break;
        }
        let share = if attempt % 3 == 0 {
            0.5
        } else {
            above / (above - below)
        };
        let middle = near + share * (far - near);
        let value = f(middle)?;
        if value > 0.0 {
            (near, above) = (middle, value);
            below *= if retained > 0 { 0.5 } else { 1.0 };
            retained = 1;
        } else {
            (far, below) = (middle, value);
            above *= if retained < 0 { 0.5 } else { 1.0 };
            retained = -1;
        }
        if value == 0.0 {
            break;
        }
    }
    Ok(far)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_is_found_to_the_last_digits() {
        for (f, expected) in [
            ((|x| 2.0 - x * x) as fn(f64) -> f64, 2.0_f64.sqrt()),
            (|x| (1.3 - x).powi(3), 1.3),
            (|x| if x < 0.4 { 1.0 } else { -1e-9 }, 0.4),
        ] {
            let ends = [(0.0, f(0.0)), (1.5, f(1.5))];
            let found = root(|x| Ok(f(x)), ends, f64::EPSILON).unwrap();
            assert!(
                (found - expected).abs() < 1e-15,
                "{found} in place of {expected}"
            );
        }
    }
}
