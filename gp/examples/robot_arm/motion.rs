//! Motion over seconds from a noisy state, under the recorded torques (Fig. 5.14).

use crate::Failure;
use crate::arm::{Arm, N, PLANE, State};
use crate::models::Fit;
use crate::record::{RATE, Sample};
use dynamics::constrained::{Baumgarte, Tolerance};
use dynamics::{acceleration, integrate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Step of the symplectic Euler method, s.
pub const STEP: f64 = 0.0024;
/// Standard deviations of the initial state: rad, rad/s.
const BEGINNING: (f64, f64) = (2e-4, 2e-3);

/// A predicted motion.
pub struct Motion {
    pub name: &'static str,
    /// Seconds since its beginning.
    pub t: Vec<f64>,
    pub q: Vec<[f64; N]>,
    /// Tip above the plane, m; below it negative.
    pub height: Vec<f64>,
    /// Tip, m.
    pub tip: Vec<[f64; 3]>,
}

/// Torques between the samples of a run, linearly.
fn torque(samples: &[Sample], t: f64) -> [f64; N] {
    let at = (t * RATE).clamp(0.0, (samples.len() - 1) as f64);
    let (k, part) = (at.floor() as usize, at.fract());
    let next = (k + 1).min(samples.len() - 1);
    std::array::from_fn(|i| (1.0 - part) * samples[k].x.u[i] + part * samples[next].x.u[i])
}

fn simulate(
    name: &'static str,
    arm: &Arm,
    samples: &[Sample],
    start: &integrate::State<f64, N, 0>,
    a: &dyn Fn(&State) -> Result<[f64; N], Failure>,
) -> Result<Motion, Failure> {
    let mut s = *start;
    let mut out = Motion {
        name,
        t: Vec::new(),
        q: Vec::new(),
        height: Vec::new(),
        tip: Vec::new(),
    };
    let steps = ((samples.len() - 1) as f64 / RATE / STEP).floor() as usize;
    for k in 0..=steps {
        let t = k as f64 * STEP;
        let at = |t: f64, s: &integrate::State<f64, N, 0>| State {
            t,
            q: s.q,
            v: s.v,
            u: torque(samples, t),
            z: [],
        };
        let tip = arm.terms(&at(t, &s)).position;
        out.t.push(t);
        out.q.push(s.q);
        out.height.push(tip[2] - PLANE);
        out.tip.push(tip.into());
        let rate = |t: f64, s: &integrate::State<f64, N, 0>| {
            Ok::<_, Failure>(integrate::State {
                q: s.v,
                v: a(&at(t, s))?,
                z: [],
            })
        };
        s = integrate::symplectic_euler_step(rate, t, &s, STEP)?;
    }
    Ok(out)
}

/// The true motion from the measured state, then from a noisier one: SE-GP, GP²
/// without stabilisation, GP² with Baumgarte's `b̃` (ω = 10/s, ζ = 1).
pub fn motions(
    arm: &Arm,
    samples: &[Sample],
    se: &Fit,
    structured: &Fit,
    seed: u64,
) -> Result<Vec<Motion>, Failure> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sd: f64| -> f64 {
        let e: f64 = StandardNormal.sample(&mut rng);
        sd * e
    };
    let first = &samples[0].x;
    let exact = integrate::State {
        q: first.q,
        v: first.v,
        z: [],
    };
    let mut noisy = exact;
    (0..N).for_each(|i| noisy.q[i] += noise(BEGINNING.0));
    (0..N).for_each(|i| noisy.v[i] += noise(BEGINNING.1));
    let how = Baumgarte::critical(10.0);
    let truth = |x: &State| -> Result<[f64; N], Failure> {
        Ok(acceleration(arm, x, Some(&how), &Tolerance::default())?
            .a
            .into())
    };
    let run = |name, start, a: &dyn Fn(&State) -> Result<[f64; N], Failure>| {
        simulate(name, arm, samples, start, a)
    };
    Ok(vec![
        run("truth", &exact, &truth)?,
        run("SE", &noisy, &|x| se.acceleration(arm, x, None))?,
        run("GP²", &noisy, &|x| structured.acceleration(arm, x, None))?,
        run("GP², Baumgarte", &noisy, &|x| {
            structured.acceleration(arm, x, Some(&how))
        })?,
    ])
}
