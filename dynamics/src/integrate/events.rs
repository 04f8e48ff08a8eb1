//! Events: a function of time and state crosses zero on the way.

use core::ops::ControlFlow;

use super::dormand_prince::{Stages, try_step};
use super::{DormandPrince, IntegrationError, Segment, StateVector, Statistics};
use crate::Real;

/// Which way a function crosses zero, along the integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From below.
    Rising,
    /// From above.
    Falling,
    /// Both.
    Either,
}

/// What to look for on the way, and what to do there.
///
/// An event is found where its function has crossed zero to round-off of the time, on a step of
/// the integrator of its own that ends there. It is looked for at eight places of every step:
/// two crossings between neighbours of these go unseen; [`DormandPrince::max_step`] brings them
/// closer. Where the integration begins, and right behind an event of its own, a function that is
/// zero is no event. Events that pile up, such as the last bounces of a ball, end where their
/// distance falls below the resolution of time: end the integration, or the motion, before that.
#[derive(Clone, Copy, Debug)]
pub struct Events<G, A, const K: usize> {
    /// Which crossings count, one per function.
    pub directions: [Direction; K],
    /// `FnMut(t, &y) -> [T; K]`: the functions. They may not jump inside a step.
    pub functions: G,
    /// `FnMut(event, t, &mut y) -> ControlFlow<()>`: what happens at an event, by its index. It
    /// may change the state, and ends the integration by `ControlFlow::Break`. Events at one
    /// time come in the order of their indices, all of those that were due.
    pub action: A,
}

/// A step is looked at in so many places, equally far apart.
const PLACES: i32 = 8;
/// Behind an event, in so many more, each half as far from its start as the next.
const NEAR_PLACES: i32 = 44;

/// Where a function crosses zero.
#[derive(Clone, Copy, Debug)]
struct Bracket<T> {
    /// From the start of the step, s: in front of the crossing, and behind it.
    ends: (T, T),
    /// The side that it comes from.
    side: i8,
}

/// How a function stands.
#[derive(Clone, Copy, Debug)]
struct Standing<T> {
    /// The side of zero that it is on, −1 or 1; 0 as long as it has not left it.
    side: i8,
    /// What counts as not having left it.
    rest: T,
}

impl<T: Real> DormandPrince<T> {
    /// Integrates as [`DormandPrince::integrate`], stopping at every event on the way. `sink` is
    /// given every step, those that end at an event, too.
    ///
    /// ```
    /// use core::convert::Infallible;
    /// use core::ops::ControlFlow;
    /// use dynamics::integrate::{Direction, DormandPrince, Events};
    ///
    /// // A ball at [height, velocity], which keeps 80 % of its speed when it bounces.
    /// let fall = |_t: f64, y: &[f64; 2]| Ok::<_, Infallible>([y[1], -9.81]);
    /// let mut bounces = 0;
    /// let events = Events {
    ///     directions: [Direction::Falling],
    ///     functions: |_t: f64, y: &[f64; 2]| [y[0]],
    ///     action: |_event: usize, t: f64, y: &mut [f64; 2]| {
    ///         let first = (2.0_f64 / 9.81).sqrt();
    ///         let expected = if bounces == 0 { first } else { first + 1.6 * first };
    ///         assert!((t - expected).abs() < 1e-12);
    ///         y[1] *= -0.8;
    ///         bounces += 1;
    ///         if bounces == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    ///     },
    /// };
    /// DormandPrince::default()
    ///     .integrate_with_events(fall, (0.0, &[1.0, 0.0]), 10.0, events, |_| ControlFlow::Continue(()))
    ///     .unwrap();
    /// ```
    ///
    /// # Errors
    ///
    /// As [`DormandPrince::integrate`].
    pub fn integrate_with_events<Y: StateVector<T>, E, G, A, const K: usize>(
        &self,
        mut f: impl FnMut(T, &Y) -> Result<Y, E>,
        (t0, y0): (T, &Y),
        t1: T,
        mut events: Events<G, A, K>,
        mut sink: impl FnMut(&Segment<T, Y>) -> ControlFlow<()>,
    ) -> Result<(T, Y, Statistics), IntegrationError<E>>
    where
        G: FnMut(T, &Y) -> [T; K],
        A: FnMut(usize, T, &mut Y) -> ControlFlow<()>,
    {
        let (mut t, mut y) = (t0, *y0);
        let mut standing = (events.functions)(t, &y).map(Standing::of);
        let mut total = Statistics::default();
        loop {
            let leg = Self {
                max_steps: self
                    .max_steps
                    .saturating_sub(total.accepted + total.rejected),
                ..*self
            };
            let mut crossed = None;
            let (end_t, end_y, cost) = leg
                .integrate(&mut f, t, &y, t1, |segment| {
                    let brackets = events.watch(&mut standing, segment);
                    if brackets.iter().all(Option::is_none) {
                        return sink(segment);
                    }
                    crossed = Some((*segment, brackets));
                    ControlFlow::Break(())
                })
                .map_err(|error| within(error, self.max_steps))?;
            total.accepted += cost.accepted;
            total.rejected += cost.rejected;
            total.evaluations += cost.evaluations;
            let Some((segment, brackets)) = crossed else {
                return Ok((end_t, end_y, total));
            };
            let mut rate = |t: T, y: &Y| {
                total.evaluations += 1;
                f(t, y).map_err(|source| IntegrationError::Rate {
                    t: t.to_f64(),
                    source,
                })
            };
            let (arrived, due) = events.arrive(&mut rate, &segment, &brackets)?;
            (t, y) = (arrived.end_time(), *arrived.end());
            if sink(&arrived).is_break() {
                return Ok((t, y, total));
            }
            for event in (0..K).filter(|&event| due[event]) {
                if (events.action)(event, t, &mut y).is_break() {
                    return Ok((t, y, total));
                }
            }
            standing = (events.functions)(t, &y).map(Standing::of);
            for event in (0..K).filter(|&event| due[event]) {
                standing[event].side = 0;
            }
        }
    }
}

impl<G, A, const K: usize> Events<G, A, K> {
    /// Follows the functions through a step, up to the first crossing of each that counts.
    fn watch<T: Real, Y: StateVector<T>>(
        &mut self,
        standing: &mut [Standing<T>; K],
        segment: &Segment<T, Y>,
    ) -> [Option<Bracket<T>>; K]
    where
        G: FnMut(T, &Y) -> [T; K],
    {
        let (start, whole) = (segment.start_time(), length(segment));
        let mut brackets = [None; K];
        let mut near = T::zero();
        let behind_an_event = standing.iter().any(|standing| standing.side == 0);
        let first = if behind_an_event { -NEAR_PLACES } else { 1 };
        for place in (first..=PLACES).filter(|&place| place != 0) {
            let values = match place {
                PLACES => (self.functions)(segment.end_time(), segment.end()),
                _ => {
                    let t = start + whole * share(place);
                    (self.functions)(t, &segment.at(t))
                }
            };
            let far = whole * share(place);
            for event in 0..K {
                let side = standing[event].side;
                let counts = self.directions[event].counts(side);
                if has_crossed(side, values[event]) && counts && brackets[event].is_none() {
                    let ends = (near, far);
                    brackets[event] = Some(Bracket { ends, side });
                }
                standing[event].follow(values[event]);
            }
            near = far;
        }
        brackets
    }

    /// A step that ends at the first of the crossings, and which events are due there.
    fn arrive<T: Real, Y: StateVector<T>, E>(
        &mut self,
        rate: &mut impl FnMut(T, &Y) -> Result<Y, E>,
        segment: &Segment<T, Y>,
        brackets: &[Option<Bracket<T>>; K],
    ) -> Result<(Segment<T, Y>, [bool; K]), E>
    where
        G: FnMut(T, &Y) -> [T; K],
    {
        let (t, y) = (segment.start_time(), segment.start());
        let first = rate(t, y)?;
        let whole = length(segment);
        let resolution = T::epsilon() * (t.abs() + whole.abs());
        let mut soonest: Option<(usize, T)> = None;
        for event in 0..K {
            let Some(Bracket { ends, .. }) = brackets[event] else {
                continue;
            };
            let mut on_a_step = |h: T| {
                let (_, next, _) = try_step(rate, t, t + h, y, &first, h)?;
                Ok((self.functions)(t + h, &next)[event])
            };
            // The dense output saw the crossing; a step of its own may see it a hair elsewhere.
            let h = match root(&mut on_a_step, ends, resolution)? {
                Some(h) => h,
                None => {
                    let mut on_the_curve =
                        |h: T| Ok((self.functions)(t + h, &segment.at(t + h))[event]);
                    root(&mut on_the_curve, ends, resolution)?.unwrap_or(ends.1)
                }
            };
            if soonest.is_none_or(|(_, least)| h.abs() < least.abs()) {
                soonest = Some((event, h));
            }
        }
        let (chosen, h) = soonest.unwrap_or((0, whole));
        let (stages, next, _): (Stages<Y>, Y, Y) = try_step(rate, t, t + h, y, &first, h)?;
        let arrived = Segment::new((t, y), (t + h, &next), &stages);
        let values = (self.functions)(t + h, &next);
        let due = core::array::from_fn(|event| {
            let came = brackets[event].is_some_and(|b| has_crossed(b.side, values[event]));
            came || event == chosen
        });
        Ok((arrived, due))
    }
}

impl Direction {
    /// Whether a crossing counts that comes from this side.
    fn counts(self, before: i8) -> bool {
        match self {
            Self::Rising => before < 0,
            Self::Falling => before > 0,
            Self::Either => true,
        }
    }
}

impl<T: Real> Standing<T> {
    fn of(value: T) -> Self {
        Self {
            side: side(value),
            rest: value.abs() + value.abs(),
        }
    }

    fn follow(&mut self, value: T) {
        if self.side != 0 || value.abs() > self.rest {
            self.side = side(value);
        }
    }
}

fn length<T: Real, Y: StateVector<T>>(segment: &Segment<T, Y>) -> T {
    segment.end_time() - segment.start_time()
}

/// How far into a step a place is: eighths, and in front of the first of them halves of halves,
/// counted from `-NEAR_PLACES` to −1.
fn share<T: Real>(place: i32) -> T {
    match place {
        1.. => T::from_f64(f64::from(place) / f64::from(PLACES)),
        _ => T::from_f64(0.5).powi(3 - place),
    }
}

/// −1, 0 or 1; 0 for what is no number.
fn side<T: Real>(value: T) -> i8 {
    i8::from(value > T::zero()) - i8::from(value < T::zero())
}

/// Whether a value is no longer on the side `before`.
fn has_crossed<T: Real>(before: i8, value: T) -> bool {
    match before {
        1 => value <= T::zero(),
        -1 => value >= T::zero(),
        _ => false,
    }
}

/// Where a function has just crossed zero between two places, to `resolution`: false position
/// in the Illinois variant, with a bisection wherever three steps did not halve the bracket.
/// `None` if it does not cross.
fn root<T: Real, E>(
    value: &mut impl FnMut(T) -> Result<T, E>,
    (mut near, mut far): (T, T),
    resolution: T,
) -> Result<Option<T>, E> {
    let (mut at_near, mut at_far) = (value(near)?, value(far)?);
    let before = side(at_near);
    if before == 0 || !has_crossed(before, at_far) {
        return Ok(None);
    }
    let half = T::from_f64(0.5);
    let mut checkpoint = (far - near).abs();
    let mut since = 0;
    while (far - near).abs() > resolution + resolution {
        let bisect = since == 3 && (far - near).abs() > half * checkpoint;
        if since == 3 {
            (checkpoint, since) = ((far - near).abs(), 0);
        }
        since += 1;
        let guess = match bisect {
            true => near + half * (far - near),
            false => near + (far - near) * (at_near / (at_near - at_far)),
        };
        // A step inside, so that both ends close in.
        let (low, high) = (near.min(far) + resolution, near.max(far) - resolution);
        let guess = guess.max(low).min(high);
        let at_guess = value(guess)?;
        if has_crossed(before, at_guess) {
            (far, at_far) = (guess, at_guess);
            at_near = half * at_near;
        } else {
            (near, at_near) = (guess, at_guess);
            at_far = half * at_far;
        }
    }
    Ok(Some(far))
}

/// The limit that was asked for, in place of what was left of it.
fn within<E>(error: IntegrationError<E>, limit: usize) -> IntegrationError<E> {
    match error {
        IntegrationError::TooManySteps { t, .. } => IntegrationError::TooManySteps { t, limit },
        other => other,
    }
}
