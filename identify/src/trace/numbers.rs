//! What a log says where all numbers of a model's robot description may be wrong.

use super::described::opened;
use super::dictionary::{Dictionary, Source};
use super::learn::{Learner, Learnt};
use super::outcome::Basis;
use super::progress::Stage;
use super::search::Task;
use super::selection::Selection;
use super::settings::MAX_TERMS;
use super::slow_errors::Inquiries;
use std::cell::OnceCell;

/// The numbers of a robot description, and what was found of them. They are asked alone at first: beside all effects
/// they are dear. That none of them shows is no answer: the model as given is asked before.
pub(super) struct Numbers<'a> {
    learner: &'a Learner<'a>,
    /// All of them, once they are asked; none where the model has names of its own like theirs.
    dictionary: &'a OnceCell<Option<Dictionary>>,
    alone: Option<Inquiries<'a>>,
}

impl<'a> Numbers<'a> {
    /// Those of a learner's model; nothing is asked yet.
    pub fn new(learner: &'a Learner<'a>, dictionary: &'a OnceCell<Option<Dictionary>>) -> Self {
        Self {
            learner,
            dictionary,
            alone: None,
        }
    }

    /// At most so many numbers that leave no forces, neither in the part of the log that is searched first nor in the
    /// whole.
    pub fn that_leave_nothing(&mut self, at_most: usize) -> Option<Learnt> {
        self.without_forces(Selection::leaves_nothing, at_most)
    }

    /// So many numbers that are a better explanation than another, because they are fewer or leave much less; than one
    /// that leaves nothing, because they are fewer.
    pub fn better_than(&mut self, known: &Selection, at_most: usize) -> Option<Learnt> {
        if !known.forces_remain() {
            let fewer = known.terms.len().saturating_sub(1);
            let is_better = |other: &Selection| other.explains_with_less(known);
            return self.without_forces(is_better, fewer.min(at_most));
        }
        let text = opened(self.learner.source.text)?;
        let is_better =
            |other: &Selection| other.explains_with_less(known) || other.leaves_much_less(known);
        self.beside_effects(&text, is_better, at_most)
    }

    /// What is better, if at most so many of them leave no forces in the part of the log that is searched first.
    fn without_forces(
        &mut self,
        is_better: impl Fn(&Selection) -> bool,
        at_most: usize,
    ) -> Option<Learnt> {
        let text = opened(self.learner.source.text)?;
        let alone = self.alone(&text)?;
        if alone.leaves_forces_at_first(at_most).ok()? {
            return None;
        }
        self.beside_effects(&text, is_better, at_most)
    }

    /// The search in which they are asked alone, in a model whose `text` has them open.
    fn alone(&mut self, text: &str) -> Option<&mut Inquiries<'a>> {
        let learner = self.learner;
        let derived = || {
            learner.progress.enter(Stage::Derive, &[]);
            Dictionary::of_parameters(&self.source(text), learner.ranges).ok()
        };
        let dictionary = self.dictionary.get_or_init(derived).as_ref()?;
        let task = Task {
            only_with_terms: true,
            ..learner.task(dictionary)
        };
        let new = || Inquiries::new(task, learner.felt.clone(), &learner.given);
        Some(self.alone.get_or_insert_with(new))
    }

    /// What is found of them beside all effects, if they are better both alone and so.
    fn beside_effects(
        &mut self,
        text: &str,
        is_better: impl Fn(&Selection) -> bool,
        at_most: usize,
    ) -> Option<Learnt> {
        let alone = self.alone(text)?.ask(at_most, None).ok()?;
        if alone.terms.is_empty() || !is_better(&alone) {
            return None;
        }
        let dictionary = Dictionary::new(&self.source(text), self.learner.ranges).ok()?;
        let at_most = match alone.leaves_nothing() {
            true => at_most,
            false => MAX_TERMS,
        };
        let selection = self.learner.motion(&dictionary).ask(at_most, None).ok()?;
        is_better(&selection).then_some(Learnt {
            dictionary,
            selection,
            basis: Basis::Motion,
        })
    }

    /// The learner's model with this text.
    fn source<'b>(&self, text: &'b str) -> Source<'b>
    where
        'a: 'b,
    {
        Source {
            text,
            ..self.learner.source
        }
    }
}
