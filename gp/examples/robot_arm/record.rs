//! A run of the arm, what its sensors say of it, and what is made of that.

use crate::Failure;
use crate::arm::{Arm, N, State};
use crate::control::{Controller, path};
use dynamics::constrained::{Baumgarte, Tolerance};
use dynamics::{Simulation, acceleration, integrate};
use gp::{Inputs, Scaling, farthest_points};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Samples per second.
pub const RATE: f64 = 240.0;
/// Standard deviation of the encoders, rad.
const ENCODER: f64 = 5e-6;
/// Standard deviation of the noise added to accelerations, rad/s².
pub const NOISE: f64 = 0.1;
/// Corner of the low-pass filter, Hz.
const CORNER: f64 = 25.0;
/// Samples dropped at either end, where the filter settles.
const EDGE: usize = 240;

/// A state as measured, and what the sensors cannot say.
#[derive(Clone)]
pub struct Sample {
    /// Seconds since the beginning of the run.
    pub t: f64,
    /// Filtered angles, velocities by differences, filtered torques.
    pub x: State,
    /// Acceleration by differences, with noise.
    pub measured: [f64; N],
    /// The same without the noise: what encoders, filter and differences make of it.
    pub differences: [f64; N],
    /// Noise-free acceleration at the measured state.
    pub truth: [f64; N],
    /// True multiplier at the measured state, N.
    pub lambda: f64,
}

/// A simulated run.
pub struct Run {
    pub samples: Vec<Sample>,
    /// Tip of the simulated arm, m, sample by sample, with its time.
    pub tip: Vec<(f64, [f64; 3])>,
    /// Largest distance of the simulated tip to the plane, m.
    pub violation: f64,
}

/// Simulate `segments` segments and process the log.
pub fn run(arm: &Arm, segments: usize, seed: u64) -> Result<Run, Failure> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let controller = Controller::new(arm);
    let simulation = Simulation::new(arm).with_baumgarte(Baumgarte::critical(10.0));
    let start = controller.start()?;
    let mut s = integrate::State {
        q: start.q,
        v: start.v,
        z: [],
    };
    let (mut angles, mut torques, mut tip) = (Vec::new(), Vec::new(), Vec::new());
    let mut violation = 0.0f64;
    let mut t = 0.0;
    for segment in path(segments, &mut rng) {
        for k in 0..(segment.seconds * RATE).ceil() as usize {
            let x = State {
                q: s.q,
                v: s.v,
                ..State::zero()
            };
            let u = controller.torque(&x, &segment.at(k as f64 / RATE))?;
            let position = arm.terms(&x).position;
            violation = violation.max((position[2] - crate::arm::PLANE).abs());
            tip.push((t, [position[0], position[1], position[2]]));
            angles.push(s.q);
            torques.push(u);
            s = simulation.rk4_step(t, &s, 1.0 / RATE, |_, _| u)?;
            t += 1.0 / RATE;
        }
    }
    let samples = process(arm, &angles, &torques, &mut rng)?;
    Ok(Run {
        samples,
        tip,
        violation,
    })
}

/// Encoder noise, one filter for angles and torques alike, differences.
fn process(
    arm: &Arm,
    angles: &[[f64; N]],
    torques: &[[f64; N]],
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Sample>, Failure> {
    let mut noise = |sd: f64| -> f64 {
        let e: f64 = StandardNormal.sample(rng);
        sd * e
    };
    let columns = |data: &[[f64; N]], e: &mut dyn FnMut() -> f64| -> Vec<Vec<f64>> {
        let column = |i: usize, e: &mut dyn FnMut() -> f64| -> Vec<f64> {
            data.iter().map(|d| d[i] + e()).collect()
        };
        (0..N).map(|i| low_pass(&column(i, e))).collect()
    };
    let q = columns(angles, &mut || noise(ENCODER));
    // A torque is held from one sample to the next: at the instant of a sample the
    // smooth signal behind it is the mean of the torques before and after.
    let held: Vec<[f64; N]> = (0..torques.len())
        .map(|k| std::array::from_fn(|i| 0.5 * (torques[k.max(1) - 1][i] + torques[k][i])))
        .collect();
    let u = columns(&held, &mut || 0.0);
    let mut out = Vec::new();
    for k in EDGE..angles.len().saturating_sub(EDGE) {
        let x = State {
            q: std::array::from_fn(|i| q[i][k]),
            v: std::array::from_fn(|i| 0.5 * RATE * (q[i][k + 1] - q[i][k - 1])),
            u: std::array::from_fn(|i| u[i][k]),
            ..State::zero()
        };
        let second = |i: usize| RATE * RATE * (q[i][k + 1] - 2.0 * q[i][k] + q[i][k - 1]);
        let differences: [f64; N] = std::array::from_fn(second);
        let measured = std::array::from_fn(|i| differences[i] + noise(NOISE));
        let solution = acceleration(arm, &x, None, &Tolerance::default())?;
        out.push(Sample {
            t: k as f64 / RATE,
            x,
            measured,
            differences,
            truth: solution.a.into(),
            lambda: solution.lambda[0],
        });
    }
    Ok(out)
}

/// Butterworth filter of second order, forwards and backwards: no delay.
fn low_pass(signal: &[f64]) -> Vec<f64> {
    let mut out = biquad(signal);
    out.reverse();
    let mut out = biquad(&out);
    out.reverse();
    out
}

fn biquad(signal: &[f64]) -> Vec<f64> {
    let c = (std::f64::consts::PI * CORNER / RATE).tan();
    let root = std::f64::consts::SQRT_2;
    let scale = 1.0 / (1.0 + root * c + c * c);
    let (b, a1, a2) = (
        c * c * scale,
        2.0 * (c * c - 1.0) * scale,
        (1.0 - root * c + c * c) * scale,
    );
    let first = signal.first().copied().unwrap_or(0.0);
    let (mut x, mut y) = ([first; 2], [first; 2]);
    signal
        .iter()
        .map(|&s| {
            let out = b * (s + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
            (x, y) = ([s, x[0]], [out, y[0]]);
            out
        })
        .collect()
}

/// Kernel input `(q, v, u)`.
pub fn input(x: &State) -> Vec<f64> {
    [x.q, x.v, x.u].concat()
}

/// Kernel inputs of samples, not scaled.
fn raw(samples: &[Sample]) -> gp::Result<Inputs> {
    Inputs::from_rows(&samples.iter().map(|s| input(&s.x)).collect::<Vec<_>>())
}

/// Mean and standard deviation of the inputs.
pub fn scaling(samples: &[Sample]) -> gp::Result<Scaling> {
    Scaling::of_inputs(&raw(samples)?)
}

/// The first `count` samples in farthest-point order, by scaled inputs.
pub fn farthest(samples: &[Sample], scaling: &Scaling, count: usize) -> gp::Result<Vec<Sample>> {
    let chosen = farthest_points(&scaling.inputs(&raw(samples)?)?, count, 0)?;
    Ok(chosen.into_iter().map(|i| samples[i].clone()).collect())
}

/// Samples at equal distances in time, `count` of them.
pub fn even(samples: &[Sample], count: usize) -> Vec<Sample> {
    (0..count.min(samples.len()))
        .map(|i| samples[i * samples.len() / count.max(1)].clone())
        .collect()
}
