//! Which groups to take in: those that predict blocks they were not fitted to.

use super::columns::Columns;
use super::equations::Equations;
use super::estimate::{Design, Normal, Signs, estimate};
use super::point::TEN;
use rayon::prelude::*;

/// What was taken in.
#[derive(Debug, Clone, Default)]
pub(super) struct Chosen {
    pub groups: Vec<usize>,
    /// Per group, what it brought when it came.
    pub gains: Vec<Gain>,
    /// Whether corrected inertias predict better than the stated ones.
    pub inertias: bool,
    /// By how many nats these blocks are likelier with them.
    pub inertia_nats: f64,
}

/// What a group brings on blocks that it was not fitted to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gain {
    /// Share of the squared error that it removes.
    pub share: f64,
    /// By how much they become likelier.
    pub nats: f64,
}

/// The weights and what they leave settle in a few rounds.
const ROUNDS: usize = 3;
/// What says something of the machine's structure, a load, a coupling or other inertias, removes at
/// least this share of the error when it comes: a body's inertia that is a little wrong looks like
/// a small load, a bearing's friction that depends on the posture like a small coupling.
const STRUCTURE: f64 = 0.05;
/// Student's t, one-sided, of twelve blocks.
const ONE_IN_A_HUNDRED: f64 = 2.72;
/// A rise of a joint's squared error by less than this share is none.
const RISE: f64 = 0.01;

/// Forward selection by cross-validation over blocks, then backwards: what has become
/// idle goes again. Errors are measured by what all candidates together leave (the
/// equations are returned so weighed): what a single one leaves is not noise yet. Inertias are
/// freed, where they may be, if that predicts.
pub(super) fn select(
    columns: &Columns,
    equations: Equations,
    may_free: bool,
) -> (Chosen, Equations) {
    let equations = weighed_by_all(columns, equations, true);
    let mut chosen = Chosen::default();
    let selection = Selection {
        columns,
        equations: &equations,
    };
    selection.take_in(&mut chosen);
    selection.drop_idle(&mut chosen);
    selection.drop_harmful(&mut chosen);
    let help = may_free.then(|| selection.inertias_help(&chosen.groups));
    if let Some(nats) = help.flatten() {
        chosen.inertias = true;
        chosen.inertia_nats = nats;
        // What wrong inertias hid is seen now, and terms that stood in for them have nothing left
        // to do.
        selection.take_in(&mut chosen);
        selection.drop_idle(&mut chosen);
        selection.drop_harmful(&mut chosen);
    }
    (chosen, equations)
}

/// Equations whose errors are measured by what all candidates together leave, with inertias freed or not.
pub(super) fn weighed_by_all(
    columns: &Columns,
    mut equations: Equations,
    inertias: bool,
) -> Equations {
    // A load is within the span of the inertias.
    let linear = (0..columns.groups.len()).filter(|&g| columns.groups[g].load.is_none());
    let all: Vec<usize> = linear.collect();
    for _ in 0..ROUNDS {
        let everything = estimate(columns, &equations, &all, inertias, Signs::Free);
        equations.reweigh(&everything.values);
    }
    equations
}

/// What a choice is made with.
struct Selection<'a> {
    columns: &'a Columns,
    equations: &'a Equations,
}

/// Squared errors by block, each by what the other blocks say.
type Errors = Vec<f64>;

impl Selection<'_> {
    /// By how many nats what inertias were not fitted to is likelier with freed ones, if that is
    /// beyond chance. The terms have
    /// been found with the inertias that the model states: those are measured or designed,
    /// and free ones would take the place of rotors and friction.
    fn inertias_help(&self, groups: &[usize]) -> Option<f64> {
        if self.columns.inertial == 0 || !self.is_possible(groups, true) {
            return None;
        }
        let (held, free) = (self.held_out(groups, false)?, self.held_out(groups, true)?);
        let helps =
            self.is_significant(&held, &free) && !self.hurts((groups, false), (groups, true));
        let total = held.iter().sum::<f64>();
        let fall = total - free.iter().sum::<f64>();
        (helps && fall > STRUCTURE * total).then_some(0.5 * self.equations.news * fall)
    }

    /// Takes in one group after the other. What acts in one place is simpler than what couples two:
    /// it comes first; what couples two may leave something in one that nobody saw before.
    fn take_in(&self, chosen: &mut Chosen) {
        for reach in [0, 1, 0] {
            while let Some((group, gain)) = self.best(&chosen.groups, chosen.inertias, reach) {
                chosen.groups.push(group);
                chosen.gains.push(gain);
            }
        }
    }

    /// The group that helps most, if it helps for certain and no joint pays for it.
    fn best(&self, chosen: &[usize], inertias: bool, reach: usize) -> Option<(usize, Gain)> {
        let before = self.held_out(chosen, inertias)?;
        let of = |&group: &usize| &self.columns.groups[group];
        // One load, and none where inertias are free: they would explain it, too.
        let has_load = inertias || chosen.iter().any(|g| of(g).load.is_some());
        let mut trials: Vec<(usize, Errors)> = (0..self.columns.groups.len())
            .into_par_iter()
            .filter(|group| !chosen.contains(group) && of(group).reach() == reach)
            .filter(|group| !has_load || of(group).load.is_none())
            .filter_map(|group| {
                let with = [chosen, &[group]].concat();
                if !self.is_possible(&with, inertias) {
                    return None;
                }
                self.held_out(&with, inertias).map(|errors| (group, errors))
            })
            .collect();
        let total: f64 = before.iter().sum();
        let gain = |after: &Errors| total - after.iter().sum::<f64>();
        trials.retain(|(_, after)| self.is_significant(&before, after));
        trials.sort_by(|(_, x), (_, y)| gain(y).total_cmp(&gain(x)));
        let kept = trials.iter().find(|(group, after)| {
            let with = [chosen, &[*group]].concat();
            let is_enough = !of(group).is_bold() || gain(after) > STRUCTURE * total;
            let is_load = of(group).load.is_none() || self.is_load(chosen, *group, after);
            is_enough && is_load && !self.hurts((chosen, inertias), (&with, inertias))
        });
        let (group, after) = kept?;
        let gain = Gain {
            share: gain(after) / total,
            nats: 0.5 * self.equations.news * gain(after),
        };
        Some((*group, gain))
    }

    /// Whether a load explains no worse than ten other inertias of its body would: one mass in
    /// one place is what is simpler.
    fn is_load(&self, chosen: &[usize], group: usize, after: &Errors) -> bool {
        let mut design = Design::new(self.columns, chosen, false);
        let first = self.columns.groups[group].columns.start;
        design.used.extend(first..first + TEN);
        let other = self.held_out_by(&design);
        other.is_none_or(|other| !self.is_significant(after, &other))
    }

    /// Whether what was not fitted to has become so much likelier that the best of all
    /// candidates would not do so by chance: errors are in units of their scale, and only
    /// the share `news` of them says something new.
    fn is_significant(&self, before: &Errors, after: &Errors) -> bool {
        let fall = before.iter().sum::<f64>() - after.iter().sum::<f64>();
        self.exceeds_chance(fall)
    }

    fn exceeds_chance(&self, fall: f64) -> bool {
        let nats = 0.5 * self.equations.news * fall;
        nats > 2.0 * (self.columns.groups.len().max(2) as f64).ln()
    }

    /// Whether the second is worse than the first in some joint, on blocks that neither was
    /// fitted to, beyond chance: what helps one joint must not be paid for by another. Chance
    /// is what the errors' memory leaves of the log, or how the blocks differ; of a force that
    /// lasts, the first says little.
    fn hurts(&self, first: (&[usize], bool), second: (&[usize], bool)) -> bool {
        let errors = |(groups, inertias): (&[usize], bool)| {
            let design = Design::new(self.columns, groups, inertias);
            self.held_out_by_joint(&design)
        };
        let (Some(before), Some(after)) = (errors(first), errors(second)) else {
            return false;
        };
        let mut joints = before.iter().zip(&after);
        joints.any(|(before, after)| {
            let pairs = before.iter().zip(after);
            let rises: Vec<f64> = pairs.map(|(before, after)| after - before).collect();
            let rise: f64 = rises.iter().sum();
            rise > RISE * before.iter().sum::<f64>()
                && (self.exceeds_chance(rise) || is_consistent(&rises))
        })
    }

    /// Friction that drives and rotors of negative inertia do not exist, nor do such couplings:
    /// the log may want a coefficient below its bound by its uncertainty only, or something else
    /// is at work. So it is where the log does not know that a load has mass at all.
    fn is_possible(&self, groups: &[usize], inertias: bool) -> bool {
        let found = estimate(self.columns, self.equations, groups, inertias, Signs::Free);
        let mut loads = groups
            .iter()
            .filter_map(|&g| self.columns.groups[g].load.as_ref());
        let is_new = loads.any(|load| load.carried.is_none());
        if (found.point).is_some_and(|(load, std)| is_new && load.mass < 2.0 * std[0]) {
            return false;
        }
        let lower = self.columns.lower().into_iter().enumerate();
        let inertial = self.columns.inertial;
        lower
            .filter(|(column, _)| *column >= inertial && found.std[*column].is_finite())
            .all(|(column, lower)| found.values[column] >= lower - 2.0 * found.std[column])
    }

    /// Squared error of each block by what the others say.
    fn held_out(&self, groups: &[usize], inertias: bool) -> Option<Errors> {
        self.held_out_by(&Design::new(self.columns, groups, inertias))
    }

    fn held_out_by(&self, design: &Design) -> Option<Errors> {
        let blocks = self.without_each(design)?;
        let pairs = self.equations.blocks.iter().zip(blocks);
        Some(pairs.map(|(block, x)| block.squared_error(&x)).collect())
    }

    /// The same per joint; under constraints per direction.
    fn held_out_by_joint(&self, design: &Design) -> Option<Vec<Errors>> {
        let blocks = self.without_each(design)?;
        let mut joints = vec![Vec::new(); self.equations.scale.len()];
        for (block, x) in blocks.iter().enumerate() {
            let errors = self.equations.squared_errors(block, x);
            joints
                .iter_mut()
                .zip(errors)
                .for_each(|(all, own)| all.push(own));
        }
        Some(joints)
    }

    /// Per block, what the others say.
    fn without_each(&self, design: &Design) -> Option<Vec<Vec<f64>>> {
        let Self { columns, equations } = self;
        (0..equations.blocks.len())
            .map(|out| {
                let others = equations.blocks.iter().enumerate();
                let others = others
                    .filter(|(index, _)| *index != out)
                    .map(|(_, block)| block);
                let normal = Normal::new(columns, design, others, equations.news, Signs::Kept);
                let solved = normal.solve()?;
                Some(normal.coefficients(columns, design, &solved))
            })
            .collect()
    }

    /// Takes out, one by one, groups without which the blocks are predicted as well.
    fn drop_idle(&self, chosen: &mut Chosen) {
        loop {
            let Some(with) = self.held_out(&chosen.groups, chosen.inertias) else {
                return;
            };
            let idle = (0..chosen.groups.len()).find(|&index| {
                let without = self.held_out(&without(&chosen.groups, index), chosen.inertias);
                without.is_some_and(|without| !self.is_significant(&without, &with))
            });
            match idle {
                Some(index) => chosen.drop(index),
                None => return,
            }
        }
    }

    /// Takes out groups without which some joint is predicted better beyond chance, those that
    /// brought least first.
    fn drop_harmful(&self, chosen: &mut Chosen) {
        loop {
            let mut order: Vec<usize> = (0..chosen.groups.len()).collect();
            order.sort_by(|&a, &b| chosen.gains[a].nats.total_cmp(&chosen.gains[b].nats));
            let harmful = order.into_iter().find(|&index| {
                let fewer = without(&chosen.groups, index);
                self.hurts((&fewer, chosen.inertias), (&chosen.groups, chosen.inertias))
            });
            match harmful {
                Some(index) => chosen.drop(index),
                None => return,
            }
        }
    }
}

/// Whether numbers that stand for each other are above zero by more than they differ.
fn is_consistent(rises: &[f64]) -> bool {
    let count = rises.len() as f64;
    let mean = rises.iter().sum::<f64>() / count;
    let squares: f64 = rises.iter().map(|rise| (rise - mean).powi(2)).sum();
    mean > ONE_IN_A_HUNDRED * (squares / (count * (count - 1.0))).sqrt()
}

impl Chosen {
    fn drop(&mut self, index: usize) {
        self.groups.remove(index);
        self.gains.remove(index);
    }
}

fn without(groups: &[usize], index: usize) -> Vec<usize> {
    let mut fewer = groups.to_vec();
    fewer.remove(index);
    fewer
}
