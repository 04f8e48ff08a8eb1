//! Whether a force that remembers is another than the one it was taken for.
//!
//! Any hysteresis is near to any other: Bouc's and Wen's, taken for bristles, leaves a hundredth of the
//! accelerations, of which no picture shows what they depend on. But what it leaves comes back at each
//! reversal. With `p` where the coordinate has come from lately, as a share of the way over which the effect
//! forgets, two forces are null where friction slides: `sign(v) (1 − p²)`, by which bristles that bend otherwise
//! differ while they do, and `p (1 − p²)`. The slopes of the likelihood along both, run by run of the log, are
//! about zero for the right law, whatever pushes the machine besides; Hotelling's test says whether they are. They
//! also say how much likelier such forces would make the log, `½ sᵀ I⁻¹ s` by the sum `s` of the slopes and the
//! information `I`: what rounding of a clean log leaves is plain, and worth nothing.

use super::dictionary::Dictionary;
use super::linearised::{linearised, smooth};
use super::remembered::{past, remembered_ways};
use super::selection::Selection;
use crate::machine::SolveError;
use crate::regression::{ErrorDynamics, Whitener};
use nalgebra::{Matrix2, Vector2};

/// Runs of the log.
const RUNS: usize = 20;

/// One right law in this many is doubted.
const RARELY: f64 = 100.0;

/// Whether what a selection's forces that remember leave speaks against the law of one of them. A model
/// that cannot be moved along the log says nothing of that.
pub(super) fn is_another(dictionary: &Dictionary, selection: &Selection) -> bool {
    speaks_against(dictionary, selection).is_ok_and(|against| against > RARELY.ln())
}

/// Nats by which what the most telling of a selection's forces that remember leaves speaks against its law, by
/// Hotelling's test and by the likelihood; null if there is none.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
fn speaks_against(dictionary: &Dictionary, selection: &Selection) -> Result<f64, SolveError> {
    let ways = remembered_ways(dictionary, selection);
    if ways.is_empty() {
        return Ok(0.0);
    }
    let accepted = selection.accepted();
    let observed = selection.observed.clone();
    let known = smooth(dictionary, &accepted, observed, &selection.values)?;
    let focus = dictionary.focus(&accepted);
    let dynamics = linearised(&focus, &known.observed, &known.values)?;
    let readings = known
        .observed
        .readings(&focus, &known.values, &dynamics.accelerations());
    let curve = &known.observed.curve;
    let against = ways.into_iter().map(|(i, way)| {
        let forces = differences(&curve.t, &curve.v[i], way);
        let slopes = |dynamics: &ErrorDynamics| {
            let pushes = Whitener::new(dynamics, &readings, &known.noise).pushes();
            let mut slopes = [Vector2::zeros(); RUNS];
            for (k, (push, force)) in pushes.iter().zip(&forces).enumerate() {
                slopes[k * RUNS / pushes.len()] += force * push[i];
            }
            slopes
        };
        let here = slopes(&dynamics);
        let slope: Vector2<f64> = here.iter().sum();
        // Slopes fall off in proportion to a force.
        let information = [0, 1].map(|j| {
            let force: Vec<f64> = forces.iter().map(|force| force[j]).collect();
            let there = slopes(&dynamics.with_force(i, &force));
            slope - there.iter().sum::<Vector2<f64>>()
        });
        let gain = Matrix2::from_columns(&information)
            .try_inverse()
            .map_or(0.0, |inverse| 0.5 * slope.dot(&(inverse * slope)));
        unlikely(&here).min(gain)
    });
    Ok(against.fold(0.0, f64::max))
}

/// By how much a coordinate's hysteresis may differ from bristles that forget over a way: the two forces, by
/// interval.
fn differences(t: &[f64], v: &[f64], way: f64) -> Vec<Vector2<f64>> {
    let past = past(t, v, way);
    let each = past.windows(2).zip(v.windows(2)).map(|(past, v)| {
        let share = 0.5 * (past[0] + past[1]) / way;
        Vector2::new((v[0] + v[1]).signum(), share) * (1.0 - share * share)
    });
    each.collect()
}

/// How unlikely pairs are of which the mean is zero, nats: `−ln` of the share of draws that are as far off by
/// Hotelling's `T²`, which is `(1 + T²/(n − 1))^(−(n − 2)/2)` for pairs.
fn unlikely(pairs: &[Vector2<f64>]) -> f64 {
    let n = pairs.len() as f64;
    let mean = pairs.iter().sum::<Vector2<f64>>() / n;
    let spread = pairs.iter().map(|x| (x - mean) * (x - mean).transpose());
    let covariance = spread.sum::<Matrix2<f64>>() / (n - 1.0);
    let t2 = covariance
        .cholesky()
        .map_or(0.0, |c| n * mean.dot(&c.solve(&mean)));
    0.5 * (n - 2.0) * (t2 / (n - 1.0)).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, named, rectangular, traced};
    use super::*;
    use crate::trace::Verdict;
    use crate::trace::linearised::first_noise;
    use std::fmt::Write;

    /// The log of a wheel with a hysteresis `dot(z) = bent(v, z)` of 0.1 N·m, which bends over 0.05 rad.
    fn log(bent: impl Fn(f64, f64) -> f64) -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(6);
        let (mut z, h) = (0.0, 2.5e-4);
        for tick in 0..80_000 {
            let t = h * f64::from(tick);
            let waves = [(0.35, 2.3), (0.2, 5.9), (0.1, 0.7)];
            let [q, v, a] = waves.iter().fold([0.0; 3], |[q, v, a], &(size, w)| {
                let (sin, cos) = (w * t).sin_cos();
                [q + size * sin, v + size * w * cos, a - size * w * w * sin]
            });
            if tick % 20 == 0 {
                let (read, turned) = (q + 1e-4 * noise(), 0.02 * a + 0.1 * z);
                writeln!(text, "{t},{read},{turned}").unwrap();
            }
            z += h * bent(v, z) / 0.05;
        }
        text
    }

    #[test]
    fn bristles_are_called_so_and_another_hysteresis_is_not() {
        let sliding = |v: f64| 1.0 + 0.8 * (-(v / 0.4_f64).powi(2)).exp();
        let bristles = traced(WHEEL, &log(|v, z| v - v.abs() * z / sliding(v)));
        let [friction] = &bristles.findings[..] else {
            panic!("{:?}: {:#?}", bristles.verdict, bristles.findings);
        };
        assert_eq!(friction.effect, "lugre");
        // Bouc's and Wen's, which bends more readily where it is let go.
        let other = traced(
            WHEEL,
            &log(|v, z| v - 0.67 * v.abs() * z - 0.33 * v * z.abs()),
        );
        assert_eq!(other.verdict, Verdict::Unknown, "{:#?}", other.findings);
        let nearest = other.nearest.expect("what comes nearest is said");
        assert_eq!(nearest.findings[0].effect, "lugre");
    }

    /// A push of the same force through all intervals is what the likelihood gains by that force.
    #[test]
    fn pushes_are_the_likelihoods_slope() {
        let (dictionary, start) = begun(WHEEL, &log(|v, z| v - v.abs() * z), ["angle", "motor"]);
        let constant = named(&dictionary, "constant_force(angle)");
        let force = dictionary.candidates[constant].strengths[0];
        let (focus, observed) = (dictionary.focus(&[constant]), &start.observed);
        let noise = first_noise(&focus, observed, &start.values).unwrap();
        let loss = |by: f64| {
            let mut values = start.values.clone();
            values[force] += by;
            let dynamics = linearised(&focus, observed, &values).unwrap();
            let readings = observed.readings(&focus, &values, &dynamics.accelerations());
            let whitener = Whitener::new(&dynamics, &readings, &noise);
            let pushes = whitener.pushes();
            let pushed: f64 = pushes.iter().map(|push| push[0]).sum();
            (whitener.losses().iter().sum::<f64>(), pushed)
        };
        let step = 1e-4;
        let slope = (loss(-step).0 - loss(step).0) / (2.0 * step);
        let pushed = loss(0.0).1;
        assert!((pushed / slope - 1.0).abs() < 1e-3, "{pushed} {slope}");
    }

    /// Twenty pairs off zero by a quarter of their spread in one direction: `T² = 20/16 · 19/20`.
    #[test]
    fn pairs_about_zero_are_likely() {
        let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let pairs = |off: f64| -> Vec<Vector2<f64>> {
            let pair = |k: usize| Vector2::new(signs[k % 4][0] + off, signs[k % 4][1]);
            (0..20).map(pair).collect()
        };
        assert!(unlikely(&pairs(0.0)).abs() < 1e-12);
        let t2: f64 = 20.0 / 16.0 * 19.0 / 20.0;
        let expected = 9.0 * (1.0 + t2 / 19.0).ln();
        assert!((unlikely(&pairs(0.25)) - expected).abs() < 1e-12);
        assert_eq!(unlikely(&[Vector2::zeros(); 20]), 0.0);
    }
}
