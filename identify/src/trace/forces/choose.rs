//! Which effects predict the forces on blocks of the log that they were not fitted to.

use super::equations::Equations;
use super::reach::REACHES;
use crate::regression::Gram;
use crate::trace::dictionary::Dictionary;
use crate::trace::screen::{Considered, ShapedCandidate};
use crate::trace::settings::{MARGIN, TIE};
use rayon::prelude::*;

/// An option with its strengths' columns that are in use.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    /// Which option.
    pub option: usize,
    /// Which of the option's columns.
    pub kept: Vec<usize>,
}

/// All that a choice is made with.
pub(super) struct Choice<'a> {
    pub dictionary: &'a Dictionary,
    pub options: &'a [ShapedCandidate],
    pub equations: &'a Equations,
    pub gram: Gram,
    /// Per column: whether enough of the log shows it.
    pub visible: Vec<bool>,
    /// Per candidate: how far its reach is, see [`reaches`].
    pub reaches: Vec<usize>,
}

/// Terms, and how far from the log they are.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub terms: Vec<Chosen>,
    /// Half the squares that are left: nats.
    pub left: f64,
    /// The same and the terms' price.
    cost: f64,
}

/// Terms at most.
const MOST_TERMS: usize = 60;
/// A term must remove this share of the squares that are left in some coordinate, also of
/// blocks that it was not fitted to: something small can be said about any machine.
const LEAST_REMOVED: f64 = 0.05;
/// Squared multiple correlation from which two terms at one place are one.
const THE_SAME: f64 = 0.8;

impl Choice<'_> {
    /// The choice that explains most for its price: of what is near first, and of everything at once. Of a machine that
    /// lacks a lot, a wrong centre of mass explains some of nearly everything; a load explains more than anything near, and
    /// laws of the joints that were taken for it stay.
    pub fn choose(&self) -> State {
        let near_first: Vec<usize> = (0..REACHES).collect();
        let (near_first, at_once) =
            rayon::join(|| self.chosen(&near_first), || self.chosen(&[REACHES - 1]));
        match at_once.cost < near_first.cost {
            true => at_once,
            false => near_first,
        }
    }

    /// One term after the other, of those that reach no further than each of some limits in turn; what has become idle
    /// goes again, and what another would do better is exchanged.
    fn chosen(&self, limits: &[usize]) -> State {
        let mut state = self.state(Vec::new());
        for &reach in limits {
            loop {
                while state.terms.len() < MOST_TERMS {
                    let Some(more) = self.with_one_more(&state, reach) else {
                        break;
                    };
                    state = more;
                    while let Some(fewer) = self.with_less(&state) {
                        state = fewer;
                    }
                }
                let other = self.with_one_other(&state, reach);
                match other.or_else(|| self.with_one_for_two(&state, reach)) {
                    Some(other) => state = other,
                    None => break,
                }
            }
        }
        while let Some(fewer) = self.without_chance(&state) {
            state = fewer;
        }
        while let Some(simpler) = self.simpler(&state) {
            state = simpler;
        }
        state
    }

    /// Per term: nats by which the log is less likely without it, less its price; and the
    /// candidates that explain about as much in its stead, with the nats by which each
    /// explains more, best first.
    pub fn questioned(&self, state: &State) -> Vec<(f64, Vec<(usize, f64)>)> {
        let each = (0..state.terms.len()).map(|index| {
            let mut others = state.terms.clone();
            others.remove(index);
            let evidence = self.state(others.clone()).cost - state.cost;
            let candidate = |term: &Chosen| self.options[term.option].candidate;
            let taken: Vec<usize> = state.terms.iter().map(candidate).collect();
            let free = |&o: &usize| !taken.contains(&self.options[o].candidate);
            let options = (0..self.options.len()).into_par_iter().filter(free);
            let trials = options.filter_map(|option| {
                let with = self.state(self.possible(&others, &[option])?);
                let better = state.cost - with.cost;
                (better > -TIE).then_some((self.options[option].candidate, better))
            });
            let mut rivals: Vec<(usize, f64)> = trials.collect();
            rivals.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
            rivals.dedup_by_key(|rival| rival.0);
            rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
            (evidence, rivals)
        });
        each.collect()
    }

    /// What every candidate is worth alone, the best first.
    pub fn considered(&self) -> Vec<Considered> {
        let nothing = self.state(Vec::new());
        let each = (0..self.options.len())
            .into_par_iter()
            .filter_map(|option| {
                let state = self.state(self.possible(&[], &[option])?);
                let (columns, strengths) = self.strengths(&state.terms);
                let shaped = &self.options[option];
                let candidate = &self.dictionary.candidates[shaped.candidate];
                let mut values = candidate.shapes[shaped.shape].clone();
                for (column, step) in columns.iter().zip(strengths) {
                    let place = shaped.columns.iter().position(|c| c == column)?;
                    let parameter = candidate.strengths[place];
                    values.push((parameter, self.dictionary.defaults[parameter] + step));
                }
                let (part, own) = self.part(&columns);
                Some(Considered {
                    candidate: shaped.candidate,
                    gain: nothing.left - state.left,
                    score: nothing.cost - state.cost,
                    held_out_gain: part.held_out_gain(&[], &own).map(|gain| 0.5 * gain),
                    values,
                    columns,
                    other_shapes: Vec::new(),
                })
            });
        let mut all: Vec<Considered> = each.collect();
        all.sort_by(|a, b| {
            let best_first = b.score.total_cmp(&a.score);
            a.candidate.cmp(&b.candidate).then(best_first)
        });
        all.dedup_by_key(|considered| considered.candidate);
        all.sort_by(|a, b| b.score.total_cmp(&a.score));
        all
    }

    /// The candidates of some terms.
    pub fn candidates(&self, terms: &[Chosen]) -> Vec<usize> {
        let each = terms.iter();
        each.map(|term| self.options[term.option].candidate)
            .collect()
    }

    /// Candidates that are one law with another and have fewer numbers.
    pub fn plainer_than(&self, candidate: usize) -> Vec<usize> {
        let others = self.dictionary.nested.beside(candidate);
        let size = |candidate: usize| self.dictionary.candidates[candidate].size();
        others
            .filter(|&other| size(other) < size(candidate))
            .collect()
    }

    /// Every two of what is [plainer](Self::plainer_than) that are two laws, with fewer numbers together than it.
    pub fn pairs_plainer_than(&self, candidate: usize) -> Vec<[usize; 2]> {
        let plainer = self.plainer_than(candidate);
        let size = |candidate: usize| self.dictionary.candidates[candidate].size();
        let after = |(i, &a): (usize, &usize)| {
            let others = plainer[i + 1..].iter();
            others.map(move |&b| [a, b]).collect::<Vec<_>>()
        };
        let mut pairs: Vec<[usize; 2]> = plainer.iter().enumerate().flat_map(after).collect();
        pairs.retain(|&[a, b]| {
            size(a) + size(b) < size(candidate) && !self.dictionary.nested.are_one(a, b)
        });
        pairs
    }

    /// Two candidates in the shapes that leave least beside some terms.
    pub fn best_beside(&self, terms: &[Chosen], pair: [usize; 2]) -> Option<[Chosen; 2]> {
        let shapes = |candidate: usize| {
            let all = self.options.iter().enumerate();
            let own = all.filter(move |(_, option)| option.candidate == candidate);
            own.map(|(option, shaped)| Chosen {
                option,
                kept: (0..shaped.columns.len()).collect(),
            })
        };
        let of_first = shapes(pair[0]);
        let all = of_first.flat_map(|a| shapes(pair[1]).map(move |b| [a.clone(), b]));
        let left = |two: &[Chosen; 2]| self.state([terms, two].concat()).left;
        let rated = all.map(|two| (left(&two), two));
        rated.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }

    /// The option of a candidate that is most like a term, by how well its columns explain the term's.
    pub fn most_like(&self, term: &Chosen, candidate: usize) -> Option<usize> {
        let theirs: Vec<usize> = self.own_columns(term).collect();
        let likeness = |option: usize| -> f64 {
            let columns = self.options[option].columns.iter().copied();
            let own: Vec<usize> = columns.filter(|&c| self.visible[c]).collect();
            let each = theirs.iter();
            each.map(|&column| self.gram.explained_by(column, &own))
                .sum()
        };
        let shapes = (0..self.options.len()).filter(|&o| self.options[o].candidate == candidate);
        let rated = shapes.map(|option| (option, likeness(option)));
        rated.max_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0)
    }

    /// The options of candidates that reach no further.
    fn within(&self, reach: usize) -> Vec<usize> {
        let near = |&option: &usize| self.reaches[self.options[option].candidate] <= reach;
        (0..self.options.len()).filter(near).collect()
    }

    /// The columns in use.
    pub fn columns(&self, terms: &[Chosen]) -> Vec<usize> {
        terms
            .iter()
            .flat_map(|term| self.own_columns(term))
            .collect()
    }

    fn own_columns(&self, term: &Chosen) -> impl Iterator<Item = usize> {
        let all = &self.options[term.option].columns;
        term.kept.iter().map(|&i| all[i])
    }

    /// The strengths of all columns in use.
    pub fn strengths(&self, terms: &[Chosen]) -> (Vec<usize>, Vec<f64>) {
        let columns = self.columns(terms);
        let (strengths, _) = self.gram.solved(&columns);
        (columns, strengths.as_slice().to_vec())
    }

    /// A term's price: that of its parameters, and what the best of many gains by chance.
    fn price(&self, term: &Chosen) -> f64 {
        let option = &self.options[term.option];
        let shapes = self.dictionary.candidates[option.candidate].shapes[option.shape].len();
        self.price_of_numbers(term.kept.len() + shapes)
    }

    /// The price of a candidate with all its parameters.
    pub fn price_of(&self, candidate: usize) -> f64 {
        self.price_of_numbers(self.dictionary.candidates[candidate].size())
    }

    /// The price of so many numbers, and of having looked for what has them.
    pub fn price_of_numbers(&self, numbers: usize) -> f64 {
        let search = (self.dictionary.candidates.len() as f64).ln() + MARGIN;
        0.5 * numbers as f64 * self.equations.effective().ln() + search
    }

    /// The part of the products that some columns need: of more than a thousand a handful.
    fn part(&self, columns: &[usize]) -> (Gram, Vec<usize>) {
        (self.gram.part(columns), (0..columns.len()).collect())
    }

    /// Some terms with what they leave.
    pub fn state(&self, terms: Vec<Chosen>) -> State {
        let left = 0.5 * self.gram.solved(&self.columns(&terms)).1;
        State {
            left,
            cost: left + terms.iter().map(|term| self.price(term)).sum::<f64>(),
            terms,
        }
    }

    fn best(&self, trials: impl ParallelIterator<Item = State>, limit: f64) -> Option<State> {
        let trials: Vec<State> = trials.filter(|trial| trial.cost < limit).collect();
        trials.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    fn with_one_more(&self, state: &State, reach: usize) -> Option<State> {
        let taken = |&option: &usize| {
            let candidate = |option: usize| self.options[option].candidate;
            let mut terms = state.terms.iter();
            terms.any(|term| candidate(term.option) == candidate(option))
        };
        let mut free = self.within(reach);
        free.retain(|option| !taken(option));
        let single = free.par_iter().map(|&option| vec![option]);
        // Friction that rises from a step, an inertia beside it: neither may lead anywhere alone.
        let pairs = free.par_iter().enumerate().flat_map(|(index, &a)| {
            let rest = free[index + 1..].par_iter();
            let together = rest.filter(move |&&b| self.is_pair(a, b));
            together.map(move |&b| vec![a, b])
        });
        let trials = single
            .chain(pairs)
            .filter_map(|more| self.possible(&state.terms, &more));
        let trials = trials.map(|terms| self.state(terms));
        let mut trials: Vec<State> = trials.filter(|trial| trial.cost < state.cost).collect();
        trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let before = self.left(&state.terms);
        trials
            .into_iter()
            .find(|trial| is_enough(&before, &self.left(&trial.terms)))
    }

    /// Squares left per coordinate.
    fn left(&self, terms: &[Chosen]) -> Vec<f64> {
        let (columns, strengths) = self.strengths(terms);
        self.equations.left(&columns, &strengths)
    }

    /// Whether two options are different effects at the one coordinate that both act on.
    fn is_pair(&self, a: usize, b: usize) -> bool {
        let candidate = |option: usize| self.options[option].candidate;
        let on = |option: usize| self.dictionary.candidates[candidate(option)].subject.on();
        candidate(a) != candidate(b) && on(a).len() == 1 && on(a) == on(b)
    }

    /// Without a term or one of its strengths.
    fn with_less(&self, state: &State) -> Option<State> {
        let trials = less(&state.terms).into_par_iter();
        self.best(trials.map(|terms| self.state(terms)), state.cost)
    }

    /// Without the term, or the strength, that predicts least of what it was not fitted to, if
    /// that is next to nothing.
    fn without_chance(&self, state: &State) -> Option<State> {
        let held_out = |terms: &[Chosen]| self.equations.held_out(&self.gram, &self.columns(terms));
        let whole = held_out(&state.terms);
        let trials = less(&state.terms).into_par_iter();
        let trials = trials.map(|terms| (held_out(&terms), terms));
        let mut idle: Vec<(f64, Vec<Chosen>)> = trials
            .filter(|(left, _)| !is_enough(left, &whole))
            .map(|(left, terms)| (left.iter().sum(), terms))
            .collect();
        idle.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (_, terms) = idle.into_iter().next()?;
        Some(self.state(terms))
    }

    /// With a rich effect that does not need all of itself in two simple ones, if these
    /// explain as much.
    fn simpler(&self, state: &State) -> Option<State> {
        let rich = |term: &&Chosen| term.kept.len() < self.options[term.option].columns.len();
        state.terms.iter().filter(rich).find_map(|term| {
            let others: Vec<Chosen> = state.terms.iter().filter(|t| *t != term).cloned().collect();
            let on = |option: usize| {
                self.dictionary.candidates[self.options[option].candidate]
                    .subject
                    .on()
            };
            let simple = |&option: &usize| {
                let taken =
                    |t: &Chosen| self.options[t.option].candidate == self.options[option].candidate;
                self.options[option].columns.len() == 1
                    && on(option) == on(term.option)
                    && !state.terms.iter().any(taken)
            };
            let simple: Vec<usize> = (0..self.options.len()).filter(simple).collect();
            let mut steads: Vec<Vec<usize>> = simple.iter().map(|&option| vec![option]).collect();
            for (index, &a) in simple.iter().enumerate() {
                let partners = simple[index + 1..].iter().filter(|&&b| self.is_pair(a, b));
                steads.extend(partners.map(|&b| vec![a, b]));
            }
            let fits = |stead: &Vec<usize>| stead.len() <= term.kept.len();
            let trials = steads.into_par_iter().filter(fits).filter_map(|stead| {
                let terms = self.possible(&others, &stead)?;
                let whole = terms.len() == others.len() + stead.len();
                whole.then(|| self.state(terms))
            });
            // Two names for what one says do not cost more.
            self.best(trials, f64::INFINITY)
                .filter(|simpler| simpler.left < state.left + TIE)
        })
    }

    fn with_one_other(&self, state: &State, reach: usize) -> Option<State> {
        let options = self.within(reach);
        let pairs = (0..state.terms.len())
            .into_par_iter()
            .flat_map(|index| options.par_iter().map(move |&option| (index, option)));
        let trials = pairs.filter_map(|(index, option)| {
            let mut others = state.terms.clone();
            let own = others.remove(index);
            let candidate = |option: usize| self.options[option].candidate;
            let taken = |term: &Chosen| candidate(term.option) == candidate(option);
            if own.option == option || others.iter().any(taken) {
                return None;
            }
            self.possible(&others, &[option])
        });
        self.best(trials.map(|terms| self.state(terms)), state.cost - MARGIN)
    }

    /// With one law in the place of two on the same coordinates: what was chosen beside something else may need
    /// neither.
    fn with_one_for_two(&self, state: &State, reach: usize) -> Option<State> {
        let on = |option: usize| {
            let candidate = self.options[option].candidate;
            self.dictionary.candidates[candidate].subject.on()
        };
        let terms = &state.terms;
        let after = |a: usize| (a + 1..terms.len()).map(move |b| (a, b));
        let pairs = (0..terms.len()).flat_map(after);
        let pairs = pairs.filter(|&(a, b)| on(terms[a].option) == on(terms[b].option));
        let options = self.within(reach);
        let trials = pairs.flat_map(|(a, b)| {
            let place = on(terms[a].option);
            let options = options.iter().copied();
            let there = options.filter(move |&option| on(option) == place);
            there.map(move |option| (a, b, option))
        });
        let trials: Vec<(usize, usize, usize)> = trials.collect();
        let trials = trials.into_par_iter().filter_map(|(a, b, option)| {
            let mut others = terms.clone();
            others.remove(b);
            others.remove(a);
            let candidate = |option: usize| self.options[option].candidate;
            let taken = |term: &Chosen| candidate(term.option) == candidate(option);
            let is_free = !others.iter().any(taken);
            is_free.then(|| self.possible(&others, &[option]))?
        });
        self.best(trials.map(|terms| self.state(terms)), state.cost)
    }

    /// The terms with some options more, of all those columns whose strengths nature allows;
    /// `None` if nothing is left of one of them.
    fn possible(&self, terms: &[Chosen], more: &[usize]) -> Option<Vec<Chosen>> {
        let mut with = terms.to_vec();
        for &option in more {
            let own = self.options[option].candidate;
            let is_one_law = |term: &Chosen| {
                let other = self.options[term.option].candidate;
                self.dictionary.nested.are_one(own, other)
            };
            if with.iter().any(is_one_law) {
                return None;
            }
            let columns = &self.options[option].columns;
            let visible = |&i: &usize| self.visible[columns[i]];
            let kept: Vec<usize> = (0..columns.len()).filter(visible).collect();
            with.push(Chosen { option, kept });
        }
        loop {
            with.retain(|term| !term.kept.is_empty());
            let present = |option: &usize| with.iter().any(|term| term.option == *option);
            if !more.iter().all(present) {
                return None;
            }
            let (_, strengths) = self.strengths(&with);
            let mut next = strengths.into_iter();
            let mut wrong = Vec::new();
            for (index, term) in with.iter().enumerate() {
                let candidate = self.options[term.option].candidate;
                let own = &self.dictionary.candidates[candidate].strengths;
                for (position, &i) in term.kept.iter().enumerate() {
                    let step = next.next().unwrap_or(f64::NAN);
                    if !self.is_possible(own[i], step) {
                        wrong.push((index, position));
                    }
                }
            }
            // What is new gives way first.
            let Some(&(index, position)) = wrong.last() else {
                return (!self.is_the_same(terms, &with[with.len() - more.len()..]))
                    .then_some(with);
            };
            with[index].kept.remove(position);
        }
    }

    /// Whether a new term says little that another does not say at the same place.
    fn is_the_same(&self, terms: &[Chosen], new: &[Chosen]) -> bool {
        let on = |term: &Chosen| {
            let candidate = self.options[term.option].candidate;
            self.dictionary.candidates[candidate].subject.on()
        };
        new.iter().any(|term| {
            let there: Vec<Chosen> = terms
                .iter()
                .filter(|t| on(t) == on(term))
                .cloned()
                .collect();
            let known = self.columns(&there);
            let own: Vec<usize> = self.own_columns(term).collect();
            let explained = |&column: &usize| self.gram.explained_by(column, &known);
            own.iter().all(|column| explained(column) > THE_SAME)
        })
    }

    fn is_possible(&self, parameter: usize, step: f64) -> bool {
        let value = self.dictionary.defaults[parameter] + step;
        let bounds = &self.dictionary.machine.compiled.model.parameters[parameter];
        value >= bounds.lower && value <= bounds.upper
    }
}

/// Whether squares fall far enough in some coordinate.
fn is_enough(before: &[f64], after: &[f64]) -> bool {
    let mut pairs = before.iter().zip(after);
    pairs.any(|(before, after)| *after < (1.0 - LEAST_REMOVED) * before)
}

/// The terms without one of them, or without one strength of one.
fn less(terms: &[Chosen]) -> Vec<Vec<Chosen>> {
    let without = |index: usize, part: Option<usize>| {
        let mut fewer = terms.to_vec();
        match part {
            Some(position) => drop(fewer[index].kept.remove(position)),
            None => drop(fewer.remove(index)),
        }
        fewer
    };
    let all = terms.iter().enumerate().flat_map(|(index, term)| {
        let several = term.kept.len() > 1;
        let strengths = (0..term.kept.len()).filter(move |_| several).map(Some);
        let parts = strengths.chain([None]);
        parts.map(move |part| without(index, part))
    });
    all.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::forces::balance::Balance;
    use crate::trace::forces::reach::reaches;
    use crate::trace::forces::{columns, first_columns, force_options, weighed};
    use crate::trace::wheel::{WHEEL, begun, named, turned};

    /// What was chosen beside something else that is gone now needs neither of two laws.
    #[test]
    fn one_law_takes_the_place_of_two() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-6), |[_, v, a]| {
            0.02 * a + 0.01 * v
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let observed = &start.observed;
        let balance = Balance::narrowed(&observed.record, observed.hold, 1).unwrap();
        let missing = balance.missing(&dictionary.machine, &dictionary.defaults);
        let columns = columns(&dictionary, &balance).unwrap();
        let options = force_options(&dictionary);
        let first = first_columns(&options);
        let equations = weighed(Equations::new(&missing.unwrap(), &columns), &first);
        let choice = Choice {
            dictionary: &dictionary,
            options: &options,
            gram: equations.gram(),
            visible: equations.visible(),
            equations: &equations,
            reaches: reaches(&dictionary),
        };
        let option = |name: &str| {
            let candidate = named(&dictionary, name);
            options.iter().position(|o| o.candidate == candidate)
        };
        let two = ["coulomb(angle)", "quadratic_drag(angle)"].map(|name| option(name).unwrap());
        let two = choice.state(choice.possible(&[], &two).unwrap());
        assert_eq!(two.terms.len(), 2);
        let one = choice.with_one_for_two(&two, REACHES - 1).unwrap();
        let viscous = [named(&dictionary, "viscous(angle)")];
        assert_eq!(choice.candidates(&one.terms), viscous);
        assert!(choice.with_one_for_two(&one, REACHES - 1).is_none());
    }
}
