//! Jumping up (6.4.2): one wheel's current by the clock, step by step; the balancing controllers take over, each
//! when the robot is near enough to upright.

use crate::balance::Balance;
use crate::estimator::{Estimator, Settings, Tilt};
use crate::tick::Readings;
use crate::wheel::Wheel;
use dynamics::{Real, Scalar};

/// A current until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<T> {
    /// Its end, s since the robot was switched on.
    pub until: T,
    /// A, on a robot that lies on its positive side.
    pub current: T,
    /// At the end the current falls to nothing along a quarter of a cosine, for so many seconds.
    pub easing: T,
    /// There is none while the wheel turns faster than this in the current's direction, rad/s.
    pub fastest: T,
}

/// How many segments a plan has.
pub const SEGMENTS: usize = 6;

/// When a controller takes over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandOver<T> {
    /// Whether it is the pitch that tells, and not the roll.
    pub by_pitch: bool,
    /// Where it does, as an angle from upright, rad.
    pub within: T,
}

/// A way up in two steps, on a robot that lies on its positive side: its roll or its pitch is a right angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan<T> {
    /// Whether the rolling wheel does it, and not the reaction wheel.
    pub by_rolling: bool,
    /// One after the other.
    pub segments: [Segment<T>; SEGMENTS],
    /// From when on the estimator runs, s,
    pub begin: T,
    /// and the angle that it begins with, rad. Until then it says so.
    pub first: T,
    /// When the second step begins, s: controllers take over from here on.
    pub second: T,
    /// When roll and pitch are balanced.
    pub hand_over: [HandOver<T>; 2],
}

impl<T: Real> Plan<T> {
    /// The wheel's current at a time, A, where it turns with `rate` rad/s. Nothing after the last segment.
    pub fn current(&self, t: T, rate: T) -> T {
        let mut segments = self.segments.iter();
        let Some(segment) = segments.find(|segment| t < segment.until) else {
            return T::zero();
        };
        if rate * segment.current.sign() >= segment.fastest {
            return T::zero();
        }
        let left = segment.until - t;
        if left >= segment.easing {
            return segment.current;
        }
        let share = T::one() - left / segment.easing;
        segment.current * (share * T::from_f64(core::f64::consts::FRAC_PI_2)).cos()
    }
}

impl Plan<f64> {
    /// In another type of numbers.
    pub fn cast<T: Real>(&self) -> Plan<T> {
        let segment = |s: Segment<f64>| Segment {
            until: T::from_f64(s.until),
            current: T::from_f64(s.current),
            easing: T::from_f64(s.easing),
            fastest: T::from_f64(s.fastest),
        };
        Plan {
            by_rolling: self.by_rolling,
            segments: self.segments.map(segment),
            begin: T::from_f64(self.begin),
            first: T::from_f64(self.first),
            second: T::from_f64(self.second),
            hand_over: self.hand_over.map(|h| HandOver {
                by_pitch: h.by_pitch,
                within: T::from_f64(h.within),
            }),
        }
    }
}

/// Estimator, controllers and the clock.
#[derive(Clone, Copy, Debug)]
pub struct Jump<T: Real> {
    plan: Plan<T>,
    /// 1 or −1: on which side the robot lies.
    side: T,
    estimator: Estimator<T>,
    balance: Balance<T>,
    /// The reaction wheel and the rolling wheel.
    wheels: [Wheel<T>; 2],
    interval: T,
    ticks: u32,
    /// What is shown until the estimator begins.
    waiting: Tilt<T>,
    balanced: [bool; 2],
}

impl<T: Real> Jump<T> {
    /// Nothing read yet. `positive` is the side on which the robot lies.
    pub fn new(plan: Plan<T>, positive: bool, settings: Settings<T>, balance: Balance<T>) -> Self {
        let side = if positive { T::one() } else { -T::one() };
        let mut start = [T::zero(); 2];
        start[usize::from(plan.by_rolling)] = side * plan.first;
        let zero = [T::zero(); 3];
        Self {
            plan,
            side,
            estimator: Estimator::new(settings, start),
            balance,
            wheels: [Wheel::new(); 2],
            interval: <T as Scalar>::from_f64(crate::INTERVAL),
            ticks: 0,
            waiting: Tilt {
                fused: start,
                felt: start,
                rates: zero,
                pivot: zero,
            },
            balanced: [false; 2],
        }
    }

    /// Whether roll and pitch are balanced yet.
    pub fn balanced(&self) -> [bool; 2] {
        self.balanced
    }

    /// Reads everything once: the estimate, and the currents of the reaction wheel and of the rolling wheel, A.
    pub fn tick(&mut self, readings: &Readings<T>) -> (Tilt<T>, [T; 2]) {
        let counts = [readings.reaction, readings.rolling];
        for k in 0..2 {
            self.wheels[k].read(counts[k], self.interval);
        }
        let t = T::from_f64(f64::from(self.ticks)) * self.interval;
        self.ticks = self.ticks.saturating_add(1);
        let begun = t >= self.plan.begin;
        let tilt = match begun {
            true => self.estimator.update(readings, &self.wheels[1]),
            false => self.waiting,
        };
        if t >= self.plan.second {
            self.hand_over(tilt.fused);
        }
        let [reaction, rolling] = self.wheels.map(|wheel| (wheel.angle, wheel.rate));
        let [roll_rate, pitch_rate, _] = tilt.rates;
        let none = [T::zero(); 2];
        let (rates, wheels) = ([roll_rate, pitch_rate], [reaction, rolling]);
        let balancing = self.balance.currents(tilt.fused, rates, wheels, none);
        let driving = usize::from(self.plan.by_rolling);
        let rate = self.side * self.wheels[driving].rate;
        let forward = self.side * self.plan.current(t, rate);
        let current = |k: usize| match (self.balanced[k], k == driving) {
            (true, _) => balancing[k],
            (false, true) => forward,
            (false, false) => T::zero(),
        };
        (tilt, core::array::from_fn(current))
    }

    /// Gives wheels to their controllers; their angles count from here.
    fn hand_over(&mut self, tilt: [T; 2]) {
        for k in 0..2 {
            let HandOver { by_pitch, within } = self.plan.hand_over[k];
            if !self.balanced[k] && tilt[usize::from(by_pitch)].abs() < within {
                self.balanced[k] = true;
                self.wheels[k].restart();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::Gains;

    fn segment(until: f64, current: f64, easing: f64, fastest: f64) -> Segment<f64> {
        Segment {
            until,
            current,
            easing,
            fastest,
        }
    }

    fn plan() -> Plan<f64> {
        let last = segment(0.5, 12.0, 0.1, f64::INFINITY);
        Plan {
            by_rolling: false,
            segments: [
                segment(0.2, -5.0, 0.0, 290.0),
                segment(0.3, 0.0, 0.0, f64::INFINITY),
                last,
                last,
                last,
                last,
            ],
            begin: 0.0,
            first: 0.5,
            second: 0.1,
            hand_over: [HandOver {
                by_pitch: false,
                within: 0.1,
            }; 2],
        }
    }

    #[test]
    fn currents_follow_the_clock() {
        let plan = plan();
        assert_eq!(plan.current(0.0, 0.0), -5.0);
        assert_eq!(plan.current(0.1, -290.0), 0.0);
        assert_eq!(plan.current(0.1, 400.0), -5.0);
        assert_eq!(plan.current(0.25, 0.0), 0.0);
        assert_eq!(plan.current(0.35, 0.0), 12.0);
        let halfway = 12.0 * core::f64::consts::FRAC_1_SQRT_2;
        assert!((plan.current(0.45, 0.0) - halfway).abs() < 1e-12);
        assert!(plan.current(0.5 - 1e-9, 0.0) < 1e-6);
        assert_eq!(plan.current(0.6, 0.0), 0.0);
    }

    /// A robot that lies still at a roll until it is held upright: on the other side currents have the other sign, and
    /// both controllers take over when the estimate is near, not before the second step.
    #[test]
    fn controllers_take_over_near_upright() {
        let balance = Balance {
            gains: Gains::PUBLISHED,
            bias: [0.0; 2],
        };
        let mut jump = Jump::new(plan(), false, Settings::published(), balance);
        // Upright, turned back into the axes of every IMU.
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let felt = crate::imu::mountings::<f64>()
            .map(|mounting| axes.map(|axis| 9.81 * mounting.to_body(axis)[2]));
        let readings = Readings {
            gyroscopes: [[0.0; 3]; 4],
            accelerometers: felt,
            reaction: 0,
            rolling: 0,
        };
        let (tilt, currents) = jump.tick(&readings);
        assert!((tilt.fused[0] + 0.49).abs() < 1e-9, "{tilt:?}");
        assert_eq!(currents, [5.0, 0.0]);
        let mut since = None;
        for tick in 1..200 {
            let (tilt, _) = jump.tick(&readings);
            assert_eq!(jump.balanced(), [tilt.fused[0].abs() < 0.1; 2]);
            since = since.or(jump.balanced()[0].then_some(tick));
        }
        // 0.5 · 0.98ⁿ < 0.1.
        assert_eq!(since, Some(79));
    }
}
