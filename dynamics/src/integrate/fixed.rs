//! Methods of fixed step.

use super::{State, StateVector};
use crate::Scalar;

/// One step of the classical fourth-order Runge–Kutta method: `y(t + h)`.
///
/// # Errors
///
/// Whatever `f` returns.
///
/// ```
/// use core::convert::Infallible;
/// use dynamics::integrate::rk4_step;
///
/// let decay = |_t: f64, y: &[f64; 1]| Ok::<_, Infallible>([-y[0]]);
/// let y = rk4_step(decay, 0.0, &[1.0], 0.1).unwrap();
/// assert!((y[0] - (-0.1_f64).exp()).abs() < 1e-7);
/// ```
pub fn rk4_step<T: Scalar, Y: StateVector<T>, E>(
    mut f: impl FnMut(T, &Y) -> Result<Y, E>,
    t: T,
    y: &Y,
    h: T,
) -> Result<Y, E> {
    let half = T::from_f64(0.5) * h;
    let k1 = f(t, y)?;
    let k2 = f(t + half, &y.add_scaled(half, &k1))?;
    let k3 = f(t + half, &y.add_scaled(half, &k2))?;
    let k4 = f(t + h, &y.add_scaled(h, &k3))?;
    let sixth = h / T::from_f64(6.0);
    let middle = sixth + sixth;
    Ok(y.add_scaled(sixth, &k1)
        .add_scaled(middle, &k2)
        .add_scaled(middle, &k3)
        .add_scaled(sixth, &k4))
}

/// One step of the semi-implicit (symplectic) Euler method:
/// `v⁺ = v + h a(t, q, v)`, `q⁺ = q + h v⁺`, `z⁺ = z + h ż(t, q, v)`.
///
/// `f` returns the rates `(q̇, a, ż)`; its `q̇` is not used. Symplectic, so that energy
/// stays bounded, where `M` is constant and forces depend on `q` alone; of first order
/// always.
///
/// # Errors
///
/// Whatever `f` returns.
pub fn symplectic_euler_step<T: Scalar, const N: usize, const Z: usize, E>(
    mut f: impl FnMut(T, &State<T, N, Z>) -> Result<State<T, N, Z>, E>,
    t: T,
    y: &State<T, N, Z>,
    h: T,
) -> Result<State<T, N, Z>, E> {
    let rate = f(t, y)?;
    let v = y.v.add_scaled(h, &rate.v);
    Ok(State {
        q: y.q.add_scaled(h, &v),
        v,
        z: y.z.add_scaled(h, &rate.z),
    })
}
