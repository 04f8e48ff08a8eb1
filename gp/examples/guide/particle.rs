//! A particle on a surface that an unknown force brakes, and the model that learns it.
//!
//! Between the marks stands what the page `docs/gp.md` shows.

// page
use dynamics::Point;
use generated::surface_particle::{Parameters, equation_of_motion};
use gp::*;

/// A quantity at states: what the model file knows, and a force that it does not, of the velocity.
pub fn rows(states: &[Point<f64, 3, 3, 0>], quantity: Quantity) -> Result<Functionals> {
    let mut out = Functionals::new(3, 3);
    for x in states {
        let e = equation_of_motion(&Parameters::nominal(), x);
        let (mass, a) = (e.mass_matrix.concat(), e.constraint_jacobian.concat());
        let point = GaussPoint::new(&mass, &a, &e.constraint_bias, &e.force)?;
        let r = point.rows(quantity, Layout::Force)?;
        out.push(&x.v, &r.h, &r.mean)?;
    }
    Ok(out)
}

/// The posterior of the unknown force, given states and their measured accelerations.
pub fn learn(states: &[Point<f64, 3, 3, 0>], y: &[f64]) -> Result<Posterior> {
    let data = rows(states, Quantity::Acceleration)?;
    // One kernel, shared by three unknown forces; the noise has a standard deviation of 0.01.
    let prior = LatentPrior::shared(3, Kernel::squared_exponential(&[1.0; 3], 1.0));
    let problem = Problem::new(Model::new(prior, &[1e-4; 3])?, &data, y);
    let training = Training::new(&problem)
        .bounds("*log_length*", 0.3f64.ln(), 20f64.ln())?
        .start_in("*log_length*", 0.5f64.ln(), 5f64.ln())?
        .fix("log_noise*")?;
    Posterior::new(&training.restarts(3).run(&problem)?.model, &data, y)
}
// end
use dynamics::System;
use dynamics::nalgebra::SVector;
use generated::surface_particle::{self, SurfaceParticle};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// What brakes the particle, unknown to the model: `−0.6 ‖v‖ v`, N.
pub fn brake(x: &Point<f64, 3, 3, 0>) -> [f64; 3] {
    let speed = x.v.iter().map(|v| v * v).sum::<f64>().sqrt();
    x.v.map(|v| -0.6 * speed * v)
}

/// True acceleration and multiplier, by the solver of the crate `dynamics`.
pub fn truth(x: &Point<f64, 3, 3, 0>) -> Result<([f64; 3], f64)> {
    use dynamics::constrained::{Tolerance, solve};
    let e = SurfaceParticle::nominal().equation(x);
    let force = e.force + SVector::from(brake(x));
    let constraint = e.constraint;
    let s = solve(
        &e.mass_matrix,
        &force,
        &constraint.a,
        &constraint.b,
        &Tolerance::default(),
    )
    .map_err(|e| GpError::Structure {
        theta: Vec::new(),
        message: e.to_string(),
    })?;
    Ok((s.a.into(), s.lambda[0]))
}

/// A state on the surface, drawn from a seeded generator.
pub fn state(rng: &mut impl Rng) -> Point<f64, 3, 3, 0> {
    let mut draw = |w: f64| rng.random_range(-w..w);
    let mut x = Point {
        q: [draw(2.0), draw(2.0), 0.0],
        v: [draw(2.0), draw(2.0), 0.0],
        u: [draw(5.0), draw(5.0), draw(5.0)],
        ..Point::zero()
    };
    let parameters = Parameters::nominal();
    x.q[2] = surface_particle::constraint_residual(&parameters, &x)[0];
    x.v[2] = surface_particle::constraint_rate(&parameters, &x)[0];
    x
}

/// Sixty states and, behind one another, their accelerations measured with noise of
/// standard deviation 0.01 m/s².
pub fn log(rng: &mut impl Rng) -> Result<(Vec<Point<f64, 3, 3, 0>>, Vec<f64>)> {
    let noise = |rng: &mut _| -> f64 { StandardNormal.sample(rng) };
    let (mut states, mut y) = (Vec::new(), Vec::new());
    for _ in 0..60 {
        let x = state(rng);
        y.extend(truth(&x)?.0.map(|a| a + 0.01 * noise(rng)));
        states.push(x);
    }
    Ok((states, y))
}
