//! Inertias that a rigid body can have: log-Cholesky parameters (Rucker, Wensing 2022).
//!
//! The pseudo-inertia `P = [[Σ, h], [hᵀ, m]]`, `Σ = ½ tr(I) 1 − I`, of a body is positive
//! definite; `P = U Uᵀ` with an upper triangular `U` whose diagonal is exponentials has no
//! other.

use super::columns::Columns;
use super::equations::Equations;
use super::estimate::{Design, Estimate, Normal, Signs, estimate};
use super::point::TEN;
use super::select::Chosen;
use nalgebra::{DMatrix, DVector, Matrix4};

/// A thin rod stands at the edge of what a body can be: steps there are short.
const ITERATIONS: usize = 1000;

/// Where the entries of `U` above its diagonal stand.
const ABOVE: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

/// The estimate with consistent inertias, and per inertial column whether its body has come to
/// the edge of what can be: Levenberg–Marquardt from the model's own.
pub(super) fn refine(
    columns: &Columns,
    equations: &Equations,
    chosen: &Chosen,
) -> (Estimate, Vec<bool>) {
    let linear = estimate(columns, equations, &chosen.groups, true, Signs::Kept);
    let design = Design::new(columns, &chosen.groups, true);
    let used = &design.used;
    let blocks = equations.blocks.iter();
    let mut normal = Normal::new(columns, &design, blocks, equations.news, Signs::Kept);
    // What is carried stays what the linear fit says.
    if let Some((point, _)) = &linear.point {
        normal.carry(point);
    }
    let bodies = columns.inertial / TEN;
    let mut theta: Vec<f64> = (0..bodies)
        .flat_map(|b| parameters_of(&columns.stated[TEN * b..TEN * (b + 1)]))
        .collect();
    let mut floors: Vec<f64> = theta.chunks(TEN).flat_map(floors).collect();
    let lower = columns.lower();
    floors.extend(used[columns.inertial..].iter().map(|&c| lower[c]));
    raise(&mut theta, &floors);
    theta.extend(used[columns.inertial..].iter().map(|&c| linear.values[c]));
    let mut damping = 1e-3;
    let mut cost = cost(&normal, &corrections(columns, &theta));
    for _ in 0..ITERATIONS {
        let slope = slope(columns, &theta);
        let x = DVector::from_vec(corrections(columns, &theta));
        let gradient = slope.tr_mul(&(&normal.gram * &x - &normal.moment));
        let curvature = slope.tr_mul(&normal.gram) * &slope;
        let mut damped = curvature.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] += damping * curvature[(i, i)].max(1e-12);
        }
        let Some(cholesky) = damped.cholesky() else {
            damping *= 10.0;
            continue;
        };
        let step = cholesky.solve(&gradient);
        let mut trial: Vec<f64> = theta.iter().zip(step.iter()).map(|(t, s)| t - s).collect();
        raise(&mut trial, &floors);
        let new = self::cost(&normal, &corrections(columns, &trial));
        if new.is_finite() && new < cost {
            let done = cost - new < 1e-9 * (1.0 + cost.abs());
            (theta, cost) = (trial, new);
            damping = (damping * 0.3).max(1e-12);
            if done {
                break;
            }
        } else if damping > 1e12 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    let mut result = linear;
    for (&column, value) in used.iter().zip(corrections(columns, &theta)) {
        match result.inertial.get_mut(column) {
            // A payload is in the values, too.
            Some(inertial) => {
                result.values[column] += value - *inertial;
                *inertial = value;
            }
            None => result.values[column] = value,
        }
        // Standard errors are those of the linear fit, which may hold other coefficients at zero.
        if lower[column].is_finite() {
            let std = &mut result.std[column];
            *std = match value > lower[column] {
                true if std.is_nan() => f64::INFINITY,
                true => *std,
                false => f64::NAN,
            };
        }
    }
    (result, at_edge(&theta[..columns.inertial], &floors))
}

/// How near to its floor, relative to the floor's distance from the stated size, counts as there.
const AT_FLOOR: f64 = 1e-6;

/// Per inertial parameter, whether a floor holds it: that of the mass its mass, those of the
/// extents its second moments. A first moment has none.
fn at_edge(theta: &[f64], floors: &[f64]) -> Vec<bool> {
    let bodies = theta.chunks(TEN).zip(floors.chunks(TEN));
    let of_body = |(theta, floors): (&[f64], &[f64])| {
        let held = |k: usize| theta[k] - floors[k] < AT_FLOOR * THINNEST.ln().abs();
        let (thin, light) = ((0..3).any(held), held(3));
        (0..TEN).map(move |k| match k {
            0 => light,
            1..=3 => false,
            _ => thin,
        })
    };
    bodies.flat_map(of_body).collect()
}

/// Where a log is silent the best body may have no extent at all; it is kept this share of
/// its stated size away from that, so that round-off cannot make it impossible.
const THINNEST: f64 = 1e-3;

/// Lower bounds of a body's ten parameters: `ln U_ii` has one.
fn floors(stated: &[f64]) -> [f64; TEN] {
    let size = stated[..3].iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
    let mut floors = [f64::NEG_INFINITY; TEN];
    floors[..3].fill(size + THINNEST.ln());
    floors[3] = stated[3] + THINNEST.ln();
    floors
}

fn raise(theta: &mut [f64], floors: &[f64]) {
    let pairs = theta.iter_mut().zip(floors);
    pairs.for_each(|(value, floor)| *value = value.max(*floor));
}

fn cost(normal: &Normal, x: &[f64]) -> f64 {
    let x = DVector::from_column_slice(x);
    0.5 * x.dot(&(&normal.gram * &x)) - normal.moment.dot(&x)
}

/// `φ(θ) − φ_stated` per body, then the groups' coefficients as they are.
fn corrections(columns: &Columns, theta: &[f64]) -> Vec<f64> {
    let mut x = Vec::with_capacity(theta.len());
    for body in 0..columns.inertial / TEN {
        let own = standard_of(&theta[TEN * body..TEN * (body + 1)]);
        let stated = &columns.stated[TEN * body..];
        x.extend(own.iter().zip(stated).map(|(value, stated)| value - stated));
    }
    x.extend(&theta[columns.inertial..]);
    x
}

/// `∂x/∂θ`, by central differences of the closed form, block by block.
fn slope(columns: &Columns, theta: &[f64]) -> DMatrix<f64> {
    let mut slope = DMatrix::identity(theta.len(), theta.len());
    for body in 0..columns.inertial / TEN {
        let first = TEN * body;
        for k in 0..TEN {
            let mut own = theta[first..first + TEN].to_vec();
            let step = 1e-6 * (1.0 + own[k].abs());
            own[k] += step;
            let above = standard_of(&own);
            own[k] -= 2.0 * step;
            let below = standard_of(&own);
            for row in 0..TEN {
                slope[(first + row, first + k)] = (above[row] - below[row]) / (2.0 * step);
            }
        }
    }
    slope
}

/// `m, h, I_o` from `ln U_00 … ln U_33` and what stands above the diagonal.
fn standard_of(theta: &[f64]) -> [f64; 10] {
    let mut u = Matrix4::zeros();
    for i in 0..4 {
        u[(i, i)] = theta[i].exp();
    }
    for (&(i, j), &value) in ABOVE.iter().zip(&theta[4..]) {
        u[(i, j)] = value;
    }
    let p = u * u.transpose();
    let trace = p[(0, 0)] + p[(1, 1)] + p[(2, 2)];
    [
        p[(3, 3)],
        p[(0, 3)],
        p[(1, 3)],
        p[(2, 3)],
        trace - p[(0, 0)],
        trace - p[(1, 1)],
        trace - p[(2, 2)],
        -p[(0, 1)],
        -p[(0, 2)],
        -p[(1, 2)],
    ]
}

/// The inverse of [`standard_of`]; what is stated and impossible is moved inside first.
fn parameters_of(standard: &[f64]) -> [f64; 10] {
    let [m, hx, hy, hz, xx, yy, zz, xy, xz, yz] =
        std::array::from_fn(|k| standard.get(k).copied().unwrap_or(0.0));
    let half = 0.5 * (xx + yy + zz);
    let mut p = Matrix4::new(
        half - xx,
        -xy,
        -xz,
        hx,
        -xy,
        half - yy,
        -yz,
        hy,
        -xz,
        -yz,
        half - zz,
        hz,
        hx,
        hy,
        hz,
        m,
    );
    let size = p.trace().abs().max(f64::MIN_POSITIVE);
    let mut lift = 1e-9 * size;
    // Upper triangular factor: that of the matrix read backwards, read backwards.
    let lower = loop {
        let turned = Matrix4::from_fn(|i, j| p[(3 - i, 3 - j)]);
        if let Some(cholesky) = turned.cholesky() {
            break cholesky.l();
        }
        for i in 0..3 {
            p[(i, i)] += lift;
        }
        lift *= 10.0;
        if !lift.is_finite() {
            break Matrix4::identity();
        }
    };
    let u = Matrix4::from_fn(|i, j| lower[(3 - i, 3 - j)]);
    let mut theta = [0.0; 10];
    for i in 0..4 {
        theta[i] = u[(i, i)].max(f64::MIN_POSITIVE).ln();
    }
    for (value, &(i, j)) in theta[4..].iter_mut().zip(&ABOVE) {
        *value = u[(i, j)];
    }
    theta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_and_back() {
        let standard = [2.0, 0.1, -0.2, 0.3, 0.2, 0.25, 0.15, 0.01, -0.02, 0.03];
        let back = standard_of(&parameters_of(&standard));
        for (x, y) in standard.iter().zip(back) {
            assert!((x - y).abs() < 1e-12, "{standard:?} {back:?}");
        }
    }

    /// Whatever the parameters, the body can exist: `I` obeys the triangle inequality.
    #[test]
    fn every_parameter_is_a_body() {
        let theta = [-1.0, 0.3, -0.5, 0.2, 0.7, -0.4, 0.1, 0.3, -0.2, 0.5];
        let body = standard_of(&theta);
        assert!(body[0] > 0.0);
        let (x, y, z) = (body[4], body[5], body[6]);
        assert!(x + y > z && y + z > x && z + x > y);
    }
}
