//! A search that can be asked more than once.

use super::answer::{self, Answer};
use super::beam::Search;
use super::fit::Fitted;
use super::{Task, discrepancy, standing};
use crate::machine::SolveError;
use crate::trace::constraints::closing;
use crate::trace::estimate::Observed;
use crate::trace::progress::Stage;
use crate::trace::selection::Selection;
use crate::trace::sensor_memory::with_memory;
use crate::trace::settings::{SEARCHED, SEARCHED_READINGS};
use std::cell::OnceCell;
use std::sync::Arc;

/// A search for the terms that explain a log best. It can be asked more than once: where more terms are allowed, or
/// others were suggested, it goes on from what it has.
pub struct Inquiry<'a> {
    task: Task<'a>,
    observed: Arc<Observed>,
    given: Option<&'a Given>,
    begun: Option<Begun<'a>>,
}

/// The model as given, fitted to the part of a log that is searched first, under each assumption about inputs; once a
/// search has done so. All that are about the same log begin with it, whatever else each of them looks for.
pub type Given = OnceCell<Vec<Arc<Fitted>>>;

/// How far a search has come.
struct Begun<'a> {
    /// In the part of the log that it begins with, or the whole of a short one.
    search: Search<'a>,
    /// Whether that is a part.
    is_part: bool,
    /// The log seen through sensors whose errors last, if they seem to under the model as given.
    lasting: Option<Observed>,
    ended: Option<Ended<'a>>,
}

/// A search that has come to an end, and what it said then.
struct Ended<'a> {
    /// The best hypothesis that it had.
    best: Arc<Fitted>,
    /// Hypotheses of so many terms were not gone on from.
    at_most: usize,
    /// The same beside forces that last.
    search: Search<'a>,
    at_first: Option<Answer>,
    in_all: Option<Answer>,
}

impl<'a> Inquiry<'a> {
    /// Into a log, of which nothing was asked yet.
    pub fn new(task: Task<'a>, observed: Observed) -> Self {
        Self {
            task,
            observed: Arc::new(observed),
            given: None,
            begun: None,
        }
    }

    /// The same beside other searches in the same log, with the same assumptions about inputs.
    pub fn beside(task: Task<'a>, observed: Observed, given: &'a Given) -> Self {
        Self {
            given: Some(given),
            ..Self::new(task, observed)
        }
    }

    /// The log seen through sensors whose errors last, if they seem to under the model as given; known once
    /// something was asked.
    pub fn lasting(&self) -> Option<&Observed> {
        self.begun.as_ref()?.lasting.as_ref()
    }

    /// The terms that explain the log best, going on from hypotheses of fewer than `at_most` terms. What the balance
    /// of forces has `suggested`, which is cheap to ask, is fitted first.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn ask(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Answer, SolveError> {
        let Task {
            only_with_terms,
            progress,
            ..
        } = self.task;
        let whole = Arc::clone(&self.observed);
        let (ended, is_part) = self.ended(at_most, suggested)?;
        if let Some(known) = &ended.in_all {
            return Ok(known.clone());
        }
        let is_spent = only_with_terms && ended.search.best().hypothesis.candidates().is_empty();
        // Who has to end says what the part says: each fit of the whole may take longer than the search has taken.
        let is_over = progress.ended().is_some();
        let answer = match is_part && !is_spent && !is_over {
            true => on_the_whole(ended.search.clone(), &whole)?,
            false => ended.at_first()?,
        };
        ended.in_all = Some(answer.clone());
        Ok(answer)
    }

    /// What the part of the log says that is searched first, which is the whole of a short one; asked as by
    /// [`ask`](Self::ask).
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn ask_at_first(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Answer, SolveError> {
        self.ended(at_most, suggested)?.0.at_first()
    }

    /// What the balance of forces has suggested, without what is one too many in the motion, where it leaves no forces
    /// there; `None` where it does. Nothing else is looked for.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn confirmed(self, suggested: &Selection) -> Result<Option<Selection>, SolveError> {
        self.task.progress.enter(Stage::Fit, &[]);
        let at_most = suggested.terms.len() + 1;
        let (mut search, part) = begun(self.task, (&self.observed, self.given), at_most)?;
        search.try_terms(suggested);
        search.lighten();
        let best = search.best();
        if best.hypothesis.candidates().is_empty() || best.leaves_forces() {
            return Ok(None);
        }
        let answer = match part.is_some() && self.task.progress.ended().is_none() {
            true => on_the_whole(search, &self.observed)?,
            false => settled(search)?,
        };
        Ok(Some(Selection {
            considered: suggested.considered.clone(),
            ..answer.selection
        }))
    }

    /// Whether the terms that explain the part of the log best that is searched first leave forces there; `at_most` is
    /// as for [`ask`](Self::ask).
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn leaves_forces_at_first(&mut self, at_most: usize) -> Result<bool, SolveError> {
        Ok(self.searched(at_most, None)?.search.best().leaves_forces())
    }

    /// Searches in the part of the log that is searched first.
    fn searched(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<&mut Begun<'a>, SolveError> {
        let begun = match &mut self.begun {
            Some(begun) => {
                begun.search.at_most = at_most;
                begun.search.try_suggested(suggested)?;
                begun
            }
            none => {
                let seen = (&*self.observed, self.given);
                none.insert(Begun::new(self.task, seen, at_most, suggested)?)
            }
        };
        begun.search.run()?;
        begun.search.name_plainly();
        Ok(begun)
    }

    /// The search that has come to an end there, and whether that is a part of the log.
    fn ended(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<(&mut Ended<'a>, bool), SolveError> {
        let task = self.task;
        let begun = self.searched(at_most, suggested)?;
        let best = Arc::clone(begun.search.best());
        let known = begun.ended.take();
        let known = known.filter(|known| known.holds_for(&best, at_most));
        let ended = match known {
            Some(known) => known,
            None => Ended {
                best,
                at_most,
                search: begun.beside_forces(task)?,
                at_first: None,
                in_all: None,
            },
        };
        Ok((begun.ended.insert(ended), begun.is_part))
    }
}

/// A search that begins with the model as given in the part of a log that is searched first, and that part, where it
/// is not the whole.
fn begun<'a>(
    task: Task<'a>,
    (whole, given): (&Observed, Option<&Given>),
    at_most: usize,
) -> Result<(Search<'a>, Option<Observed>), SolveError> {
    let shown = whole.record.sensed.as_ref();
    let shown = shown.map_or(0, |sensed| sensed.readings.len());
    let part = whole.excerpt(SEARCHED.min(SEARCHED_READINGS / shown.max(1)));
    let searched = part.as_ref().unwrap_or(whole);
    let search = match given.and_then(OnceCell::get) {
        Some(known) => {
            let known = known.iter().map(|given| given.shared_with(task.dictionary));
            Search::from_given(task, at_most, known.map(Arc::new).collect())
        }
        None => Search::begin(task, searched, at_most)?,
    };
    if let Some(given) = given {
        given.get_or_init(|| search.given.clone());
    }
    Ok((search, part))
}

impl<'a> Begun<'a> {
    /// Begins with the model as given in the part of a log that is searched first, and with what was suggested.
    fn new(
        task: Task<'a>,
        (whole, given): (&Observed, Option<&Given>),
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Self, SolveError> {
        task.progress.enter(Stage::Fit, &[]);
        let dictionary = task.dictionary;
        let (mut search, part) = begun(task, (whole, given), at_most)?;
        let searched = part.as_ref().unwrap_or(whole);
        let (closing, measured) = (closing(dictionary, searched), searched.curve.clone());
        let lasting = with_memory(dictionary, search.best(), searched)?.map(|seen| {
            let mut whole = whole.clone();
            whole.err_as(&seen);
            whole
        });
        search.try_suggested(suggested)?;
        search.try_closing(closing, &measured)?;
        Ok(Self {
            search,
            is_part: part.is_some(),
            lasting,
            ended: None,
        })
    }

    /// The search that has come to an end, beside forces that last where it leaves such.
    fn beside_forces(&self, task: Task<'_>) -> Result<Search<'a>, SolveError> {
        let mut search = self.search.clone();
        if search.best().leaves_forces()
            && task.progress.ended().is_none()
            && let Some(correlation) = discrepancy::correlation(task.dictionary, search.best())?
        {
            search = search.again(|observed| observed.correlation = correlation)?;
            search.run()?;
        }
        Ok(search)
    }
}

impl Ended<'_> {
    /// Whether a search would end so again that has this best hypothesis.
    fn holds_for(&self, best: &Arc<Fitted>, at_most: usize) -> bool {
        let answers = [&self.at_first, &self.in_all].into_iter().flatten();
        let mut sizes = answers.map(|answer| answer.selection.terms.len());
        let may_go_on = sizes.any(|size| size >= self.at_most);
        Arc::ptr_eq(&self.best, best) && (self.at_most == at_most || !may_go_on)
    }

    /// What the search says where it began.
    fn at_first(&mut self) -> Result<Answer, SolveError> {
        if let Some(known) = &self.at_first {
            return Ok(known.clone());
        }
        let answer = settled(self.search.clone())?;
        self.at_first = Some(answer.clone());
        Ok(answer)
    }
}

/// What a search says of the `whole` log, of which it began with a part.
fn on_the_whole(search: Search<'_>, whole: &Observed) -> Result<Answer, SolveError> {
    let beside = &search.given[0].explanation.observed;
    let whole = Observed {
        correlation: beside.correlation.clone(),
        ..whole.clone()
    };
    let mut search = search.on_the_whole(&whole)?;
    search.run()?;
    search.question();
    settled(search)
}

/// What a search says in the end.
fn settled(mut search: Search<'_>) -> Result<Answer, SolveError> {
    loop {
        let best = answer::determined(&search);
        let answer = answer::answer(&search, &best)?;
        let Some(nameless) = search.nameless_in(&best) else {
            return Ok(answer);
        };
        // What has no name is a force without one, and takes nothing from what is named.
        search.leave_out(nameless);
        search.left_out_nameless = true;
        let left = search.best();
        if left.hypothesis.candidates().is_empty() || standing::makes_up(&best, left) {
            return Ok(answer);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::forces;
    use crate::trace::progress::{Progress, Silent};
    use crate::trace::selection::Term;
    use crate::trace::wheel::{WHEEL, begun, named, turned, turned_for};
    use std::sync::Mutex;

    /// That a wheel lacks nothing its part says already: who only wants what is found there need not look at the
    /// whole.
    #[test]
    fn a_search_for_terms_alone_ends_where_its_part_shows_none() {
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        let log = turned_for(4000, waves, (5, 1e-4), |[_, _, a]| 0.02 * a);
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let rows = |only_with_terms: bool| {
            let task = Task {
                dictionary: &dictionary,
                free_hold: false,
                only_with_terms,
                progress: &Silent,
            };
            let Selection {
                terms, observed, ..
            } = {
                let mut inquiry = Inquiry::new(task, start.observed.clone());
                inquiry.ask(2, None).unwrap().selection
            };
            assert!(terms.is_empty(), "{terms:#?}");
            observed.record.len()
        };
        let whole = start.observed.record.len();
        assert_eq!([true, false].map(rows), [SEARCHED, whole]);
    }

    /// How often a search has entered a stage.
    #[derive(Debug, Default)]
    struct Count(Mutex<usize>);

    impl Progress for Count {
        fn enter(&self, _: Stage, _: &[String]) {
            *self.0.lock().unwrap() += 1;
        }

        fn notice(&self, _: &str) {}
    }

    /// A wheel with friction and a spring.
    #[test]
    fn asked_for_more_terms_it_goes_on_and_asked_the_same_it_knows() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[q, v, a]| {
            0.02 * a + 0.01 * v + 0.2 * q
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let steps = Count::default();
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &steps,
        };
        let mut inquiry = Inquiry::new(task, start.observed.clone());
        let mut ask = |at_most: usize| {
            let before = *steps.0.lock().unwrap();
            let found = inquiry.ask(at_most, None).unwrap().selection.accepted();
            (found, *steps.0.lock().unwrap() - before)
        };
        let (_, at_first) = ask(1);
        let (both, further) = ask(3);
        let (again, nothing) = ask(3);
        assert_eq!(both.len(), 2);
        assert_eq!((again, nothing), (both.clone(), 0));
        let mut anew = Inquiry::new(task, start.observed);
        assert_eq!(anew.ask(3, None).unwrap().selection.accepted(), both);
        let whole = *steps.0.lock().unwrap() - at_first - further;
        assert!(further < whole, "{further} {whole}");
    }

    /// Friction and a spring as the balance of forces would suggest them, and a constant force that is not there; the
    /// friction alone, which leaves the spring.
    #[test]
    fn what_forces_suggest_is_confirmed_without_what_is_not_there() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[q, v, a]| {
            0.02 * a + 0.01 * v + 0.2 * q
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        let known = forces::learn(&dictionary, &start.observed, 1);
        let known = known.unwrap().unwrap();
        let confirmed = |names: &[&str]| {
            let term = |name: &&str| Term {
                candidate: named(&dictionary, name),
                ..known.terms[0].clone()
            };
            let suggested = Selection {
                terms: names.iter().map(term).collect(),
                ..known.clone()
            };
            let inquiry = Inquiry::new(task, start.observed.clone());
            let mut found = inquiry.confirmed(&suggested).unwrap()?.accepted();
            found.sort_unstable();
            Some(found)
        };
        let mut both = ["viscous(angle)", "spring(angle)"].map(|name| named(&dictionary, name));
        both.sort_unstable();
        let more = ["constant_force(angle)", "viscous(angle)", "spring(angle)"];
        assert_eq!(confirmed(&more), Some(both.to_vec()));
        assert_eq!(confirmed(&more[..2]), None);
    }
}
