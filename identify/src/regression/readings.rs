//! What sensors show along a curve.

use crate::log::{Aside, Reading, is_aside};

/// Sensor readings minus the curve, and the sensors' noise.
#[derive(Debug, Clone)]
pub struct Readings {
    /// `y_q − q̂`, per coordinate.
    pub position: Vec<Vec<f64>>,
    /// Standard deviation of the position sensors.
    pub position_sd: Vec<f64>,
    /// `y_v − v̂` where velocity is measured.
    pub velocity: Vec<Option<Vec<f64>>>,
    /// Standard deviation of the velocity sensors.
    pub velocity_sd: Vec<f64>,
    /// `y_a` itself where acceleration is measured.
    pub acceleration: Vec<Option<Vec<f64>>>,
    /// Standard deviation of the acceleration sensors.
    pub acceleration_sd: Vec<f64>,
    /// What is not known of positions and velocities where they were read, beside the sensors' noise: per
    /// coordinate, a value per sample or nothing.
    pub doubt: [Vec<Vec<f64>>; 2],
    /// Samples that no sensor read.
    pub aside: Aside,
    /// What the model's sensors showed.
    pub instruments: Vec<Reading>,
    /// `Σ ln |∂y/∂x|` over all readings `y` of sensors that do not show `x` itself: what makes
    /// densities of corrected readings comparable with those of others. Without it a sensor
    /// that is thought to magnify would always be right, as all errors shrink.
    pub log_slope: f64,
}

impl Readings {
    /// Every sensor of the `n` coordinates that was read at a sample, with how noisy it is.
    pub(super) fn each(&self, n: usize, sample: usize, update: &mut impl FnMut(Sensor, f64)) {
        for i in 0..n {
            let [q, v, a] = self.aside.of(i).map(|flags| !is_aside(flags, sample));
            let [beside_q, beside_v] = self.doubt.each_ref().map(|doubt| {
                let own = doubt.get(i).and_then(|own| own.get(sample));
                own.copied().unwrap_or(0.0)
            });
            if q {
                update(Sensor::Position(i), self.position_sd[i].hypot(beside_q));
            }
            if v && self.velocity[i].is_some() {
                update(Sensor::Velocity(i), self.velocity_sd[i].hypot(beside_v));
            }
            if a && self.acceleration[i].is_some() {
                update(Sensor::Acceleration(i), self.acceleration_sd[i]);
            }
        }
        for (place, reading) in self.instruments.iter().enumerate() {
            if reading.is_new(sample) {
                update(Sensor::Instrument(place), reading.sd);
            }
        }
    }
}

/// What is read.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sensor {
    Position(usize),
    Velocity(usize),
    Acceleration(usize),
    /// One of the model's own that the log has.
    Instrument(usize),
    /// A holonomic constraint, which reads zero.
    Closure(usize),
}
