//! The page `docs/gp.md` shows the code of the example `guide`, and that code is right.

use crate::particle;
use gp::Quantity;
use rand::SeedableRng;

const PAGE: &str = include_str!("../../../docs/gp.md");
const CODE: [&str; 2] = [include_str!("particle.rs"), include_str!("main.rs")];

/// Text without the layout that differs between a page and a formatted file.
fn words(text: &str) -> String {
    text.split_whitespace().collect()
}

/// What stands between a mark and `// end`.
fn marked(code: &str, mark: &str) -> String {
    let (_, rest) = code.split_once(&format!("// {mark}\n")).unwrap();
    words(rest.split_once("// end").unwrap().0)
}

#[test]
fn the_page_shows_the_code() {
    let blocks: Vec<String> = PAGE
        .split("```rust\n")
        .skip(1)
        .map(|rest| words(rest.split_once("```").unwrap().0))
        .collect();
    assert_eq!(blocks, [marked(CODE[0], "page"), marked(CODE[1], "use")]);
    let code = |line: &&str| !(line.trim().is_empty() || line.trim().starts_with("//"));
    let lines = PAGE.split("```rust\n").skip(1);
    let lines: usize = lines
        .map(|rest| {
            rest.split_once("```")
                .unwrap()
                .0
                .lines()
                .filter(code)
                .count()
        })
        .sum();
    assert!(lines <= 30, "the page promises thirty lines: {lines}");
}

#[test]
fn acceleration_and_constraint_force_are_predicted() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let (states, y) = particle::log(&mut rng).unwrap();
    let model = particle::learn(&states, &y).unwrap();
    let (mut learnt, mut known, mut inside) = (0.0, 0.0, 0);
    for _ in 0..100 {
        let x = particle::state(&mut rng);
        let (a_true, lambda_true) = particle::truth(&x).unwrap();
        let a = model
            .predict(&particle::rows(&[x], Quantity::Acceleration).unwrap())
            .unwrap();
        let e = generated::surface_particle::equation_of_motion(
            &generated::surface_particle::Parameters::nominal(),
            &x,
        );
        let product: f64 = (0..3)
            .map(|i| e.constraint_jacobian[0][i] * a.mean[i])
            .sum();
        assert!((product - e.constraint_bias[0]).abs() < 1e-11, "A a = b");
        let without = particle::rows(&[x], Quantity::Acceleration).unwrap();
        let square =
            |p: &[f64]| -> f64 { p.iter().zip(a_true).map(|(p, t)| (p - t).powi(2)).sum() };
        learnt += square(&a.mean);
        known += square(without.mean());
        let lambda = model
            .predict(&particle::rows(&[x], Quantity::Multiplier).unwrap())
            .unwrap();
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
