//! Inputs that a model assumes and a log does not know.

use super::{Log, Warning};

impl Log {
    /// Adds a channel of zeros for each of `inputs` that has no column, with a
    /// warning: a joint that nothing is said to drive is not driven. If the log has
    /// a `u_` column that belongs to none of `inputs`, nothing is added: a misspelt
    /// column is more likely than a missing motor.
    pub fn assume_no_input<'a>(&mut self, inputs: impl Iterator<Item = &'a str>) {
        let columns: Vec<String> = inputs.map(|name| format!("u_{name}")).collect();
        let stray = |column: &String| {
            column.starts_with("u_") && !columns.iter().any(|known| known == column)
        };
        if self.channels.keys().any(stray) {
            return;
        }
        for column in columns {
            let commanded = column.replacen("u_", "ucmd_", 1);
            if !self.channels.contains_key(&column) && !self.channels.contains_key(&commanded) {
                self.warnings.push(Warning::AssumedZero {
                    column: column.clone(),
                });
                self.channels.insert(column, vec![0.0; self.t.len()]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::headed;

    #[test]
    fn what_has_no_column_is_not_driven() {
        let mut log = headed("t,q_a,q_b,u_a");
        log.assume_no_input(["a", "b"].into_iter());
        assert_eq!(log.channels["u_b"], vec![0.0; 60]);
        assert_eq!(log.channels["u_a"], vec![1.0; 60]);
        assert_eq!(log.warnings.len(), 1);
    }

    #[test]
    fn a_misspelt_column_is_not_overlooked() {
        let mut log = headed("t,q_a,q_b,u_1");
        log.assume_no_input(["a", "b"].into_iter());
        assert!(!log.channels.contains_key("u_a"));
    }
}
