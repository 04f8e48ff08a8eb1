//! The tilt estimator of Fig. 6.10: gyroscopes and accelerometers fused by a complementary filter.

use crate::euler_rates::euler_rates;
use crate::gravity;
use crate::imu::{COUNT, Mounting, in_body_axes, mean, mountings};
use crate::pivot::{self, Moving, Terms};
use crate::sphere::Sphere;
use crate::tick::Readings;
use crate::vector::{Attitude, Vector, difference, scaled};
use crate::wheel::Wheel;
use dynamics::Real;

/// How the accelerometers' readings become tilt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accelerometers {
    /// By the least-squares map of [6.14], as the robot does it.
    LeastSquares,
    /// Gravity has its length and the body is rigid: [`crate::sphere`].
    Sphere,
}

/// What can be chosen.
#[derive(Clone, Copy, Debug)]
pub struct Settings<T> {
    /// Seconds from one tick to the next.
    pub interval: T,
    /// `α` of [6.20], the accelerometers' share.
    pub fusion: T,
    /// `r_w`, m.
    pub radius: T,
    /// Terms of the pivot's acceleration.
    pub terms: Terms,
    /// How the accelerometers are read.
    pub accelerometers: Accelerometers,
}

impl<T: Real> Settings<T> {
    /// The robot's (wheelbot-v2.5, e8aebc5), with the wheel radius of its firmware.
    pub fn published() -> Self {
        Self {
            interval: T::from_f64(crate::INTERVAL),
            fusion: T::from_f64(0.02),
            radius: T::from_f64(0.049),
            terms: Terms::PUBLISHED,
            accelerometers: Accelerometers::LeastSquares,
        }
    }
}

/// Roll and pitch, rad, by three ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt<T> {
    /// Fused: `q̂₁, q̂₂`.
    pub fused: [T; 2],
    /// From the accelerometers alone: `q₁,A, q₂,A`.
    pub felt: [T; 2],
    /// Rates of roll, pitch and yaw from the gyroscopes, rad/s.
    pub rates: Vector<T>,
    /// The pivot's acceleration that was assumed, in body axes, m/s².
    pub pivot: Vector<T>,
}

/// The estimator and what it remembers.
#[derive(Clone, Copy, Debug)]
pub struct Estimator<T: Real> {
    settings: Settings<T>,
    mountings: [Mounting<T>; COUNT],
    weights: [T; COUNT],
    sphere: Sphere<T>,
    tilt: Tilt<T>,
    /// Whether `tilt.rates` are those of a tick.
    started: bool,
}

impl<T: Real> Estimator<T> {
    /// Starts from an estimate of roll and pitch, rad.
    pub fn new(settings: Settings<T>, start: [T; 2]) -> Self {
        let mountings = mountings();
        let zero = [T::zero(); 3];
        Self {
            settings,
            weights: gravity::weights(&mountings),
            sphere: Sphere::new(&mountings, T::from_f64(9.81)),
            mountings,
            tilt: Tilt {
                fused: start,
                felt: start,
                rates: zero,
                pivot: zero,
            },
            started: false,
        }
    }

    /// One that goes on from an estimate of roll and pitch, rad, and from rates of roll, pitch and
    /// yaw, rad/s.
    #[must_use]
    pub fn remembering(mut self, fused: [T; 2], rates: Vector<T>) -> Self {
        (self.tilt.fused, self.tilt.rates) = (fused, rates);
        self.started = true;
        self
    }

    /// What it made of the last tick.
    pub fn tilt(&self) -> &Tilt<T> {
        &self.tilt
    }

    /// One tick: `wheel` is the rolling wheel, its encoder already read.
    pub fn update(&mut self, readings: &Readings<T>, wheel: &Wheel<T>) -> Tilt<T> {
        let Settings {
            interval, fusion, ..
        } = self.settings;
        let before = self.tilt;
        let attitude = Attitude::new(before.fused[0], before.fused[1]);
        let omega = mean(&in_body_axes(&self.mountings, &readings.gyroscopes));
        let rates = euler_rates(&attitude, omega);
        let pivot = self.pivot(&attitude, rates, wheel);
        let felt = in_body_axes(&self.mountings, &readings.accelerometers);
        let gravity = match self.settings.accelerometers {
            Accelerometers::LeastSquares => gravity::estimate(&self.weights, &felt, pivot),
            Accelerometers::Sphere => self.sphere.estimate(&felt, pivot, omega),
        };
        let felt = gravity::tilt(gravity);
        let fused = core::array::from_fn(|k| {
            let turned = before.fused[k] + interval * rates[k];
            fusion * felt[k] + (T::one() - fusion) * turned
        });
        self.started = true;
        self.tilt = Tilt {
            fused,
            felt,
            rates,
            pivot,
        };
        self.tilt
    }

    /// `ᴮp̈_W`; accelerations of the angles are differences of the rates of two ticks.
    fn pivot(&self, attitude: &Attitude<T>, rates: Vector<T>, wheel: &Wheel<T>) -> Vector<T> {
        let Settings {
            interval,
            radius,
            terms,
            ..
        } = self.settings;
        let change = difference(rates, self.tilt.rates);
        let accelerations = match self.started {
            true => scaled(interval.recip(), change),
            false => [T::zero(); 3],
        };
        let moving = Moving {
            rates,
            accelerations,
            wheel_rate: wheel.rate,
            wheel_acceleration: wheel.acceleration,
        };
        pivot::acceleration(terms, radius, attitude, &moving)
    }
}
