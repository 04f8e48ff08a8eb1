//! Motion of a trained GP² over time, with and without Baumgarte's stabilisation.
//!
//! `cargo run --release -p eqmotion-gp --example baumgarte` trains the particle of
//! `docs/gp.md`, puts it 2 cm off its surface, as a noisy measurement would, and
//! moves it for ten seconds with the integrators of the crate `dynamics`. Without
//! stabilisation the distance stays and grows; with `b̃ = b − 2ζω ċ − ω² c` (thesis
//! 5.32, sign corrected) it decays as `c̈ + 2ζω ċ + ω² c = 0` says. Only the mean
//! changes, since `P` does not contain `b`.

#[allow(dead_code, reason = "only its model is needed")]
#[path = "../guide/particle.rs"]
mod particle;
#[cfg(test)]
mod tests;

use dynamics::constrained::Baumgarte;
use dynamics::integrate::{DormandPrince, State, symplectic_euler_step};
use dynamics::{Point, System};
use generated::surface_particle::SurfaceParticle;
use gp::{GaussPoint, GpError, Layout, Posterior, Quantity, Result};
use rand::SeedableRng;

/// Step of the symplectic Euler method, s (that of thesis Fig. 5.14).
pub const STEP: f64 = 0.0024;

/// The forces that drive the particle, N.
fn input(t: f64) -> [f64; 3] {
    [3.0 * t.sin(), 3.0 * (1.3 * t).cos(), 0.0]
}

fn point(t: f64, s: &State<f64, 3, 0>) -> Point<f64, 3, 3, 0> {
    Point {
        t,
        q: s.q,
        v: s.v,
        u: input(t),
        z: [],
    }
}

/// Velocity and predicted mean acceleration at a state.
pub fn rate(
    model: &Posterior,
    stabilisation: Option<&Baumgarte<f64>>,
    t: f64,
    s: &State<f64, 3, 0>,
) -> Result<State<f64, 3, 0>> {
    let e = SurfaceParticle::nominal().equation(&point(t, s));
    let b = stabilisation.map_or(e.constraint.b, |how| how.stabilise(&e.constraint));
    let (mass, a) = (e.mass_matrix.transpose(), e.constraint.a.transpose()); // row-major
    let rows = GaussPoint::new(
        mass.as_slice(),
        a.as_slice(),
        b.as_slice(),
        e.force.as_slice(),
    )?
    .rows(Quantity::Acceleration, Layout::Force)?;
    let a = model.mean_at(&s.v, &rows.h, &rows.mean)?;
    Ok(State {
        q: s.v,
        v: [a[0], a[1], a[2]],
        z: [],
    })
}

/// Height of the surface above the particle, m.
pub fn violation(s: &State<f64, 3, 0>) -> f64 {
    SurfaceParticle::nominal().constraint(&point(0.0, s)).c[0]
}

/// A state at rest in the coordinates `x, y`, this far below the surface.
pub fn start(offset: f64) -> State<f64, 3, 0> {
    let mut s = State {
        q: [1.0, -0.5, 0.0],
        v: [0.0; 3],
        z: [],
    };
    s.q[2] = violation(&s) - offset;
    s
}

/// Violation at equal intervals, symplectic Euler.
pub fn euler(
    model: &Posterior,
    stabilisation: Option<&Baumgarte<f64>>,
    seconds: f64,
    offset: f64,
) -> Result<Vec<f64>> {
    let mut s = start(offset);
    let mut out = vec![violation(&s)];
    for k in 0..(seconds / STEP).round() as usize {
        let f = |t: f64, s: &State<f64, 3, 0>| rate(model, stabilisation, t, s);
        s = symplectic_euler_step(f, k as f64 * STEP, &s, STEP)?;
        out.push(violation(&s));
    }
    Ok(out)
}

/// Times and violations every 0.1 s, Dormand–Prince.
pub fn dormand_prince(
    model: &Posterior,
    stabilisation: Option<&Baumgarte<f64>>,
    seconds: f64,
    offset: f64,
) -> Result<Vec<(f64, f64)>> {
    let solver = DormandPrince {
        relative: 1e-9,
        absolute: 1e-9,
        ..Default::default()
    };
    let mut out = Vec::new();
    let f = |t: f64, s: &State<f64, 3, 0>| rate(model, stabilisation, t, s);
    solver
        .sample(f, 0.0, &start(offset), seconds, 0.1, |t, s| {
            out.push((t, violation(s)));
        })
        .map_err(|e| GpError::Structure {
            theta: Vec::new(),
            message: format!("integration: {e}"),
        })?;
    Ok(out)
}

/// A GP² trained on sixty noisy accelerations.
pub fn trained() -> Result<Posterior> {
    let (states, y) = particle::log(&mut rand_chacha::ChaCha8Rng::seed_from_u64(1))?;
    particle::learn(&states, &y)
}

fn main() -> Result<()> {
    let model = trained()?;
    let stabilisation = Baumgarte::critical(10.0);
    println!("distance to the surface, mm; begun 20 mm off it");
    println!(
        "{:>5} {:>34} {:>34}",
        "t/s", "symplectic Euler, 2.4 ms", "Dormand–Prince, 1e-9"
    );
    println!(
        "{:>5} {:>17}{:>17} {:>17}{:>17}",
        "", "plain", "Baumgarte", "plain", "Baumgarte"
    );
    let how = [None, Some(&stabilisation)];
    let [euler, stable] = how.map(|s| euler(&model, s, 10.0, 0.02));
    let [fine, fine_stable] = how.map(|s| dormand_prince(&model, s, 10.0, 0.02));
    let (euler, stable, fine, fine_stable) = (euler?, stable?, fine?, fine_stable?);
    for t in [0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0] {
        let (step, sample) = ((t / STEP).round() as usize, (t / 0.1f64).round() as usize);
        println!(
            "{t:>5} {:>17.6}{:>17.6} {:>17.6}{:>17.6}",
            1e3 * euler[step],
            1e3 * stable[step],
            1e3 * fine[sample].1,
            1e3 * fine_stable[sample].1
        );
    }
    Ok(())
}
