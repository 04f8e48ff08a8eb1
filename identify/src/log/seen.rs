//! The columns that a log has, and those that it lacks, as messages show them.

use super::table::Column;
use crate::number::short;
use std::fmt::Write;

/// Columns that a message lists; a map to start from lists all.
const LISTED: usize = 40;

/// Steps of a column that differ by less than this share of their median are even.
const EVEN: f64 = 0.05;

/// A column that a log has.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Its name; its number, from 1 on, in a log without a header.
    pub name: String,
    /// What its values look like, where the name says nothing.
    pub glance: Option<Glance>,
}

impl Seen {
    /// A column of which only the name is known.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            glance: None,
        }
    }
}

/// What the values of a column look like.
#[derive(Debug, Clone, PartialEq)]
pub struct Glance {
    /// The least and the largest value.
    pub range: (f64, f64),
    /// By how much it rises from row to row, if it does so evenly, as stamps do.
    pub rises: Option<f64>,
}

impl Glance {
    pub(super) fn at(values: &[f64]) -> Self {
        let widen = |(least, most): (f64, f64), x: &f64| (least.min(*x), most.max(*x));
        let range = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), widen);
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step = super::median(&steps).filter(|step| *step > 0.0);
        let rises = step.filter(|step| {
            let even = |found: &&f64| (*found - step).abs() < EVEN * step;
            let gaps = steps.iter().all(|found| *found > 0.0);
            gaps && 10 * steps.iter().filter(even).count() > 9 * steps.len()
        });
        Self { range, rises }
    }
}

impl std::fmt::Display for Glance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (least, most) = self.range;
        match self.rises {
            _ if least > most => write!(f, "no numbers"),
            _ if least == most => write!(f, "always {}", bare(least)),
            Some(step) => write!(
                f,
                "rises from {} to {} by {} a row, as stamps do",
                bare(least),
                bare(most),
                bare(step)
            ),
            None => write!(f, "{} to {}", bare(least), bare(most)),
        }
    }
}

/// A number in few digits, without noughts at its end.
fn bare(value: f64) -> String {
    let text = short(value);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The columns of a table, with a glance at each where there is no header.
pub(super) fn seen(columns: &[Column], headless: bool) -> Vec<Seen> {
    let seen = columns.iter().map(|column| Seen {
        name: column.name.clone(),
        glance: headless.then(|| Glance::at(&column.values)),
    });
    seen.collect()
}

/// A column that is needed and not there.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// What it would be called.
    pub column: String,
    /// What it is for.
    pub role: String,
    /// The most similar of those that are there.
    pub nearest: Option<String>,
}

impl Missing {
    /// The column of stamps.
    pub(super) fn time(found: &[Seen]) -> Self {
        let alike = |alias: &&str| found.iter().find(|s| s.name.eq_ignore_ascii_case(alias));
        Self {
            column: "t".to_owned(),
            role: "the time stamps [s]".to_owned(),
            nearest: TIME_NAMES.iter().find_map(alike).map(|s| s.name.clone()),
        }
    }

    /// A column that a map names.
    pub(super) fn named(column: &str, role: String, found: &[Seen]) -> Self {
        Self {
            column: column.to_owned(),
            nearest: nearest(column, found),
            role,
        }
    }
}

/// What the column of time stamps is called elsewhere.
const TIME_NAMES: [&str; 6] = ["T", "time", "_time", "timestamp", "stamp", "t_s"];

/// The column most likely meant by a name that a log does not have, or by a number where the log
/// has a header.
fn nearest(name: &str, found: &[Seen]) -> Option<String> {
    let number = name.parse::<usize>().ok();
    let counted = number.and_then(|number| found.get(number.checked_sub(1)?));
    let same = || found.iter().find(|s| s.name.eq_ignore_ascii_case(name));
    if let Some(seen) = counted.or_else(same) {
        return Some(seen.name.clone());
    }
    let names: Vec<&str> = found.iter().map(|seen| seen.name.as_str()).collect();
    let close = similar::get_close_matches(name, &names, 1, 0.6);
    close.first().map(|name| (*name).to_owned())
}

/// All that is missing, and what is there.
pub(super) fn missing(missing: &[Missing], found: &[Seen]) -> String {
    let mut text = match missing.len() {
        0 => "no map names columns, and not exactly one topic holds joint states; the log has "
            .to_owned(),
        1 => "a column is missing; the log has ".to_owned(),
        n => format!("{n} columns are missing; the log has "),
    };
    let names: Vec<String> = found
        .iter()
        .map(|seen| format!("`{}`", seen.name))
        .collect();
    text += &match names.len() {
        0 => "none".to_owned(),
        n if n > LISTED => format!("{} … and {} more", names[..LISTED].join(", "), n - LISTED),
        _ => names.join(", "),
    };
    for Missing {
        column,
        role,
        nearest,
    } in missing
    {
        let meant = nearest.as_ref().map(|name| format!(" (is it `{name}`?)"));
        let meant = meant.unwrap_or_default();
        write!(text, "\n    `{column}`, {role}{meant}").expect("text takes any text");
    }
    text
}

/// What to do about it.
pub(super) fn mend_missing(missing: &[Missing], found: &[Seen]) -> String {
    let headless = found.iter().any(|seen| seen.glance.is_some());
    let mut mend = match headless {
        true => "the log has no header: name its columns by their numbers, from 1 on",
        false => "say in the log's map which columns they are, or add them to the log",
    }
    .to_owned();
    if missing
        .iter()
        .any(|missing| missing.role.contains("time stamps"))
    {
        mend += "; a log without stamps has a rate: `[time] rate = 1000` (Hz)";
    }
    mend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glance_tells_stamps_from_channels() {
        let stamps: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
        let swing: Vec<f64> = stamps.iter().map(|t| (3.0 * t).sin()).collect();
        insta::assert_snapshot!(Glance::at(&stamps), @"rises from 0 to 0.59 by 0.01 a row, as stamps do");
        assert_eq!(Glance::at(&swing).rises, None);
        insta::assert_snapshot!(Glance::at(&[2.0; 5]), @"always 2");
        insta::assert_snapshot!(Glance::at(&[]), @"no numbers");
    }

    #[test]
    fn a_number_means_the_column_that_stands_there() {
        let found = ["t", "angle", "load"].map(Seen::named);
        assert_eq!(nearest("2", &found).as_deref(), Some("angle"));
        assert_eq!(nearest("Load", &found).as_deref(), Some("load"));
        assert_eq!(nearest("angel", &found).as_deref(), Some("angle"));
        assert_eq!(nearest("0", &found), None);
    }
}
