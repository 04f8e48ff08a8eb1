//! What a log shows in the place of coordinates: readings of the model's own sensors.

use super::Log;
use super::record::stretches;
use super::ticks::ages;
use dynamics_codegen::Model;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::model::Sensor;
use std::f64::consts::TAU;
use std::ops::Range;

/// A sensor of a model, whose name a column of a log may bear. A vector has one for each component.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gauge {
    /// Its name: the column.
    pub name: String,
    /// Readings per second, each of which stands in the rows until the next one; `None`: one in each row.
    pub rate: Option<f64>,
    /// Whether it shows an angle: one that stays within half a turn may be whole turns off.
    pub turns: bool,
}

/// What one of the model's sensors showed.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Which of the model's sensors it is, counted from zero.
    pub sensor: usize,
    /// Its name.
    pub name: String,
    /// What it showed at each of n samples, in its unit.
    pub values: Vec<f64>,
    /// How long before each sample it was read, s; `None` where it is the reading of the sample
    /// before. Empty where a reading was taken at every sample.
    pub age: Vec<Option<f64>>,
    /// Standard deviation of its noise, in its unit; null until that is estimated.
    pub sd: f64,
    /// Whether it shows an angle, which may be a whole turn off.
    pub turns: bool,
}

impl Gauge {
    /// Those of a model, vectors by components, in its order.
    pub fn of(model: &Model) -> Vec<Self> {
        let gauge = |sensor: &Sensor| Self {
            name: sensor.name.clone(),
            rate: sensor.rate,
            turns: sensor.dimension == Some(Dimension::ONE),
        };
        model.sensors.iter().map(gauge).collect()
    }
}

impl Reading {
    /// Whether the sensor read anew at a sample.
    pub fn is_new(&self, sample: usize) -> bool {
        self.age.get(sample).is_none_or(Option::is_some)
    }

    /// What it showed at a sample, an angle as near to `shown` as whole turns bring it.
    pub fn near(&self, shown: f64, sample: usize) -> f64 {
        let value = self.values[sample];
        match self.turns {
            true => value - TAU * ((value - shown) / TAU).round(),
            false => value,
        }
    }

    /// Where it read anew: when, on the time stamps `t`, and what.
    pub fn taken(&self, t: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let new = (0..t.len()).filter(|&k| self.is_new(k));
        let age = |k: usize| self.age.get(k).copied().flatten().unwrap_or(0.0);
        new.map(|k| (t[k] - age(k), self.values[k])).unzip()
    }
}

/// What a log shows in the place of coordinates that no column of it measures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensed {
    /// The model's sensors that the log has.
    pub readings: Vec<Reading>,
    /// Per coordinate, whether no column measures it: its position and velocity in the record are
    /// estimates from the readings, and set aside.
    pub unmeasured: Vec<bool>,
    /// Standard deviations of these estimates, of position and velocity, per coordinate; null of
    /// what is measured.
    pub sd: Vec<[f64; 2]>,
}

impl Sensed {
    /// Every `stride`-th sample, from the first on; a reading that is left out stands in no other.
    pub(super) fn thinned(&self, stride: usize) -> Self {
        let mut thinned = self.clone();
        for reading in &mut thinned.readings {
            reading.values = reading.values.iter().step_by(stride).copied().collect();
            reading.age = reading.age.iter().step_by(stride).copied().collect();
        }
        thinned
    }

    /// The samples of some ranges, one after the other.
    pub(super) fn stretches(&self, ranges: &[Range<usize>]) -> Self {
        let mut cut = self.clone();
        for reading in &mut cut.readings {
            reading.values = stretches(&reading.values, ranges);
            reading.age = stretches(&reading.age, ranges);
        }
        cut
    }

    /// What `log` has of `gauges`.
    pub(super) fn of(log: &Log, gauges: &[Gauge]) -> Vec<Reading> {
        let reading = |(sensor, gauge): (usize, &Gauge)| {
            let values = log.channels.get(&gauge.name)?.clone();
            Some(Reading {
                sensor,
                name: gauge.name.clone(),
                age: gauge
                    .rate
                    .map_or_else(Vec::new, |rate| ages(log, &values, rate)),
                turns: gauge.turns && values.iter().all(|value| value.abs() <= HALF_A_TURN),
                values,
                sd: 0.0,
            })
        };
        gauges.iter().enumerate().filter_map(reading).collect()
    }
}

/// The largest angle that is not counted beyond turns, with its rounding, rad.
const HALF_A_TURN: f64 = 3.15;

#[cfg(test)]
mod tests {
    use super::*;

    fn log(step: f64, rows: usize) -> Log {
        let t: Vec<f64> = (0..rows).map(|k| step * k as f64).collect();
        let columns = vec![("t".to_owned(), t.clone()), ("gyro".to_owned(), t)];
        Log::from_columns("log", columns, None).unwrap()
    }

    fn readings(log: &Log, rate: f64) -> Vec<Reading> {
        let gauge = Gauge {
            name: "gyro".into(),
            rate: Some(rate),
            turns: false,
        };
        Sensed::of(log, &[Gauge::default(), gauge])
    }

    fn new_rows(log: &Log, rate: f64) -> Vec<usize> {
        let readings = readings(log, rate);
        assert_eq!(readings[0].sensor, 1);
        (0..log.len()).filter(|&k| readings[0].is_new(k)).collect()
    }

    /// At 100 rows a second: every other row, every third or fourth, all.
    #[test]
    fn a_slow_sensor_reads_at_its_own_times() {
        let log = log(0.01, 60);
        let every = |n: usize| (0..60).step_by(n).collect::<Vec<usize>>();
        assert_eq!(new_rows(&log, 50.0), every(2));
        assert_eq!(new_rows(&log, 100.0), every(1));
        assert_eq!(new_rows(&log, 500.0), every(1));
        assert_eq!(new_rows(&log, 30.0)[..5], [0, 4, 7, 10, 14]);
        let (t, _) = readings(&log, 30.0)[0].taken(&log.t);
        let late = |(n, t): (usize, &f64)| (t - n as f64 / 30.0).abs();
        assert!(
            t.iter().enumerate().map(late).all(|late| late < 1e-9),
            "{t:?}"
        );
    }

    #[test]
    fn an_angle_is_read_as_near_as_turns_bring_it() {
        let reading = Reading {
            sensor: 0,
            name: "crank".into(),
            values: vec![-3.0],
            age: Vec::new(),
            sd: 1e-3,
            turns: true,
        };
        assert!((reading.near(3.2, 0) - (TAU - 3.0)).abs() < 1e-12);
        assert!((reading.near(-3.1, 0) + 3.0).abs() < 1e-12);
    }
}
