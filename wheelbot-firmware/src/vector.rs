//! Vectors of space, and the turn from the heading's axes to those of the body.

use dynamics::Scalar;

/// Three components.
pub type Vector<T> = [T; 3];

/// `a + b`.
pub fn sum<T: Scalar>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    core::array::from_fn(|i| a[i] + b[i])
}

/// `a − b`.
pub fn difference<T: Scalar>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    core::array::from_fn(|i| a[i] - b[i])
}

/// `factor · a`.
pub fn scaled<T: Scalar>(factor: T, a: Vector<T>) -> Vector<T> {
    a.map(|x| factor * x)
}

/// `aᵀ b`.
pub fn dot<T: Scalar>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b`.
pub fn cross<T: Scalar>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Sine and cosine of roll and of pitch.
#[derive(Clone, Copy, Debug)]
pub struct Attitude<T> {
    /// `(sin q₁, cos q₁)`.
    pub roll: (T, T),
    /// `(sin q₂, cos q₂)`.
    pub pitch: (T, T),
}

impl<T: Scalar> Attitude<T> {
    /// Of roll and pitch, rad.
    pub fn new(roll: T, pitch: T) -> Self {
        Self {
            roll: roll.sin_cos(),
            pitch: pitch.sin_cos(),
        }
    }

    /// `R₂ᵀ R₁ᵀ a`: from the axes of `{C}` (level, turned with the heading) to those of the body.
    pub fn to_body(&self, a: Vector<T>) -> Vector<T> {
        let ((s1, c1), (s2, c2)) = (self.roll, self.pitch);
        let [x, y, z] = [a[0], c1 * a[1] + s1 * a[2], c1 * a[2] - s1 * a[1]];
        [c2 * x - s2 * z, y, s2 * x + c2 * z]
    }
}
