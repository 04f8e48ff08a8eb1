//! The page `docs/gp.md` shows the code of `examples/guide.rs`, and that code is right.

#[allow(dead_code)]
#[path = "../examples/guide.rs"]
mod guide;

use gp::Quantity;
use rand::SeedableRng;

const PAGE: &str = include_str!("../../docs/gp.md");
const CODE: &str = include_str!("../examples/guide.rs");

/// Text without the layout that differs between a page and a formatted file.
fn words(text: &str) -> String {
    text.split_whitespace().collect()
}

/// What stands between a mark and `// end`.
fn marked(mark: &str) -> String {
    let (_, rest) = CODE.split_once(&format!("// {mark}\n")).unwrap();
    words(rest.split_once("// end").unwrap().0)
}

#[test]
fn the_page_shows_the_code() {
    let blocks: Vec<String> = PAGE
        .split("```rust\n")
        .skip(1)
        .map(|rest| words(rest.split_once("```").unwrap().0))
        .collect();
    assert_eq!(blocks, [marked("page"), marked("use")]);
}

#[test]
fn acceleration_and_constraint_force_are_predicted() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let model = guide::learn(&guide::log(&mut rng).unwrap()).unwrap();
    let (mut learnt, mut known, mut inside) = (0.0, 0.0, 0);
    for _ in 0..100 {
        let x = guide::state(&mut rng);
        let (a_true, lambda_true) = guide::truth(&x).unwrap();
        let a = guide::ask(&model, &x, Quantity::Acceleration).unwrap();
        let e = generated::surface_particle::equation_of_motion(
            &generated::surface_particle::Parameters::nominal(),
            &x,
        );
        let product: f64 = (0..3)
            .map(|i| e.constraint_jacobian[0][i] * a.mean[i])
            .sum();
        assert!((product - e.constraint_bias[0]).abs() < 1e-11, "A a = b");
        let without = guide::known(&x)
            .unwrap()
            .rows(Quantity::Acceleration, gp::Layout::Force)
            .unwrap();
        let square =
            |p: &[f64]| -> f64 { p.iter().zip(a_true).map(|(p, t)| (p - t).powi(2)).sum() };
        learnt += square(&a.mean);
        known += square(&without.mean);
        let lambda = guide::ask(&model, &x, Quantity::Multiplier).unwrap();
        let (low, high) = lambda.band95();
        inside += usize::from(low[0] < lambda_true && lambda_true < high[0]);
    }
    println!(
        "squared error {learnt:.3} against {known:.3} of the known physics; λ inside {inside}"
    );
    assert!(learnt < 0.01 * known, "{learnt} {known}");
    assert!(
        inside >= 90,
        "{inside} of 100 multipliers inside their 95 % band"
    );
}
