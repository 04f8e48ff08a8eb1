//! One step of `dz/dt = J z + g(t)`, stable however fast `z` decays.

/// `φ₁(x) = (eˣ − 1)/x` and `φ₂(x) = (eˣ − 1 − x)/x²`.
fn phi(x: f64) -> (f64, f64) {
    if x.abs() < 1e-2 {
        let first = 1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0)));
        let second = 0.5 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0)));
        return (first, second);
    }
    let first = x.exp_m1() / x;
    (first, (first - 1.0) / x)
}

/// `z` after `h` seconds, where `g` goes linearly from `start` to `end`. Exact for
/// constant `J`; of an exponential integrator the second order.
pub(super) fn step(z: f64, jacobian: f64, start: f64, end: f64, h: f64) -> f64 {
    let x = h * jacobian;
    let (first, second) = phi(x);
    z * (x * first + 1.0) + h * (first * start + second * (end - start))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `dz/dt = −a z + b t` from `z₀`, in closed form.
    #[test]
    fn linear_equations_are_exact() {
        for a in [1e-6_f64, 0.01, 0.5, 3.0, 1e4] {
            let (z0, b, h) = (0.7, 2.0, 0.3);
            let exact = if a < 1e-3 {
                z0 * (1.0 - a * h) + b * h * h / 2.0 * (1.0 - a * h / 3.0)
            } else {
                b / a * (h - 1.0 / a) + (z0 + b / (a * a)) * (-a * h).exp()
            };
            let found = step(z0, -a, 0.0, b * h, h);
            assert!((found - exact).abs() < 1e-10, "{a}: {found} {exact}");
        }
    }
}
