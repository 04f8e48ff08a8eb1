//! A wheel's angle, rate and acceleration from its encoder.

use dynamics::Scalar;

/// Counts per turn of the encoders.
pub const COUNTS_PER_TURN: i32 = 20_000;

/// Share of the newest rate in the low-passed one, as the robot has it.
const NEW: f64 = 0.3;

/// What is known of a wheel, against the body.
#[derive(Clone, Copy, Debug)]
pub struct Wheel<T> {
    /// Low-passed rate, rad/s.
    pub rate: T,
    /// Difference of the rates of two ticks, without the low-pass, rad/s².
    pub acceleration: T,
    /// Turn since the controller was switched on, rad.
    pub angle: T,
    /// Counts where the controller was switched on.
    start: i32,
    /// Counts at the tick before.
    before: Option<i32>,
    /// Rate at the tick before, without the low-pass.
    unfiltered: T,
}

impl<T: Scalar> Wheel<T> {
    /// Nothing read yet.
    pub fn new() -> Self {
        Self {
            rate: T::zero(),
            acceleration: T::zero(),
            angle: T::zero(),
            start: 0,
            before: None,
            unfiltered: T::zero(),
        }
    }

    /// Reads the encoder, `interval` seconds after the last time. Counts may wrap.
    pub fn read(&mut self, counts: i32, interval: T) {
        let turned = self.counted(counts);
        self.turn(turned, interval);
    }

    /// Counts since the last time, and since the first; both are zero the first time.
    pub fn counted(&mut self, counts: i32) -> [T; 2] {
        if self.before.is_none() {
            self.start = counts;
        }
        let before = self.before.replace(counts).unwrap_or(counts);
        [before, self.start].map(|from| T::from_f64(f64::from(counts.wrapping_sub(from))))
    }

    /// Goes on by a tick of `interval` seconds; `turned` are counts as [`counted`](Self::counted)
    /// gives them.
    pub fn turn(&mut self, turned: [T; 2], interval: T) {
        let turn = T::from_f64(core::f64::consts::TAU / f64::from(COUNTS_PER_TURN));
        let [step, way] = turned.map(|counts| counts * turn);
        let rate = step / interval;
        let new = T::from_f64(NEW);
        self.rate = new * rate + (T::one() - new) * self.rate;
        self.acceleration = (rate - self.unfiltered) / interval;
        self.unfiltered = rate;
        self.angle = way;
    }

    /// Counts the angle from here on.
    pub fn restart(&mut self) {
        self.start = self.before.unwrap_or(self.start);
        self.angle = T::zero();
    }

    /// What the next tick needs of this one: the rates with and without the low-pass, rad/s.
    pub fn memory(&self) -> [T; 2] {
        [self.rate, self.unfiltered]
    }

    /// A wheel that goes on from there.
    pub fn remembering([rate, unfiltered]: [T; 2]) -> Self {
        Self {
            rate,
            unfiltered,
            ..Self::new()
        }
    }
}

impl<T: Scalar> Default for Wheel<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel that turns steadily past the end of the counter.
    #[test]
    fn counts_wrap() {
        let mut wheel = Wheel::<f32>::new();
        let mut counts = i32::MAX - 1000;
        for _ in 0..100 {
            wheel.read(counts, 0.01);
            counts = counts.wrapping_add(200);
        }
        let turned = 99.0 * 200.0 / COUNTS_PER_TURN as f32 * core::f32::consts::TAU;
        assert!((wheel.angle - turned).abs() < 1e-4);
        assert!((wheel.rate - turned / 0.99).abs() < 1e-3);
        assert!(wheel.acceleration.abs() < 1e-3);
    }
}
