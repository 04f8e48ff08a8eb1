//! `M a = Q` and its constrained relative as straight-line code.

use super::mechanism::{Link, Mechanism};
use super::space::Space;
use crate::graph::{ExprId, Graph};

/// `M = Lᵀ D L`, factored from the leaves to the root: a tree's zeros stay
/// zeros (Featherstone 2005), and zero nodes cost nothing.
#[derive(Debug, Clone)]
pub struct Factor {
    /// Unit lower triangular in elimination order; entry `[k][i]`.
    lower: Vec<Vec<ExprId>>,
    /// `1 / D`
    inverse: Vec<ExprId>,
    /// Roots first; elimination runs from the back.
    order: Vec<usize>,
}

/// What a constrained system accelerates by.
#[derive(Debug, Clone)]
pub struct Constrained {
    /// `a`, one entry per coordinate.
    pub acceleration: Vec<ExprId>,
    /// `λ`, one entry per row of `A`; `Q_I = Aᵀ λ`.
    pub multipliers: Vec<ExprId>,
}

impl Factor {
    /// Factors a positive definite matrix. `order` lists its indices, roots
    /// before leaves; each must occur once.
    pub fn new(g: &mut Graph, matrix: &[Vec<ExprId>], order: Vec<usize>) -> Self {
        let mut work: Vec<Vec<ExprId>> = matrix.to_vec();
        let size = order.len();
        let zero = g.zero();
        let mut lower = vec![vec![zero; matrix.len()]; matrix.len()];
        let mut inverse = vec![zero; matrix.len()];
        let one = g.one();
        for position in (0..size).rev() {
            let k = order[position];
            inverse[k] = g.div(one, work[k][k]);
            for &i in &order[..position] {
                lower[k][i] = g.mul(work[k][i], inverse[k]);
            }
            for (count, &i) in order[..position].iter().enumerate() {
                for &j in &order[..=count] {
                    let product = g.mul(lower[k][i], work[k][j]);
                    work[i][j] = g.sub(work[i][j], product);
                    work[j][i] = work[i][j];
                }
            }
        }
        Self {
            lower,
            inverse,
            order,
        }
    }

    /// `L⁻ᵀ x`
    fn descend(&self, g: &mut Graph, x: &mut [ExprId]) {
        for (position, &k) in self.order.iter().enumerate().rev() {
            for &i in &self.order[..position] {
                let product = g.mul(self.lower[k][i], x[k]);
                x[i] = g.sub(x[i], product);
            }
        }
    }

    /// `D⁻¹ x`
    fn divide(&self, g: &mut Graph, x: &mut [ExprId]) {
        for &k in &self.order {
            x[k] = g.mul(x[k], self.inverse[k]);
        }
    }

    /// `L⁻¹ x`
    fn ascend(&self, g: &mut Graph, x: &mut [ExprId]) {
        for (position, &k) in self.order.iter().enumerate() {
            for &i in &self.order[..position] {
                let product = g.mul(self.lower[k][i], x[i]);
                x[k] = g.sub(x[k], product);
            }
        }
    }

    /// `M⁻¹ x`
    pub fn solve(&self, g: &mut Graph, x: &[ExprId]) -> Vec<ExprId> {
        let mut x = x.to_vec();
        self.descend(g, &mut x);
        self.divide(g, &mut x);
        self.ascend(g, &mut x);
        x
    }

    /// `−M⁻¹ x`. The sign enters where a difference can take it up, not as an
    /// operation of its own.
    pub fn solve_negative(&self, g: &mut Graph, x: &[ExprId]) -> Vec<ExprId> {
        let mut x = x.to_vec();
        // Whether x[i] holds the negative of what it stands for.
        let mut flipped = vec![false; x.len()];
        for (position, &k) in self.order.iter().enumerate().rev() {
            for &i in &self.order[..position] {
                let product = g.mul(self.lower[k][i], x[k]);
                if g.is_zero(product) {
                    continue;
                }
                x[i] = match (flipped[i], flipped[k]) {
                    (false, false) => g.sub(product, x[i]),
                    (false, true) => g.add(product, x[i]),
                    (true, false) => g.add(x[i], product),
                    (true, true) => g.sub(x[i], product),
                };
                flipped[i] |= !flipped[k];
            }
        }
        self.divide(g, &mut x);
        for &k in &self.order {
            if !flipped[k] {
                x[k] = g.neg(x[k]);
            }
        }
        self.ascend(g, &mut x);
        x
    }

    /// `M⁻¹`, symmetric node by node.
    pub fn inverse(&self, g: &mut Graph) -> Vec<Vec<ExprId>> {
        let size = self.inverse.len();
        let zero = g.zero();
        let mut result = vec![vec![zero; size]; size];
        // Column k of M⁻¹ from row k on: what stands before is known by symmetry.
        for (position, &k) in self.order.iter().enumerate() {
            let mut x = vec![zero; size];
            x[k] = g.one();
            self.descend(g, &mut x);
            self.divide(g, &mut x);
            for (row, &i) in self.order.iter().enumerate() {
                if row < position {
                    x[i] = result[i][k];
                    continue;
                }
                for &j in &self.order[..row] {
                    let product = g.mul(self.lower[i][j], x[j]);
                    x[i] = g.sub(x[i], product);
                }
                result[i][k] = x[i];
                result[k][i] = x[i];
            }
        }
        result
    }

    /// `M a = Q + Aᵀλ`, `A a = b` through `G = A M⁻¹ Aᵀ` (thesis 3.38–3.42).
    pub(crate) fn constrained(
        &self,
        g: &mut Graph,
        force: &[ExprId],
        rows: &[Vec<ExprId>],
        bias: &[ExprId],
    ) -> Constrained {
        let mut load = force.to_vec();
        self.descend(g, &mut load);
        let halves: Vec<Vec<ExprId>> = (rows.iter())
            .map(|row| {
                let mut half = row.clone();
                self.descend(g, &mut half);
                half
            })
            .collect();
        let scaled: Vec<Vec<ExprId>> = (halves.iter())
            .map(|half| {
                let mut scaled = half.clone();
                self.divide(g, &mut scaled);
                scaled
            })
            .collect();
        let gram: Vec<Vec<ExprId>> = (0..rows.len())
            .map(|r| {
                let entries = 0..rows.len();
                entries
                    .map(|s| g.inner_product(&halves[r.min(s)], &scaled[r.max(s)]))
                    .collect()
            })
            .collect();
        let demand: Vec<ExprId> = (scaled.iter().zip(bias))
            .map(|(scaled, &b)| {
                let free = g.inner_product(scaled, &load);
                g.sub(b, free)
            })
            .collect();
        let multipliers = Self::new(g, &gram, (0..rows.len()).collect()).solve(g, &demand);
        for (half, &multiplier) in halves.iter().zip(&multipliers) {
            for (x, &h) in load.iter_mut().zip(half) {
                let push = g.mul(h, multiplier);
                *x = g.add(*x, push);
            }
        }
        self.divide(g, &mut load);
        self.ascend(g, &mut load);
        Constrained {
            acceleration: load,
            multipliers,
        }
    }
}

impl Mechanism {
    /// `a = M⁻¹ (Q_C + Q)` for an applied generalised force `Q`; for a floating
    /// body the quaternion's acceleration obeys its unit constraint.
    ///
    /// # Panics
    /// If `force` does not have one entry per coordinate.
    pub fn forward_dynamics(&self, g: &mut Graph, force: &[ExprId]) -> Vec<ExprId> {
        if self.is_articulated() {
            return self.articulated_forward_dynamics(g, force);
        }
        self.constrained_forward_dynamics(g, force, &[], &[])
            .acceleration
    }

    /// `M a = Q_C + Q + Aᵀλ`, `A a = b`, for rows `A` that are independent: with
    /// dependent ones the straight-line code divides by zero, where the
    /// run-time solver of the `dynamics` crate takes the pseudo-inverse. For a
    /// floating body, the multiplier of the unit constraint is not among `λ`.
    ///
    /// # Panics
    /// If a length does not fit the number of coordinates or rows.
    pub fn constrained_forward_dynamics(
        &self,
        g: &mut Graph,
        force: &[ExprId],
        rows: &[Vec<ExprId>],
        bias: &[ExprId],
    ) -> Constrained {
        assert_eq!(force.len(), self.coordinates, "one force per coordinate");
        assert_eq!(rows.len(), bias.len(), "one right-hand side per row");
        let quasi = Space::quasi(g, self);
        let factor = self.quasi_factor(g, &quasi);
        let rest = vec![g.zero(); self.coordinates];
        let needed = self.inverse_dynamics_over(g, &quasi, &rest, self.lumped.beside_mass);
        let applied = self.to_quasi(g, force);
        let total: Vec<ExprId> = (applied.iter().zip(&needed))
            .map(|(&applied, &needed)| g.sub(applied, needed))
            .collect();
        let drift = self.quaternion_drift(g);
        let quasi_rows: Vec<Vec<ExprId>> = rows.iter().map(|row| self.to_quasi(g, row)).collect();
        let bias: Vec<ExprId> = (rows.iter().zip(bias))
            .map(|(row, &b)| {
                let moved = g.inner_product(row, &drift);
                g.sub(b, moved)
            })
            .collect();
        let mut solution = factor.constrained(g, &total, &quasi_rows, &bias);
        solution.acceleration = self.of_quasi(g, &solution.acceleration);
        for (a, &drift) in solution.acceleration.iter_mut().zip(&drift) {
            *a = g.add(*a, drift);
        }
        solution
    }

    /// The factors of the mass matrix over quasi-velocities.
    pub(super) fn quasi_factor(&self, g: &mut Graph, quasi: &Space) -> Factor {
        let over_freedoms = self.freedom_mass_matrix(g);
        let matrix = quasi.congruence(g, &over_freedoms);
        Factor::new(g, &matrix, self.elimination_order())
    }

    /// The factors of the mass matrix as [`mass_matrix`](Self::mass_matrix) gives it.
    pub fn factor(&self, g: &mut Graph) -> Factor {
        let matrix = self.mass_matrix(g);
        Factor::new(g, &matrix, self.factor_order())
    }

    /// All coordinates, roots before leaves.
    pub(crate) fn factor_order(&self) -> Vec<usize> {
        let mut order = self.elimination_order();
        for link in &self.links {
            if let Some([.., last]) = link.spherical {
                order.insert(0, last);
            }
        }
        order
    }

    /// Coordinates, roots before leaves; a quaternion's unused fourth place is
    /// left out.
    pub(super) fn elimination_order(&self) -> Vec<usize> {
        let mut order = Vec::new();
        for link in &self.links {
            let used: Vec<usize> = match link.spherical {
                Some([x, y, z, _]) => vec![x, y, z],
                None => link
                    .freedoms
                    .iter()
                    .flat_map(|f| &f.map)
                    .map(|m| m.0)
                    .collect(),
            };
            for index in used {
                if !order.contains(&index) {
                    order.push(index);
                }
            }
        }
        order
    }

    /// Links whose attitude is a quaternion, with its places among the coordinates.
    fn spherical_links(&self) -> impl Iterator<Item = (&Link, [usize; 4])> {
        let links = self.links.iter();
        links.filter_map(|link| Some((link, link.spherical?)))
    }

    /// A covector on `v` (a force, a row of `A`) as one on quasi-velocities:
    /// with `η̇ = ½ Eᵀω` its quaternion part is `½ E Q_η`.
    pub(super) fn to_quasi(&self, g: &mut Graph, force: &[ExprId]) -> Vec<ExprId> {
        let mut quasi = force.to_vec();
        for (link, places) in self.spherical_links() {
            for (freedom, &place) in link.freedoms.iter().zip(&places) {
                let mut total = g.zero();
                for &(index, coefficient) in &freedom.map {
                    let term = quarter_of(g, coefficient, force[index]);
                    total = g.add(total, term);
                }
                quasi[place] = total;
            }
            quasi[places[3]] = g.zero();
        }
        quasi
    }

    /// Accelerations of quasi-velocities as `a` up to the drift: `η̈ = ½ Eᵀ ω̇`.
    pub(super) fn of_quasi(&self, g: &mut Graph, quasi: &[ExprId]) -> Vec<ExprId> {
        let mut acceleration = quasi.to_vec();
        for (link, places) in self.spherical_links() {
            for place in places {
                acceleration[place] = g.zero();
            }
            for (freedom, &omega_dot) in link.freedoms.iter().zip(&places) {
                for &(index, coefficient) in &freedom.map {
                    let term = quarter_of(g, coefficient, quasi[omega_dot]);
                    acceleration[index] = g.add(acceleration[index], term);
                }
            }
        }
        acceleration
    }

    /// What keeps a quaternion a unit: `−(η̇ᵀη̇) η = −¼ (ωᵀω) η`, zero elsewhere.
    pub(super) fn quaternion_drift(&self, g: &mut Graph) -> Vec<ExprId> {
        let mut drift = vec![g.zero(); self.coordinates];
        for link in &self.links {
            let Some((places, quaternion)) = link.spherical.zip(link.quaternion) else {
                continue;
            };
            let rates: Vec<ExprId> = link.freedoms.iter().map(|f| f.rate).collect();
            let square = g.inner_product(&rates, &rates);
            let inward = g.scale(-0.25, square);
            for (place, value) in places.into_iter().zip(quaternion) {
                drift[place] = g.mul(inward, value);
            }
        }
        drift
    }
}

/// `½ E` times a value, from a coefficient of the map of freedoms, which holds `2 E`.
fn quarter_of(g: &mut Graph, coefficient: ExprId, value: ExprId) -> ExprId {
    let quarter = g.scale(0.25, coefficient);
    g.mul(quarter, value)
}
