//! The model's sensors as a log shows them: with noise, in steps, at rates and times of their own.

use crate::mistake::Mistake;
use crate::noise::Channel;
use dynamics_codegen::Model;
use std::collections::VecDeque;

/// Streams of random numbers of sensors begin here; those of a log's other columns lie below.
const FIRST_STREAM: u64 = 1 << 32;

/// What the sensors showed last.
#[derive(Debug)]
pub(super) struct Gauges {
    gauges: Vec<Gauge>,
}

#[derive(Debug)]
struct Gauge {
    noise: Channel,
    resolution: Option<f64>,
    /// When it reads; `None`: whenever somebody looks.
    due: Option<Ticks>,
    /// What a reading is of, where that is another time.
    elsewhen: Option<Elsewhen>,
    shown: f64,
}

/// Times of some rates, from a start on.
#[derive(Debug, Clone)]
struct Ticks {
    start: f64,
    rates: Vec<(f64, u64)>,
}

/// Values at times before or behind those of the readings.
#[derive(Debug)]
struct Elsewhen {
    /// How much later than the reading its value is, s.
    lead: f64,
    /// The readings whose values are still to come.
    to_come: Ticks,
    /// The values of readings to come.
    seen: VecDeque<f64>,
}

/// How sensors are looked at.
pub(super) struct Looks {
    /// When the first readings are taken, s.
    pub start: f64,
    /// How often somebody looks, per second.
    pub rates: Vec<f64>,
    /// Per sensor how much later than a reading its value is, s.
    pub leads: Vec<f64>,
}

impl Gauges {
    /// The sensors of a model.
    pub fn new(model: &Model, seed: u64, looks: &Looks) -> Self {
        let Looks {
            start,
            rates,
            leads,
        } = looks;
        let gauge = |(index, sensor): (usize, &dynamics_codegen::model::Sensor)| {
            let lead = leads[index];
            let own = sensor.rate.map(|rate| Ticks::new(*start, &[rate]));
            // Whoever looks at what is of another time has to have said so before.
            let due = match own {
                None if lead != 0.0 => Some(Ticks::new(*start, rates)),
                own => own,
            };
            let elsewhen = due.clone().filter(|_| lead != 0.0);
            Gauge {
                noise: Channel::new(sensor.noise, seed, FIRST_STREAM + index as u64),
                resolution: sensor.resolution,
                elsewhen: elsewhen.map(|to_come| Elsewhen {
                    lead,
                    to_come,
                    seen: VecDeque::new(),
                }),
                due,
                shown: 0.0,
            }
        };
        Self {
            gauges: model.sensors.iter().enumerate().map(gauge).collect(),
        }
    }

    /// When the motion has to be looked at next for a sensor; never, if there is no such time.
    pub fn next(&self) -> f64 {
        let times = self.gauges.iter().map(Gauge::next);
        times.fold(f64::INFINITY, f64::min)
    }

    /// The shortest time between two readings of one sensor, s.
    pub fn shortest_interval(&self) -> f64 {
        let due = self.gauges.iter().filter_map(|gauge| gauge.due.as_ref());
        let rates = due.flat_map(|ticks| ticks.rates.iter());
        rates.fold(f64::INFINITY, |least, (rate, _)| least.min(1.0 / rate))
    }

    /// How long after a reading the last sensor knows what it is, s.
    pub fn patience(&self) -> f64 {
        let leads = self.gauges.iter().map(Gauge::lead);
        leads.fold(0.0, f64::max)
    }

    /// Refuses sensors that are early, for a controller to read.
    ///
    /// # Errors
    /// If there is one.
    pub fn refuse_early(&self, model: &Model) -> Result<(), Mistake> {
        let mut pairs = self.gauges.iter().zip(&model.sensors);
        let Some((gauge, sensor)) = pairs.find(|(gauge, _)| gauge.is_early()) else {
            return Ok(());
        };
        let message = format!(
            "the sensor `{}` shows what comes {} s later: no controller can read that",
            sensor.name,
            gauge.lead()
        );
        Err(Mistake::new(message).help("make it late, or leave out `--control`"))
    }

    /// The sensors see `values` at `t`; those that are due read. Sensors without a rate read whenever
    /// they are asked.
    pub fn read(&mut self, t: f64, instant: f64, values: &[f64]) {
        for (gauge, &value) in self.gauges.iter_mut().zip(values) {
            gauge.see(t, instant, value);
            if !gauge.is_early() {
                gauge.read(t, instant, value);
            }
        }
    }

    /// Early sensors, which know by now what they are to show at `t`, put it in its place.
    pub fn read_early(&mut self, t: f64, instant: f64, shown: &mut [f64]) {
        for (gauge, shown) in self.gauges.iter_mut().zip(shown) {
            if gauge.is_early() {
                gauge.read(t, instant, f64::NAN);
                *shown = gauge.shown;
            }
        }
    }

    /// What they show.
    pub fn shown(&self) -> impl Iterator<Item = f64> {
        self.gauges.iter().map(|gauge| gauge.shown)
    }
}

impl Gauge {
    fn lead(&self) -> f64 {
        self.elsewhen.as_ref().map_or(0.0, |other| other.lead)
    }

    fn is_early(&self) -> bool {
        self.lead() > 0.0
    }

    fn next(&self) -> f64 {
        let value = self.elsewhen.as_ref().map(Elsewhen::next);
        let reading = self.due.as_ref().filter(|_| !self.is_early());
        let times = value.into_iter().chain(reading.map(Ticks::next));
        times.fold(f64::INFINITY, f64::min)
    }

    /// Keeps the values of readings that are not due yet, or were before.
    fn see(&mut self, t: f64, instant: f64, value: f64) {
        let Some(other) = &mut self.elsewhen else {
            return;
        };
        while other.next() <= t + instant {
            other.to_come.pass(instant);
            other.seen.push_back(value);
        }
    }

    /// Reads all that is due at `t`.
    fn read(&mut self, t: f64, instant: f64, value: f64) {
        let Some(due) = &mut self.due else {
            self.shown = self.seen(value);
            return;
        };
        let mut taken = Vec::new();
        while due.next() <= t + instant {
            due.pass(instant);
            let then = self.elsewhen.as_mut().map(|other| other.seen.pop_front());
            taken.push(then.flatten().unwrap_or(value));
        }
        for value in taken {
            self.shown = self.seen(value);
        }
    }

    fn seen(&mut self, value: f64) -> f64 {
        let noisy = value + self.noise.draw();
        match self.resolution {
            Some(step) => (noisy / step).round() * step,
            None => noisy,
        }
    }
}

impl Elsewhen {
    /// When the next value is; before the start all is as at the start.
    fn next(&self) -> f64 {
        (self.to_come.next() + self.lead).max(self.to_come.start)
    }
}

impl Ticks {
    fn new(start: f64, rates: &[f64]) -> Self {
        Self {
            start,
            rates: rates.iter().map(|&rate| (rate, 0)).collect(),
        }
    }

    fn next(&self) -> f64 {
        let times = self.rates.iter().map(|(rate, count)| *count as f64 / rate);
        self.start + times.fold(f64::INFINITY, f64::min)
    }

    /// Goes on behind the next time; what is closer to it than `instant` is the same.
    fn pass(&mut self, instant: f64) {
        let next = self.next();
        for (rate, count) in &mut self.rates {
            if self.start + *count as f64 / *rate <= next + instant {
                *count += 1;
            }
        }
    }
}
