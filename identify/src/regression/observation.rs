//! What readings show of a departure, and of what columns change at once.

use super::moments::Moments;
use super::readings::Sensor;
use super::whitener::{Mix, Update, Whitener};
use nalgebra::{DMatrix, DVector};

impl Whitener<'_> {
    /// The entry of `δ` that a reading shows, if it shows one alone.
    pub(super) fn unit_row(&self, update: &Update) -> Option<usize> {
        let place = match update.sensor {
            Sensor::Position(i) => i,
            Sensor::Velocity(i) => self.dynamics.coordinate_count() + i,
            Sensor::Acceleration(_) | Sensor::Instrument(_) | Sensor::Closure(_) => return None,
        };
        (self.after(update) == 0.0).then_some(place)
    }

    /// Seconds from the sample of a reading to when it was made. Accelerations are compared with those at
    /// the sample.
    fn after(&self, update: &Update) -> f64 {
        let moments = match update.sensor {
            Sensor::Position(i) | Sensor::Velocity(i) => self.readings.moments.get(i),
            Sensor::Instrument(place) => {
                let sensor = self.readings.instruments[place].sensor;
                self.dynamics.moments.get(sensor)
            }
            Sensor::Acceleration(_) | Sensor::Closure(_) => None,
        };
        let after = |moments: &Moments| moments.after(update.reading as usize);
        moments.and_then(Option::as_ref).map_or(0.0, after)
    }

    /// `h` of a reading, `z = h·δ`. A time `τ` after a sample a departure is `δ + τ (δv, δa, 0)`.
    pub(super) fn write_slope(&self, update: &Update, row: &mut DVector<f64>) {
        let dynamics = self.dynamics;
        let n = dynamics.coordinate_count();
        let sample = update.sample as usize;
        row.fill(0.0);
        match update.sensor {
            Sensor::Position(i) => row[i] = 1.0,
            Sensor::Velocity(i) => row[n + i] = 1.0,
            Sensor::Acceleration(i) => row.tr_copy_from(&dynamics.slope[sample].row(i)),
            Sensor::Instrument(place) => {
                let sensor = self.readings.instruments[place].sensor;
                let shown = &dynamics.shown[update.reading as usize];
                row.tr_copy_from(&shown.slope.row(sensor));
            }
            Sensor::Closure(i) => {
                let gradient = dynamics.closed.gradient[sample].row(i);
                row.rows_mut(0, n).tr_copy_from(&gradient);
            }
        }
        let after = self.after(update);
        if after != 0.0 {
            let [of_positions, of_velocities] = [0, n].map(|from| row.rows(from, n).into_owned());
            let mut to_velocities = row.rows_mut(n, n);
            to_velocities.axpy(after, &of_positions, 1.0);
            row.gemv_tr(after, &dynamics.slope[sample], &of_velocities, 1.0);
        }
    }

    /// What the columns make sensors read at once.
    pub(super) fn direct(&self, sample: usize, mix: &Mix<'_>) -> Direct {
        let senses_acceleration = self.readings.acceleration.iter().any(Option::is_some);
        Direct {
            acceleration: senses_acceleration.then(|| mix.of(&self.dynamics.acceleration[sample])),
            shown: self.shown(sample, mix),
            sensed: self.dynamics.sensed.of(sample, mix),
            closed: self.dynamics.closed.of(sample, mix),
        }
    }

    /// What the columns make the model's sensors show in a row of the log.
    fn shown(&self, row: usize, mix: &Mix<'_>) -> Option<DMatrix<f64>> {
        let has_any = !self.readings.instruments.is_empty();
        has_any.then(|| mix.of(&self.dynamics.shown[row].values))
    }

    /// What the departure, and the columns at once, would make a sensor read. What columns do at once
    /// between a sample and a reading beside it is left out. The row is there to be written to.
    pub(super) fn predict_reading(
        &self,
        update: &Update,
        mix: &Mix<'_>,
        (state, direct): (&DMatrix<f64>, &Direct),
        (row, reading): (&mut DVector<f64>, &mut DVector<f64>),
    ) {
        match self.unit_row(update) {
            Some(place) => reading.tr_copy_from(&state.row(place)),
            None => {
                self.write_slope(update, row);
                reading.gemv_tr(1.0, state, row, 0.0);
            }
        }
        let n = self.dynamics.coordinate_count();
        let logged = update.reading as usize;
        // What a sensor that is early or late reads is known by the row of the log.
        let is_elsewhere = update.reading != update.sample;
        let place = match update.sensor {
            Sensor::Instrument(place) => {
                let shown = is_elsewhere.then(|| self.shown(logged, mix));
                let sensor = self.readings.instruments[place].sensor;
                return add(shown.as_ref().unwrap_or(&direct.shown), sensor, reading);
            }
            Sensor::Closure(place) => return add(&direct.closed, place, reading),
            Sensor::Position(i) => i,
            Sensor::Velocity(i) => n + i,
            Sensor::Acceleration(i) => {
                add(&direct.acceleration, i, reading);
                2 * n + i
            }
        };
        let sensed = is_elsewhere.then(|| self.dynamics.sensed.of(logged, mix));
        add(sensed.as_ref().unwrap_or(&direct.sensed), place, reading);
    }

    /// What the reading itself is, beside the curve where it is one of a coordinate.
    pub(super) fn reading(&self, update: &Update) -> Option<f64> {
        let row = update.reading as usize;
        match update.sensor {
            Sensor::Position(i) => Some(self.readings.position[i][row]),
            Sensor::Velocity(i) => self.readings.velocity[i].as_ref().map(|v| v[row]),
            Sensor::Acceleration(i) => self.readings.acceleration[i].as_ref().map(|a| a[row]),
            Sensor::Instrument(place) => {
                let reading = &self.readings.instruments[place];
                let shown = self.dynamics.shown[row].values[(reading.sensor, 0)];
                Some(reading.near(shown, row))
            }
            Sensor::Closure(place) => Some(-self.dynamics.closed.residual[row][place]),
        }
    }
}

/// Adds a row of what columns do at once, if they do anything.
fn add(at_once: &Option<DMatrix<f64>>, row: usize, reading: &mut DVector<f64>) {
    if let Some(at_once) = at_once {
        for (column, reading) in reading.iter_mut().enumerate() {
            *reading += at_once[(row, column)];
        }
    }
}

/// What columns make sensors read without a departure.
pub(super) struct Direct {
    /// Accelerations, `n×count`, where these are measured.
    acceleration: Option<DMatrix<f64>>,
    /// What the model's sensors show, `s×count`, where the log has some of them.
    shown: Option<DMatrix<f64>>,
    /// What is read of a motion that stays as it is, `3n×count`.
    sensed: Option<DMatrix<f64>>,
    /// How much farther off constraints are, `m×count`.
    closed: Option<DMatrix<f64>>,
}
