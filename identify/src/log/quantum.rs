//! The quantisation step of a channel.

/// Smallest distinct increments tried as a step.
const CANDIDATES: usize = 40;

/// Increments up to this many steps take part; longer ones add up the error
/// of the candidate.
const REACH: f64 = 30.0;

/// Fewest increments from which a step is believed.
const FEWEST: usize = 30;

/// Increments that differ by less than this share are one.
const SAME: f64 = 1e-3;

/// Mean resultant length above which increments count as multiples.
const CONCENTRATED: f64 = 0.97;

/// Estimates the step `s` of which all increments of a channel are multiples.
///
/// Candidates are the smallest distinct non-zero increments. A candidate is a
/// step when the phases `2π Δ/s` of the increments `Δ` that are not much
/// longer than itself concentrate at zero, `|mean exp(2πi Δ/s)| ≥ 0.97`; the
/// longest such candidate, refined by least squares over the multiples, is
/// returned. At least three different multiples must occur, or a tenth of
/// the samples equal the one before: a mere ramp has no step. Numbers written with few decimals have those as their step.
///
/// `None` for a channel that is constant, changes by arbitrary amounts, or
/// always changes by many steps at once.
pub fn quantisation_step(values: &[f64]) -> Option<f64> {
    let mut increments: Vec<f64> = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|increment| increment.is_finite() && *increment > 0.0)
        .collect();
    if increments.len() < FEWEST {
        return None;
    }
    increments.sort_by(f64::total_cmp);
    let still = values.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let fewest_multiples = if 10 * still >= values.len() { 1 } else { 3 };
    let range = values
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    distinct(&increments, 1e-12 * range)
        .into_iter()
        .rev()
        .find_map(|candidate| accepted(candidate, &increments, fewest_multiples))
}

/// The smallest increments, those that differ by rounding taken as one.
fn distinct(increments: &[f64], rounding: f64) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for &increment in increments {
        let last = found.last().copied().unwrap_or(0.0);
        if increment > last * (1.0 + SAME) + rounding {
            found.push(increment);
            if found.len() == CANDIDATES {
                break;
            }
        }
    }
    found
}

/// The refined step when the increments are multiples of the candidate.
fn accepted(candidate: f64, sorted: &[f64], fewest_multiples: usize) -> Option<f64> {
    let refined = refine(candidate, sorted, 3.0);
    let step = refine(refined, sorted, REACH);
    let near = &sorted[..sorted.partition_point(|increment| *increment <= REACH * step)];
    // What is much shorter than a step is no multiple of it, however near its phase is to zero.
    let shorter = near
        .iter()
        .filter(|i| (SAME * step..0.5 * step).contains(*i));
    if shorter.count() as f64 > (1.0 - CONCENTRATED) * near.len() as f64 {
        return None;
    }
    let mut multiples: Vec<u32> = near.iter().map(|i| (i / step).round() as u32).collect();
    multiples.dedup();
    if near.len() < FEWEST || multiples.len() < fewest_multiples {
        return None;
    }
    let (sine, cosine) = near.iter().fold((0.0, 0.0), |(sine, cosine), increment| {
        let (s, c) = (std::f64::consts::TAU * increment / step).sin_cos();
        (sine + s, cosine + c)
    });
    let length = f64::hypot(sine, cosine) / near.len() as f64;
    (cosine > 0.0 && length >= CONCENTRATED).then_some(step)
}

/// Least squares of `Δ ≈ n s` over the increments within `reach` steps.
fn refine(step: f64, sorted: &[f64], reach: f64) -> f64 {
    let near = sorted
        .iter()
        .take_while(|increment| **increment <= reach * step);
    let (product, square) = near.fold((0.0, 0.0), |(product, square), increment| {
        let n = (increment / step).round();
        (product + n * increment, square + n * n)
    });
    if square > 0.0 { product / square } else { step }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A noisy sine read through an encoder of step `quantum`, as text would
    /// hold it with `decimals`.
    fn encoder(quantum: f64, noise: f64, decimals: i32) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let scale = 10_f64.powi(decimals);
        (0..2000)
            .map(|k| {
                let clean = (0.01 * f64::from(k)).sin();
                let noisy = clean + noise * (rng.random::<f64>() - 0.5);
                let read = if quantum > 0.0 {
                    (noisy / quantum).round() * quantum
                } else {
                    noisy
                };
                (read * scale).round() / scale
            })
            .collect()
    }

    #[test]
    fn finds_the_step_of_an_encoder() {
        for quantum in [1.92e-4, 3.83e-4, 2.4e-5, 0.00291] {
            let step = quantisation_step(&encoder(quantum, 2.0 * quantum, 6)).unwrap();
            assert!((step / quantum - 1.0).abs() < 2e-2, "{quantum}: {step}");
        }
    }

    /// Beside a step as long as wild cells are far off all others are short.
    #[test]
    fn wild_cells_hide_no_step() {
        let quantum = 3.83e-4;
        for seed in 0..20 {
            let mut values = encoder(quantum, 2.0 * quantum, 6);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            for _ in 0..20 {
                let at = rng.random_range(0..values.len());
                values[at] += 0.2 * (5.0 * rng.random::<f64>()).exp();
            }
            let step = quantisation_step(&values).unwrap();
            assert!((step / quantum - 1.0).abs() < 2e-2, "{seed}: {step}");
        }
    }

    #[test]
    fn the_last_decimal_is_a_step() {
        let step = quantisation_step(&encoder(0.0, 1e-3, 4)).unwrap();
        assert!((step / 1e-4 - 1.0).abs() < 1e-6, "{step}");
    }

    #[test]
    fn continuous_and_constant_channels_have_none() {
        assert_eq!(quantisation_step(&encoder(0.0, 1e-3, 15)), None);
        assert_eq!(quantisation_step(&[1.5; 400]), None);
        let ramp: Vec<f64> = (0..400).map(|k| 0.25 * f64::from(k)).collect();
        assert_eq!(quantisation_step(&ramp), None);
    }
}
