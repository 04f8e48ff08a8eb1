//! Training of the surface particle, and many points through inducing inputs.
//!
//! `cargo bench -p eqmotion-gp --bench training` prints the wall time of training at 100
//! observations with 5 restarts (force prior, known mean, known parameters and
//! estimated ones), and of one variational bound with gradient at 20 000 points
//! with 7 outputs, 154 hyper-parameters and 100 inducing inputs. Names pick parts:
//! `-- particle theta many`.

#[path = "../tests/benchmarks/systems.rs"]
mod systems;

use gp::{
    Atlas, Functionals, GaussPoint, Inputs, Kernel, LatentPrior, Layout, Model, Problem, Quantity,
    SparsePosterior, Structure, Tangent, Training, farthest_points, sparse_evidence,
};
use rand::{RngExt, SeedableRng};
use std::time::Instant;

/// Wall seconds that training may take on two cores.
const BUDGET: f64 = 5.0;

const TRUE: [f64; 7] = [0.08, 0.05, 0.05, 0.0, 0.0, 0.1, 3.0];

/// The particle at given states, all seven surface parameters free or none.
struct Surface {
    x: Vec<Vec<f64>>,
    free: bool,
}

impl Surface {
    fn parameters<'a>(&self, theta: &'a [f64]) -> &'a [f64] {
        if self.free { theta } else { &TRUE }
    }
}

impl Structure for Surface {
    fn n_theta(&self) -> usize {
        if self.free { 7 } else { 0 }
    }

    fn functionals(&self, theta: &[f64]) -> gp::Result<Functionals> {
        let mut out = Functionals::new(9, 3);
        for x in &self.x {
            let s = systems::surface(x, self.parameters(theta));
            let p = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known)?;
            let r = p.rows(Quantity::Acceleration, Layout::Force)?;
            out.push(x, &r.h, &r.mean)?;
        }
        Ok(out)
    }

    fn tangents(&self, theta: &[f64]) -> gp::Result<Vec<Tangent>> {
        let mut out = vec![Tangent::default(); theta.len()];
        for x in self.x.iter().filter(|_| self.free) {
            let s = systems::surface(x, theta);
            let p = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known)?;
            for (out, d) in out.iter_mut().zip(&s.tangents) {
                let t = p.tangent(d, Quantity::Acceleration, Layout::Force)?;
                out.rows.extend(t.rows);
                out.mean.extend(t.mean);
            }
        }
        Ok(out)
    }
}

fn observations(count: usize) -> gp::Result<(Vec<Vec<f64>>, Vec<f64>)> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let (mut states, mut y) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let mut draw = |w: f64| rng.random_range(-w..w);
        let mut x = vec![
            draw(2.0),
            draw(2.0),
            0.0,
            draw(0.5),
            draw(0.5),
            0.0,
            draw(5.0),
            draw(5.0),
            draw(5.0),
        ];
        x[2] = systems::surface_gap(&x, &TRUE);
        let s = systems::surface(&x, &TRUE);
        x[5] = s.a[0] * x[3] + s.a[1] * x[4];
        let force = systems::surface_damping(&x);
        let total: Vec<f64> = s.known.iter().zip(&force).map(|(k, f)| k + f).collect();
        let a = GaussPoint::new(&s.mass, &s.a, &s.b, &total)?
            .rows(Quantity::Acceleration, Layout::Force)?
            .mean;
        y.extend(a.iter().map(|a| a + draw(0.17)));
        states.push(x);
    }
    Ok((states, y))
}

fn particle(free: bool) -> gp::Result<()> {
    let (x, y) = observations(100)?;
    let structure = Surface { x, free };
    let kernels = (0..3)
        .map(|_| Kernel::squared_exponential(&[2.0; 9], 1.0))
        .collect();
    let model = Model::new(LatentPrior::independent(kernels), &[0.01; 3])?;
    let theta: &[f64] = if free { &TRUE } else { &[] };
    let problem = Problem::new(model, &structure, &y).with_theta(theta, Atlas::free(theta.len()));
    let (low, high) = (0.5f64.ln(), 20f64.ln());
    let mut training = Training::new(&problem)
        .bounds("*log_length*", low, high)?
        .start_in("*log_length*", low, high)?
        .bounds("*log_variance", 0.01f64.ln(), 100f64.ln())?
        .start_in("*log_variance", 0.1f64.ln(), 10f64.ln())?
        .restarts(5);
    if free {
        training = training.bounds("theta*", -5.0, 5.0)?;
    }
    let start = Instant::now();
    let fitted = training.run(&problem)?;
    let seconds = start.elapsed().as_secs_f64();
    let evaluations: u64 = fitted.runs.iter().map(|r| r.evaluations).sum();
    println!(
        "surface particle, 100 observations, 5 restarts, {} parameters: {seconds:.2} s on {} threads (budget {BUDGET} s{}), {evaluations} evaluations, nll {:.2}",
        problem.names().len(),
        rayon::current_num_threads(),
        if seconds < BUDGET { "" } else { ": EXCEEDED" },
        fitted.nll
    );
    Ok(())
}

fn many() -> gp::Result<()> {
    let (points, inducing, outputs, inputs) = (20_000, 100, 7, 21);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut f = Functionals::new(inputs, outputs);
    let mut y = Vec::new();
    for _ in 0..points {
        let mut draw =
            |n: usize, w: f64| -> Vec<f64> { (0..n).map(|_| rng.random_range(-w..w)).collect() };
        let x = draw(inputs, 2.0);
        f.push(&x, &draw(outputs * outputs, 1.0), &vec![0.0; outputs])?;
        y.extend((0..outputs).map(|i| (x[i] + 0.3 * x[i + 7]).sin()));
    }
    let kernels = (0..outputs)
        .map(|_| Kernel::squared_exponential(&vec![3.0; inputs], 1.0))
        .collect();
    let model = Model::new(LatentPrior::independent(kernels), &vec![0.01; outputs])?;
    let start = Instant::now();
    let z: Inputs = f
        .inputs()
        .subset(&farthest_points(&f.inputs(), inducing, 0)?)?;
    println!(
        "{points} points, {outputs} outputs: {inducing} farthest points in {:.2} s",
        start.elapsed().as_secs_f64()
    );
    let start = Instant::now();
    let posterior = SparsePosterior::new(&model, &f, &y, &z)?;
    println!("  posterior {:.2} s", start.elapsed().as_secs_f64());
    let start = Instant::now();
    let e = sparse_evidence(&model, &f, &y, &z, &[])?;
    println!(
        "  bound and gradient {:.2} s",
        start.elapsed().as_secs_f64()
    );
    assert_eq!(e.nll, -posterior.bound());
    Ok(())
}

fn main() -> gp::Result<()> {
    let wanted = |name: &str| {
        let mut named = std::env::args()
            .skip(1)
            .filter(|a| !a.starts_with('-'))
            .peekable();
        named.peek().is_none() || named.any(|a| a == name)
    };
    if wanted("particle") {
        particle(false)?;
    }
    if wanted("theta") {
        particle(true)?;
    }
    if wanted("many") {
        many()?;
    }
    Ok(())
}
