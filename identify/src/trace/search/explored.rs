//! Every hypothesis that was fitted. None is fitted twice from the same start, and the best one
//! is never lost.

use super::fit::{Fitted, by_score};
use super::hypothesis::Hypothesis;
use crate::trace::dictionary::Dictionary;
use crate::trace::settings::KEPT;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is remembered of a hypothesis that was fitted.
#[derive(Debug, Clone)]
pub struct Outline {
    /// Nats, the less the better; infinite where the machine cannot move so.
    pub score: f64,
    /// Whether each of its terms does something, within what is possible.
    pub is_possible: bool,
    /// What of that is believed before the log is read, nats.
    pub prior: f64,
    /// Its negative log likelihood alone, nats.
    pub cost: f64,
    /// Values of all the dictionary's parameters.
    pub values: Vec<f64>,
}

/// What was explored.
#[derive(Debug, Clone, Default)]
pub struct Explored {
    known: BTreeMap<Hypothesis, Outline>,
    /// The best ones, best first.
    kept: Vec<Arc<Fitted>>,
}

impl Explored {
    /// Remembers a hypothesis, if it is better than what is known of it.
    pub fn add(&mut self, dictionary: &Dictionary, fitted: Arc<Fitted>) {
        let score = match fitted.score.is_finite() {
            true => fitted.score,
            false => f64::INFINITY,
        };
        let is_possible = fitted.is_possible(dictionary) && score.is_finite();
        let known = self.known.get(&fitted.hypothesis);
        let rank = |is_possible: bool, score: f64| (!is_possible, score);
        if known.is_some_and(|k| rank(k.is_possible, k.score) <= rank(is_possible, score)) {
            return;
        }
        let outline = Outline {
            score,
            is_possible,
            prior: fitted.prior,
            cost: fitted.estimate.cost,
            values: fitted.explanation.values.clone(),
        };
        self.known.insert(fitted.hypothesis.clone(), outline);
        if is_possible {
            self.kept
                .retain(|kept| kept.hypothesis != fitted.hypothesis);
            self.kept.push(fitted);
            self.kept.sort_by(|a, b| by_score(a, b));
            self.kept.truncate(KEPT);
        }
    }

    /// Remembers a hypothesis, whatever was known of it.
    pub fn replace(&mut self, dictionary: &Dictionary, fitted: Arc<Fitted>) {
        self.known.remove(&fitted.hypothesis);
        self.add(dictionary, fitted);
    }

    /// Remembers that a hypothesis cannot be.
    pub fn rule_out(&mut self, hypothesis: &Hypothesis) {
        let impossible = Outline {
            score: f64::INFINITY,
            is_possible: false,
            prior: 0.0,
            cost: f64::INFINITY,
            values: Vec::new(),
        };
        self.known.entry(hypothesis.clone()).or_insert(impossible);
    }

    /// Knows beside `best` of a log that is so many `times` as long what is known here beside
    /// `found`: so many times as well it tells hypotheses apart. Prices stay as they are.
    pub fn carried_over(&self, found: &Fitted, best: &Fitted, times: f64) -> Self {
        let known = self.known.iter().map(|(hypothesis, outline)| {
            let apart = outline.cost - found.estimate.cost;
            let price = outline.score - found.score - apart;
            let carried = Outline {
                score: match outline.score.is_finite() {
                    true => best.score + times * apart + price,
                    false => f64::INFINITY,
                },
                is_possible: outline.is_possible,
                prior: outline.prior,
                cost: best.estimate.cost + times * apart,
                values: outline.values.clone(),
            };
            (hypothesis.clone(), carried)
        });
        Self {
            known: known.collect(),
            kept: Vec::new(),
        }
    }

    /// Forgets all hypotheses that hold other terms than one does.
    pub fn keep_within(&mut self, hypothesis: &Hypothesis) {
        let is_within = |own: &Hypothesis| {
            let mut terms = own.candidates().iter();
            terms.all(|&term| hypothesis.contains(term))
        };
        self.known.retain(|own, _| is_within(own));
        self.kept.retain(|kept| is_within(&kept.hypothesis));
    }

    /// Takes out what is better than a score, best first.
    pub fn take_below(&mut self, score: f64) -> Vec<(Hypothesis, Outline)> {
        let mut taken = Vec::new();
        self.known.retain(|hypothesis, outline| {
            let is_below = outline.is_possible && outline.score < score;
            if is_below {
                taken.push((hypothesis.clone(), outline.clone()));
            }
            !is_below
        });
        taken.sort_by(|a, b| a.1.score.total_cmp(&b.1.score));
        taken
    }

    /// What is known of a hypothesis.
    pub fn of(&self, hypothesis: &Hypothesis) -> Option<&Outline> {
        self.known.get(hypothesis)
    }

    /// The best ones, best first.
    pub fn kept(&self) -> &[Arc<Fitted>] {
        &self.kept
    }

    /// All that were fitted.
    pub fn all(&self) -> impl Iterator<Item = (&Hypothesis, &Outline)> {
        self.known.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::search::fit::fit;
    use crate::trace::wheel::{WHEEL, begun, named};
    use std::fmt::Write;

    /// A wheel under 1.5 times the inertia that its model states.
    fn fitted() -> (Dictionary, Arc<Fitted>, Arc<Fitted>) {
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..400 {
            let t = 0.01 * f64::from(k);
            writeln!(text, "{t},{},{}", (5.0 * t).sin(), -0.75 * (5.0 * t).sin()).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let nothing = Hypothesis::nothing(Hold::Linear);
        let heavier = nothing.exchange(&[], &[named(&dictionary, "parameter(i)")]);
        let [nothing, heavier] =
            [nothing, heavier].map(|one| Arc::new(fit(&dictionary, &one, start.clone()).unwrap()));
        (dictionary, nothing, heavier)
    }

    /// What knows these.
    fn with(known: [&Arc<Fitted>; 2], dictionary: &Dictionary) -> Explored {
        let mut explored = Explored::default();
        for fitted in known {
            explored.add(dictionary, Arc::clone(fitted));
        }
        explored
    }

    #[test]
    fn the_best_fit_of_a_hypothesis_is_never_lost() {
        let (dictionary, nothing, heavier) = fitted();
        let mut explored = with([&heavier, &nothing], &dictionary);
        let worse = Fitted {
            score: heavier.score + 5.0,
            ..Fitted::clone(&heavier)
        };
        explored.add(&dictionary, Arc::new(worse));
        explored.rule_out(&heavier.hypothesis);
        assert_eq!(
            explored.of(&heavier.hypothesis).unwrap().score,
            heavier.score
        );
        assert_eq!(explored.kept()[0].hypothesis, heavier.hypothesis);
        assert_eq!(explored.kept().len(), 2);
    }

    #[test]
    fn what_holds_other_terms_is_forgotten() {
        let (dictionary, nothing, heavier) = fitted();
        let mut explored = with([&heavier, &nothing], &dictionary);
        explored.keep_within(&heavier.hypothesis);
        assert_eq!(explored.kept().len(), 2);
        explored.keep_within(&nothing.hypothesis);
        assert_eq!(explored.kept().len(), 1);
        assert!(explored.of(&heavier.hypothesis).is_none());
    }

    #[test]
    fn a_longer_log_tells_hypotheses_apart_better() {
        let (dictionary, nothing, heavier) = fitted();
        let explored = with([&heavier, &nothing], &dictionary);
        let mut whole = explored.carried_over(&heavier, &heavier, 3.0);
        let apart = |explored: &Explored| {
            let of = |one: &Fitted| explored.of(&one.hypothesis).unwrap().cost;
            of(&nothing) - of(&heavier)
        };
        assert!((apart(&whole) - 3.0 * apart(&explored)).abs() < 1e-6);
        let taken = whole.take_below(heavier.score + 1.0);
        assert_eq!(taken.len(), 1);
        assert_eq!(taken[0].0, heavier.hypothesis);
        assert!(whole.of(&heavier.hypothesis).is_none());
    }
}
