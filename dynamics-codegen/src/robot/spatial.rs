//! Rotations, placements and inertias as plain numbers.

/// A 3-vector.
pub type Vector3 = [f64; 3];

/// A 3×3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];

/// The identity matrix.
pub const IDENTITY: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Where a frame stands in another: `p_outer = R·p_inner + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// `R`: its columns are the inner axes in outer coordinates.
    pub rotation: Matrix3,
    /// `t`: the inner origin in outer coordinates, in m.
    pub translation: Vector3,
}

impl Placement {
    /// The frame itself.
    pub const IDENTITY: Self = Self {
        rotation: IDENTITY,
        translation: [0.0; 3],
    };

    /// This placement after `inner`: `(R₁R₂, R₁t₂ + t₁)`.
    #[must_use]
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: product(&self.rotation, &inner.rotation),
            translation: self.point(inner.translation),
        }
    }

    /// The placement that undoes this one: `(Rᵀ, −Rᵀ t)`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.rotation[j][i]));
        Self {
            rotation,
            translation: apply(&rotation, self.translation).map(|x| 0.0 - x),
        }
    }

    /// `R·p + t`.
    pub fn point(&self, p: Vector3) -> Vector3 {
        let rotated = apply(&self.rotation, p);
        [0, 1, 2].map(|i| rotated[i] + self.translation[i])
    }
}

/// The inertia of a rigid body in the axes of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Mass `m` in kg.
    pub mass: f64,
    /// Centre of mass `c` in m, from the frame's origin.
    pub center: Vector3,
    /// Inertia tensor about the centre of mass in kg·m², in the frame's axes;
    /// symmetric.
    pub tensor: Matrix3,
}

impl Inertia {
    /// Nothing: a frame without mass.
    pub const ZERO: Self = Self {
        mass: 0.0,
        center: [0.0; 3],
        tensor: [[0.0; 3]; 3],
    };

    /// Whether there is neither mass nor rotational inertia.
    pub fn is_zero(&self) -> bool {
        self.mass == 0.0 && self.tensor.iter().flatten().all(|&x| x == 0.0)
    }

    /// The same body in the outer frame: `m`, `Rc + t`, `R I Rᵀ`.
    #[must_use]
    pub fn placed(&self, placement: &Placement) -> Self {
        Self {
            mass: self.mass,
            center: if self.mass == 0.0 {
                [0.0; 3]
            } else {
                placement.point(self.center)
            },
            tensor: congruent(&placement.rotation, &self.tensor),
        }
    }

    /// Both bodies welded together, exactly (parallel axis theorem):
    ///
    /// `m = m₁ + m₂`, `c = (m₁c₁ + m₂c₂)/m`,
    /// `I = I₁ + I₂ + (m₁m₂/m)·(dᵀd·1 − d dᵀ)` with `d = c₂ − c₁`.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let mut tensor = self.tensor;
        for i in 0..3 {
            for j in 0..3 {
                tensor[i][j] += other.tensor[i][j];
            }
        }
        let center = match (self.mass == 0.0, other.mass == 0.0) {
            (true, true) => [0.0; 3],
            (true, false) => other.center,
            (false, true) => self.center,
            (false, false) => {
                let d = [0, 1, 2].map(|i| other.center[i] - self.center[i]);
                let reduced = self.mass * (other.mass / mass);
                add_steiner(&mut tensor, reduced, d);
                let share = other.mass / mass;
                [0, 1, 2].map(|i| self.center[i] + share * d[i])
            }
        };
        Self {
            mass,
            center,
            tensor,
        }
    }

    /// The inertia tensor about the frame's origin:
    /// `I + m·(cᵀc·1 − c cᵀ)` in kg·m².
    pub fn about_origin(&self) -> Matrix3 {
        let mut tensor = self.tensor;
        add_steiner(&mut tensor, self.mass, self.center);
        tensor
    }
}

/// Adds `m·(dᵀd·1 − d dᵀ)`.
fn add_steiner(tensor: &mut Matrix3, mass: f64, d: Vector3) {
    let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    for i in 0..3 {
        for j in 0..3 {
            let delta = if i == j { square } else { 0.0 };
            tensor[i][j] += mass * (delta - d[i] * d[j]);
        }
    }
}

/// Roll, pitch, yaw about fixed axes: `R = R_z(yaw)·R_y(pitch)·R_x(roll)`, rad.
pub fn rotation_from_rpy([roll, pitch, yaw]: Vector3) -> Matrix3 {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// The rotation by `angle` rad about a unit vector (Rodrigues).
pub fn rotation_about([x, y, z]: Vector3, angle: f64) -> Matrix3 {
    let (s, c) = angle.sin_cos();
    let v = 1.0 - c;
    [
        [c + v * x * x, v * x * y - s * z, v * x * z + s * y],
        [v * x * y + s * z, c + v * y * y, v * y * z - s * x],
        [v * x * z - s * y, v * y * z + s * x, c + v * z * z],
    ]
}

/// The rotation of a quaternion `(x, y, z, w)` of any length but zero.
pub fn rotation_from_quaternion(quaternion: [f64; 4]) -> Matrix3 {
    // Scaled first: the square of a tiny number is zero.
    let scale = quaternion.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let [x, y, z, w] = quaternion.map(|x| x / scale);
    let s = 2.0 / (x * x + y * y + z * z + w * w);
    [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (x * z + y * w),
        ],
        [
            s * (x * y + z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z - x * w),
        ],
        [
            s * (x * z - y * w),
            s * (y * z + x * w),
            1.0 - s * (x * x + y * y),
        ],
    ]
}

/// `A·B`.
pub fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j]))
}

/// `A·x`.
pub fn apply(a: &Matrix3, x: Vector3) -> Vector3 {
    a.map(|row| dot(row, x))
}

/// `aᵀb`.
pub fn dot(a: Vector3, b: Vector3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b`.
pub fn cross(a: Vector3, b: Vector3) -> Vector3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `R I Rᵀ` for a symmetric `I`; the result is symmetric to the last bit.
pub(crate) fn congruent(r: &Matrix3, tensor: &Matrix3) -> Matrix3 {
    if *r == IDENTITY {
        return *tensor;
    }
    let half = product(r, tensor);
    let mut result = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in i..3 {
            result[i][j] = dot(half[i], r[j]);
            result[j][i] = result[i][j];
        }
    }
    result
}

/// The eigenvalues of a symmetric matrix in ascending order.
pub fn principal_values(symmetric: &Matrix3) -> Vector3 {
    let (mut values, _) = principal_axes(symmetric);
    values.sort_by(f64::total_cmp);
    values
}

/// The eigenvalues of a symmetric matrix, with their eigenvectors as columns, by Jacobi's
/// rotations (Golub and Van Loan, *Matrix Computations*, 8.5).
pub fn principal_axes(symmetric: &Matrix3) -> (Vector3, Matrix3) {
    let (mut a, mut axes) = (*symmetric, IDENTITY);
    // Quadratic convergence: five sweeps reach round-off, the rest is reserve.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate_away(&mut a, &mut axes, p, q);
        }
    }
    ([a[0][0], a[1][1], a[2][2]], axes)
}

/// One Jacobi rotation: makes `a[p][q]` zero, and turns the columns of `axes` along.
fn rotate_away(a: &mut Matrix3, axes: &mut Matrix3, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = 1.0_f64.copysign(tau) / (tau.abs() + (tau * tau + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut().chain(axes) {
        let (x, y) = (row[p], row[q]);
        row[p] = c * x - s * y;
        row[q] = s * x + c * y;
    }
    for k in 0..3 {
        let (x, y) = (a[p][k], a[q][k]);
        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
    }
    a[p][q] = 0.0;
    a[q][p] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn close(a: &[f64], b: &[f64]) {
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() < 1e-14, "{a:?} {b:?}");
        }
    }

    #[test]
    fn roll_pitch_yaw_turn_about_fixed_axes() {
        // A quarter turn about x takes y to z; then one about z takes x to y.
        let r = rotation_from_rpy([FRAC_PI_2, 0.0, FRAC_PI_2]);
        close(&apply(&r, [0.0, 1.0, 0.0]), &[0.0, 0.0, 1.0]);
        close(&apply(&r, [1.0, 0.0, 0.0]), &[0.0, 1.0, 0.0]);
        let product = product(
            &product(
                &rotation_from_rpy([0.0, 0.0, 0.3]),
                &rotation_from_rpy([0.0, -0.7, 0.0]),
            ),
            &rotation_from_rpy([1.1, 0.0, 0.0]),
        );
        close(
            rotation_from_rpy([1.1, -0.7, 0.3]).as_flattened(),
            product.as_flattened(),
        );
    }

    #[test]
    fn quaternion_and_angle_agree() {
        let half: f64 = 0.4;
        let q = [0.0, 0.0, 3.0 * half.sin(), 3.0 * half.cos()];
        close(
            rotation_from_quaternion(q).as_flattened(),
            rotation_from_rpy([0.0, 0.0, 0.8]).as_flattened(),
        );
    }

    #[test]
    fn principal_values_of_a_known_matrix() {
        // Eigenvalues of the second-difference matrix: 2 - √2, 2, 2 + √2.
        let a = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]];
        let r = 2.0_f64.sqrt();
        close(&principal_values(&a), &[2.0 - r, 2.0, 2.0 + r]);
    }

    #[test]
    fn principal_axes_give_the_matrix_back() {
        let a = [[2.0, -0.3, 0.1], [-0.3, 1.5, 0.7], [0.1, 0.7, 3.0]];
        let (values, axes) = principal_axes(&a);
        let diagonal = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { values[i] } else { 0.0 }));
        close(congruent(&axes, &diagonal).as_flattened(), a.as_flattened());
    }

    #[test]
    fn welding_two_halves_of_a_rod_gives_the_rod() {
        // A thin rod of mass m and length l: m·l²/12 about its centre.
        let half = |x: f64| Inertia {
            mass: 1.5,
            center: [x, 0.2, 0.0],
            tensor: [
                [0.0, 0.0, 0.0],
                [0.0, 1.5 / 12.0, 0.0],
                [0.0, 0.0, 1.5 / 12.0],
            ],
        };
        let rod = half(-0.5).plus(&half(0.5));
        assert_eq!(rod.mass, 3.0);
        close(&rod.center, &[0.0, 0.2, 0.0]);
        let whole = 3.0 * 4.0 / 12.0;
        close(
            rod.tensor.as_flattened(),
            &[0.0, 0.0, 0.0, 0.0, whole, 0.0, 0.0, 0.0, whole],
        );
        close(&[rod.about_origin()[2][2]], &[whole + 3.0 * 0.04]);
    }

    #[test]
    fn a_body_moves_with_its_frame() {
        let body = Inertia {
            mass: 2.0,
            center: [1.0, 0.0, 0.0],
            tensor: [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.5]],
        };
        let placement = Placement {
            rotation: rotation_from_rpy([0.0, 0.0, FRAC_PI_2]),
            translation: [0.0, 0.0, 5.0],
        };
        let placed = body.placed(&placement);
        close(&placed.center, &[0.0, 1.0, 5.0]);
        close(
            &[
                placed.tensor[0][0],
                placed.tensor[1][1],
                placed.tensor[2][2],
            ],
            &[2.0, 1.0, 2.5],
        );
        let back = placement.then(&Placement::IDENTITY);
        assert_eq!(back, placement);
    }
}
