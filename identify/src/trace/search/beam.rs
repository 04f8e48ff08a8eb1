//! The search: from the best hypothesis to its neighbours, until none of them is better.

use super::Task;
use super::explored::Explored;
use super::fit::{Fitted, bar, by_score, fit, fit_with, given_with, sharpened};
use super::hypothesis::Hypothesis;
use super::moves::merge::is_on_a_body;
use super::moves::{ALIKE, EXCHANGE, LEAP, MORE, Move, STEP};
use super::neighbourhood::Neighbourhood;
use super::placement::placed;
use super::proposal::Proposal;
use super::score::{is_expected, structure};
use super::standing::is_outdone;
use crate::machine::{SolveError, States};
use crate::regression::Hold;
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::linearised::first_noise;
use crate::trace::progress::{Progress, Stage};
use crate::trace::refine::{Effort, Explanation};
use crate::trace::screen::Considered;
use crate::trace::selection::Selection;
use crate::trace::settings::{BEAM, KEPT, MARGIN, NEAR_MISS, SAME_FIT, SHORTLISTED, TIE};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// What to do next, and with which hypothesis.
enum Next {
    /// All moves, as far as one leads on.
    Expand(Arc<Fitted>),
    /// The leaps alone.
    Leap(Arc<Fitted>),
}

/// A search in a part of a log.
#[derive(Clone)]
pub struct Search<'a> {
    /// What may be there.
    pub dictionary: &'a Dictionary,
    /// Who is told how far it is.
    pub progress: &'a dyn Progress,
    /// Whether the log says what inputs do between samples.
    pub free_hold: bool,
    /// Hypotheses of so many terms are not gone on from.
    pub at_most: usize,
    /// The model as given, under each assumption about inputs that is open.
    pub given: Vec<Arc<Fitted>>,
    /// Everything that was fitted.
    pub explored: Explored,
    /// What each candidate is worth beside the model as given.
    pub fresh: Arc<[Considered]>,
    /// Which hypotheses were expanded.
    expanded: BTreeSet<Hypothesis>,
    /// From which ones leaps were tried.
    leapt: BTreeSet<Hypothesis>,
    /// Whether a term was left out that had lost what gives it its name.
    pub left_out_nameless: bool,
    /// Whether nothing is left to look into.
    is_done: bool,
    /// Whether only the best hypothesis is gone on from, and by single steps.
    by_steps: bool,
}

impl<'a> Search<'a> {
    /// Begins with the model as given, under each assumption about inputs that is open; hypotheses of `at_most` terms
    /// are not gone on from.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn begin(task: Task<'a>, observed: &Observed, at_most: usize) -> Result<Self, SolveError> {
        let (dictionary, free_hold) = (task.dictionary, task.free_hold);
        let noise = first_noise(&dictionary.focus(&[]), observed, &dictionary.defaults)?;
        let other = Hypothesis::nothing(observed.hold).held_otherwise().hold;
        let is_open = free_hold && !observed.record.u.is_empty();
        let holds: &[Hold] = if is_open {
            &[observed.hold, other]
        } else {
            &[observed.hold]
        };
        let mut given = Vec::new();
        for &hold in holds {
            if task.progress.ended().is_some() && !given.is_empty() {
                break;
            }
            let fitted = given_with(dictionary, observed, (hold, Effort::FULL), &noise)?;
            given.push(Arc::new(fitted));
        }
        Ok(Self::from_given(task, at_most, given))
    }

    /// Begins with the model as given as it was fitted, under each assumption about inputs that is open.
    pub fn from_given(task: Task<'a>, at_most: usize, given: Vec<Arc<Fitted>>) -> Self {
        let mut explored = Explored::default();
        for given in &given {
            explored.add(task.dictionary, Arc::clone(given));
        }
        Self {
            dictionary: task.dictionary,
            progress: task.progress,
            free_hold: task.free_hold,
            at_most,
            given,
            explored,
            fresh: Arc::default(),
            expanded: BTreeSet::new(),
            leapt: BTreeSet::new(),
            left_out_nameless: false,
            is_done: false,
            by_steps: false,
        }
    }

    /// The same task once more.
    fn task(&self, free_hold: bool) -> Task<'a> {
        Task {
            dictionary: self.dictionary,
            free_hold,
            only_with_terms: false,
            progress: self.progress,
        }
    }

    /// Fits what the balance of forces says before anything else, under each assumption about inputs.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn try_suggested(&mut self, suggested: Option<&Selection>) -> Result<(), SolveError> {
        let Some(suggested) = suggested else {
            return Ok(());
        };
        let suggested = (suggested.accepted(), suggested.values.clone());
        self.try_first(&[suggested], self.given.clone())
    }

    /// The same without a look at anything else.
    pub fn try_terms(&mut self, suggested: &Selection) {
        self.enter(Stage::Fit);
        for given in self.given.clone() {
            let proposal = Proposal::first(&given, &suggested.accepted(), &suggested.values);
            self.try_all(&given, vec![proposal]);
        }
    }

    /// Fits what makes positions fulfil constraints that are grossly missed as they were measured: along
    /// such a log first order says little of anything else. The fits begin with the `curve` as it was measured:
    /// the model as given has bent its own until it closes.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn try_closing(
        &mut self,
        closing: Vec<(usize, Vec<f64>)>,
        curve: &States,
    ) -> Result<(), SolveError> {
        if closing.is_empty() {
            return Ok(());
        }
        let closing = closing.into_iter().take(SHORTLISTED);
        let closing: Vec<_> = closing.map(|(term, values)| (vec![term], values)).collect();
        let mut given = self.given.clone();
        for given in &mut given {
            let measured = &mut Arc::make_mut(given).explanation.observed.curve;
            measured.clone_from(curve);
        }
        self.try_first(&closing, given)
    }

    /// Fits terms, begun with values, before anything else, beside the model as `given` under each assumption about
    /// inputs.
    pub(super) fn try_first(
        &mut self,
        first: &[(Vec<usize>, Vec<f64>)],
        given: Vec<Arc<Fitted>>,
    ) -> Result<(), SolveError> {
        // What each candidate is worth by itself is known from here on, as of any search.
        if self.fresh.is_empty() {
            self.enter(Stage::Screen);
            let at = Neighbourhood::new(self.dictionary, &self.given[0], &[], self.free_hold)?;
            self.fresh = at.considered.into();
        }
        self.enter(Stage::Fit);
        for given in given {
            let proposals = first.iter();
            let proposals = proposals.map(|(terms, values)| Proposal::first(&given, terms, values));
            self.try_all(&given, proposals.collect());
        }
        Ok(())
    }

    /// The model as given beside the log of a hypothesis, with inputs as they are there.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn as_given(&self, of: &Fitted) -> Result<Fitted, SolveError> {
        let Explanation {
            observed, noise, ..
        } = &self.given[0].explanation;
        let hold = of.hypothesis.hold;
        given_with(self.dictionary, observed, (hold, Effort::FULL), noise)
    }

    /// A search in the same log, seen otherwise, begun with what this has found.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn again(self, seen: impl FnOnce(&mut Observed)) -> Result<Self, SolveError> {
        let found = Arc::clone(self.best());
        let mut observed = self.given[0].explanation.observed.clone();
        observed.hold = found.hypothesis.hold;
        seen(&mut observed);
        let mut search = Self::begin(self.task(self.free_hold), &observed, self.at_most)?;
        let likely = self.explored.kept().iter().map(|kept| Proposal {
            hypothesis: kept.hypothesis.clone(),
            values: kept.explanation.values.clone(),
            promise: kept.score,
            within_reach: f64::INFINITY,
            ahead: 0.0,
        });
        let from = search.as_given(&found)?;
        search.enter(Stage::Settle);
        search.try_all(&from, likely.collect());
        search.by_steps = true;
        Ok(search)
    }

    /// A search in the whole of a log whose part this has searched: from its answer, and from what
    /// the whole may say is as good.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn on_the_whole(self, whole: &Observed) -> Result<Self, SolveError> {
        let found = Arc::clone(self.best());
        let dictionary = self.dictionary;
        let mut observed = Observed {
            hold: found.hypothesis.hold,
            ..whole.clone()
        };
        // What the part was seen to lack, the whole lacks, too; and the least gap of a constraint would be another there.
        let holds_alike = |given: &&Arc<Fitted>| given.hypothesis.hold == observed.hold;
        let part = self.given.iter().find(holds_alike);
        let part = part.unwrap_or(&self.given[0]);
        let start = Explanation {
            observed: observed.clone(),
            ..part.explanation.clone()
        };
        let given = fit(dictionary, &Hypothesis::nothing(observed.hold), start)?;
        let given = Self::from_given(self.task(false), self.at_most, vec![Arc::new(given)]);
        self.enter(Stage::Settle);
        // A sensor that was found to misread has read another motion all along.
        let focus = dictionary.focus(found.hypothesis.candidates());
        observed.reread(&focus, &dictionary.defaults, &found.explanation.values);
        let start = Explanation {
            observed,
            ..found.explanation.clone()
        };
        let best = fit(dictionary, &found.hypothesis, start)?;
        let best = match self.is_over() {
            true => best,
            false => sharpened(dictionary, best, f64::INFINITY),
        };
        let best = Arc::new(best);
        let part = found.explanation.observed.record.len();
        let times = whole.record.len() as f64 / part as f64;
        let mut explored = self.explored.carried_over(&found, &best, times);
        let likely = explored.take_below(best.score + TIE);
        let mut search = Self {
            free_hold: self.free_hold,
            fresh: self.fresh,
            explored,
            ..given
        };
        for given in &search.given {
            search.explored.replace(dictionary, Arc::clone(given));
        }
        search.explored.replace(dictionary, Arc::clone(&best));
        // Forces too small to be worth a name are not looked into again; of others the whole may show
        // more than the part, one term at a time.
        search.is_done = !best.leaves_forces();
        search.by_steps = true;
        let likely = likely.into_iter().take(KEPT);
        let likely = likely.map(|(hypothesis, outline)| Proposal {
            hypothesis,
            values: outline.values,
            promise: outline.score,
            within_reach: f64::INFINITY,
            ahead: 0.0,
        });
        search.try_all(&best, likely.collect());
        Ok(search)
    }

    /// Goes on until no hypothesis is left that may lead on, or the time is over.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve of a hypothesis.
    pub fn run(&mut self) -> Result<(), SolveError> {
        while !self.is_over()
            && !self.is_done
            && let Some(next) = self.next()
        {
            match next {
                Next::Expand(from) => self.expand(&from)?,
                Next::Leap(from) => self.leap(&from)?,
            }
        }
        Ok(())
    }

    /// Whether the search is to end.
    pub fn is_over(&self) -> bool {
        self.progress.ended().is_some()
    }

    /// The best hypothesis so far.
    pub fn best(&self) -> &Arc<Fitted> {
        // The model as given is there from the beginning, and the best is never forgotten.
        &self.explored.kept()[0]
    }

    /// What to do next: with the best hypothesis, and where that is spent and the answer is not
    /// simple, from the model as given and from the next best ones.
    fn next(&self) -> Option<Next> {
        let kept = self.explored.kept();
        let best = self.best();
        let is_expanded = |fitted: &Arc<Fitted>| {
            let Fitted { hypothesis, .. } = fitted.as_ref();
            hypothesis.candidates().len() >= self.at_most || self.expanded.contains(hypothesis)
        };
        let mut as_good = kept.iter().filter(|k| k.score < best.score + SAME_FIT);
        if !as_good.any(is_expanded) {
            return Some(Next::Expand(Arc::clone(best)));
        }
        if self.by_steps {
            return None;
        }
        let forces_remain = best.leaves_forces();
        let stated = |&&term: &&usize| !is_expected(self.dictionary, term, &best.explanation);
        let terms = best.hypothesis.candidates().iter();
        let is_simple = !forces_remain && terms.filter(stated).count() < 2;
        let mut given = self.given.iter();
        if let Some(given) = given.find(|given| given.hypothesis.hold == best.hypothesis.hold) {
            // What was suggested may be hardly better than nothing, and others far better.
            if best.score > given.score - MARGIN && !is_expanded(given) {
                return Some(Next::Expand(Arc::clone(given)));
            }
            if !is_simple && !self.leapt.contains(&given.hypothesis) {
                return Some(Next::Leap(Arc::clone(given)));
            }
        }
        let others = || {
            kept.iter()
                .filter(|k| k.hypothesis.hold == best.hypothesis.hold)
        };
        if !forces_remain || others().filter(|k| is_expanded(k)).count() > BEAM {
            return None;
        }
        let next = others().find(|k| !is_expanded(k));
        next.map(|next| Next::Expand(Arc::clone(next)))
    }

    fn enter(&self, stage: Stage) {
        let subject = |&c: &usize| self.dictionary.candidates[c].subject.to_string();
        let found: Vec<String> = match self.explored.kept().first() {
            Some(best) => best.hypothesis.candidates().iter().map(subject).collect(),
            None => Vec::new(),
        };
        self.progress.enter(stage, &found);
    }

    /// Tries what leads on from a hypothesis; where nothing did, what questions its terms.
    fn expand(&mut self, from: &Fitted) -> Result<(), SolveError> {
        self.expanded.insert(from.hypothesis.clone());
        self.enter(Stage::Screen);
        let (dictionary, fresh) = (self.dictionary, Arc::clone(&self.fresh));
        let at = Neighbourhood::new(dictionary, from, &fresh, self.free_hold)?;
        if self.fresh.is_empty() {
            self.fresh = at.considered.clone().into();
        }
        let moves = if self.by_steps { MORE } else { STEP };
        self.try_moves(moves, &at, Stage::Fit);
        if self.by_steps {
            return Ok(());
        }
        if self.best().leaves_forces() {
            self.try_moves(ALIKE, &at, Stage::Fit);
        }
        if self.best().score < from.score {
            return Ok(());
        }
        if from.leaves_forces() {
            self.leapt.insert(from.hypothesis.clone());
            self.try_moves(LEAP, &at, Stage::Fit);
        }
        if self.best().score >= from.score && !at.terms().is_empty() {
            self.try_moves(EXCHANGE, &at, Stage::Question);
        }
        Ok(())
    }

    /// Tries what goes two steps at once from a hypothesis.
    fn leap(&mut self, from: &Fitted) -> Result<(), SolveError> {
        self.leapt.insert(from.hypothesis.clone());
        self.enter(Stage::Screen);
        let (dictionary, fresh) = (self.dictionary, Arc::clone(&self.fresh));
        let at = Neighbourhood::new(dictionary, from, &fresh, self.free_hold)?;
        self.try_moves(LEAP, &at, Stage::Fit);
        Ok(())
    }

    /// Tries what some moves propose.
    fn try_moves(&mut self, moves: &[&dyn Move], at: &Neighbourhood<'_>, stage: Stage) {
        let mut proposals = Vec::new();
        for one in moves {
            if !self.is_over() {
                proposals.extend(one.propose(at, &self.explored));
            }
        }
        if self.by_steps {
            proposals.truncate(BEAM);
        }
        self.enter(stage);
        self.try_all(at.fitted, proposals);
    }

    /// Fits what is new of some proposals: the most promising first, and the others as far as they
    /// may still come near the best. Those that come near it get another start each.
    pub fn try_all(&mut self, from: &Fitted, proposals: Vec<Proposal>) {
        let mut seen: Vec<&Hypothesis> = Vec::new();
        let mut new: Vec<&Proposal> = Vec::new();
        for proposal in &proposals {
            let known = self.explored.of(&proposal.hypothesis);
            let is_known = known.is_some_and(|known| known.cost < proposal.within_reach + SAME_FIT);
            let doubles = (self.dictionary.nested).doubles(proposal.hypothesis.candidates());
            if !is_known && !doubles && !seen.contains(&&proposal.hypothesis) {
                seen.push(&proposal.hypothesis);
                new.push(proposal);
            }
        }
        let mut tried = Vec::new();
        let (first, others) = new.split_at(new.len().min(1));
        for wave in [first, others] {
            if self.is_over() {
                break;
            }
            let known = self.best().score.min(
                tried
                    .iter()
                    .map(|fitted: &Fitted| fitted.score)
                    .fold(f64::INFINITY, f64::min),
            );
            let fitted = wave.par_iter().map(|proposal| {
                let hypothesis = &proposal.hypothesis;
                let effort = Effort {
                    bar: bar(known, structure(self.dictionary, hypothesis)),
                    ..Effort::FULL
                };
                let start = proposal.start(self.dictionary, from);
                // Under which the machine cannot move, it is no explanation.
                fit_with(self.dictionary, hypothesis, start, effort).ok()
            });
            let fitted: Vec<Option<Fitted>> = fitted.collect();
            for (proposal, fitted) in wave.iter().zip(fitted) {
                match fitted {
                    Some(fitted) => tried.push(fitted),
                    None => self.explored.rule_out(&proposal.hypothesis),
                }
            }
        }
        let improved = self.improved(from, tried).into_iter().map(Arc::new);
        let improved: Vec<Arc<Fitted>> = improved.collect();
        for fitted in &improved {
            self.explored.add(self.dictionary, Arc::clone(fitted));
        }
        // What is worth nothing beside another term has shown that one alone, which may not have been tried: it
        // promised less.
        for fitted in improved {
            if let Some(alone) = self.without_the_worthless(&fitted)
                && !self.is_over()
            {
                self.try_all(&fitted, vec![alone]);
            }
        }
    }

    /// Another chance for some fits that leave forces: less of them to begin with and another place
    /// on its body, where none of all leaves sensor noise alone and one comes near the best, or behind a special case
    /// of itself; another place, where one term stands for several.
    fn improved(&self, from: &Fitted, tried: Vec<Fitted>) -> Vec<Fitted> {
        if self.is_over() || self.by_steps {
            return tried;
        }
        let limit = self.near_miss(from, &tried);
        let may_be_outdone = limit > f64::NEG_INFINITY && from.leaves_forces();
        let cost = |of: &Hypothesis| {
            let known = self.explored.of(of).map(|known| known.cost);
            let new = tried.iter().find(|new| new.hypothesis == *of);
            let costs = known.into_iter().chain(new.map(|new| new.estimate.cost));
            costs.fold(f64::INFINITY, f64::min)
        };
        let is_near = |fitted: &Fitted| {
            fitted.score <= limit || may_be_outdone && is_outdone(self.dictionary, fitted, cost)
        };
        let near: Vec<bool> = tried.iter().map(is_near).collect();
        let size = |fitted: &Fitted| fitted.hypothesis.candidates().len();
        let improved = tried.into_par_iter().zip(near).map(|(fitted, is_near)| {
            if !fitted.leaves_forces() {
                return fitted;
            }
            if !is_near {
                return match size(&fitted) < size(from) {
                    true => self.replaced(from, fitted),
                    false => fitted,
                };
            }
            let structure = structure(self.dictionary, &fitted.hypothesis);
            let bar = bar(self.best().score, structure);
            let fitted = sharpened(self.dictionary, fitted, bar);
            self.replaced(from, fitted)
        });
        improved.collect()
    }

    /// The score up to which fits come near the best one, if that leaves forces.
    fn near_miss(&self, from: &Fitted, tried: &[Fitted]) -> f64 {
        let possible = |fitted: &&Fitted| fitted.is_possible(self.dictionary);
        let best = tried.iter().filter(possible).min_by(|a, b| by_score(a, b));
        let Some(best) = best.filter(|best| best.leaves_forces()) else {
            return f64::NEG_INFINITY;
        };
        // Beside a hypothesis that explains the log, what leaves forces needs no second chance.
        match best.score < from.score {
            true => {
                let most = from.score - best.score.min(self.best().score);
                from.score - NEAR_MISS * most
            }
            false if from.leaves_forces() => best.score,
            false => from.score,
        }
    }

    /// The fit with its new effect on a body at another place there, if that is better. One that the
    /// best hypothesis holds has found its place.
    fn replaced(&self, from: &Fitted, fitted: Fitted) -> Fitted {
        if !fitted.leaves_forces() {
            return fitted;
        }
        let known = [&from.hypothesis, &self.best().hypothesis];
        let terms = fitted.hypothesis.candidates().iter().copied();
        let mut new = terms.filter(|&term| {
            let subject = &self.dictionary.candidates[term].subject;
            let is_new = known.iter().all(|known| !known.contains(term));
            is_new && is_on_a_body(self.dictionary, subject)
        });
        let again = new.next().and_then(|term| {
            let start = placed(self.dictionary, &fitted, term)?;
            fit(self.dictionary, &fitted.hypothesis, start).ok()
        });
        match again {
            Some(again) if again.score < fitted.score => again,
            _ => fitted,
        }
    }
}
