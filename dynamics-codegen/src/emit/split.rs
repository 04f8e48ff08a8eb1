//! Long bodies in parts.
//!
//! A compiler's time grows faster than the length of a function, and its stack with it
//! (rust-lang/rust#93908). So a body of many operations becomes several functions of about
//! equal length; what one part computes and a later one needs is carried in an array,
//! whose places are used again when nobody needs what they hold.

use super::body::{Body, Statement, Term, reads};
use super::symbols::{Argument, Role, Symbols};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The most operations and temporaries that one function holds: about a second of rustc.
const LONGEST: usize = 6000;

/// Some statements of a body.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    pub statements: Range<usize>,
    /// Temporaries of earlier parts, with their places.
    pub takes: Vec<(usize, usize)>,
    /// Temporaries that later parts need, with their places.
    pub gives: Vec<(usize, usize)>,
    /// What it reads of the arguments.
    pub reads: BTreeSet<Role>,
    /// Whether it reads what the function begins with.
    pub reads_given: bool,
}

/// A body's parts; the last one holds the results.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    pub parts: Vec<Part>,
    /// How many temporaries are carried at once.
    pub places: usize,
}

impl Part {
    /// Whether it reads anything of an argument.
    pub fn reads_of(&self, argument: Argument) -> bool {
        self.reads.iter().any(|role| role.argument() == argument)
    }
}

impl Parts {
    /// As few parts as the bound on their length allows.
    pub fn of(body: &Body, symbols: &Symbols) -> Self {
        Self::bounded(body, symbols, LONGEST)
    }

    fn bounded(body: &Body, symbols: &Symbols, longest: usize) -> Self {
        let ranges = ranges(&body.statements, longest);
        let uses: Vec<(BTreeSet<usize>, BTreeSet<Role>)> = ranges
            .iter()
            .enumerate()
            .map(|(index, range)| {
                let terms = body.statements[range.clone()].iter().flat_map(terms_of);
                let last = index + 1 == ranges.len();
                let results = body.results.iter().filter(|_| last);
                used(terms.chain(results), symbols)
            })
            .collect();
        let mut last_use: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, (locals, _)) in uses.iter().enumerate() {
            last_use.extend(locals.iter().map(|&local| (local, index)));
        }
        let mut carried = Carried::default();
        let mut parts = Vec::new();
        for (index, (range, (locals, roles))) in ranges.into_iter().zip(uses).enumerate() {
            let takes = carried
                .held
                .iter()
                .filter(|(local, _)| locals.contains(local));
            let takes = takes.map(|(&local, &place)| (local, place)).collect();
            carried.release(|local| last_use[&local] <= index);
            let own = body.statements[range.clone()].iter().flat_map(defined);
            let later = own.filter(|local| last_use.get(local).is_some_and(|&last| last > index));
            let gives = later.map(|local| (local, carried.hold(local))).collect();
            parts.push(Part {
                statements: range,
                takes,
                gives,
                reads: roles,
                reads_given: locals.iter().any(|&local| local < body.given),
            });
        }
        Self {
            parts,
            places: carried.places,
        }
    }

    /// Whether there is more than one.
    pub fn are_several(&self) -> bool {
        self.parts.len() > 1
    }
}

/// Which place holds what.
#[derive(Debug, Default)]
struct Carried {
    held: BTreeMap<usize, usize>,
    free: BTreeSet<usize>,
    places: usize,
}

impl Carried {
    fn release(&mut self, done: impl Fn(usize) -> bool) {
        let free = &mut self.free;
        self.held.retain(|&local, &mut place| {
            let over = done(local);
            if over {
                free.insert(place);
            }
            !over
        });
    }

    fn hold(&mut self, local: usize) -> usize {
        let place = self.free.pop_first().unwrap_or(self.places);
        self.places = self.places.max(place + 1);
        self.held.insert(local, place);
        place
    }
}

/// Stretches of about equal numbers of operations.
fn ranges(statements: &[Statement], longest: usize) -> Vec<Range<usize>> {
    let lengths: Vec<usize> = statements
        .iter()
        .map(|s| terms_of(s).map(operations).sum::<usize>() + 1)
        .collect();
    let total: usize = lengths.iter().sum();
    let count = total.div_ceil(longest).max(1);
    let share = total.div_ceil(count);
    let (mut ranges, mut start, mut length) = (Vec::new(), 0, 0);
    for (index, own) in lengths.into_iter().enumerate() {
        length += own;
        if length >= share && index + 1 < statements.len() {
            ranges.push(start..index + 1);
            (start, length) = (index + 1, 0);
        }
    }
    ranges.push(start..statements.len());
    ranges
}

fn operations(term: &Term) -> usize {
    match term {
        Term::Constant(_) | Term::Symbol(_) | Term::Local(_) => 0,
        Term::Unary(_, x) => 1 + operations(x),
        Term::Binary(_, x, y) => 1 + operations(x) + operations(y),
        Term::Fused(_, terms) => 2 + terms.iter().map(operations).sum::<usize>(),
    }
}

fn terms_of(statement: &Statement) -> Box<dyn Iterator<Item = &Term> + '_> {
    match statement {
        Statement::Let { value, .. } => Box::new(std::iter::once(value)),
        Statement::SinCos { argument, .. } => Box::new(std::iter::once(argument)),
        Statement::SinCosEach(group) => Box::new(group.iter().map(|c| &c.argument)),
    }
}

fn defined(statement: &Statement) -> Vec<usize> {
    match statement {
        Statement::Let { local, .. } => vec![*local],
        Statement::SinCos { sine, cosine, .. } => vec![*sine, *cosine],
        Statement::SinCosEach(group) => group.iter().flat_map(|c| [c.sine, c.cosine]).collect(),
    }
}

/// Temporaries and arguments that terms read.
fn used<'a>(
    terms: impl Iterator<Item = &'a Term>,
    symbols: &Symbols,
) -> (BTreeSet<usize>, BTreeSet<Role>) {
    let (mut locals, mut roles) = (BTreeSet::new(), BTreeSet::new());
    for term in terms {
        locals.extend(reads(term));
        roles_of(term, symbols, &mut roles);
    }
    (locals, roles)
}

fn roles_of(term: &Term, symbols: &Symbols, roles: &mut BTreeSet<Role>) {
    match term {
        Term::Constant(_) | Term::Local(_) => {}
        Term::Symbol(symbol) => {
            roles.insert(symbols.get(*symbol).role);
        }
        Term::Unary(_, x) => roles_of(x, symbols, roles),
        Term::Binary(_, x, y) => {
            roles_of(x, symbols, roles);
            roles_of(y, symbols, roles);
        }
        Term::Fused(_, terms) => terms.iter().for_each(|x| roles_of(x, symbols, roles)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::{Emission, Functions, identifier};
    use crate::{Library, compile};

    /// Every temporary is defined before it is read, through the places that carry it.
    #[test]
    fn nothing_is_lost_between_parts() {
        let text = include_str!("../../../models/fourbar.model");
        let compiled = compile("fourbar.model", text, &Library::builtin()).unwrap();
        let emission = Emission::new(&compiled, "fourbar.model", &Functions::full()).unwrap();
        let symbols = emission.plan.symbols(&[], identifier);
        for function in &emission.plan.functions {
            let body = function.body(&emission.plan.model, &symbols, ".");
            for longest in [5, 17, 60, 250, 100_000] {
                let parts = Parts::bounded(&body, &symbols, longest);
                let mut places: Vec<Option<usize>> = vec![None; parts.places];
                let mut next = 0;
                for (index, part) in parts.parts.iter().enumerate() {
                    assert_eq!(part.statements.start, next, "no statement is left out");
                    next = part.statements.end;
                    let mut known = BTreeSet::new();
                    for &(local, place) in &part.takes {
                        assert_eq!(places[place], Some(local), "{}", function.name);
                        known.insert(local);
                    }
                    for statement in &body.statements[part.statements.clone()] {
                        let read: BTreeSet<usize> = terms_of(statement).flat_map(reads).collect();
                        assert!(read.is_subset(&known), "{}", function.name);
                        known.extend(defined(statement));
                    }
                    if index + 1 == parts.parts.len() {
                        let read: BTreeSet<usize> = body.results.iter().flat_map(reads).collect();
                        assert!(read.is_subset(&known), "{}", function.name);
                        assert!(part.gives.is_empty());
                    }
                    for &(local, place) in &part.gives {
                        places[place] = Some(local);
                    }
                }
                assert_eq!(next, body.statements.len());
            }
        }
    }
}
