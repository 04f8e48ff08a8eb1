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
            start: 0,
            before: None,
            unfiltered: T::zero(),
        }
    }

    /// Reads the encoder, `interval` seconds after the last time. Counts may wrap.
    pub fn read(&mut self, counts: i32, interval: T) {
        let Some(before) = self.before.replace(counts) else {
            self.start = counts;
            return;
        };
        let rate = angle::<T>(counts.wrapping_sub(before)) / interval;
        let new = T::from_f64(NEW);
        self.rate = new * rate + (T::one() - new) * self.rate;
        self.acceleration = (rate - self.unfiltered) / interval;
        self.unfiltered = rate;
    }

    /// Turn since the controller was switched on, rad.
    pub fn angle(&self) -> T {
        let counts = self.before.unwrap_or(self.start);
        angle(counts.wrapping_sub(self.start))
    }
}

impl<T: Scalar> Default for Wheel<T> {
    fn default() -> Self {
        Self::new()
    }
}

fn angle<T: Scalar>(counts: i32) -> T {
    let turn = T::from_f64(core::f64::consts::TAU / f64::from(COUNTS_PER_TURN));
    T::from_f64(f64::from(counts)) * turn
}
