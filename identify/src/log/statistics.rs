//! Statistics of a channel.

/// Median; the mean of the middle two for an even count; `None` for none.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    let n = sorted.len();
    if n == 0 {
        return None;
    }
    let (below, upper, _) = sorted.select_nth_unstable_by(n / 2, f64::total_cmp);
    let upper = *upper;
    if n % 2 == 1 {
        return Some(upper);
    }
    let lower = below.iter().copied().max_by(f64::total_cmp)?;
    Some(0.5 * (lower + upper))
}

/// The value below which a share `p` in \[0, 1\] of the values lies.
pub(crate) fn quantile(values: &[f64], p: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    let last = sorted.len().checked_sub(1)?;
    let k = (p.clamp(0.0, 1.0) * last as f64).round() as usize;
    let (_, value, _) = sorted.select_nth_unstable_by(k.min(last), f64::total_cmp);
    Some(*value)
}

/// Standard deviation of zero-mean Gaussian values from the median of their
/// magnitudes, `1.4826 · median |x|`: unmoved by a minority of outliers.
pub(crate) fn mad_sd(values: &[f64]) -> Option<f64> {
    let magnitudes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    median(&magnitudes).map(|value| 1.482_602_218_505_602 * value)
}

/// Root mean square; zero for none.
pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Effective over actual number of errors that follow one another as an autoregressive
/// process of first order, `(1 − ρ)/(1 + ρ)` with the autocorrelation `ρ ≥ 0` of neighbours.
pub(crate) fn share_of_news(errors: &[f64]) -> f64 {
    let products = errors.windows(2).map(|pair| pair[0] * pair[1]);
    let squares: f64 = errors.iter().map(|x| x * x).sum();
    let correlation = products.sum::<f64>() / squares.max(f64::MIN_POSITIVE);
    let correlation = correlation.clamp(0.0, 0.999);
    (1.0 - correlation) / (1.0 + correlation)
}
