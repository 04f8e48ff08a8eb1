//! Data and fits of the unicycle and the particle: GP² on the unconstrained
//! acceleration (thesis 5.14, zero mean) and independent SE-GPs.

use crate::systems::{self, State};
use gp::{
    Functionals, GaussPoint, Kernel, LatentPrior, Layout, Model, Posterior, Problem, Quantity,
    Result, Rows, Training,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

/// A system with known `M, A, b`; what drives it is unknown to the models.
#[derive(Clone, Copy)]
pub struct System {
    state: fn(&[f64]) -> State,
    /// True force beyond the `known` of [`State`].
    hidden: fn(&[f64]) -> Vec<f64>,
    draw: fn(&mut ChaCha8Rng) -> Vec<f64>,
    noise: f64,
}

/// Surface of the data, `p` of [`systems::surface`].
pub const SURFACE: [f64; 7] = [0.08, 0.05, 0.05, 0.0, 0.0, 0.1, 3.0];
/// Surface that no data were taken on: `q3 = 0.1 q1 − 0.15 q2 − 0.1 cos 3 q1`.
pub const OTHER: [f64; 7] = [0.0, 0.0, 0.0, 0.1, -0.15, -0.1, 3.0];

pub const UNICYCLE: System = System {
    state: |x| systems::unicycle(x, &[0.05, 0.02]),
    hidden: |x| {
        let s = systems::unicycle(x, &[0.05, 0.02]);
        let k = -0.5 * x[0].hypot(x[1]);
        (0..3)
            .map(|i| k * (s.mass[3 * i] * x[0] + s.mass[3 * i + 1] * x[1]))
            .collect()
    },
    draw: |rng| {
        let (speed, q3) = (rng.random_range(0.0..1.0), rng.random_range(-PI..PI));
        let v3 = rng.random_range(-0.5..0.5);
        vec![speed * q3.cos(), speed * q3.sin(), q3, v3, 0.0, 0.0]
    },
    noise: 0.01,
};

pub const PARTICLE: System = System {
    state: |x| systems::surface(x, &SURFACE),
    hidden: systems::surface_damping,
    draw: |rng| {
        let mut draw = |w: f64| rng.random_range(-w..w);
        let mut x = vec![draw(2.0), draw(2.0), 0.0, draw(0.5), draw(0.5), 0.0];
        x.extend([draw(5.0), draw(5.0), draw(5.0)]);
        on_surface(x, &SURFACE)
    },
    noise: 0.1,
};

pub const OTHER_PARTICLE: System = System {
    state: |x| systems::surface(x, &OTHER),
    ..PARTICLE
};

/// The particle moved onto a surface, its velocity into the tangent plane.
pub fn on_surface(mut x: Vec<f64>, p: &[f64]) -> Vec<f64> {
    x[2] = 0.0;
    x[2] = systems::surface_gap(&x, p);
    let a = systems::surface(&x, p).a;
    x[5] = a[0] * x[3] + a[1] * x[4];
    x
}

impl System {
    /// Rows of a quantity for a model that knows `M`, `A`, `b` and no force.
    pub fn rows(&self, x: &[f64], quantity: Quantity) -> Result<Rows> {
        let s = (self.state)(x);
        GaussPoint::new(&s.mass, &s.a, &s.b, &[0.0; 3])?.rows(quantity, Layout::Acceleration)
    }

    /// The true value of a quantity.
    pub fn truth(&self, x: &[f64], quantity: Quantity) -> Result<Vec<f64>> {
        let s = (self.state)(x);
        let hidden = (self.hidden)(x);
        let force: Vec<f64> = s.known.iter().zip(hidden).map(|(k, h)| k + h).collect();
        let point = GaussPoint::new(&s.mass, &s.a, &s.b, &force)?;
        Ok(point.rows(quantity, Layout::Force)?.mean)
    }

    /// `|A a − b|`.
    pub fn violation(&self, x: &[f64], a: &[f64]) -> f64 {
        let s = (self.state)(x);
        (s.a.iter().zip(a).map(|(r, a)| r * a).sum::<f64>() - s.b[0]).abs()
    }

    /// Functionals of a quantity at many states.
    pub fn at(&self, states: &[Vec<f64>], quantity: Quantity) -> Result<Functionals> {
        let mut out = Functionals::new(states[0].len(), 3);
        for x in states {
            let rows = self.rows(x, quantity)?;
            out.push(x, &rows.h, &rows.mean)?;
        }
        Ok(out)
    }

    /// States and noisy accelerations.
    pub fn observe(&self, count: usize, seed: u64) -> Result<(Vec<Vec<f64>>, Vec<f64>)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let states: Vec<Vec<f64>> = (0..count).map(|_| (self.draw)(&mut rng)).collect();
        let mut y = Vec::new();
        for x in &states {
            for a in self.truth(x, Quantity::Acceleration)? {
                let e: f64 = StandardNormal.sample(&mut rng);
                y.push(a + self.noise * e);
            }
        }
        Ok((states, y))
    }
}

/// Functionals that know no constraint: every acceleration is a function of its own.
pub fn plain(states: &[Vec<f64>]) -> Result<Functionals> {
    let inputs = gp::Inputs::from_rows(states)?;
    Ok(Functionals::identity(&inputs, 3))
}

/// A model before training; one kernel per latent function.
pub fn prior(system: &System, dims: usize, variance: f64) -> Result<Model> {
    let kernels = (0..3)
        .map(|_| Kernel::squared_exponential(&vec![1.5; dims], variance))
        .collect();
    Model::new(
        LatentPrior::independent(kernels),
        &[system.noise.powi(2); 3],
    )
}

/// Train on accelerations and condition.
pub fn fit(model: Model, data: &Functionals, y: &[f64], seed: u64) -> Result<Posterior> {
    let problem = Problem::new(model, data, y);
    let (low, high) = (0.3f64.ln(), 50f64.ln());
    let fitted = Training::new(&problem)
        .bounds("*log_length*", low, high)?
        .start_in("*log_length*", low, 10f64.ln())?
        .bounds("*log_variance", 1e-4f64.ln(), 1e4f64.ln())?
        .start_in("*log_variance", 0.1f64.ln(), 100f64.ln())?
        .fix("log_noise*")?
        .restarts(4)
        .seed(seed)
        .run(&problem)?;
    Posterior::new(&fitted.model, data, y)
}
