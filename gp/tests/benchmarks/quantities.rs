//! Any quantity from measurements of any other (thesis 5.11), all 49 pairs: against
//! conditioning written out with dense matrices, and against the equation of motion.

use crate::systems::{self, State};
use faer::Mat;
use faer::linalg::solvers::Solve;
use gp::{
    Functionals, GaussPoint, Inputs, Kernel, LatentPrior, Layout, Model, Posterior, Quantity,
    sample_prior,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const ALL: [Quantity; 7] = [
    Quantity::Acceleration,
    Quantity::UnconstrainedAcceleration,
    Quantity::Multiplier,
    Quantity::ConstraintForce,
    Quantity::TotalForce,
    Quantity::Force,
    Quantity::NonIdealForce,
];

struct System {
    name: &'static str,
    at: fn(&[f64], &[f64]) -> State,
    p: Vec<f64>,
    dims: usize,
}

fn systems() -> [System; 3] {
    let system = |name, at, p, dims| System { name, at, p, dims };
    [
        system(
            "surface",
            systems::surface,
            vec![0.08, 0.05, 0.05, 0.01, -0.02, 0.1, 3.0],
            9,
        ),
        system("unicycle", systems::unicycle, vec![0.05, 0.02], 6),
        system(
            "duffing",
            systems::duffing,
            vec![1.0, 0.3, 6.0, 10.0, 12.0, 0.1, 0.15],
            5,
        ),
    ]
}

impl System {
    fn states(&self, count: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|_| {
                (0..self.dims)
                    .map(|_| rng.random_range(-1.0..1.0))
                    .collect()
            })
            .collect()
    }

    fn functionals(&self, x: &[Vec<f64>], quantity: Quantity, layout: Layout) -> Functionals {
        let n = (self.at)(&x[0], &self.p).known.len();
        let mut out = Functionals::new(self.dims, layout.n_latent(n));
        for x in x {
            let s = (self.at)(x, &self.p);
            let point = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known).unwrap();
            let r = point.rows(quantity, layout).unwrap();
            out.push(x, &r.h, &r.mean).unwrap();
        }
        out
    }
}

/// Length-scale and variance of each latent function.
fn hyper(d: usize) -> (f64, f64) {
    (1.3 + 0.2 * d as f64, 0.5 + 0.3 * d as f64)
}

fn model(n_latent: usize, dims: usize, noise: f64) -> Model {
    let kernels = (0..n_latent)
        .map(|d| Kernel::squared_exponential(&vec![hyper(d).0; dims], hyper(d).1))
        .collect();
    Model::new(LatentPrior::independent(kernels), &[noise; 3]).unwrap()
}

/// `cov(f_c(x), f_d(z))` as a formula.
fn covariance(x: &[f64], z: &[f64], c: usize, d: usize) -> f64 {
    let (length, variance) = hyper(c);
    let r2: f64 = x.iter().zip(z).map(|(a, b)| (a - b) * (a - b)).sum();
    if c == d {
        variance * (-0.5 * r2 / (length * length)).exp()
    } else {
        0.0
    }
}

/// `H` of all points side by side, and the covariance of everything they see.
fn wide(f: &Functionals, offset: usize, columns: usize) -> Mat<f64> {
    let mut out = Mat::zeros(f.n_rows(), columns);
    for i in 0..f.n_points() {
        for r in f.rows_of(i) {
            for (d, h) in f.row(r).iter().enumerate() {
                out[(r, offset + i * f.n_latent() + d)] = *h;
            }
        }
    }
    out
}

/// Posterior mean and covariance by the textbook, in the space of all latent values.
fn conditioned(
    data: &Functionals,
    y: &[f64],
    noise: f64,
    at: &Functionals,
) -> (Vec<f64>, Mat<f64>) {
    let n = data.n_latent();
    let points: Vec<Vec<f64>> = [data, at]
        .iter()
        .flat_map(|f| (0..f.n_points()).map(|i| f.inputs().point(i)))
        .collect();
    let size = points.len() * n;
    let k = Mat::from_fn(size, size, |i, j| {
        covariance(&points[i / n], &points[j / n], i % n, j % n)
    });
    let (h, g) = (wide(data, 0, size), wide(at, data.n_points() * n, size));
    let sigma = &h * &k * h.transpose()
        + Mat::from_fn(y.len(), y.len(), |i, j| if i == j { noise } else { 0.0 });
    let lu = sigma.partial_piv_lu();
    let r = Mat::from_fn(y.len(), 1, |i, _| y[i] - data.mean()[i]);
    let cross = &g * &k * h.transpose();
    let mean = &cross * lu.solve(&r);
    let cov = &g * &k * g.transpose() - &cross * lu.solve(cross.transpose());
    let mean = (0..at.n_rows()).map(|i| mean[(i, 0)] + at.mean()[i]);
    (mean.collect(), cov)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn every_quantity_from_every_other() {
    let (layout, noise) = (Layout::SplitForce, 0.01);
    for system in systems() {
        let (train, test) = (system.states(6, 1), system.states(4, 2));
        for measured in ALL {
            let data = system.functionals(&train, measured, layout);
            let y: Vec<f64> = data
                .mean()
                .iter()
                .enumerate()
                .map(|(i, m)| m + (1.3 * i as f64).sin())
                .collect();
            let model = model(data.n_latent(), system.dims, noise);
            let posterior = Posterior::new(&model, &data, &y).unwrap();
            let means = ALL.map(|asked| {
                let at = system.functionals(&test, asked, layout);
                let name = format!("{}: {asked:?} from {measured:?}", system.name);
                agree(&name, &posterior, &at, conditioned(&data, &y, noise, &at))
            });
            motion(&system, &test, &means);
        }
    }
}

fn agree(
    name: &str,
    posterior: &Posterior,
    at: &Functionals,
    want: (Vec<f64>, Mat<f64>),
) -> Vec<f64> {
    let got = posterior.predict(at).unwrap();
    let scale = 1.0 + largest(want.0.iter().copied());
    let mean = largest(got.mean.iter().zip(&want.0).map(|(a, b)| a - b));
    assert!(mean < 1e-10 * scale, "{name}: mean {mean:e}");
    let cov = posterior.covariance(at).unwrap();
    let n = at.n_rows();
    let scale = 1.0 + largest((0..n).map(|i| want.1[(i, i)]));
    let error = largest((0..n * n).map(|k| cov[(k / n, k % n)] - want.1[(k / n, k % n)]));
    assert!(error < 1e-10 * scale, "{name}: covariance {error:e}");
    let error = largest((0..n).map(|i| got.variance[i] - want.1[(i, i)]));
    assert!(error < 1e-10 * scale, "{name}: variance {error:e}");
    got.mean
}

/// `M a = Q̄ + Q_I`, `M ā = Q̄`, `Q̄ = Q + Q_z`, `Q_I = A^T λ`, `A a = b`, whatever was measured.
fn motion(system: &System, x: &[Vec<f64>], means: &[Vec<f64>; 7]) {
    let [a, free, lambda, ideal, total, force, other] = means;
    for (i, x) in x.iter().enumerate() {
        let s = (system.at)(x, &system.p);
        let n = s.known.len();
        let mass =
            |v: &[f64], r: usize| -> f64 { (0..n).map(|j| s.mass[r * n + j] * v[i * n + j]).sum() };
        for r in 0..n {
            let k = i * n + r;
            let checks = [
                mass(a, r) - total[k] - ideal[k],
                mass(free, r) - total[k],
                total[k] - force[k] - other[k],
                ideal[k] - s.a[r] * lambda[i],
            ];
            let scale = 1.0 + total[k].abs() + ideal[k].abs();
            assert!(
                largest(checks.into_iter()) < 1e-10 * scale,
                "{} {checks:?}",
                system.name
            );
        }
        let residual: f64 = (0..n).map(|j| s.a[j] * a[i * n + j]).sum::<f64>() - s.b[0];
        assert!(residual.abs() < 1e-10, "{} {residual:e}", system.name);
    }
}

/// What rigid bodies cannot express: an output kernel beside the force prior (thesis 5.6).
#[test]
fn adventitious_error_is_told_from_force() {
    let (layout, noise) = (Layout::ForceAndOutput, 1e-4);
    for system in systems() {
        let (train, test) = (system.states(8, 3), system.states(4, 4));
        let data = system.functionals(&train, Quantity::Acceleration, layout);
        // The measured accelerations leave the constraint by 0.5 along A^T.
        let off = |f: &Functionals, x: &[Vec<f64>]| -> Vec<f64> {
            let n = f.n_rows() / x.len();
            f.mean()
                .iter()
                .enumerate()
                .map(|(i, m)| m + 0.5 * (system.at)(&x[i / n], &system.p).a[i % n])
                .collect()
        };
        let y = off(&data, &train);
        let model = model(data.n_latent(), system.dims, noise);
        let posterior = Posterior::new(&model, &data, &y).unwrap();
        for asked in &ALL[..5] {
            let at = system.functionals(&test, *asked, layout);
            let name = format!("{}: {asked:?} beside an output kernel", system.name);
            agree(&name, &posterior, &at, conditioned(&data, &y, noise, &at));
        }
        // It follows what the constraint forbids, which a force prior alone cannot.
        let seen = posterior.mean(&data).unwrap();
        assert!(largest(seen.iter().zip(&y).map(|(a, b)| a - b)) < 0.05);
        let strict = system.functionals(&train, Quantity::Acceleration, Layout::Force);
        let alone = Posterior::new(
            &self::model(strict.n_latent(), system.dims, noise),
            &strict,
            &y,
        );
        let kept = alone.unwrap().mean(&strict).unwrap();
        assert!(largest(kept.iter().zip(&y).map(|(a, b)| a - b)) > 0.2);
    }
}

#[test]
fn samples_of_every_system_and_prior_obey_the_constraint() {
    for system in systems() {
        let (train, test) = (system.states(20, 5), system.states(10, 6));
        let inputs = Inputs::from_rows(&test).unwrap();
        for layout in [Layout::Force, Layout::SplitForce, Layout::Acceleration] {
            let data = system.functionals(&train, Quantity::Acceleration, layout);
            let at = system.functionals(&test, Quantity::Acceleration, layout);
            let n = data.n_latent();
            let weights = (0..n).map(|i| vec![1.0 - 0.3 * i as f64]).collect();
            let kernel = Kernel::matern52(&vec![1.5; system.dims], 1.0);
            let coupled = LatentPrior::intrinsic(kernel, weights, &vec![0.2; n]);
            for prior in [model(n, system.dims, 0.01).prior, coupled] {
                let model = Model::new(prior, &[0.01; 3]).unwrap();
                let y: Vec<f64> = (0..data.n_rows()).map(|i| (i as f64).cos()).collect();
                let posterior = Posterior::new(&model, &data, &y).unwrap();
                let mut draws = vec![posterior.mean(&at).unwrap()];
                draws.extend(
                    posterior
                        .sample(&inputs, 6, 1)
                        .unwrap()
                        .quantity(&at)
                        .unwrap(),
                );
                draws.extend(
                    sample_prior(&model, &inputs, 6, 1)
                        .unwrap()
                        .quantity(&at)
                        .unwrap(),
                );
                for a in draws {
                    for (x, a) in test.iter().zip(a.chunks(at.n_rows() / test.len())) {
                        let s = (system.at)(x, &system.p);
                        let left: f64 = s.a.iter().zip(a).map(|(c, a)| c * a).sum();
                        let residual = left - s.b[0];
                        assert!(residual.abs() < 1e-10, "{} {residual:e}", system.name);
                    }
                }
            }
        }
    }
}
