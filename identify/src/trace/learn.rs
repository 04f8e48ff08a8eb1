//! What the log to learn from says: in its motion, in the balance of its forces, and of the
//! numbers of a robot description.

use super::between_samples::is_hidden;
use super::candidate::Candidate;
use super::described::opened;
use super::dictionary::{Dictionary, Ranges, Source};
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::{Verdict, verdict};
use super::forces;
use super::judge::trained;
use super::numbers::Numbers;
use super::outcome::Basis;
use super::progress::Progress;
use super::search::{Given, Task, is_on_a_body};
use super::selection::{Selection, Term};
use super::settings::{GLANCE, MAX_TERMS, NEARLY_NOTHING, NO_EXCESS};
use super::slow_errors::Inquiries;
use super::subject::Subject;
use crate::machine::SolveError;
use std::cell::OnceCell;

/// More terms than this are looked for after as few numbers of a description: one wrong length looks like many effects.
const FEW_TERMS: usize = 2;

/// Fewer findings than this are better looked for in the motion, which is known more exactly, as
/// long as they explain it.
const MANY: usize = 5;

/// In a band narrower than that in which the log shows accelerations forces say less of what is missing than the
/// motion does: what they say counts for more where it brings predictions to this share of their errors (no unit), and
/// wherever only a part of the motion was asked. With 1, damping that depends on the position was called plain friction.
const CLEARLY: f64 = 0.5;

/// What was selected, and out of what.
pub(super) struct Learnt {
    /// Everything that might have been missing.
    pub dictionary: Dictionary,
    /// What is.
    pub selection: Selection,
    /// What it was found in.
    pub basis: Basis,
}

/// In what the log was explained.
enum Explained {
    /// Terms of the model as given.
    AsGiven(Basis, Box<Selection>),
    /// Numbers of its robot description.
    Described(Box<Learnt>),
}

impl Explained {
    fn by_forces(forces: Selection) -> Self {
        Self::AsGiven(Basis::Forces, Box::new(forces))
    }

    fn by_motion(motion: Selection) -> Self {
        Self::AsGiven(Basis::Motion, Box::new(motion))
    }
}

/// How a log is looked at.
pub(super) struct Learner<'a> {
    /// The model.
    pub source: Source<'a>,
    /// The log.
    pub observed: &'a Observed,
    /// The log with inputs as the machine felt them.
    pub felt: &'a Observed,
    /// Where it goes.
    pub ranges: &'a Ranges,
    /// How long predictions run that are compared, s.
    pub horizon: f64,
    /// The model as given, once it was fitted to the log as it was felt and read.
    pub given: Given,
    /// Whether the log is to say what inputs do between samples.
    pub free_hold: bool,
    /// Seed of everything random.
    pub seed: u64,
    /// Who is told how far the work is.
    pub progress: &'a dyn Progress,
}

impl Learner<'_> {
    /// Selects out of `dictionary`, which is that of the model as given.
    ///
    /// # Errors
    /// If the log cannot be smoothed, or the equation of motion has no solution along it.
    pub fn learn(&self, dictionary: Dictionary) -> Result<Learnt, TraceError> {
        let mut learnt = self.searched(dictionary)?;
        (learnt.selection).keep_losses_possible(&learnt.dictionary);
        Ok(learnt)
    }

    /// The same with losses as the log says, which may be less than none.
    fn searched(&self, dictionary: Dictionary) -> Result<Learnt, TraceError> {
        let located = |source| TraceError::at(source, &self.observed.record.t);
        let immobile = is_immobile(&dictionary, self.observed);
        // Smoothed inputs leave errors that follow one another: noise is known here, and not taken off.
        let logged = Observed {
            input_noise: self.felt.input_noise.clone(),
            ..self.observed.clone()
        };
        let numbers = OnceCell::new();
        let mut numbers = Numbers::new(self, &numbers);
        let by_forces = forces::learn(&dictionary, &logged, self.seed)?;
        let explained = match by_forces {
            Some(forces) if immobile => Explained::by_forces(forces),
            Some(forces) if forces.terms.len() >= MANY => {
                self.by_many_forces(&dictionary, forces, &mut numbers)
            }
            few => {
                let explained = self.by_motion_or_few_forces(&dictionary, few, &mut numbers);
                explained.map_err(located)?
            }
        };
        let (basis, selection) = match explained {
            Explained::AsGiven(basis, selection) => (basis, *selection),
            Explained::Described(learnt) => return Ok(*learnt),
        };
        // What effects do not explain, or several only together, may be one number of the description.
        let is_settled = match basis {
            Basis::Forces => self.is_settled(&dictionary, &selection),
            _ => is_plain(&dictionary, &selection) && !selection.forces_remain(),
        };
        let seen = (&selection.observed.record, &selection.values[..]);
        let findings = selection.terms.iter();
        let findings = findings.filter(|term| !is_hidden(&dictionary, term, seen));
        let is_suspicious = !is_settled && (selection.forces_remain() || findings.count() > 1);
        let described = match is_suspicious && !immobile && !self.is_over() {
            true => {
                let at_most = match selection.terms.len() >= MANY {
                    true => FEW_TERMS,
                    false => MAX_TERMS,
                };
                numbers.better_than(&selection, at_most)
            }
            false => None,
        };
        Ok(described.unwrap_or(Learnt {
            dictionary,
            selection,
            basis,
        }))
    }

    fn is_over(&self) -> bool {
        self.progress.ended().is_some()
    }

    /// Whether what was found in forces leaves less of them than what was found in motion, and
    /// foretells the motion better, too. A drive that holds a machine to its way exerts against every
    /// force that no model holds: then inputs are what errs, and not the motion that follows from them. So
    /// they do where their columns carry noise.
    /// Where nothing drives a coordinate there is nothing of that kind, and a part without mass would
    /// leave its forces in perfect balance. Predictions are nearer whose errors are less than this `share` of the others'.
    /// Where time is over before the motion has a name for what is missing, that which forces have stands.
    fn is_nearer(
        &self,
        dictionary: &Dictionary,
        forces: &Selection,
        motion: &Selection,
        share: f64,
    ) -> bool {
        if self.is_over() && is_named(dictionary, forces) && !is_named(dictionary, motion) {
            return true;
        }
        if !motion.forces_remain() && self.felt.noisy_inputs().next().is_none() {
            return false;
        }
        let logged = &self.observed.record.u;
        let seen = (&logged[..], forces.narrowing);
        let left = |selection: &Selection| forces::left(dictionary, selection, seen).ok();
        let leaves_less = || {
            let pair = left(forces).zip(left(motion));
            pair.is_some_and(|(forces, motion)| forces < motion)
        };
        let share = match forces.narrowing {
            1 => share,
            _ => CLEARLY * share,
        };
        let foretells = || {
            let of = |selection: &Selection| {
                let terms = selection.accepted();
                self.errors(dictionary, (&terms, &selection.values), &forces.observed)
            };
            of(forces).zip(of(motion)).is_some_and(|(forces, motion)| {
                forces[0] < motion[0] && forces[1] < share * motion[1]
            })
        };
        is_driven(dictionary, &forces.observed) && leaves_less() && foretells()
    }

    /// A selection beside all of the log to learn from, where it is of a part alone: of that which is searched first,
    /// or where time was over.
    fn in_all(&self, selection: &Selection) -> Selection {
        let mut selection = selection.clone();
        if selection.observed.record.len() != self.felt.record.len() {
            selection.observed = self.felt.clone();
        }
        selection
    }

    /// Errors of accelerations and of predictions along the log to learn from.
    fn errors(
        &self,
        dictionary: &Dictionary,
        (terms, values): (&[usize], &[f64]),
        observed: &Observed,
    ) -> Option<[f64; 2]> {
        let score = trained(dictionary, (terms, values, observed), self.horizon).ok()?;
        Some([score.acceleration.total, score.rollout.errors.total])
    }

    /// Whether many findings of a narrower band foretell the motion clearly better than the model as given: what
    /// shakes there keeps the motion from saying so itself, however long it is asked.
    fn foretells_clearly(&self, dictionary: &Dictionary, forces: &Selection) -> bool {
        if forces.narrowing == 1 {
            return false;
        }
        let of = |terms: &[usize], values: &[f64]| {
            self.errors(dictionary, (terms, values), &forces.observed)
        };
        let found = of(&forces.accepted(), &forces.values);
        let pair = found.zip(of(&[], &dictionary.defaults));
        pair.is_some_and(|(found, given)| {
            (0..2).all(|measure| found[measure] < CLEARLY * given[measure])
        })
    }

    /// What many findings in the balance of forces come to in the motion, which knows their values more exactly and
    /// needs fewer of them, where they are plain there, each with its name, and leave nothing: that is asked in a few
    /// fits. Or else themselves, where they are plain, and what a search says otherwise.
    fn by_many_forces(
        &self,
        dictionary: &Dictionary,
        forces: Selection,
        numbers: &mut Numbers<'_>,
    ) -> Explained {
        let confirmed = self.motion(dictionary).confirmed(&forces).ok().flatten();
        let says_all = |motion: &Selection| !motion.forces_remain() && is_named(dictionary, motion);
        match confirmed.filter(says_all) {
            Some(motion) if is_plain(dictionary, &motion) => Explained::by_motion(motion),
            _ if self.is_settled(dictionary, &forces) => Explained::by_forces(forces),
            _ => self.by_motion_or_many_forces(dictionary, forces, numbers),
        }
    }

    /// Whether nothing is to be asked beside plain findings: they leave nearly nothing, or hardly more than everything
    /// together leaves where the columns of inputs carry noise, which is the rest.
    fn is_settled(&self, dictionary: &Dictionary, forces: &Selection) -> bool {
        let is_noise =
            || self.felt.noisy_inputs().next().is_some() && forces.reduced_misfit < NO_EXCESS;
        is_plain(dictionary, forces) && (leaves_nearly_nothing(forces) || is_noise())
    }

    /// What explains the motion up to sensor noise where the balance of forces says that a lot is missing, or else what
    /// that balance says. One sensor that misreads, or one length that is wrong, makes forces everywhere: a few terms
    /// that explain the motion are right. What the balance leaves a lot of beside all that it says, it has not found:
    /// from there the motion goes on, unless that is so much that it would take longer than anyone waits, or foretells
    /// the motion clearly better already.
    fn by_motion_or_many_forces(
        &self,
        dictionary: &Dictionary,
        forces: Selection,
        numbers: &mut Numbers<'_>,
    ) -> Explained {
        let mut motion = self.motion(dictionary);
        match self.in_few_terms(&mut motion, numbers) {
            Ok(Explained::AsGiven(_, few)) if few.forces_remain() => {}
            Ok(explained) => return explained,
            Err(_) => {}
        }
        if self.is_over()
            || leaves_nearly_nothing(&forces)
            || forces.terms.len() >= MAX_TERMS
            || self.foretells_clearly(dictionary, &forces)
        {
            return Explained::by_forces(forces);
        }
        match motion.ask(MAX_TERMS, Some(&forces)) {
            Ok(all) if !all.forces_remain() => Explained::by_motion(all),
            _ => Explained::by_forces(forces),
        }
    }

    /// What the motion says, beginning with what the balance of forces does, or else what that balance says, where it is
    /// nearer to the log; where there is a robot description whose numbers are not open, in few terms first. Where the
    /// part of the motion that is searched first says clearly less than the balance of forces, and the noise of its
    /// sensors is not in question, the whole is not asked.
    fn by_motion_or_few_forces(
        &self,
        dictionary: &Dictionary,
        forces: Option<Selection>,
        numbers: &mut Numbers<'_>,
    ) -> Result<Explained, SolveError> {
        let nearer = |motion: &Selection, share: f64| {
            let forces = forces.as_ref()?;
            let is_nearer = self.is_nearer(dictionary, forces, &self.in_all(motion), share);
            is_nearer.then(|| Explained::by_forces(forces.clone()))
        };
        let mut motion = self.motion(dictionary);
        if opened(self.source.text).is_some() {
            match self.in_few_terms(&mut motion, numbers)? {
                Explained::AsGiven(_, few) if few.forces_remain() && !self.is_over() => {}
                Explained::AsGiven(_, few) => {
                    return Ok(nearer(&few, 1.0).unwrap_or(Explained::by_motion(*few)));
                }
                described @ Explained::Described(_) => return Ok(described),
            }
        }
        if forces.is_some()
            && let Some(part) = motion.settled_at_first(MAX_TERMS, forces.as_ref())?
            && let Some(explained) = nearer(&part, CLEARLY)
        {
            return Ok(explained);
        }
        let all = motion.ask(MAX_TERMS, forces.as_ref())?;
        Ok(nearer(&all, 1.0).unwrap_or(Explained::by_motion(all)))
    }

    /// What few terms of the motion say; where they leave forces in the part that is searched first, few numbers of a
    /// robot description in their place that leave none. One wrong length looks like many effects, and like slow errors
    /// of many sensors, which are dear to ask.
    fn in_few_terms(
        &self,
        motion: &mut Inquiries<'_>,
        numbers: &mut Numbers<'_>,
    ) -> Result<Explained, SolveError> {
        if motion.leaves_forces_at_first(FEW_TERMS)?
            && !self.is_over()
            && let Some(described) = numbers.that_leave_nothing(FEW_TERMS)
        {
            return Ok(Explained::Described(Box::new(described)));
        }
        let few = motion.ask(FEW_TERMS, None)?;
        Ok(Explained::by_motion(few))
    }

    /// A search in the motion, as the machine felt its inputs.
    pub fn motion<'b>(&'b self, dictionary: &'b Dictionary) -> Inquiries<'b> {
        Inquiries::new(self.task(dictionary), self.felt.clone(), &self.given)
    }

    /// What is searched for.
    pub fn task<'b>(&'b self, dictionary: &'b Dictionary) -> Task<'b> {
        Task {
            dictionary,
            free_hold: self.free_hold,
            only_with_terms: false,
            progress: self.progress,
        }
    }
}

/// Whether many findings are what real drives have, friction and rotors, with one load at most: neither a sensor nor a
/// description that is wrong looks like that.
fn is_plain(dictionary: &Dictionary, forces: &Selection) -> bool {
    let is_load = |term: &&Term| {
        let Candidate {
            subject, is_loss, ..
        } = &dictionary.candidates[term.candidate];
        let is_value = matches!(subject, Subject::Parameter(_)) && !is_loss;
        is_value || is_on_a_body(dictionary, subject)
    };
    forces.terms.len() >= MANY && forces.terms.iter().filter(is_load).count() <= 1
}

/// Whether something was found, of which each has what gives it its name.
fn is_named(dictionary: &Dictionary, selection: &Selection) -> bool {
    !matches!(
        verdict(dictionary, selection, false),
        Verdict::Unknown | Verdict::None
    )
}

/// Whether findings leave hardly any of what was missing before.
fn leaves_nearly_nothing(forces: &Selection) -> bool {
    let remaining = &forces.remaining;
    remaining.share_after < NEARLY_NOTHING * remaining.share_before
}

/// Whether inputs exert forces on each coordinate.
fn is_driven(dictionary: &Dictionary, observed: &Observed) -> bool {
    let states = observed.curve.spread(GLANCE);
    let terms = dictionary.machine.terms(&states, &dictionary.defaults);
    let is_driven = |i: usize| {
        let mut each = terms.iter();
        each.any(|terms| terms.input_matrix.row(i).iter().any(|b| *b != 0.0))
    };
    (0..dictionary.machine.coordinate_count()).all(is_driven)
}

/// Whether the model as given cannot be solved for accelerations along the log.
fn is_immobile(dictionary: &Dictionary, observed: &Observed) -> bool {
    let focus = dictionary.focus(&[]);
    let values = focus.values(&dictionary.defaults);
    let motion = focus.machine.motion(&observed.curve, &values);
    matches!(
        motion,
        Err(SolveError::Singular { .. } | SolveError::Indefinite { .. })
    )
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, rectangular, turned_for};
    use crate::log::Log;
    use crate::trace::{Ended, Progress, Request, Stage, Verdict, trace};
    use dynamics_codegen::Library;
    use std::cell::RefCell;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Time is over from the time on that it is asked for so often.
    #[derive(Debug)]
    struct Over {
        at: usize,
        asked: AtomicUsize,
    }

    impl Progress for Over {
        fn enter(&self, _: Stage, _: &[String]) {}

        fn notice(&self, _: &str) {}

        fn ended(&self) -> Option<Ended> {
            let asked = self.asked.fetch_add(1, Ordering::Relaxed);
            (asked >= self.at).then_some(Ended::TimeLimit)
        }
    }

    /// Wherever a search ends, it has an answer, though what is measured as a force was looked at in all of a long log
    /// and the motion only in a part: a wheel with dry friction, whose torque is noisy. What its forces have named stands
    /// until the motion has a name, too.
    #[test]
    fn a_search_may_end_anywhere() {
        let noise = RefCell::new(rectangular(5));
        let torque = |[_, v, a]: [f64; 3]| {
            let noise = 4e-3 * (noise.borrow_mut())();
            0.02 * a + 0.05 * (v / 0.03).tanh() + noise
        };
        let text = turned_for(2600, [(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), torque);
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        let library = Library::builtin();
        let mut at = 0;
        loop {
            let progress = Over {
                at,
                asked: AtomicUsize::new(0),
            };
            let request = Request {
                progress: &progress,
                ..Request::new("wheel", WHEEL, &library, &log)
            };
            let outcome = trace(&request).unwrap();
            let is_done = progress.asked.load(Ordering::Relaxed) <= at;
            assert_eq!(outcome.unfinished.is_some(), !is_done);
            assert_eq!(outcome.verdict, Verdict::Effect, "{at}: {outcome:#?}");
            if is_done {
                break;
            }
            at += 1 + at / 2;
        }
    }
}
