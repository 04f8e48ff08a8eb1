//! What sensors show along a curve.

use super::moments::Moments;
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
    /// What is not known of positions, velocities and accelerations where they were read, beside the
    /// sensors' noise: per coordinate, a value per sample of the beginning or nothing.
    pub doubt: [Vec<Vec<f64>>; 3],
    /// When sensors were read, per coordinate, or nothing: at the stamps.
    pub moments: Vec<Option<Moments>>,
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
    /// Doubts what sensors of one derivative of the positions read still more: per coordinate, from the
    /// first sample on.
    pub fn doubt_more(&mut self, derivative: usize, more: Vec<Vec<f64>>) {
        let doubt = &mut self.doubt[derivative];
        doubt.resize(doubt.len().max(more.len()), Vec::new());
        for (doubt, more) in doubt.iter_mut().zip(more) {
            doubt.resize(doubt.len().max(more.len()), 0.0);
            let pairs = doubt.iter_mut().zip(more);
            pairs.for_each(|(doubt, more)| *doubt = doubt.hypot(more));
        }
    }

    /// Every sensor of the `n` coordinates, and of the model, that was read next to a sample, which of its
    /// readings that was, and how noisy it is. `of_model` says when the model's sensors were read.
    pub(super) fn each(
        &self,
        n: usize,
        sample: usize,
        of_model: &[Option<Moments>],
        update: &mut impl FnMut(Sensor, usize, f64),
    ) {
        for i in 0..n {
            for &row in made_at(&self.moments, i, &[sample]) {
                self.each_of(i, row, update);
            }
        }
        for (place, reading) in self.instruments.iter().enumerate() {
            let moments = of_model.get(reading.sensor).and_then(Option::as_ref);
            for &row in made_at(of_model, reading.sensor, &[sample]) {
                if reading.is_new(row) {
                    let doubt = moments.map_or(0.0, |moments| moments.doubt(row));
                    update(Sensor::Instrument(place), row, reading.sd.hypot(doubt));
                }
            }
        }
    }

    /// The same of one coordinate and one row of the log.
    fn each_of(&self, i: usize, reading: usize, update: &mut impl FnMut(Sensor, usize, f64)) {
        let [q, v, a] = self.aside.of(i).map(|flags| !is_aside(flags, reading));
        let [beside_q, beside_v, beside_a] = self.doubt.each_ref().map(|doubt| {
            let own = doubt.get(i).and_then(|own| own.get(reading));
            own.copied().unwrap_or(0.0)
        });
        if q {
            let sd = self.position_sd[i].hypot(beside_q);
            update(Sensor::Position(i), reading, sd);
        }
        if v && self.velocity[i].is_some() {
            let sd = self.velocity_sd[i].hypot(beside_v);
            update(Sensor::Velocity(i), reading, sd);
        }
        if a && self.acceleration[i].is_some() {
            let sd = self.acceleration_sd[i].hypot(beside_a);
            update(Sensor::Acceleration(i), reading, sd);
        }
    }
}

/// The readings of a sensor that were made next to a sample: its own, if all are on time.
fn made_at<'a>(
    moments: &'a [Option<Moments>],
    sensor: usize,
    sample: &'a [usize; 1],
) -> &'a [usize] {
    match moments.get(sensor) {
        Some(Some(moments)) => moments.at(sample[0]),
        _ => sample,
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
