//! Other estimators on the readings of a run that is over, and how far they are from the truth.

use crate::trial::{Row, rms};
use wheelbot_firmware::wheel::Wheel;
use wheelbot_firmware::{Estimator, INTERVAL, Readings, Settings, Tilt};

/// Corner of the low-pass of Fig. 6.11, Hz: that of the complementary filter at `α = 0.02`.
const CORNER: f64 = 0.32;

/// A motion as an estimator meets it: true roll and pitch, rad, and the readings.
#[derive(Debug, Clone, Copy)]
pub struct Met {
    /// `q₁, q₂`.
    pub tilt: [f64; 2],
    /// At the same time.
    pub readings: Readings<f32>,
}

impl Met {
    /// Of a run.
    pub fn in_run(rows: &[Row]) -> Vec<Self> {
        let met = |row: &Row| Self {
            tilt: [row.state.q[2], row.state.q[3]],
            readings: row.readings,
        };
        rows.iter().map(met).collect()
    }
}

/// What an estimator makes of a motion.
pub fn replayed(settings: Settings<f32>, motion: &[Met]) -> Vec<Tilt<f32>> {
    let start = motion.first().map_or([0.0; 2], |met| met.tilt);
    let mut estimator = Estimator::new(settings, start.map(|x| x as f32));
    let mut wheel = Wheel::new();
    let tick = |met: &Met| {
        wheel.read(met.readings.rolling, INTERVAL as f32);
        estimator.update(&met.readings, &wheel)
    };
    motion.iter().map(tick).collect()
}

/// `y + (1 − e^(−2π f h)) (x − y)`: a first-order low-pass that starts at its first value.
pub fn low_passed(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let share = 1.0 - (-std::f64::consts::TAU * CORNER * INTERVAL).exp();
    let pass = |last: &mut Option<f64>, value: f64| {
        let before = last.unwrap_or(value);
        *last = Some(before + share * (value - before));
        *last
    };
    values.scan(None, pass).collect()
}

/// Where estimators are compared: each is first told its bias on a robot that balances, as (6.22)
/// demands it.
#[derive(Debug, Clone)]
pub struct Bench {
    calm: Vec<Met>,
}

/// Errors behind the low-pass, rms, degrees: of roll and of pitch.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Of the accelerometers' tilt.
    pub felt: [f64; 2],
    /// Of the fused tilt.
    pub fused: [f64; 2],
}

impl Bench {
    /// With the readings of a robot that balances.
    pub fn new(calm: &[Row]) -> Self {
        Self {
            calm: Met::in_run(calm),
        }
    }

    /// How far an estimator is from the truth on a motion.
    pub fn errors(&self, settings: Settings<f32>, motion: &[Met]) -> Errors {
        let (calm, tilts) = (replayed(settings, &self.calm), replayed(settings, motion));
        let error = |pick: fn(&Tilt<f32>) -> [f32; 2]| {
            [0, 1].map(|k| {
                let of = |tilt: &Tilt<f32>| f64::from(pick(tilt)[k]);
                let bias = calm.iter().map(of).sum::<f64>() / calm.len().max(1) as f64;
                let missed = motion.iter().zip(&tilts);
                let missed = missed.map(|(met, tilt)| of(tilt) - bias - met.tilt[k]);
                rms(low_passed(missed).into_iter()).to_degrees()
            })
        };
        Errors {
            felt: error(|tilt| tilt.felt),
            fused: error(|tilt| tilt.fused),
        }
    }
}
