//! Functions that solve the equation of motion in loops.
//!
//! Written out, factoring `M` and solving for every column of the derivatives grows with the
//! cube of the number of coordinates. Beyond [`MOST_WRITTEN_OUT`] of them emitted code calls
//! `equation_of_motion` and `residual_derivatives`, which grow with the square, and solves
//! `K ∂[a; −λ]/∂s = −∂[R; S]/∂s` in loops over a table of which coordinate carries which.

use super::counts::OperationCount;
use super::plan::{Function, Plan};
use crate::derive::{Group, Item, System, Term};
use crate::graph::Graph;

/// Models of more coordinates than this solve in loops. Where the two ways meet in size and
/// in time: docs/performance.md has the figures.
const MOST_WRITTEN_OUT: usize = 16;

/// The function that derivatives are solved from.
pub(super) const SLOPES: &str = "residual_derivatives";

/// What a function in loops solves for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Solved {
    /// Whether the constraints take part.
    pub constrained: bool,
    /// What is differentiated by, in the order of emission.
    pub groups: Vec<Group>,
}

/// The part of a solution that a quantity holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// `a`
    Acceleration,
    /// `λ`
    Multipliers,
}

impl Unknown {
    /// What an item is a value or derivative of, if it is solved for.
    pub fn of(item: Item) -> Option<Self> {
        match item.term {
            Term::ForwardDynamics | Term::ConstrainedAcceleration => Some(Self::Acceleration),
            Term::ConstrainedMultipliers => Some(Self::Multipliers),
            _ => None,
        }
    }
}

impl Solved {
    /// How a function of `items` is solved for in loops, if it is to be.
    pub fn of(coordinates: usize, items: &[Item]) -> Option<Self> {
        let constrained = items.first()?.term != Term::ForwardDynamics;
        let mut groups = Vec::new();
        for item in items {
            let same = (item.term != Term::ForwardDynamics) == constrained;
            let by_state = !matches!(item.by, Some(Group::Parameters | Group::Time));
            if Unknown::of(*item).is_none() || !same || !by_state {
                return None;
            }
            groups.extend(item.by.filter(|group| !groups.contains(group)));
        }
        (coordinates > MOST_WRITTEN_OUT).then_some(Self {
            constrained,
            groups,
        })
    }
}

/// The quantity of [`SLOPES`] that holds `∂R/∂s` or `∂S/∂s`.
pub(super) fn slope_of(term: Term, group: Group) -> String {
    Item::slope(term, group).to_string()
}

/// For each coordinate the next one on the way to its root, itself at a root: the elimination
/// tree of `M`, from the last row to the first. Of a tree of bodies whose coordinates are
/// numbered from the root it is that tree (Featherstone 2005).
pub(super) fn parents(graph: &Graph, system: &System) -> Vec<usize> {
    let mass = &system.mass_matrix;
    let mut filled: Vec<Vec<bool>> = (mass.iter())
        .map(|row| row.iter().map(|&entry| !graph.is_zero(entry)).collect())
        .collect();
    let mut parents: Vec<usize> = (0..mass.len()).collect();
    for k in (0..mass.len()).rev() {
        let carried = filled[k].clone();
        let Some(parent) = (0..k).rev().find(|&i| carried[i]) else {
            continue;
        };
        parents[k] = parent;
        for (entry, &carried) in filled[parent][..parent].iter_mut().zip(&carried) {
            *entry |= carried;
        }
    }
    parents
}

impl Plan {
    /// The function that solves in loops, if any does: what it needs is then there.
    pub fn solves(&self) -> bool {
        self.functions.iter().any(|f| f.solved.is_some())
    }

    /// Of [`SLOPES`], the quantity of this name, if the model has it.
    pub fn has_slope(&self, name: &str) -> bool {
        let slopes = self.functions.iter().filter(|f| f.name == SLOPES);
        slopes.flat_map(|f| &f.quantities).any(|q| q.name == name)
    }

    /// What the loops of a function compute, beside the functions that it calls.
    pub fn loop_count(&self, function: &Function, solved: &Solved) -> OperationCount {
        let depths = depths(&self.parents);
        let n = depths.len();
        let rows = if solved.constrained {
            self.model.constraints.len()
        } else {
            0
        };
        let columns: usize = (function.quantities.iter())
            .filter(|q| q.item.and_then(Unknown::of) == Some(Unknown::Acceleration))
            .map(|q| q.len() / n.max(1))
            .sum();
        let columns = columns.max(1);
        let chain: Vec<usize> = (0..rows).collect();
        let per_column = |depths: &[usize]| 2 * depths.iter().sum::<usize>();
        let updates: usize = (depths.iter().chain(&chain))
            .map(|depth| depth * (depth + 1) / 2)
            .sum();
        // The response of `M` to the rows, `G`, then every column with what the rows do to it.
        let solves = per_column(&depths) * (rows + columns) + per_column(&chain) * columns;
        let products = n * rows * rows + 2 * n * rows * columns;
        let scaled = n * (rows + columns) + rows * columns;
        let factors: usize = depths.iter().chain(&chain).sum();
        OperationCount {
            additions: updates + solves + products,
            multiplications: updates + factors + solves + products + scaled,
            divisions: n + rows,
            ..OperationCount::default()
        }
    }
}

/// How many coordinates carry each.
fn depths(parents: &[usize]) -> Vec<usize> {
    let mut depths: Vec<usize> = Vec::with_capacity(parents.len());
    for (k, &parent) in parents.iter().enumerate() {
        depths.push(if parent < k { depths[parent] + 1 } else { 0 });
    }
    depths
}
