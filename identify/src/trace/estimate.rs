//! What the log says about the states: a curve through it, and what the sensors
//! read beside the curve.

use super::dictionary::Ranges;
use super::focus::Focus;
use super::input_noise::InputNoise;
use super::sensor_memory::SensorMemory;
use super::unmeasured::Echo;
use crate::log::{Record, Warning, evenly_spread, stretches};
use crate::machine::{History, States, shifted};
use crate::regression::{CORRELATION, Hold, Moments, Readings, derivative, divided};
use crate::smooth::{ChannelNoise, SmoothError, Smoothed, smooth_measured};
use nalgebra::DVector;
use std::ops::Range;
use std::sync::Arc;

/// A record with the curve that is thought to run through it.
#[derive(Debug, Clone)]
pub struct Observed {
    /// The log.
    pub record: Record,
    /// The states along the log.
    pub curve: States,
    /// Standard deviation of the position sensors.
    pub position_sd: Vec<f64>,
    /// Standard deviation of the velocity sensors (unused where none).
    pub velocity_sd: Vec<f64>,
    /// Standard deviation of the acceleration sensors (unused where none).
    pub acceleration_sd: Vec<f64>,
    /// How each sensor's errors follow one another.
    pub sensor_memory: SensorMemory,
    /// Noise of each input, zero where it is taken as logged.
    pub input_noise: Vec<InputNoise>,
    /// How long forces that nothing explains last, per coordinate, s.
    pub correlation: DVector<f64>,
    /// What inputs do between samples.
    pub hold: Hold,
    /// What noise of the sensors makes of estimates; empty until somebody asks, and where
    /// everything is measured.
    pub echo: Echo,
}

impl Observed {
    /// The kinematic estimate: smooth motion, no dynamics. Where nothing measures a coordinate,
    /// what the record says of it.
    ///
    /// # Errors
    /// If the log cannot be smoothed.
    pub fn new(mut record: Record, hold: Hold) -> Result<Self, SmoothError> {
        let mut smoothed = smooth_measured(&record)?;
        if drop_filtered_channels(&mut record, &smoothed) {
            smoothed = smooth_measured(&record)?;
        }
        let estimated = |i: usize| record.sensed.as_ref().map(|sensed| sensed.sd[i]);
        let noise = |pick: fn(&ChannelNoise) -> Option<f64>, derivative: usize| {
            let each = smoothed.iter().enumerate();
            let of = |(i, smoothed): (usize, &Option<Smoothed>)| match smoothed {
                Some(smoothed) => pick(&smoothed.noise),
                None => estimated(i).and_then(|sd| sd.get(derivative).copied()),
            };
            each.map(|one| of(one).unwrap_or(f64::INFINITY)).collect()
        };
        let curve = curve(&record, &smoothed);
        let position_sd = noise(|n| Some(n.sd_q), 0);
        let velocity_sd = noise(|n| n.sd_dq, 1);
        let acceleration_sd = noise(|n| n.sd_ddq, 2);
        Ok(Self {
            sensor_memory: SensorMemory::none(record.q.len()),
            input_noise: vec![InputNoise::default(); record.u.len()],
            record,
            curve,
            position_sd,
            velocity_sd,
            acceleration_sd,
            correlation: DVector::from_element(smoothed.len(), CORRELATION),
            hold,
            echo: Echo::new(),
        })
    }

    /// Stretches of the log, evenly spread over it, with about `samples` samples; `None` if
    /// there are not many more anyway. What the inputs were in between stays known.
    pub fn excerpt(&self, samples: usize) -> Option<Self> {
        let all = self.record.len();
        if (all as f64) < WORTH_CUTTING * samples as f64 {
            return None;
        }
        let length = samples / STRETCHES;
        let ranges = evenly_spread(all, STRETCHES, length);
        let curve = |ranges: &[Range<usize>]| {
            let cut = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
                columns.iter().map(|c| stretches(c, ranges)).collect()
            };
            States {
                t: stretches(&self.record.t, ranges),
                q: cut(&self.curve.q),
                v: cut(&self.curve.v),
                u: cut(&self.record.u),
                ..States::default()
            }
        };
        let mut from = 0;
        let with_lead = ranges.iter().map(|range| {
            let first = range.start.saturating_sub(LEAD_IN * length).max(from);
            from = range.end;
            first..range.end
        });
        let with_lead: Vec<Range<usize>> = with_lead.collect();
        let history = self.curve.history.clone().unwrap_or_else(|| {
            Arc::new(History {
                t: self.record.t.clone(),
                u: self.record.u.clone(),
                led: curve(&with_lead),
            })
        });
        Some(Self {
            curve: States {
                history: Some(history),
                ..curve(&ranges)
            },
            record: self.record.stretches(&ranges),
            position_sd: self.position_sd.clone(),
            velocity_sd: self.velocity_sd.clone(),
            acceleration_sd: self.acceleration_sd.clone(),
            sensor_memory: self.sensor_memory.clone(),
            input_noise: self.input_noise.clone(),
            correlation: self.correlation.clone(),
            hold: self.hold,
            echo: Echo::new(),
        })
    }

    /// Standard deviations of the sensors of one derivative of the positions.
    pub(super) fn sensor_sd_mut(&mut self, derivative: usize) -> &mut [f64] {
        let sensors = [
            &mut self.position_sd,
            &mut self.velocity_sd,
            &mut self.acceleration_sd,
        ];
        sensors.into_iter().nth(derivative).expect("at most two")
    }

    /// Standard deviations of white errors that hide as much of a slow motion as those of the sensors of
    /// one derivative of the positions.
    pub(super) fn white_equivalent(&self, derivative: usize) -> Vec<f64> {
        let sd = [&self.position_sd, &self.velocity_sd, &self.acceleration_sd];
        self.sensor_memory
            .white_equivalent(derivative, sd[derivative])
    }

    /// Takes the sensors to err as another log of the same machine has shown them to, where their errors
    /// last.
    pub(super) fn err_as(&mut self, other: &Self) {
        for derivative in 0..self.sensor_memory.0.len() {
            for i in 0..self.record.q.len() {
                let memory = other.sensor_memory.0[derivative][i];
                if memory > 0.0 {
                    let sd = [
                        &other.position_sd,
                        &other.velocity_sd,
                        &other.acceleration_sd,
                    ];
                    self.sensor_memory.0[derivative][i] = memory;
                    self.sensor_sd_mut(derivative)[i] = sd[derivative][i];
                }
            }
        }
    }

    /// Believes every sensor less.
    pub fn scale_noise(&mut self, factor: f64) {
        let sensors = [
            &mut self.position_sd,
            &mut self.velocity_sd,
            &mut self.acceleration_sd,
        ];
        sensors.into_iter().flatten().for_each(|sd| *sd *= factor);
    }

    /// What the sensors of `focus`, with these of the dictionary's values, read beside the
    /// curve, along which the accelerations are those given.
    pub fn readings(&self, focus: &Focus, values: &[f64], accelerations: &[Vec<f64>]) -> Readings {
        let values = focus.values(values);
        let mut readings = match focus.machine.has_sensor_errors() {
            true => self.corrected_readings(focus, &values, accelerations),
            false => self.plain_readings(),
        };
        if self.record.ddq.iter().any(Option::is_some) {
            readings.doubt_more(2, self.doubt_of_past(focus, &values));
        }
        readings
    }

    fn corrected_readings(
        &self,
        focus: &Focus,
        values: &[f64],
        accelerations: &[Vec<f64>],
    ) -> Readings {
        let states = focus.machine.at_rest(&self.curve, values);
        let read = focus.sensors.read(&states, accelerations, values);
        let beside = |y: &[f64], x: &[f64], slope: &[f64]| {
            let apart: Vec<f64> = y.iter().zip(x).map(|(y, x)| y - x).collect();
            divided(&apart, slope)
        };
        let channels = |i: usize| (&read.q[i][..], &read.v[i][..], &read.slope[i][..]);
        let mut readings = self.plain_readings();
        readings.doubt.clone_from(&read.doubt);
        let moments =
            |ahead: &Vec<f64>| (!ahead.is_empty()).then(|| Moments::new(&self.curve.t, ahead));
        readings.moments = read.ahead.iter().map(moments).collect();
        for i in 0..self.record.q.len() {
            let (q, v, slope) = channels(i);
            readings.position[i] = beside(&self.record.q[i], q, slope);
            readings.velocity[i] = self.record.dq[i].as_ref().map(|y| beside(y, v, slope));
            // Noise is what it is on the dial: behind a sensor that magnifies it is less.
            let magnified = slope.iter().map(|s| s.abs().max(f64::MIN_POSITIVE));
            let log_slope: f64 = magnified.map(f64::ln).sum();
            let mean = (log_slope / slope.len().max(1) as f64).exp();
            readings.position_sd[i] /= mean;
            readings.velocity_sd[i] /= mean;
            readings.acceleration_sd[i] /= mean;
            let others = [&self.record.dq[i], &self.record.ddq[i]];
            let channels = 1 + others.iter().filter(|channel| channel.is_some()).count();
            readings.log_slope += channels as f64 * log_slope;
            let [rate, acceleration] = [0, 1].map(|derivative| &read.motion[derivative][i]);
            // What is read of the acceleration beyond the acceleration itself at the sample next to it.
            let beyond: Vec<f64> = v.iter().zip(rate).map(|(read, v)| read - v).collect();
            let mut beyond = derivative(&self.curve.t, &beyond);
            if let Some(moments) = &readings.moments[i] {
                let there = acceleration.iter().zip(moments.nearest());
                let later = there.map(|(there, &sample)| there - accelerations[i][sample]);
                beyond
                    .iter_mut()
                    .zip(later)
                    .for_each(|(b, later)| *b += later);
            }
            let corrected = |y: &Vec<f64>| y.iter().zip(&beyond).map(|(y, b)| y - b).collect();
            readings.acceleration[i] = self.record.ddq[i].as_ref().map(corrected);
        }
        readings
    }

    fn plain_readings(&self) -> Readings {
        let beside = |y: &Vec<f64>, x: &Vec<f64>| y.iter().zip(x).map(|(y, x)| y - x).collect();
        let rates = self.record.dq.iter().zip(&self.curve.v);
        Readings {
            position: self
                .record
                .q
                .iter()
                .zip(&self.curve.q)
                .map(|(y, x)| beside(y, x))
                .collect(),
            position_sd: self.white_equivalent(0),
            velocity: rates
                .map(|(y, x)| y.as_ref().map(|y| beside(y, x)))
                .collect(),
            velocity_sd: self.white_equivalent(1),
            acceleration: self.record.ddq.clone(),
            acceleration_sd: self.white_equivalent(2),
            doubt: Default::default(),
            moments: Vec::new(),
            aside: self.record.aside.clone(),
            instruments: self
                .record
                .sensed
                .iter()
                .flat_map(|s| s.readings.clone())
                .collect(),
            log_slope: 0.0,
        }
    }

    /// Moves the curve by a departure `(δq, δv)` per sample.
    pub fn move_by(&mut self, departure: &[DVector<f64>]) {
        let n = self.curve.q.len();
        for (sample, delta) in departure.iter().enumerate() {
            for i in 0..n {
                self.curve.q[i][sample] += delta[i];
                self.curve.v[i][sample] += delta[n + i];
            }
        }
    }

    /// Moves the curve of one coordinate to where it is `ahead` seconds later, sample by sample.
    pub fn move_in_time(&mut self, coordinate: usize, ahead: &[f64]) {
        let curve = &self.curve;
        let accelerations = derivative(&curve.t, &curve.v[coordinate]);
        let moved = shifted(curve, coordinate, &accelerations, ahead);
        self.curve.q[coordinate] = moved.q;
        self.curve.v[coordinate] = moved.v;
    }

    /// Where the log goes.
    pub fn ranges(&self) -> Ranges {
        let sorted = |column: &Vec<f64>| {
            let mut values = column.clone();
            values.sort_by(f64::total_cmp);
            values
        };
        let sizes = |column: &Vec<f64>| {
            let mut values: Vec<f64> = column.iter().map(|u| u.abs()).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let usual = |column: &Vec<f64>| {
            let squares: f64 = column.iter().map(|v| v * v).sum();
            (squares / column.len().max(1) as f64).sqrt()
        };
        Ranges {
            positions: self.record.q.iter().map(sorted).collect(),
            measured: (0..self.record.q.len())
                .map(|i| self.record.is_measured(i))
                .collect(),
            speeds: self.curve.v.iter().map(usual).collect(),
            inputs: self.record.u.iter().map(sizes).collect(),
            sensors: self
                .record
                .readings()
                .iter()
                .map(|r| r.name.clone())
                .collect(),
            missing: Vec::new(),
        }
    }
}

/// In how many stretches an excerpt is taken.
const STRETCHES: usize = 4;
/// For how many times the length of a stretch what leads to it is remembered.
const LEAD_IN: usize = 3;
/// A log is not cut unless it is this many times as long as what is needed.
const WORTH_CUTTING: f64 = 1.5;

/// The smoothed motion of a record with its inputs; where nothing measures a coordinate, what the
/// record says of it.
fn curve(record: &Record, smoothed: &[Option<Smoothed>]) -> States {
    let of = |i: usize| match (&smoothed[i], &record.dq[i]) {
        (Some(smoothed), _) => (smoothed.q.clone(), smoothed.v.clone()),
        (None, Some(rate)) => (record.q[i].clone(), rate.clone()),
        (None, None) => (record.q[i].clone(), derivative(&record.t, &record.q[i])),
    };
    let (q, v) = (0..smoothed.len()).map(of).unzip();
    States {
        t: record.t.clone(),
        q,
        v,
        u: record.u.clone(),
        ..States::default()
    }
}

/// A velocity or acceleration whose errors follow one another this closely was
/// filtered before it was logged: it carries no news, only somebody's idea of it.
const FILTERED: f64 = 0.5;

/// Takes out channels that are no sensor's; says whether there were any.
fn drop_filtered_channels(record: &mut Record, smoothed: &[Option<Smoothed>]) -> bool {
    let mut dropped = false;
    for (i, smoothed) in smoothed.iter().enumerate() {
        for innovations in smoothed.iter().flat_map(|smoothed| &smoothed.innovations) {
            let channel = match innovations.channel {
                "dq" => &mut record.dq[i],
                "ddq" => &mut record.ddq[i],
                _ => continue,
            };
            if innovations.lag_1 > FILTERED && channel.take().is_some() {
                let column = format!("{}_{}", innovations.channel, record.coordinates[i]);
                record.warnings.push(Warning::Filtered { column });
                dropped = true;
            }
        }
    }
    dropped
}

#[cfg(test)]
mod tests {
    use super::super::linearised::linearised;
    use super::super::settle::{SMALLEST_SHARE, noise};
    use super::super::wheel::{WHEEL, begun, named, rectangular};
    use crate::regression::{Hold, Whitener};
    use std::fmt::Write;

    /// A motor that follows its input by 50 ms is at a stretch's first sample where it is there in
    /// the whole log.
    #[test]
    fn a_stretch_remembers_what_led_to_it() {
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..1500 {
            let t = 0.01 * f64::from(k);
            writeln!(text, "{t},{},{}", (3.0 * t).sin(), -0.18 * (3.0 * t).sin()).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let lag = named(&dictionary, "input_lag(motor)");
        let mut values = start.values;
        values[dictionary.candidates[lag].parameters[0]] = 0.05;
        let focus = dictionary.focus(&[lag]);
        let values = focus.values(&values);
        let whole = start.observed;
        let part = whole.excerpt(400).unwrap();
        let [whole, part] = [whole.curve, part.curve].map(|curve| {
            focus
                .machine
                .remember(&curve, Hold::Linear, &values)
                .unwrap()
        });
        assert_eq!(part.len(), 400);
        for (t, z) in part.t.iter().zip(&part.memory.z[0]) {
            let k = whole.t.iter().position(|other| other == t).unwrap();
            let expected = whole.memory.z[0][k];
            assert!((z - expected).abs() < 1e-9, "{t}: {z} {expected}");
        }
    }

    /// Whatever stands in a sample that is set aside, the fit is the same.
    #[test]
    fn what_is_set_aside_has_no_weight() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut random = rectangular(9);
        for k in 0..300 {
            let t = 0.01 * f64::from(k);
            let q = 0.3 * (3.0 * t).sin() + 1e-3 * random();
            writeln!(text, "{t},{q},{}", -0.054 * (3.0 * t).sin()).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let focus = dictionary.focus(&[]);
        let mut observed = start.observed;
        observed.record.aside.q[0] = (0..300).map(|k| k == 120).collect();
        let mut innovations = |by: f64| {
            observed.record.q[0][120] += by;
            let dynamics = linearised(&focus, &observed, &start.values).unwrap();
            let accelerations = dynamics.accelerations();
            let readings = observed.readings(&focus, &start.values, &accelerations);
            let noise = noise(&dynamics, SMALLEST_SHARE);
            let whitener = Whitener::new(&dynamics, &readings, &noise);
            assert_eq!(whitener.reading_count(), 299);
            let all = whitener.position_innovations().into_iter();
            all.map(|one| (one.sample, one.value)).collect::<Vec<_>>()
        };
        let (without, with) = (innovations(0.0), innovations(100.0));
        assert_eq!(without, with);
        assert!(with.iter().all(|(sample, _)| *sample != 120));
    }
}
