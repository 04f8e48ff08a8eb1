//! Every kernel and every mixing by name: values against numbers that were computed
//! elsewhere, gradients against central differences.

use gp::{Functionals, Inputs, Kernel, LatentPrior, Mixing, Model, Term, Workspace, evidence, nll};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const DIMS: usize = 3;
const X: [f64; DIMS] = [0.3, -1.2, 2.1];
const Z: [f64; DIMS] = [-0.4, 0.5, 1.7];
const LENGTHS: [f64; DIMS] = [0.7, 1.9, 0.6];
const PERIODS: [f64; DIMS] = [1.3, 2.2, 3.1];
const VARIANCE: f64 = 1.4;

fn leaves() -> Vec<(&'static str, Kernel)> {
    vec![
        (
            "squared exponential",
            Kernel::squared_exponential(&LENGTHS, VARIANCE),
        ),
        ("Matérn 3/2", Kernel::matern32(&LENGTHS, VARIANCE)),
        ("Matérn 5/2", Kernel::matern52(&LENGTHS, VARIANCE)),
        ("linear", Kernel::linear(&LENGTHS)),
        ("bias", Kernel::bias(VARIANCE)),
        ("periodic", Kernel::periodic(&PERIODS, &LENGTHS, VARIANCE)),
        ("white", Kernel::white(VARIANCE)),
    ]
}

/// Leaves and every way of combining them.
fn kernels() -> Vec<(&'static str, Kernel)> {
    let mut all = leaves();
    let leaf = |i: usize| leaves().swap_remove(i).1;
    all.extend([
        ("sum", leaf(0) + leaf(3) + leaf(4)),
        ("product", leaf(1) * leaf(5) * leaf(3)),
        ("product with white", leaf(6) * leaf(2)),
        ("scaled", leaf(2).scaled(0.6)),
        (
            "restricted",
            Kernel::squared_exponential(&[0.6, 0.7], VARIANCE).on(&[2, 0]),
        ),
        (
            "restricted twice",
            Kernel::periodic(&[1.3], &[0.8], 1.1).on(&[1]).on(&[2, 0]),
        ),
        (
            "nested",
            ((leaf(0) + leaf(4)).scaled(0.4) * leaf(1).on(&[1, 2, 0]) + leaf(6)) * leaf(3),
        ),
    ]);
    all
}

fn mixings() -> Vec<(&'static str, LatentPrior)> {
    let kernel = |i: usize| leaves().swap_remove(i).1;
    let weights = || vec![vec![0.9, -0.2], vec![-0.4, 0.3]];
    vec![
        (
            "independent",
            LatentPrior::independent(vec![kernel(0), kernel(1)]),
        ),
        ("shared", LatentPrior::shared(2, kernel(2))),
        (
            "intrinsic",
            LatentPrior::intrinsic(kernel(0), weights(), &[0.2, 0.5]),
        ),
        (
            "linear model of coregionalisation",
            LatentPrior::coregional(vec![
                (kernel(0), weights(), vec![0.2, 0.5]),
                (kernel(5), vec![vec![0.5], vec![1.1]], vec![0.3, 0.1]),
                (kernel(4), vec![vec![], vec![]], vec![0.4, 0.2]),
            ]),
        ),
        (
            "two groups",
            LatentPrior::shared(1, kernel(1)).and(LatentPrior::intrinsic(
                kernel(2),
                vec![vec![0.7]],
                &[0.3],
            )),
        ),
        (
            "any terms",
            LatentPrior::new(
                2,
                vec![
                    Term {
                        kernel: kernel(3),
                        mixing: Mixing::Each(vec![1, 0]),
                    },
                    Term {
                        kernel: kernel(6),
                        mixing: Mixing::Each(vec![1]),
                    },
                ],
            )
            .unwrap(),
        ),
    ]
}

/// From mpmath with 40 digits; Matérn through the Bessel function of its definition
/// (Rasmussen and Williams 2006, equation 4.14), not through the closed form of our code.
#[test]
fn values_agree_with_numbers_from_elsewhere() {
    let reference = [
        ("squared exponential", 0.455_651_510_085_263_9),
        ("Matérn 3/2", 0.375_641_994_449_791_33),
        ("Matérn 5/2", 0.397_317_586_467_220_63),
        ("linear", 0.918),
        ("bias", 1.4),
        ("periodic", 0.008_333_892_035_704_05),
        ("white", 0.0),
        ("restricted", 0.679_940_499_346_797_3),
        ("sum", 0.455_651_510_085_263_9 + 0.918 + 1.4),
        (
            "product",
            0.375_641_994_449_791_33 * 0.008_333_892_035_704_05 * 0.918,
        ),
        ("scaled", 0.397_317_586_467_220_63 * 0.6),
    ];
    let all = kernels();
    for (name, want) in reference {
        let (_, k) = all.iter().find(|(n, _)| *n == name).unwrap();
        let got = k.value(&X, &Z).unwrap();
        assert!((got - want).abs() < 1e-14, "{name}: {got}, not {want}");
        let back = k.value(&Z, &X).unwrap();
        assert!((got - back).abs() < 1e-14, "{name} is symmetric");
    }
    let same = |name: &str| {
        let (_, k) = all.iter().find(|(n, _)| *n == name).unwrap();
        k.value(&X, &X).unwrap()
    };
    assert!((same("white") - VARIANCE).abs() < 1e-15);
    assert!((same("squared exponential") - VARIANCE).abs() < 1e-15);
}

/// Points of which two coincide, so that white noise has something off the diagonal.
fn points(rng: &mut ChaCha8Rng, count: usize) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = (0..count)
        .map(|_| (0..DIMS).map(|_| rng.random_range(-2.0..2.0)).collect())
        .collect();
    rows[count - 1] = rows[0].clone();
    rows
}

/// Central difference of fourth order.
fn slope(mut at: impl FnMut(f64) -> f64) -> f64 {
    let h = 1e-4;
    (8.0 * (at(h) - at(-h)) - at(2.0 * h) + at(-2.0 * h)) / (12.0 * h)
}

/// Each entry by itself, to 1e-6 of its size (of 1 where it is smaller).
fn close(name: &str, exact: f64, numeric: f64) {
    let error = (exact - numeric).abs() / numeric.abs().max(1.0);
    assert!(error < 1e-6, "{name}: {exact} against {numeric}");
}

#[test]
fn each_kernel_has_its_gradient() {
    for (name, kernel) in kernels() {
        let names = kernel.param_names();
        assert_eq!(names.len(), kernel.n_params(), "{name}");
        for seed in 0..8 {
            let rng = &mut ChaCha8Rng::seed_from_u64(seed);
            let rows = points(rng, 9);
            let (a, b) = (
                Inputs::from_rows(&rows).unwrap(),
                Inputs::from_rows(&rows[..5]).unwrap(),
            );
            let w = faer::Mat::from_fn(9, 5, |_, _| rng.random_range(-1.0..1.0));
            let mut k = kernel.clone();
            let z: Vec<f64> = k
                .params()
                .iter()
                .map(|v| v + rng.random_range(-0.5..0.5))
                .collect();
            k.set_params(&z).unwrap();
            let exact = k.gradient(&a, &b, &w).unwrap();
            for i in 0..z.len() {
                let numeric = slope(|h| {
                    let mut moved = z.clone();
                    moved[i] += h;
                    k.set_params(&moved).unwrap();
                    let g = k.gram(&a, &b).unwrap();
                    (0..9)
                        .flat_map(|i| (0..5).map(move |j| (i, j)))
                        .map(|(i, j)| w[(i, j)] * g[(i, j)])
                        .sum()
                });
                close(&format!("{name} {}", names[i]), exact[i], numeric);
            }
        }
    }
}

fn evidence_of(name: &str, prior: LatentPrior) {
    for seed in 0..3 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let n = prior.n_latent();
        let mut model = Model::new(prior.clone(), &[0.3, 0.2]).unwrap();
        let (mut f, mut y) = (Functionals::new(DIMS, n), Vec::new());
        for x in points(rng, 7) {
            let h: Vec<f64> = (0..2 * n).map(|_| rng.random_range(-1.0..1.0)).collect();
            f.push(&x, &h, &[0.1, -0.1]).unwrap();
            y.extend([rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)]);
        }
        let mut work = Workspace::default();
        let e = evidence(&model, &f, &y, &[], &mut work).unwrap();
        let (z, names) = (model.params(), model.param_names());
        for i in 0..z.len() {
            let numeric = slope(|h| {
                let mut moved = z.clone();
                moved[i] += h;
                model.set_params(&moved).unwrap();
                nll(&model, &f, &y, &mut work).unwrap()
            });
            close(&format!("{name} {}", names[i]), e.gradient[i], numeric);
        }
    }
}

#[test]
fn the_evidence_of_each_kernel_and_mixing_has_its_gradient() {
    for (name, kernel) in kernels() {
        evidence_of(name, LatentPrior::shared(2, kernel));
    }
    for (name, prior) in mixings() {
        evidence_of(name, prior);
    }
}
