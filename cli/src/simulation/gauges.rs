//! The model's sensors as a log shows them: with noise, in steps, at rates of their own.

use crate::noise::Channel;
use dynamics_codegen::Model;

/// Streams of random numbers of sensors begin here; those of a log's other columns lie below.
const FIRST_STREAM: u64 = 1 << 32;

/// What the sensors showed last.
#[derive(Debug)]
pub(super) struct Gauges {
    gauges: Vec<Gauge>,
    start: f64,
}

#[derive(Debug)]
struct Gauge {
    noise: Channel,
    resolution: Option<f64>,
    /// Readings per second; `None`: whenever somebody looks.
    rate: Option<f64>,
    readings: u64,
    shown: f64,
}

impl Gauges {
    /// The sensors of a model; the first readings are taken at `start`.
    pub fn new(model: &Model, seed: u64, start: f64) -> Self {
        let gauge = |(index, sensor): (usize, &dynamics_codegen::model::Sensor)| Gauge {
            noise: Channel::new(sensor.noise, seed, FIRST_STREAM + index as u64),
            resolution: sensor.resolution,
            rate: sensor.rate,
            readings: 0,
            shown: 0.0,
        };
        Self {
            gauges: model.sensors.iter().enumerate().map(gauge).collect(),
            start,
        }
    }

    /// When a sensor with a rate of its own reads next; never, if there is none.
    pub fn next(&self) -> f64 {
        let times = self
            .gauges
            .iter()
            .filter_map(|gauge| gauge.next(self.start));
        times.fold(f64::INFINITY, f64::min)
    }

    /// The shortest time between two readings of one sensor, s.
    pub fn shortest_interval(&self) -> f64 {
        let rates = self.gauges.iter().filter_map(|gauge| gauge.rate);
        rates.fold(f64::INFINITY, |least, rate| least.min(1.0 / rate))
    }

    /// Those that are due at `t` read `values`. Sensors without a rate read whenever they are
    /// asked.
    pub fn read(&mut self, t: f64, instant: f64, values: &[f64]) {
        for (gauge, &value) in self.gauges.iter_mut().zip(values) {
            if gauge
                .next(self.start)
                .is_none_or(|next| next <= t + instant)
            {
                gauge.readings += 1;
                gauge.shown = gauge.seen(value);
            }
        }
    }

    /// What they show.
    pub fn shown(&self) -> impl Iterator<Item = f64> {
        self.gauges.iter().map(|gauge| gauge.shown)
    }
}

impl Gauge {
    fn next(&self, start: f64) -> Option<f64> {
        self.rate.map(|rate| start + self.readings as f64 / rate)
    }

    fn seen(&mut self, value: f64) -> f64 {
        let noisy = value + self.noise.draw();
        match self.resolution {
            Some(step) => (noisy / step).round() * step,
            None => noisy,
        }
    }
}
