//! The instruments as the controller reads them: biased, noisy, in steps, within their range.

use crate::robot::{self, INSTRUMENTS, Wheelbot};
use dynamics_codegen::diagnostic::Report;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use wheelbot_firmware::Readings;

/// Ranges: ±500 °/s,
const MOST_TURNING: f64 = 500.0 * std::f64::consts::PI / 180.0;
/// and ±2 g (6.1.2).
const MOST_FELT: f64 = 2.0 * 9.81;
/// Mean of every gyroscope at rest in the robot author's simulation, rad/s.
const TURNING_BIAS: f64 = -0.0065;
/// Standard deviation of the accelerometers' zeros from part to part, m/s²: a fifth of the 25 mg of
/// the part's data sheet (TDK ICM-20948, after mounting), for a robot that was calibrated.
const FELT_BIAS: f64 = 0.05;
/// Numbers of the IMUs: gyroscopes, then accelerometers.
const OF_IMUS: usize = 24;
const OF_GYROSCOPES: usize = 12;
/// Readings on the bench, each way up: half a minute.
const STILL: usize = 3000;

/// One of the numbers.
#[derive(Debug, Clone, Copy)]
struct Instrument {
    noise: f64,
    resolution: Option<f64>,
    bias: f64,
    range: f64,
}

/// All instruments, with their noise to come.
#[derive(Debug, Clone)]
pub struct Sensing {
    instruments: Vec<Instrument>,
    random: ChaCha8Rng,
}

impl Sensing {
    /// Noise and resolution as the model states them, bias and noise drawn from a seed.
    ///
    /// # Errors
    /// As [`robot::compiled`].
    pub fn new(seed: u64) -> Result<Self, Report> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let sensors = robot::compiled()?.model.sensors;
        let instruments = (0..).zip(&sensors).map(|(place, sensor)| {
            let (bias, range) = match place {
                0..OF_GYROSCOPES => (TURNING_BIAS, MOST_TURNING),
                OF_GYROSCOPES..OF_IMUS => {
                    let normal: f64 = StandardNormal.sample(&mut random);
                    (FELT_BIAS * normal, MOST_FELT)
                }
                _ => (0.0, f64::INFINITY),
            };
            Instrument {
                noise: sensor.noise,
                resolution: sensor.resolution,
                bias,
                range,
            }
        });
        Ok(Self {
            instruments: instruments.collect(),
            random,
        })
    }

    /// With the biases taken off that the IMUs show on a bench: the robot is held still, upright and upside down for half
    /// a minute each, and what an instrument reads on the mean of both is its bias.
    #[must_use]
    pub fn calibrated(mut self) -> Self {
        let mut sums = [0.0; OF_IMUS];
        for roll in [0.0, std::f64::consts::PI] {
            let held = robot::leaning(roll, 0.0);
            let shown = robot::shown_at(&Wheelbot::nominal(), &held, [0.0; 7]);
            for _ in 0..STILL {
                let read = self.imus(&shown);
                sums.iter_mut().zip(read).for_each(|(sum, x)| *sum += x);
            }
        }
        for (instrument, sum) in self.instruments.iter_mut().zip(sums) {
            instrument.bias -= sum / (2 * STILL) as f64;
        }
        self
    }

    /// Without noise and bias, still in steps and within range.
    #[must_use]
    pub fn without_noise(mut self) -> Self {
        for instrument in &mut self.instruments {
            (instrument.noise, instrument.bias) = (0.0, 0.0);
        }
        self
    }

    /// What the instruments read in the model's units where they show this: the IMUs' numbers, then the angles of
    /// both encoders in whole counts.
    pub fn numbers(&mut self, shown: &[f64; INSTRUMENTS]) -> Vec<f64> {
        let mut read = self.imus(shown).to_vec();
        for (place, &angle) in shown.iter().enumerate().take(OF_IMUS + 2).skip(OF_IMUS) {
            let step = self.instruments[place].resolution.unwrap_or(1.0);
            read.push((angle / step).round() * step);
        }
        read
    }

    fn imus(&mut self, shown: &[f64; INSTRUMENTS]) -> [f64; OF_IMUS] {
        let mut read = [0.0; OF_IMUS];
        for (place, value) in read.iter_mut().enumerate() {
            let Instrument {
                noise,
                resolution,
                bias,
                range,
            } = self.instruments[place];
            let normal: f64 = StandardNormal.sample(&mut self.random);
            let analogue = (shown[place] + bias + noise * normal).clamp(-range, range);
            *value = resolution.map_or(analogue, |step| (analogue / step).round() * step);
        }
        read
    }

    /// What the controller reads where the instruments show this.
    pub fn read(&mut self, shown: &[f64; INSTRUMENTS]) -> Readings<f32> {
        let read = self.imus(shown);
        let vectors = |first: usize| {
            core::array::from_fn(|imu| {
                core::array::from_fn(|axis| read[first + 3 * imu + axis] as f32)
            })
        };
        Readings {
            gyroscopes: vectors(0),
            accelerometers: vectors(OF_GYROSCOPES),
            rolling: self.counts(OF_IMUS, shown),
            reaction: self.counts(OF_IMUS + 1, shown),
        }
    }

    fn counts(&self, place: usize, shown: &[f64; INSTRUMENTS]) -> i32 {
        let step = self.instruments[place].resolution.unwrap_or(1.0);
        (shown[place] / step).round() as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{leaning, shown};
    use wheelbot_firmware::wheel::COUNTS_PER_TURN;
    use wheelbot_firmware::{Estimator, Settings, imu, wheel::Wheel};

    #[test]
    fn firmware_and_model_count_alike() {
        let sensors = robot::compiled().unwrap().model.sensors;
        for name in ["rolling", "spinning"] {
            let sensor = sensors.iter().find(|s| s.name == name).unwrap();
            let turn = f64::from(COUNTS_PER_TURN) * sensor.resolution.unwrap();
            assert!((turn - std::f64::consts::TAU).abs() < 1e-12);
        }
    }

    /// The firmware's mountings are those of the model's frames: turned back, all gyroscopes agree.
    #[test]
    fn imus_agree_in_body_axes() {
        let mut state = leaning(0.2, -0.1);
        (state.v[2], state.v[3], state.v[4]) = (1.0, -2.0, 3.0);
        let shown = shown(&Wheelbot::nominal(), &state, [0.0; 4]).unwrap();
        let read = Sensing::new(1).unwrap().without_noise().read(&shown);
        let turning = imu::in_body_axes(&imu::mountings::<f32>(), &read.gyroscopes);
        for other in &turning[1..] {
            for k in 0..3 {
                assert!((other[k] - turning[0][k]).abs() < 1e-3, "{turning:?}");
            }
        }
    }

    /// What is left of every bias is what noise leaves of the mean of a minute.
    #[test]
    fn a_bench_shows_the_biases() {
        let raw = Sensing::new(3).unwrap();
        let calibrated = raw.clone().calibrated();
        for (place, left) in calibrated.instruments.iter().enumerate() {
            let most = 4.0 * left.noise / ((2 * STILL) as f64).sqrt();
            assert!(left.bias.abs() <= most, "{place}: {}", left.bias);
        }
        let before = raw.instruments.iter().filter(|i| i.bias.abs() > 5e-3);
        assert!(before.count() > 20);
    }

    /// At rest the accelerometers say which way is up.
    #[test]
    fn a_leaning_robot_knows_its_tilt() {
        let shown = robot::shown_at(&Wheelbot::nominal(), &leaning(0.3, -0.2), [0.0; 7]);
        let read = Sensing::new(1).unwrap().without_noise().read(&shown);
        let mut estimator = Estimator::<f32>::new(Settings::published(), [0.0; 2]);
        let felt = estimator.update(&read, &Wheel::new()).felt;
        assert!(
            (felt[0] - 0.3).abs() < 1e-3 && (felt[1] + 0.2).abs() < 1e-3,
            "{felt:?}"
        );
    }
}
