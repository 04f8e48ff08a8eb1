//! The warnings of the two records that a command works with, for whoever reads them.

use super::Record;
use std::collections::BTreeSet;

/// What should be known about what is learnt from and what is judged by, each said once. Of two
/// logs (`apart`) it says which one is meant; two parts of one log need no telling apart.
pub(crate) fn said_of(train: &Record, test: &Record, apart: bool) -> Vec<String> {
    let named = [("training log", train), ("test log", test)];
    let each = named.into_iter().flat_map(|(name, record)| {
        record.warnings.iter().map(move |warning| match apart {
            true => format!("{name}: {warning}"),
            false => warning.to_string(),
        })
    });
    let mut said = BTreeSet::new();
    each.filter(|warning| said.insert(warning.clone()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;

    /// The second log says one value of an input, the first does not.
    #[test]
    fn of_two_logs_it_is_said_which() {
        let record = |input: fn(f64) -> f64| {
            let line = |k: i32| {
                let t = 0.01 * f64::from(k);
                format!("{t},{},{}\n", (3.0 * t).sin(), input(t))
            };
            let text = (0..80).map(line).collect::<String>();
            let log = Log::from_bytes("a.csv", format!("t,q_a,u_a\n{text}").as_bytes()).unwrap();
            let names = ["a".to_string()];
            log.select(&names, &names).unwrap()
        };
        let (moving, constant) = (record(f64::cos), record(|_| 1.0));
        let said = said_of(&moving, &constant, true);
        insta::assert_snapshot!(said.join("\n"), @"test log: `u_a` is constant (1): it carries no information");
        let said = said_of(&constant, &constant, false);
        insta::assert_snapshot!(said.join("\n"), @"`u_a` is constant (1): it carries no information");
    }
}
