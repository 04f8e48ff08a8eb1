//! Forward dynamics by articulated-body inertias (Featherstone 2008, table 7.1).
//!
//! The wrench that a link takes to accelerate by `δ` (against its motion at `v̇ = 0`) is
//! `I δ + w`, if all that hangs on it moves freely: `I` is its articulated inertia. With a
//! freedom's axis `s`, `U = I s` and `D = s · U`:
//!
//! * `y = τ − s · w`, then `w + U y / D` and `I − U Uᵀ / D` act on what carries the freedom;
//! * `v̇ = (y − U · δ) / D`, from the root to the leaves.
//!
//! That is the elimination of `M v̇ = Q_C + τ` from the leaves to the root without ever forming
//! `M`. It takes as many operations for every link, where the entries of `M` and its factors
//! grow with the depth of the tree.

use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Link, Mechanism};
use super::newton_euler::Wrench;
use super::turn::{self, Matrix, Stage};
use super::vector::{self, IDENTITY, Vector};
use crate::graph::{ExprId, Graph};

/// `[[J, C], [Cᵀ, N]]`: moment and force by angular and linear acceleration.
#[derive(Debug, Clone, Copy)]
struct Articulated {
    angular: Matrix,
    mixed: Matrix,
    linear: Matrix,
}

/// How a link accelerates beyond what it does at `v̇ = 0`.
#[derive(Debug, Clone, Copy)]
struct Acceleration {
    angular: Vector,
    linear: Vector,
}

/// An eliminated freedom.
struct Eliminated {
    /// `U / D`
    response: Wrench,
    /// `y / D`
    free: ExprId,
}

impl Mechanism {
    /// Whether the recursion is written for the tree: each freedom is a coordinate of its own.
    pub(super) fn has_own_coordinates(&self, g: &Graph) -> bool {
        let mut seen = vec![false; self.coordinates];
        let mut freedoms = self.links.iter().flat_map(|link| &link.freedoms);
        let own = freedoms.all(|freedom| match freedom.map[..] {
            [(index, ratio)] => {
                g.as_constant(ratio) == Some(1.0) && !std::mem::replace(&mut seen[index], true)
            }
            _ => false,
        });
        own && seen.iter().all(|&moved| moved)
    }

    /// `a` of `M a = Q_C + Q`, for a tree that [has its own
    /// coordinates](Self::has_own_coordinates).
    pub(super) fn articulated_forward_dynamics(
        &self,
        g: &mut Graph,
        force: &[ExprId],
    ) -> Vec<ExprId> {
        let rest = vec![g.zero(); self.coordinates];
        let states = self.states(g, &rest, true);
        let mut wrenches: Vec<Wrench> = (self.links.iter().zip(&states))
            .map(|(link, state)| state.second.wrench(g, &link.inertia, state.acceleration))
            .collect();
        let mut inertias: Vec<Articulated> = (self.links.iter())
            .map(|link| Articulated::of_link(g, &link.inertia))
            .collect();
        let mut eliminated: Vec<Vec<Eliminated>> = Vec::new();
        for (i, link) in self.links.iter().enumerate().rev() {
            let (mut inertia, mut wrench) = (inertias[i], wrenches[i]);
            let mut freedoms: Vec<Eliminated> = (link.freedoms.iter().rev())
                .map(|freedom| {
                    let applied = force[freedom.map[0].0];
                    eliminate(g, (&mut inertia, &mut wrench), freedom.axis, applied)
                })
                .collect();
            freedoms.reverse();
            eliminated.push(freedoms);
            if let Some(parent) = link.parent {
                let moved = inertia.seen_before(g, &link.stages, link.shift);
                inertias[parent] = inertias[parent].add(g, &moved);
                let moved = self.to_parent(g, i, &wrench);
                wrenches[parent] = wrenches[parent].add(g, &moved);
            }
        }
        eliminated.reverse();
        self.accelerations(g, &eliminated)
    }

    /// From the root to the leaves: what every freedom accelerates by.
    fn accelerations(&self, g: &mut Graph, eliminated: &[Vec<Eliminated>]) -> Vec<ExprId> {
        let mut result = vec![g.zero(); self.coordinates];
        let mut motions: Vec<Acceleration> = Vec::with_capacity(self.links.len());
        for (link, eliminated) in self.links.iter().zip(eliminated) {
            let mut motion = match link.parent {
                Some(parent) => motions[parent].seen_from(g, link),
                None => Acceleration::zero(g),
            };
            for (freedom, eliminated) in link.freedoms.iter().zip(eliminated) {
                let carried = motion.work(g, &eliminated.response);
                let rate = g.sub(eliminated.free, carried);
                result[freedom.map[0].0] = rate;
                motion = motion.with(g, freedom.axis, rate);
            }
            motions.push(motion);
        }
        result
    }
}

/// Takes a freedom that the force `applied` drives out of what acts on its carrier.
fn eliminate(
    g: &mut Graph,
    (inertia, wrench): (&mut Articulated, &mut Wrench),
    axis: Axis,
    applied: ExprId,
) -> Eliminated {
    let momentum = inertia.along(g, axis);
    let pivot = momentum.along(g, axis);
    let one = g.one();
    let inverse = g.div(one, pivot);
    let response = Wrench {
        moment: vector::scale(g, inverse, momentum.moment),
        force: vector::scale(g, inverse, momentum.force),
    };
    let own = wrench.along(g, axis);
    let rest = g.sub(applied, own);
    let pushed = Wrench {
        moment: vector::scale(g, rest, response.moment),
        force: vector::scale(g, rest, response.force),
    };
    *wrench = wrench.add(g, &pushed);
    *inertia = inertia.without(g, &momentum, &response);
    if let Some(k) = coordinate_axis(axis) {
        // What a free axis takes is zero, and what is applied is what it transmits.
        inertia.clear(g, k);
        match axis {
            Axis::Angular(k) => wrench.moment[k] = applied,
            Axis::Linear(_) => wrench.force[k - 3] = applied,
        }
    }
    Eliminated {
        response,
        free: g.mul(rest, inverse),
    }
}

/// Which of the six axes it is: three to turn about, three to slide along.
fn coordinate_axis(axis: Axis) -> Option<usize> {
    match axis {
        Axis::Angular(k) => Some(k),
        Axis::Linear(a) => IDENTITY.iter().position(|unit| *unit == a).map(|k| k + 3),
    }
}

impl Articulated {
    /// `J = tr(S) 1 − S`, `C = [h]ₓ`, `N = m 1`.
    fn of_link(g: &mut Graph, inertia: &PseudoInertia) -> Self {
        let mut angular = inertia.second.map(|row| vector::neg(g, row));
        let mut mixed = [vector::zero(g); 3];
        let mut linear = [vector::zero(g); 3];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            angular[i][i] = inertia.moment(g, i);
            mixed[j][k] = g.neg(inertia.first[i]);
            mixed[k][j] = inertia.first[i];
            linear[i][i] = inertia.mass;
        }
        Self {
            angular,
            mixed,
            linear,
        }
    }

    /// `I s`
    fn along(&self, g: &mut Graph, axis: Axis) -> Wrench {
        match axis {
            Axis::Angular(k) => Wrench {
                moment: self.angular[k],
                force: self.mixed[k],
            },
            Axis::Linear(a) => {
                let a = vector::constant(g, a);
                Wrench {
                    moment: turn::times(g, &self.mixed, a),
                    force: turn::times(g, &self.linear, a),
                }
            }
        }
    }

    fn add(&self, g: &mut Graph, other: &Self) -> Self {
        let mut sum = |x: &Matrix, y: &Matrix| [0, 1, 2].map(|i| vector::add(g, x[i], y[i]));
        Self {
            angular: sum(&self.angular, &other.angular),
            mixed: sum(&self.mixed, &other.mixed),
            linear: sum(&self.linear, &other.linear),
        }
    }

    /// `I − U (U / D)ᵀ`
    fn without(&self, g: &mut Graph, momentum: &Wrench, response: &Wrench) -> Self {
        let (u, r) = (momentum, response);
        Self {
            angular: symmetric(g, |g, i, j| {
                let product = g.mul(u.moment[i], r.moment[j]);
                g.sub(self.angular[i][j], product)
            }),
            mixed: [0, 1, 2].map(|i| {
                [0, 1, 2].map(|j| {
                    let product = g.mul(u.moment[i], r.force[j]);
                    g.sub(self.mixed[i][j], product)
                })
            }),
            linear: symmetric(g, |g, i, j| {
                let product = g.mul(u.force[i], r.force[j]);
                g.sub(self.linear[i][j], product)
            }),
        }
    }

    /// Makes the row and column of one of six axes zero.
    fn clear(&mut self, g: &mut Graph, axis: usize) {
        let zero = g.zero();
        for i in 0..3 {
            if axis < 3 {
                self.angular[axis][i] = zero;
                self.angular[i][axis] = zero;
                self.mixed[axis][i] = zero;
            } else {
                self.linear[axis - 3][i] = zero;
                self.linear[i][axis - 3] = zero;
                self.mixed[i][axis - 3] = zero;
            }
        }
    }

    /// Seen from a frame in which the old origin lies at `p`, in the axes before `stages`:
    /// `C + [p]ₓ N`, and `J − C [p]ₓ + [p]ₓ (C + [p]ₓ N)ᵀ`.
    fn seen_before(&self, g: &mut Graph, stages: &[Stage], p: Vector) -> Self {
        let [angular, mixed, linear] = [&self.angular, &self.mixed, &self.linear]
            .map(|matrix| turn::up_matrix(g, stages, matrix));
        // N is symmetric: its rows are its columns.
        let levers = turn::transpose(&linear.map(|column| vector::cross(g, p, column)));
        let moved = [0, 1, 2].map(|i| vector::add(g, mixed[i], levers[i]));
        let before = mixed.map(|row| vector::cross(g, p, row));
        let after = moved.map(|row| vector::cross(g, p, row));
        Self {
            angular: symmetric(g, |g, i, j| {
                let more = g.add(before[i][j], after[j][i]);
                g.add(angular[i][j], more)
            }),
            mixed: moved,
            linear,
        }
    }
}

/// A symmetric matrix by its entries on and above the diagonal.
fn symmetric(g: &mut Graph, mut entry: impl FnMut(&mut Graph, usize, usize) -> ExprId) -> Matrix {
    let mut matrix = [vector::zero(g); 3];
    for i in 0..3 {
        for j in i..3 {
            matrix[i][j] = entry(g, i, j);
            matrix[j][i] = matrix[i][j];
        }
    }
    matrix
}

impl Acceleration {
    fn zero(g: &mut Graph) -> Self {
        let zero = vector::zero(g);
        Self {
            angular: zero,
            linear: zero,
        }
    }

    /// That of a link which is rigidly carried.
    fn seen_from(&self, g: &mut Graph, link: &Link) -> Self {
        let lever = vector::cross(g, self.angular, link.shift);
        let linear = vector::add(g, self.linear, lever);
        Self {
            angular: turn::down(g, &link.stages, self.angular),
            linear: turn::down(g, &link.stages, linear),
        }
    }

    /// `w · δ`
    fn work(&self, g: &mut Graph, wrench: &Wrench) -> ExprId {
        let turning = vector::dot(g, wrench.moment, self.angular);
        let sliding = vector::dot(g, wrench.force, self.linear);
        g.add(turning, sliding)
    }

    /// With a freedom's own acceleration.
    fn with(mut self, g: &mut Graph, axis: Axis, rate: ExprId) -> Self {
        match axis {
            Axis::Angular(k) => self.angular[k] = g.add(self.angular[k], rate),
            Axis::Linear(a) => {
                let a = vector::constant(g, a);
                let own = vector::scale(g, rate, a);
                self.linear = vector::add(g, self.linear, own);
            }
        }
        self
    }
}
