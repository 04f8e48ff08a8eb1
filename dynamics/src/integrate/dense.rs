//! The solution inside one step.

use super::StateVector;
use super::dormand_prince::Stages;
use crate::Real;

/// Weights of the stages in the quartic of dense output (Hairer, Nørsett & Wanner,
/// *Solving Ordinary Differential Equations I*, section II.6); stage 2 has none.
const D: [f64; 6] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// One accepted step with its continuous solution, of fourth order.
#[derive(Clone, Copy, Debug)]
pub struct Segment<T, Y> {
    t: T,
    end_t: T,
    h: T,
    start: Y,
    end: Y,
    coefficients: [Y; 4],
}

impl<T: Real, Y: StateVector<T>> Segment<T, Y> {
    /// From the stages of a step from `(t, start)` to `(end_t, end)`.
    pub(super) fn new((t, start): (T, &Y), (end_t, end): (T, &Y), k: &Stages<Y>) -> Self {
        let h = end_t - t;
        let one = T::one();
        let difference = end.add_scaled(-one, start);
        let bend = k[0].scaled(h).add_scaled(-one, &difference);
        let skew = difference.add_scaled(-h, &k[6]).add_scaled(-one, &bend);
        let weight = |i: usize| h * T::from_f64(D[i]);
        let quartic = k[0]
            .scaled(weight(0))
            .add_scaled(weight(1), &k[2])
            .add_scaled(weight(2), &k[3])
            .add_scaled(weight(3), &k[4])
            .add_scaled(weight(4), &k[5])
            .add_scaled(weight(5), &k[6]);
        Self {
            t,
            end_t,
            h,
            start: *start,
            end: *end,
            coefficients: [difference, bend, skew, quartic],
        }
    }

    /// Time at the start of the step, s.
    pub fn start_time(&self) -> T {
        self.t
    }

    /// Time at the end of the step, s.
    pub fn end_time(&self) -> T {
        self.end_t
    }

    /// State at the start.
    pub fn start(&self) -> &Y {
        &self.start
    }

    /// State at the end.
    pub fn end(&self) -> &Y {
        &self.end
    }

    /// State at `t`; outside the step this extrapolates.
    pub fn at(&self, t: T) -> Y {
        let theta = (t - self.t) / self.h;
        let rest = T::one() - theta;
        let [difference, bend, skew, quartic] = &self.coefficients;
        let inner = skew.add_scaled(rest, quartic);
        let inner = bend.add_scaled(theta, &inner);
        let inner = difference.add_scaled(rest, &inner);
        self.start.add_scaled(theta, &inner)
    }
}
