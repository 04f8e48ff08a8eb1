//! A point mass on a body, and the four numbers of it that forces are explained best by.

use nalgebra::{Matrix4, SMatrix, SVector, Vector4};

/// How many standard inertial parameters a body has.
pub(super) const TEN: usize = 10;
/// Believed distance of a load from the origin of the body that carries it (one standard
/// deviation), m. A few tenths of a nat where the log knows, the answer where it is silent.
const NEAR: f64 = 0.3;
/// Steps at most, and the fall in nats that ends them.
const STEPS: usize = 60;
const SMALL: f64 = 1e-9;

type Ten = SVector<f64, TEN>;

/// Moments of inertia about the origin of a unit mass at a point (Steiner's terms), `xx yy zz xy xz yz`, m².
pub(super) fn of_unit_mass([x, y, z]: [f64; 3]) -> [f64; 6] {
    [
        y * y + z * z,
        x * x + z * z,
        x * x + y * y,
        -x * y,
        -x * z,
        -y * z,
    ]
}

/// A point mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// kg.
    pub mass: f64,
    /// In the body's frame, m.
    pub at: [f64; 3],
}

impl Point {
    /// `m, h, I_o`, in the order of [`dynamics_codegen::derive::STANDARD`].
    pub fn standard(&self) -> [f64; TEN] {
        let ([x, y, z], [xx, yy, zz, xy, xz, yz]) = (self.at, of_unit_mass(self.at));
        let shape = [1.0, x, y, z, xx, yy, zz, xy, xz, yz];
        shape.map(|entry| self.mass * entry)
    }

    /// The derivatives of these by mass and place.
    pub fn slopes(&self) -> SMatrix<f64, TEN, 4> {
        let [x, y, z] = self.at;
        let m = self.mass;
        let mut slopes = SMatrix::<f64, TEN, 4>::zeros();
        let by_mass = Point {
            mass: 1.0,
            at: self.at,
        };
        slopes.set_column(0, &Ten::from(by_mass.standard()));
        let by_x = [0.0, 1.0, 0.0, 0.0, 0.0, 2.0 * x, 2.0 * x, -y, -z, 0.0];
        let by_y = [0.0, 0.0, 1.0, 0.0, 2.0 * y, 0.0, 2.0 * y, -x, 0.0, -z];
        let by_z = [0.0, 0.0, 0.0, 1.0, 2.0 * z, 2.0 * z, 0.0, 0.0, -x, -y];
        for (k, column) in [by_x, by_y, by_z].into_iter().enumerate() {
            slopes.set_column(k + 1, &(m * Ten::from(column)));
        }
        slopes
    }

    /// The curvature of what is believed of the place.
    pub fn belief() -> [f64; 4] {
        let place = NEAR.powi(-2);
        [0.0, place, place, place]
    }
}

/// `½ φᵀ H φ − gᵀ φ`: what the ten parameters of a body cost, everything else at its best.
#[derive(Debug, Clone)]
pub(super) struct Bowl {
    pub gram: SMatrix<f64, TEN, TEN>,
    pub moment: Ten,
    /// Where the point may be along each axis, m.
    pub bounds: [(f64, f64); 3],
}

impl Bowl {
    /// Misfit in nats, with what is believed of the place.
    pub fn cost(&self, point: &Point) -> f64 {
        let phi = Ten::from(point.standard());
        let place: f64 = point.at.iter().map(|x| (x / NEAR).powi(2)).sum();
        0.5 * phi.dot(&(self.gram * phi)) - self.moment.dot(&phi) + 0.5 * place
    }

    /// The point of positive mass that costs least, from `center` and places around; `None` if
    /// none is better than nothing.
    pub fn best(&self, center: [f64; 3]) -> Option<Point> {
        let mut starts = vec![[0.0; 3], center];
        for axis in 0..3 {
            for step in [-0.25, -0.08, 0.08, 0.25] {
                let mut at = center;
                at[axis] += step;
                starts.push(at);
            }
        }
        let starts = starts.into_iter().filter_map(|at| {
            let at = std::array::from_fn(|axis| self.within(axis, at[axis]));
            let unit = Ten::from(Point { mass: 1.0, at }.standard());
            let mass = self.moment.dot(&unit) / unit.dot(&(self.gram * unit));
            (mass > 0.0 && mass.is_finite()).then_some(Point { mass, at })
        });
        let found = starts.map(|start| self.descend(start));
        found.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)))
    }

    fn within(&self, axis: usize, x: f64) -> f64 {
        let (low, high) = self.bounds[axis];
        x.clamp(low, high)
    }

    /// Levenberg–Marquardt from a point.
    pub fn descend(&self, mut point: Point) -> Point {
        let (mut damping, mut cost) = (1e-6, self.cost(&point));
        for _ in 0..STEPS {
            let phi = Ten::from(point.standard());
            let slopes = point.slopes();
            let belief = Vector4::from(Point::belief());
            let values = Vector4::new(point.mass, point.at[0], point.at[1], point.at[2]);
            let gradient =
                slopes.tr_mul(&(self.gram * phi - self.moment)) + belief.component_mul(&values);
            let curvature = slopes.tr_mul(&self.gram) * slopes + Matrix4::from_diagonal(&belief);
            let damped = curvature + Matrix4::from_diagonal(&(damping * curvature.diagonal()));
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                return point;
            };
            let next = values - step;
            let place = |k: usize| self.within(k - 1, next[k]);
            let trial = Point {
                mass: next[0].max(0.0),
                at: [place(1), place(2), place(3)],
            };
            let fall = cost - self.cost(&trial);
            if fall > 0.0 {
                (point, cost) = (trial, cost - fall);
                damping = (damping * 0.2_f64).max(1e-12);
                if fall < SMALL {
                    return point;
                }
            } else if damping > 1e9 {
                return point;
            } else {
                damping = (damping * 10.0).max(1e-6);
            }
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nearer than any arm is long.
    const NEAR_BY: [(f64, f64); 3] = [(-0.6, 0.6); 3];

    const LOAD: Point = Point {
        mass: 1.3,
        at: [0.05, -0.12, 0.2],
    };

    #[test]
    fn slopes_are_derivatives() {
        let slopes = LOAD.slopes();
        for k in 0..4 {
            let moved = |by: f64| {
                let mut point = LOAD;
                match k {
                    0 => point.mass += by,
                    axis => point.at[axis - 1] += by,
                }
                Ten::from(point.standard())
            };
            let expected = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((slopes.column(k) - expected).amax() < 1e-8, "{k}");
        }
    }

    /// From a log that shows everything, the load comes out wherever the search begins.
    #[test]
    fn the_load_is_found_from_far_away() {
        let gram = SMatrix::<f64, TEN, TEN>::from_fn(|i, j| {
            1e6 * (if i == j { 1.0 } else { 0.0 } + 0.3 / (1.0 + (i as f64 - j as f64).abs()))
        });
        let moment = gram * Ten::from(LOAD.standard());
        for center in [[0.0; 3], [0.3, 0.3, -0.3]] {
            let bowl = Bowl {
                gram,
                moment,
                bounds: NEAR_BY,
            };
            let found = bowl.best(center).unwrap();
            assert!((found.mass - LOAD.mass).abs() < 1e-4, "{found:?}");
            for (x, y) in found.at.iter().zip(LOAD.at) {
                assert!((x - y).abs() < 1e-4, "{found:?}");
            }
        }
    }

    #[test]
    fn no_load_is_negative() {
        let gram = SMatrix::<f64, TEN, TEN>::identity();
        let lighter = Point {
            mass: -1.0,
            at: [0.0; 3],
        };
        let moment = gram * Ten::from(lighter.standard());
        let bowl = Bowl {
            gram,
            moment,
            bounds: NEAR_BY,
        };
        let found = bowl.best([0.0; 3]);
        assert!(found.is_none_or(|point| point.mass == 0.0), "{found:?}");
    }
}
