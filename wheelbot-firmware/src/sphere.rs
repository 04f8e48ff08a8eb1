//! The alternative that 6.3.2 names (Muehlebach and D'Andrea 2018): gravity has its length, and the
//! body turns as a rigid one.
//!
//! With four accelerometers the least-squares map of [6.14] fits exactly, whatever the length of
//! gravity: to ask for that alone scales the estimate and leaves its direction. What brings
//! information is the structure of `Ω = ω̃² + α̃`. With `ω` from the gyroscopes,
//!
//! ```text
//! mᵢ − p̈_W − ω × (ω × pᵢ) = g + α × pᵢ + nᵢ
//! ```
//!
//! has six unknowns in twelve equations. Eliminating `α` leaves `min (g − g*)ᵀ W (g − g*)` under
//! `|g| = g₀`, whose solution `g = (W + λ)⁻¹ W g*` needs one number `λ`, found by Newton's method.

use crate::imu::{COUNT, Mounting};
use crate::vector::{Vector, cross, difference, dot, scaled, sum};
use dynamics::Real;
use dynamics::linalg::Ldlt;
use nalgebra::{SMatrix, SVector};

/// Steps of Newton's method; each about doubles the correct digits, from `λ = 0`.
const STEPS: usize = 4;

/// The estimator, with what depends on the mountings alone.
#[derive(Clone, Copy, Debug)]
pub struct Sphere<T: Real> {
    positions: [Vector<T>; COUNT],
    /// Factors of `Σ p̃ᵢᵀ p̃ᵢ`: the inertia of the four places.
    inertia: Ldlt<T, 3>,
    /// `Σ pᵢ`.
    centre: Vector<T>,
    /// `W`.
    information: SMatrix<T, 3, 3>,
    /// `g₀`, m/s².
    length: T,
}

impl<T: Real> Sphere<T> {
    /// For IMUs that do not lie on one line, where gravity has a length, m/s².
    pub fn new(mountings: &[Mounting<T>; COUNT], length: T) -> Self {
        let positions = mountings.map(|mounting| mounting.position);
        let centre = positions.iter().fold([T::zero(); 3], |s, p| sum(s, *p));
        let inertia = SMatrix::from_fn(|i, j| {
            let entry = |p: &Vector<T>| {
                let square = if i == j { dot(*p, *p) } else { T::zero() };
                square - p[i] * p[j]
            };
            positions.iter().map(entry).fold(T::zero(), |s, x| s + x)
        });
        let inertia = Ldlt::new(&inertia);
        // W = 4 − c̃ᵀ J⁻¹ c̃: column k is what the rest of `e_k` leaves when α is eliminated.
        let mut information = SMatrix::from_element(T::zero());
        for k in 0..3 {
            let unit: Vector<T> =
                core::array::from_fn(|i| if i == k { T::one() } else { T::zero() });
            let alpha = inertia.solve_vector(&SVector::from(cross(centre, unit)));
            let turned = cross([alpha[0], alpha[1], alpha[2]], centre);
            for i in 0..3 {
                information[(i, k)] = T::from_f64(COUNT as f64) * unit[i] - turned[i];
            }
        }
        Self {
            positions,
            inertia,
            centre,
            information,
            length,
        }
    }

    /// Gravity in body axes, m/s², of length `g₀`: from what the accelerometers feel, the pivot's
    /// acceleration, m/s², and the angular velocity, rad/s.
    pub fn estimate(
        &self,
        felt: &[Vector<T>; COUNT],
        pivot: Vector<T>,
        omega: Vector<T>,
    ) -> Vector<T> {
        let (mut force, mut moment) = ([T::zero(); 3], [T::zero(); 3]);
        for (reading, p) in felt.iter().zip(self.positions) {
            let centripetal = cross(omega, cross(omega, p));
            let rest = difference(difference(*reading, pivot), centripetal);
            force = sum(force, rest);
            moment = sum(moment, cross(p, rest));
        }
        // W g* = Σ rest − α₀ × Σ p with α₀ the turn that the moments alone would need.
        let alpha = self.inertia.solve_vector(&SVector::from(moment));
        let turned = cross([alpha[0], alpha[1], alpha[2]], self.centre);
        self.on_the_sphere(difference(force, turned))
    }

    /// `g = (W + λ)⁻¹ b` with `|g| = g₀`: Newton's method on `1/|g| = 1/g₀`, which is nearly linear
    /// in `λ`.
    fn on_the_sphere(&self, b: Vector<T>) -> Vector<T> {
        let b = SVector::from(b);
        let mut multiplier = T::zero();
        let mut gravity = [T::zero(); 3];
        for _ in 0..STEPS {
            let mut shifted = self.information;
            for k in 0..3 {
                shifted[(k, k)] += multiplier;
            }
            let factors = Ldlt::new(&shifted);
            let g = factors.solve_vector(&b);
            let slope = factors.solve_vector(&g);
            gravity = [g[0], g[1], g[2]];
            let square = dot(gravity, gravity);
            let along = dot(gravity, [slope[0], slope[1], slope[2]]);
            if along <= T::zero() || !along.is_finite() {
                return gravity;
            }
            multiplier += square / along * (square.sqrt() / self.length - T::one());
        }
        scaled(self.length / dot(gravity, gravity).sqrt(), gravity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gravity::tilt;
    use crate::imu::mountings;
    use crate::vector::Attitude;

    fn felt(noise: f64) -> ([Vector<f64>; COUNT], Vector<f64>) {
        let (omega, alpha) = ([3.0, -2.0, 5.0], [40.0, -70.0, 20.0]);
        let gravity = Attitude::new(0.3, -0.2).to_body([0.0, 0.0, 9.81]);
        let mut k = 0.0;
        let felt = mountings::<f64>().map(|m| {
            let turning = sum(
                cross(alpha, m.position),
                cross(omega, cross(omega, m.position)),
            );
            sum(gravity, turning).map(|x| {
                k += 1.0;
                x + noise * (1.7_f64 * k * k).sin()
            })
        });
        (felt, omega)
    }

    #[test]
    fn without_noise_it_is_exact() {
        let (felt, omega) = felt(0.0);
        let sphere = Sphere::new(&mountings(), 9.81);
        let [roll, pitch] = tilt(sphere.estimate(&felt, [0.0; 3], omega));
        assert!((roll - 0.3).abs() < 1e-12 && (pitch + 0.2).abs() < 1e-12);
    }

    /// The sum of squares that the estimate leaves, minimised over α for a given gravity.
    fn cost(
        sphere: &Sphere<f64>,
        felt: &[Vector<f64>; COUNT],
        omega: Vector<f64>,
        g: Vector<f64>,
    ) -> f64 {
        let rest = |i: usize| {
            let p = sphere.positions[i];
            difference(difference(felt[i], cross(omega, cross(omega, p))), g)
        };
        let moment = (0..COUNT).fold([0.0; 3], |m, i| sum(m, cross(sphere.positions[i], rest(i))));
        let alpha = sphere.inertia.solve_vector(&SVector::from(moment));
        let left = |i: usize| {
            let turned = cross([alpha[0], alpha[1], alpha[2]], sphere.positions[i]);
            difference(rest(i), turned)
        };
        (0..COUNT).map(|i| dot(left(i), left(i))).sum()
    }

    /// No direction nearby leaves less, and the length is that of gravity.
    #[test]
    fn it_is_the_best_on_the_sphere() {
        let (felt, omega) = felt(0.3);
        let sphere = Sphere::new(&mountings(), 9.81);
        let g = sphere.estimate(&felt, [0.0; 3], omega);
        assert!((dot(g, g).sqrt() - 9.81).abs() < 1e-12);
        let least = cost(&sphere, &felt, omega, g);
        for turn in 0..12 {
            let angle = f64::from(turn);
            let aside = cross(g, [angle.sin(), angle.cos(), (2.0 * angle).sin()]);
            for size in [1e-4, 1e-3, 1e-2] {
                let near = sum(g, scaled(size, aside));
                let near = scaled(9.81 / dot(near, near).sqrt(), near);
                assert!(cost(&sphere, &felt, omega, near) > least, "{turn} {size}");
            }
        }
    }
}
