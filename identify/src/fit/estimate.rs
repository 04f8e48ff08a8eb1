//! Weighted least squares with a prior on inertias, bounds that nature gives, and honest standard
//! errors; one point mass, in which the equations are not linear, on top.

use super::columns::Columns;
use super::equations::{Block, Equations};
use super::point::{Bowl, Point, TEN};
use super::signs::{Bounded, bounded};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Whether coefficients that cannot be below some value by their nature are held to that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Signs {
    /// They are: what is reported, and what predicts.
    Kept,
    /// They are not: what the log would have if it could.
    Free,
}

/// What is fitted at once.
#[derive(Debug, Clone)]
pub(super) struct Design {
    /// The columns in use.
    pub used: Vec<usize>,
    /// The group of the load in use.
    load: Option<usize>,
}

impl Design {
    /// The columns of some groups, behind the inertial ones if these are free.
    pub fn new(columns: &Columns, groups: &[usize], inertias: bool) -> Self {
        let mut used: Vec<usize> = (0..columns.inertial).filter(|_| inertias).collect();
        let is_load = |g: &&usize| columns.groups[**g].load.is_some();
        let linear = groups.iter().filter(|g| !is_load(g));
        used.extend(linear.flat_map(|&g| columns.groups[g].columns.clone()));
        Self {
            used,
            load: groups.iter().find(is_load).copied(),
        }
    }
}

/// Estimated corrections.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    /// One per column; zero where a column is not in use. A payload is in those of its body.
    pub values: Vec<f64>,
    /// Standard errors from how the blocks disagree and from the curvature, the larger; not a
    /// number where a coefficient is held at its bound, infinite where a column is not in use.
    pub std: Vec<f64>,
    /// The payload, in all, with the standard errors of its mass and place.
    pub point: Option<(Point, [f64; 4])>,
    /// What the inertias are corrected by, a payload not counted.
    pub inertial: Vec<f64>,
    /// Combinations of inertias whose variance the log has at least halved.
    pub determined: usize,
}

/// The normal equations of some blocks in some columns, with the prior.
pub(super) struct Normal {
    pub gram: DMatrix<f64>,
    pub moment: DVector<f64>,
    /// What each coefficient is not below.
    pub lower: Vec<f64>,
    load: Option<Load>,
}

/// What a payload adds to the normal equations.
struct Load {
    /// Between the columns in use and the ten of the body.
    cross: DMatrix<f64>,
    gram: SMatrix<f64, TEN, TEN>,
    moment: SVector<f64, TEN>,
    /// The first of the ten.
    first: usize,
    /// What the model has there already.
    carried: Option<Point>,
    /// Where it may be along each axis, m.
    bounds: [(f64, f64); 3],
    center: [f64; 3],
}

/// A solution of the normal equations.
pub(super) struct Solved {
    /// Of the columns in use.
    pub linear: Bounded,
    /// The payload in all.
    pub point: Option<Point>,
}

/// The bounded solution and where the payload is settle in a few rounds.
const ROUNDS: usize = 5;

impl Normal {
    pub fn new<'a>(
        columns: &Columns,
        design: &Design,
        blocks: impl Iterator<Item = &'a Block>,
        news: f64,
        signs: Signs,
    ) -> Self {
        let used = &design.used;
        let size = used.len();
        let (mut gram, mut moment) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let group = design.load.map(|group| &columns.groups[group]);
        let mut load = group.and_then(|group| {
            let own = group.load.as_ref()?;
            Some(Load {
                cross: DMatrix::zeros(size, TEN),
                gram: SMatrix::zeros(),
                moment: SVector::zeros(),
                first: group.columns.start,
                carried: own.carried,
                bounds: own.bounds,
                center: columns.centers[group.columns.start / TEN],
            })
        });
        for block in blocks {
            for (i, &a) in used.iter().enumerate() {
                moment[i] += news * block.moment[a];
                for (j, &b) in used.iter().enumerate() {
                    gram[(i, j)] += news * block.gram[(a, b)];
                }
            }
            if let Some(load) = &mut load {
                load.add(used, block, news);
            }
        }
        for (i, &column) in used
            .iter()
            .enumerate()
            .filter(|(_, c)| **c < columns.inertial)
        {
            gram[(i, i)] += columns.prior[column].powi(-2);
        }
        let lower = columns.lower();
        let bound = |&c: &usize| match signs {
            Signs::Kept => lower[c],
            Signs::Free => f64::NEG_INFINITY,
        };
        Self {
            gram,
            moment,
            lower: used.iter().map(bound).collect(),
            load,
        }
    }

    /// The solution within the bounds; columns that say nothing get zero. `None` where it is not
    /// determined, or a payload would have no mass.
    pub fn solve(&self) -> Option<Solved> {
        let mut gram = self.gram.clone();
        let diagonal = gram.diagonal();
        for i in 0..gram.nrows() {
            // Relative to the column's own size: units differ by orders of magnitude.
            gram[(i, i)] += (1e-12 * diagonal[i]).max(f64::MIN_POSITIVE.sqrt());
        }
        let mut linear = bounded(&gram, &self.moment, &self.lower)?;
        let Some(load) = &self.load else {
            return Some(Solved {
                linear,
                point: None,
            });
        };
        let mut point = load.carried;
        for round in 0..ROUNDS {
            let bowl = load.bowl(&gram, &self.moment, &linear);
            let from = point.map(|from| bowl.descend(from));
            let fresh = (round == 0).then(|| bowl.best(load.center)).flatten();
            let better = |a: Point, b: Point| match bowl.cost(&a) <= bowl.cost(&b) {
                true => a,
                false => b,
            };
            let found = from.into_iter().chain(fresh).reduce(better)?;
            point = Some(found);
            let moment = &self.moment - &load.cross * load.added(&found);
            let next = bounded(&gram, &moment, &self.lower)?;
            let settled = next.free == linear.free;
            linear = next;
            if settled {
                break;
            }
        }
        let has_mass = |point: &Point| point.mass > 0.0 || load.carried.is_some();
        let point = Some(point.filter(has_mass)?);
        Some(Solved { linear, point })
    }

    /// Takes a payload for known.
    pub fn carry(&mut self, point: &Point) {
        if let Some(load) = self.load.take() {
            self.moment -= &load.cross * load.added(point);
        }
    }

    /// Corrections of all columns by a solution.
    pub fn coefficients(&self, columns: &Columns, design: &Design, solved: &Solved) -> Vec<f64> {
        let mut values = vec![0.0; columns.count()];
        for (&column, x) in design.used.iter().zip(solved.linear.x.iter()) {
            values[column] = *x;
        }
        if let (Some(load), Some(point)) = (&self.load, &solved.point) {
            for (k, more) in load.added(point).iter().enumerate() {
                values[load.first + k] += more;
            }
        }
        values
    }
}

impl Load {
    fn add(&mut self, used: &[usize], block: &Block, news: f64) {
        for k in 0..TEN {
            let own = self.first + k;
            self.moment[k] += news * block.moment[own];
            for l in 0..TEN {
                self.gram[(k, l)] += news * block.gram[(own, self.first + l)];
            }
            for (i, &a) in used.iter().enumerate() {
                self.cross[(i, k)] += news * block.gram[(a, own)];
            }
        }
    }

    /// What a payload adds to the body's ten parameters, beyond the one that is there already.
    fn added(&self, point: &Point) -> SVector<f64, TEN> {
        SVector::from(point.standard()) - self.there()
    }

    fn there(&self) -> SVector<f64, TEN> {
        let carried = self.carried.map(|point| point.standard());
        SVector::from(carried.unwrap_or([0.0; TEN]))
    }

    /// What the ten parameters cost, with the columns that are not held at their best.
    fn bowl(&self, gram: &DMatrix<f64>, moment: &DVector<f64>, linear: &Bounded) -> Bowl {
        let free = &linear.free;
        let mut held = linear.x.clone();
        free.iter().for_each(|&i| held[i] = 0.0);
        let cross = DMatrix::from_fn(free.len(), TEN, |i, k| self.cross[(free[i], k)]);
        let pushed = gram * &held;
        let right = DVector::from_fn(free.len(), |i, _| moment[free[i]] - pushed[free[i]]);
        let eliminated = linear.cholesky.solve(&cross);
        let by_free = cross.tr_mul(&eliminated);
        let own = SMatrix::<f64, TEN, TEN>::from_fn(|k, l| self.gram[(k, l)] - by_free[(k, l)]);
        let by_right = eliminated.tr_mul(&right);
        let by_held = self.cross.tr_mul(&held);
        let moment = SVector::<f64, TEN>::from_fn(|k, _| self.moment[k] - by_right[k] - by_held[k]);
        Bowl {
            gram: own,
            // In all, with what is there.
            moment: moment + own * self.there(),
            bounds: self.bounds,
        }
    }
}

/// The estimate with these groups.
pub(super) fn estimate(
    columns: &Columns,
    equations: &Equations,
    groups: &[usize],
    inertias: bool,
    signs: Signs,
) -> Estimate {
    let design = Design::new(columns, groups, inertias);
    let blocks = equations.blocks.iter();
    let normal = Normal::new(columns, &design, blocks, equations.news, signs);
    let mut result = Estimate {
        values: vec![0.0; columns.count()],
        std: vec![f64::INFINITY; columns.count()],
        point: None,
        inertial: vec![0.0; columns.inertial],
        determined: 0,
    };
    let Some(solved) = normal.solve() else {
        return result;
    };
    result.values = normal.coefficients(columns, &design, &solved);
    for (i, &column) in design.used.iter().enumerate() {
        result.std[column] = f64::NAN;
        if column < columns.inertial {
            result.inertial[column] = solved.linear.x[i];
        }
    }
    // What is held is known no better or worse than the law that holds it.
    let directions = directions(&normal, &design, &solved);
    let (inverse, spread) = variances(equations, &directions, &result.values, &solved);
    let variance = |i: usize| inverse[(i, i)].max(spread[(i, i)]);
    let free = &solved.linear.free;
    for (i, &k) in free.iter().enumerate() {
        result.std[design.used[k]] = variance(i).sqrt();
    }
    result.point = solved.point.map(|point| {
        let std = std::array::from_fn(|k| match free.len() + k < inverse.nrows() {
            true => variance(free.len() + k).sqrt(),
            false => f64::NAN,
        });
        (point, std)
    });
    if inertias {
        let counts = [&inverse, &spread].map(|variance| determined(columns, variance));
        result.determined = counts[0].min(counts[1]);
    }
    result
}

/// A direction in which the coefficients may move: columns with their shares.
type Direction = Vec<(usize, f64)>;

/// Those of the columns that are not held, then those of the payload's mass and place.
fn directions(normal: &Normal, design: &Design, solved: &Solved) -> Vec<Direction> {
    let free = solved.linear.free.iter();
    let mut directions: Vec<Direction> = free.map(|&k| vec![(design.used[k], 1.0)]).collect();
    if let (Some(load), Some(point)) = (&normal.load, solved.point.filter(|p| p.mass > 0.0)) {
        let slopes = point.slopes();
        directions.extend((0..4).map(|k| {
            let entries = (0..TEN).map(|row| (load.first + row, slopes[(row, k)]));
            entries.collect::<Direction>()
        }));
    }
    directions
}

/// The inverse `G⁻¹` of the curvature in the directions, and the sandwich
/// `G⁻¹ (Σ s_b s_bᵀ) G⁻¹` with the score `s_b` of each block in them: right whatever follows what
/// within a block.
fn variances(
    equations: &Equations,
    directions: &[Direction],
    values: &[f64],
    solved: &Solved,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let (size, linear) = (directions.len(), solved.linear.free.len());
    let inverse = match size == linear {
        true => solved.linear.cholesky.inverse(),
        false => {
            let mut gram = DMatrix::zeros(size, size);
            for block in &equations.blocks {
                for (i, one) in directions.iter().enumerate() {
                    for (j, other) in directions.iter().enumerate() {
                        let pairs = one.iter().flat_map(|a| other.iter().map(move |b| (a, b)));
                        let products = pairs.map(|(a, b)| a.1 * b.1 * block.gram[(a.0, b.0)]);
                        gram[(i, j)] += equations.news * products.sum::<f64>();
                    }
                }
            }
            // With the prior.
            let own = solved.linear.cholesky.l();
            gram.view_mut((0, 0), (linear, linear))
                .copy_from(&(&own * own.transpose()));
            for (k, more) in Point::belief().into_iter().enumerate() {
                gram[(linear + k, linear + k)] += more;
            }
            let none = || DMatrix::from_element(size, size, f64::INFINITY);
            gram.try_inverse().unwrap_or_else(none)
        }
    };
    let active: Vec<usize> = (0..values.len()).filter(|&c| values[c] != 0.0).collect();
    let mut meat = DMatrix::zeros(size, size);
    for block in &equations.blocks {
        let force = |a: usize| {
            let predicted: f64 = active.iter().map(|&b| block.gram[(a, b)] * values[b]).sum();
            block.moment[a] - predicted
        };
        let along = |direction: &Direction| direction.iter().map(|&(a, s)| s * force(a)).sum();
        let score: Vec<f64> = directions.iter().map(along).collect();
        let score = equations.news * DVector::from_vec(score);
        meat += &score * score.transpose();
    }
    let spread = &inverse * meat * &inverse;
    (inverse, spread)
}

/// Directions of the inertias, which come first, in which a variance is at most half the prior's.
fn determined(columns: &Columns, variance: &DMatrix<f64>) -> usize {
    let m = columns.inertial;
    if m == 0 {
        return 0;
    }
    let relative = DMatrix::from_fn(m, m, |i, j| {
        variance[(i, j)] / (columns.prior[i] * columns.prior[j])
    });
    let values = relative.symmetric_eigenvalues();
    values.iter().filter(|&&x| x <= 0.5).count()
}
