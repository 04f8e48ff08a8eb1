//! Which groups to take in: those that predict blocks they were not fitted to.

use super::columns::Columns;
use super::equations::{Block, Equations};
use super::estimate::{Estimate, Normal, Signs, estimate, in_use};
use super::signs::Bounded;
use rayon::prelude::*;

/// What was taken in.
#[derive(Debug, Clone, Default)]
pub(super) struct Chosen {
    pub groups: Vec<usize>,
    /// Share of the held-out squared error that each removed when it came.
    pub gains: Vec<f64>,
    /// Whether corrected inertias predict better than the stated ones.
    pub inertias: bool,
}

/// The weights and what they leave settle in a few rounds.
const ROUNDS: usize = 3;

/// Forward selection by cross-validation over blocks, then backwards: what has become
/// idle goes again. Errors are measured by what all candidates together leave (the
/// equations are returned so weighed): what a single one leaves is not noise yet.
pub(super) fn select(columns: &Columns, mut equations: Equations) -> (Chosen, Equations) {
    let mut chosen = Chosen::default();
    let all: Vec<usize> = (0..columns.groups.len()).collect();
    for _ in 0..ROUNDS {
        let everything = estimate(columns, &equations, &all, true, Signs::Free);
        equations.reweigh(&everything.values);
    }
    // What acts in one joint is simpler than what couples two: it comes first.
    for places in [1, 2] {
        let mut errors = held_out(columns, &equations, &chosen.groups, false);
        while let Some((group, gain)) = best(columns, &equations, &chosen.groups, &errors, places) {
            chosen.groups.push(group);
            chosen.gains.push(gain);
            errors = held_out(columns, &equations, &chosen.groups, false);
        }
    }
    drop_idle(columns, &equations, &mut chosen);
    chosen.inertias = inertias_help(columns, &equations, &chosen.groups);
    if chosen.inertias {
        // Terms that stood in for wrong inertias have nothing left to do.
        drop_idle(columns, &equations, &mut chosen);
    }
    (chosen, equations)
}

/// Whether freeing the inertias predicts what they were not fitted to. The terms have
/// been found with the inertias that the model states: those are measured or designed,
/// and free ones would take the place of rotors and friction.
fn inertias_help(columns: &Columns, equations: &Equations, groups: &[usize]) -> bool {
    if columns.inertial == 0 {
        return false;
    }
    let held = held_out(columns, equations, groups, false);
    let free = held_out(columns, equations, groups, true);
    if !is_possible(columns, equations, groups, true) {
        return false;
    }
    held.zip(free)
        .is_some_and(|(held, free)| is_significant(columns, equations.news, &held, &free))
}

type Errors = Option<Vec<f64>>;

/// The group that helps most, if it helps for certain.
fn best(
    columns: &Columns,
    equations: &Equations,
    chosen: &[usize],
    errors: &Errors,
    places: usize,
) -> Option<(usize, f64)> {
    let before = errors.as_ref()?;
    let trials: Vec<(usize, Vec<f64>)> = (0..columns.groups.len())
        .into_par_iter()
        .filter(|&group| !chosen.contains(&group) && columns.groups[group].on.len() == places)
        .filter_map(|group| {
            let with = [chosen, &[group]].concat();
            if !is_possible(columns, equations, &with, false) {
                return None;
            }
            held_out(columns, equations, &with, false).map(|errors| (group, errors))
        })
        .collect();
    let total: f64 = before.iter().sum();
    let gain = |after: &[f64]| before.iter().sum::<f64>() - after.iter().sum::<f64>();
    let (group, after) = trials
        .into_iter()
        .filter(|(_, after)| is_significant(columns, equations.news, before, after))
        .max_by(|(_, x), (_, y)| gain(x).total_cmp(&gain(y)))?;
    Some((group, gain(&after) / total))
}

/// Whether what was not fitted to has become so much likelier that the best of all
/// candidates would not do so by chance: errors are in units of their scale, and only
/// the share `news` of them says something new.
fn is_significant(columns: &Columns, news: f64, before: &[f64], after: &[f64]) -> bool {
    let fall = before.iter().sum::<f64>() - after.iter().sum::<f64>();
    let nats = 0.5 * news * fall;
    nats > 2.0 * (columns.groups.len().max(2) as f64).ln()
}

/// Friction that drives and rotors of negative inertia do not exist, nor do such couplings: the
/// log may want a coefficient below zero by its uncertainty only, or something else is at work.
fn is_possible(columns: &Columns, equations: &Equations, groups: &[usize], inertias: bool) -> bool {
    let Estimate { values, std, .. } = estimate(columns, equations, groups, inertias, Signs::Free);
    let signed = columns.signed().into_iter().enumerate();
    signed
        .filter(|(column, signed)| *signed && std[*column].is_finite())
        .all(|(column, _)| values[column] >= -2.0 * std[column])
}

/// Squared error of each block by what the others say.
fn held_out(columns: &Columns, equations: &Equations, groups: &[usize], inertias: bool) -> Errors {
    let used = in_use(columns, groups, inertias);
    (0..equations.blocks.len())
        .map(|out| {
            let others = equations.blocks.iter().enumerate();
            let others = others
                .filter(|(index, _)| *index != out)
                .map(|(_, block)| block);
            let normal = Normal::new(columns, &used, others, equations.news, Signs::Kept);
            let Bounded { x, .. } = normal.solve()?;
            Some(squared_error(&equations.blocks[out], &used, x.as_slice()))
        })
        .collect()
}

/// `|r − X x|²` of a block.
fn squared_error(block: &Block, used: &[usize], x: &[f64]) -> f64 {
    let mut error = block.square;
    for (&a, &xa) in used.iter().zip(x) {
        error -= 2.0 * xa * block.moment[a];
        for (&b, &xb) in used.iter().zip(x) {
            error += xa * xb * block.gram[(a, b)];
        }
    }
    error.max(0.0)
}

/// Takes out, one by one, groups without which the blocks are predicted as well.
fn drop_idle(columns: &Columns, equations: &Equations, chosen: &mut Chosen) {
    loop {
        let Some(with) = held_out(columns, equations, &chosen.groups, chosen.inertias) else {
            return;
        };
        let idle = (0..chosen.groups.len()).find(|&index| {
            let mut fewer = chosen.groups.clone();
            fewer.remove(index);
            held_out(columns, equations, &fewer, chosen.inertias)
                .is_some_and(|without| !is_significant(columns, equations.news, &without, &with))
        });
        match idle {
            Some(index) => {
                chosen.groups.remove(index);
                chosen.gains.remove(index);
            }
            None => return,
        }
    }
}
