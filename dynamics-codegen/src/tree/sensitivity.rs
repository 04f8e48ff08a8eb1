//! Derivatives of inverse and forward dynamics, by recursion.
//!
//! With homogeneous transforms `X`, a link's wrench is the skew part of
//! `Ẍ P Xᵀ`. A displacement of joint `j` below turns it by the joint's twist
//! `E_j`, and `δẌ = Ë_j X + 2 Ė_j Ẋ + E_j Ẍ`. Summed over the subtree of joint
//! `i ≥ j` only three composites remain: the pseudo-inertia `P`, the mixed
//! moment `D = Σ Ẋ P Xᵀ`, and the wrench `F` (compare Carpentier, Mansard 2018;
//! Echeandia, Wensing 2021, whose `B` is the same as `D`):
//!
//! * `∂τ_i/∂q_j = s_i · (Ë_j P + 2 Ė_j D)`, `∂τ_i/∂v_j = s_i · 2 (Ė_j P + E_j D)`
//! * `∂τ_j/∂q_i = s_j · (Ë_i P + 2 Ė_i D + E_i F)`, `∂τ_j/∂v_i = s_j · 2 (Ė_i P + E_i D)`
//!
//! all with the composites of `i`. As everything runs in link frames, each
//! joint sends two wrenches, one covector wrench and one covector towards the
//! root. `D` is linear in the angular part alone: its covector needs no lever.

use super::mechanism::{Axis, Link, Mechanism};
use super::message::{AxisMotion, Change, Functional, MixedMoment};
use super::newton_euler::{State, Wrench};
use super::placement::quaternion_map;
use super::space::Space;
use super::turn;
use super::vector::{self, IDENTITY};
use crate::graph::{ExprId, Graph};

/// Derivatives of the inverse dynamics `τ(q, v, a)`; rows are forces.
#[derive(Debug, Clone)]
pub struct InverseDerivatives {
    /// `∂τ/∂q`
    pub position: Vec<Vec<ExprId>>,
    /// `∂τ/∂v`
    pub velocity: Vec<Vec<ExprId>>,
}

/// Derivatives of the forward dynamics `a(q, v, Q)`; rows are accelerations.
#[derive(Debug, Clone)]
pub struct ForwardDerivatives {
    /// `a` itself.
    pub acceleration: Vec<ExprId>,
    /// `∂a/∂q`
    pub position: Vec<Vec<ExprId>>,
    /// `∂a/∂v`
    pub velocity: Vec<Vec<ExprId>>,
    /// `∂a/∂Q = M⁻¹`
    pub force: Vec<Vec<ExprId>>,
}

/// A coordinate as seen by the link that it moves.
struct Direction {
    coordinate: usize,
    /// Displacement per unit of the coordinate.
    ratio: ExprId,
    motion: AxisMotion,
}

/// What the derivatives are assembled from: a row per freedom, a column per
/// coordinate.
struct Slopes {
    position: Vec<Vec<ExprId>>,
    velocity: Vec<Vec<ExprId>>,
    /// The first row of each link.
    starts: Vec<usize>,
}

impl Mechanism {
    /// `∂(M a − Q_C)/∂(q, v)` at fixed `a`. For a floating body they hold along
    /// changes that keep its quaternion a unit (`ηᵀδη = 0`, and `ηᵀδη̇ = 0`):
    /// how a formula continues off the unit sphere is an accident of the formula.
    ///
    /// # Panics
    /// If `acceleration` does not have one entry per coordinate.
    pub fn inverse_dynamics_derivatives(
        &self,
        g: &mut Graph,
        acceleration: &[ExprId],
    ) -> InverseDerivatives {
        let states = self.states(g, acceleration, true);
        let wrenches = self.wrenches(g, &states);
        let slopes = self.freedom_slopes(g, acceleration, &states, &wrenches);
        let space = Space::coordinates(self);
        let mut position = space.rows(g, &slopes.position);
        self.add_quaternion_slopes(g, &wrenches, &mut position);
        InverseDerivatives {
            position,
            velocity: space.rows(g, &slopes.velocity),
        }
    }

    fn freedom_slopes(
        &self,
        g: &mut Graph,
        acceleration: &[ExprId],
        states: &[State],
        wrenches: &[Wrench],
    ) -> Slopes {
        let directions: Vec<Vec<Direction>> = (0..self.links.len())
            .map(|i| self.directions(g, i, acceleration, states))
            .collect();
        let composites = self.composites(g);
        let mixed = self.mixed_moments(g, states);
        let starts = self.freedom_starts();
        let mut slopes = Slopes {
            position: vec![vec![g.zero(); self.coordinates]; starts[self.links.len()]],
            velocity: vec![vec![g.zero(); self.coordinates]; starts[self.links.len()]],
            starts,
        };
        for i in 0..self.links.len() {
            for (k, freedom) in self.links[i].freedoms.iter().enumerate() {
                let force = Functional::new(g, freedom.axis, &composites[i], &mixed[i]);
                self.send_force(g, (i, k), force, &directions, &mut slopes);
            }
            let own_entry = directions[i].len() == 1;
            for direction in &directions[i] {
                let (motion, inertia) = (&direction.motion, &composites[i]);
                let change = Change::new(g, motion, inertia, &mixed[i], &wrenches[i]);
                self.send_change(g, (i, own_entry), change, direction, &mut slopes);
            }
        }
        slopes
    }

    /// The row of a freedom, up to its own link: what moves below changes its force.
    fn send_force(
        &self,
        g: &mut Graph,
        (i, k): (usize, usize),
        mut force: Functional,
        directions: &[Vec<Direction>],
        slopes: &mut Slopes,
    ) {
        let row = slopes.starts[i] + k;
        let mut j = i;
        loop {
            // A joint with one axis reads its own entry off the change it sends.
            if j != i || directions[i].len() > 1 {
                for direction in &directions[j] {
                    let position = force.by_position(g, &direction.motion);
                    let velocity = force.by_velocity(g, &direction.motion);
                    slopes.add(g, row, direction, position, velocity);
                }
            }
            let Some(parent) = self.links[j].parent else {
                break;
            };
            force = force.to_parent(g, self, j);
            j = parent;
        }
    }

    /// The column of a coordinate, from its own link on or from the parent on:
    /// it changes the forces below.
    fn send_change(
        &self,
        g: &mut Graph,
        (i, own_entry): (usize, bool),
        mut change: Change,
        direction: &Direction,
        slopes: &mut Slopes,
    ) {
        let mut j = i;
        loop {
            if j != i || own_entry {
                for (k, freedom) in self.links[j].freedoms.iter().enumerate() {
                    let position = change.by_position.along(g, freedom.axis);
                    let velocity = change.by_velocity.along(g, freedom.axis);
                    let row = slopes.starts[j] + k;
                    slopes.add(g, row, direction, position, velocity);
                }
            }
            let Some(parent) = self.links[j].parent else {
                break;
            };
            change = change.to_parent(g, self, j);
            j = parent;
        }
    }

    fn directions(
        &self,
        g: &mut Graph,
        i: usize,
        acceleration: &[ExprId],
        states: &[State],
    ) -> Vec<Direction> {
        let (link, state) = (&self.links[i], &states[i]);
        if link.free {
            return self.free_directions(g, i, states);
        }
        if link.spherical.is_some() {
            return quaternion_directions(g, link, acceleration, state);
        }
        let zero = vector::zero(g);
        let freedom = &link.freedoms[0];
        let motion = match freedom.axis {
            Axis::Linear(a) => AxisMotion::linear(g, a, state),
            Axis::Angular(k) => {
                let axis = vector::constant(g, IDENTITY[k]);
                AxisMotion::angular(g, [axis, zero, zero], state)
            }
        };
        let (coordinate, ratio) = freedom.map[0];
        vec![Direction {
            coordinate,
            ratio,
            motion,
        }]
    }

    /// Along each component of a free link's twist. Position: the displaced link keeps its
    /// twist, so it moves as if turned by something fixed in its carrier. Velocity: the
    /// twist's axes are fixed in the link; with the carrier's twist `V_c`, the own one `V`
    /// and the component `s`, `δẌ = 2 E Ẋ + ([V, s] + 2 [V_c, s]) X`.
    fn free_directions(&self, g: &mut Graph, i: usize, states: &[State]) -> Vec<Direction> {
        let before = self.before(g, i, states, true);
        let carrier = self.carrier(g, i, &before);
        let zero = vector::zero(g);
        let ratio = g.one();
        let freedoms = self.links[i].freedoms.iter();
        freedoms
            .map(|freedom| {
                let mut along = |state: &State| match freedom.axis {
                    Axis::Linear(a) => AxisMotion::linear(g, a, state),
                    Axis::Angular(k) => {
                        let axis = vector::constant(g, IDENTITY[k]);
                        AxisMotion::angular(g, [axis, zero, zero], state)
                    }
                };
                let (fixed_there, fixed_here) = (along(&carrier), along(&states[i]));
                Direction {
                    coordinate: freedom.map[0].0,
                    ratio,
                    motion: fixed_there.at_rate_between(g, &fixed_here),
                }
            })
            .collect()
    }

    /// A quaternion's forces are `(2 E)ᵀ n`, and `E` changes with it too.
    fn add_quaternion_slopes(
        &self,
        g: &mut Graph,
        wrenches: &[Wrench],
        position: &mut [Vec<ExprId>],
    ) {
        for (link, wrench) in self.links.iter().zip(wrenches) {
            let Some(places) = link.spherical else {
                continue;
            };
            for (d, &column) in places.iter().enumerate() {
                let unit = std::array::from_fn(|c| g.constant(f64::from(u8::from(c == d))));
                let map = quaternion_map(g, unit);
                for (c, &row) in places.iter().enumerate() {
                    let entries = [map[0][c], map[1][c], map[2][c]];
                    let change = vector::dot(g, entries, wrench.moment);
                    position[row][column] = g.add(position[row][column], change);
                }
            }
        }
    }

    /// `∂a/∂(q, v, Q)` through `M ∂a = ∂Q − ∂τ` at the `a` of the forward
    /// dynamics (Carpentier and Mansard 2018). For a floating body they hold along changes
    /// that keep its quaternion a unit.
    ///
    /// # Panics
    /// If `force` does not have one entry per coordinate.
    pub fn forward_dynamics_derivatives(
        &self,
        g: &mut Graph,
        force: &[ExprId],
    ) -> ForwardDerivatives {
        let motion = self.constrained_forward_dynamics(g, force, &[], &[]);
        let acceleration = motion.acceleration;
        let slopes = self.inverse_dynamics_derivatives(g, &acceleration);
        let quasi = Space::quasi(g, self);
        let factor = self.quasi_factor(g, &quasi);
        let (along, nothing) = self.quaternion_loads(g, force);
        let mut solve = |slopes: &[Vec<ExprId>], along: &[ExprId]| {
            let columns: Vec<Vec<ExprId>> = (0..slopes.len())
                .map(|j| {
                    let mut column: Vec<ExprId> = slopes.iter().map(|row| row[j]).collect();
                    column[j] = g.sub(column[j], along[j]);
                    let column = self.to_quasi(g, &column);
                    let column = factor.solve_negative(g, &column);
                    self.of_quasi(g, &column)
                })
                .collect();
            transposed(&columns)
        };
        let (mut position, mut velocity) = (
            solve(&slopes.position, &along),
            solve(&slopes.velocity, &nothing),
        );
        self.add_unit_constraint(g, &acceleration, &mut position, &mut velocity);
        let inverse = factor.inverse(g);
        let half: Vec<Vec<ExprId>> = inverse.iter().map(|row| self.of_quasi(g, row)).collect();
        let columns: Vec<Vec<ExprId>> = transposed(&half)
            .iter()
            .map(|row| self.of_quasi(g, row))
            .collect();
        ForwardDerivatives {
            acceleration,
            position,
            velocity,
            force: columns,
        }
    }

    fn mixed_moments(&self, g: &mut Graph, states: &[State]) -> Vec<MixedMoment> {
        let mut moments: Vec<MixedMoment> = (self.links.iter().zip(states))
            .map(|(link, state)| MixedMoment::of_link(g, &link.inertia, state))
            .collect();
        for i in (0..self.links.len()).rev() {
            let link = &self.links[i];
            if let Some(parent) = link.parent {
                let column = turn::up(g, &link.stages, moments[i].column);
                let block = turn::up_matrix(g, &link.stages, &moments[i].block);
                let moved = MixedMoment { block, column }.shift(g, link.shift);
                moments[parent] = moments[parent].add(g, &moved);
            }
        }
        moments
    }

    /// `λ = −ηᵀQ_η` at a quaternion's places: what its unit constraint takes
    /// off the applied force, and turns with it. Zero elsewhere; and all zeros.
    fn quaternion_loads(&self, g: &mut Graph, force: &[ExprId]) -> (Vec<ExprId>, Vec<ExprId>) {
        let nothing = vec![g.zero(); self.coordinates];
        let mut loads = nothing.clone();
        for link in &self.links {
            let Some((places, quaternion)) = link.spherical.zip(link.quaternion) else {
                continue;
            };
            let applied = places.map(|place| force[place]);
            let along = g.inner_product(&quaternion, &applied);
            let load = g.neg(along);
            for place in places {
                loads[place] = load;
            }
        }
        (loads, nothing)
    }

    /// The part along `η`: `ηᵀη̈ = −η̇ᵀη̇` gives `ηᵀ∂η̈ = −∂ηᵀη̈ − 2 η̇ᵀ∂η̇`.
    fn add_unit_constraint(
        &self,
        g: &mut Graph,
        acceleration: &[ExprId],
        position: &mut [Vec<ExprId>],
        velocity: &mut [Vec<ExprId>],
    ) {
        for link in &self.links {
            let Some(((places, values), rates)) = link
                .spherical
                .zip(link.quaternion)
                .zip(link.quaternion_rates)
            else {
                continue;
            };
            for (&row, &value) in places.iter().zip(&values) {
                for (&column, &rate) in places.iter().zip(&rates) {
                    let pull = g.mul(value, acceleration[column]);
                    position[row][column] = g.sub(position[row][column], pull);
                    let doubled = g.scale(2.0, rate);
                    let pull = g.mul(value, doubled);
                    velocity[row][column] = g.sub(velocity[row][column], pull);
                }
            }
        }
    }
}

impl Slopes {
    fn add(
        &mut self,
        g: &mut Graph,
        row: usize,
        direction: &Direction,
        position: ExprId,
        velocity: ExprId,
    ) {
        let column = direction.coordinate;
        let position = g.mul(direction.ratio, position);
        self.position[row][column] = g.add(self.position[row][column], position);
        let velocity = g.mul(direction.ratio, velocity);
        self.velocity[row][column] = g.add(self.velocity[row][column], velocity);
    }
}

/// Along each of a quaternion's four coordinates.
fn quaternion_directions(
    g: &mut Graph,
    link: &Link,
    acceleration: &[ExprId],
    state: &State,
) -> Vec<Direction> {
    let Some(((places, values), rates)) = link
        .spherical
        .zip(link.quaternion)
        .zip(link.quaternion_rates)
    else {
        return Vec::new();
    };
    // ε = 2 E(η) δη with the same δη at all times: ε̇ = 2 E(η̇) δη, and
    // ε̈ = 2 E(η̈) δη + 2 ω η̇ᵀδη: while η̇ᵀδη ≠ 0 the path η + δη leaves
    // the unit sphere, and ω̇ = 2 E η̈ is not divided by its length. Where the stated η̈ does not
    // keep η a unit, ∂ω̇ = 2 E(δη) η̈ has its excess along η with the other sign than ε̈.
    let seconds = places.map(|place| acceleration[place]);
    let inward = g.inner_product(&rates, &rates);
    let outward = g.inner_product(&values, &seconds);
    let excess = g.add(outward, inward);
    let excess = g.scale(-2.0, excess);
    let maps = [values, rates, seconds].map(|x| quaternion_map(g, x));
    let ratio = g.one();
    (places.into_iter().enumerate())
        .map(|(c, coordinate)| {
            let [axis, rate, second] = maps.map(|map| [map[0][c], map[1][c], map[2][c]]);
            let doubled = g.scale(2.0, rates[c]);
            let stretch = vector::scale(g, doubled, state.omega);
            let turned = vector::scale(g, excess, axis);
            let second = vector::add(g, second, stretch);
            let columns = [axis, rate, vector::add(g, second, turned)];
            let motion = AxisMotion::angular(g, columns, state);
            Direction {
                coordinate,
                ratio,
                motion,
            }
        })
        .collect()
}

/// Rows from columns.
fn transposed(columns: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
    let size = columns.first().map_or(0, Vec::len);
    (0..size)
        .map(|i| columns.iter().map(|column| column[i]).collect())
        .collect()
}
