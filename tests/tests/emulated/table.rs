//! The table of `docs/firmware.md`: what the firmware costs, as it is promised.

use integration_tests::files::root;
use std::collections::BTreeMap;

/// How much a number may change before the table has to.
const TOLERANCE: f64 = 0.02;

/// The rows, by their first two cells.
pub struct Table(BTreeMap<[String; 2], Vec<u64>>);

impl Table {
    /// The table behind the heading.
    pub fn read(heading: &str) -> Self {
        let page = std::fs::read_to_string(root().join("docs/firmware.md")).unwrap();
        Self::from(&page, heading)
    }

    fn from(page: &str, heading: &str) -> Self {
        let (_, section) = page.split_once(heading).expect("the heading is there");
        let rows = section.lines().skip_while(|line| !line.starts_with('|'));
        let rows = rows.take_while(|line| line.starts_with('|')).skip(2);
        let rows = rows.map(|row| {
            let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
            let numbers = cells[2..].iter().map(|cell| {
                let digits: String = cell.chars().filter(char::is_ascii_digit).collect();
                digits.parse().unwrap_or(0)
            });
            ([cells[0], cells[1]].map(str::to_owned), numbers.collect())
        });
        Self(rows.collect())
    }

    /// What is wrong with a row, if its numbers are not these.
    pub fn fault(&self, row: [&str; 2], measured: &[u64]) -> Option<String> {
        let written = self.0.get(&row.map(str::to_owned));
        let near = |(&measured, &written): (&u64, &u64)| {
            let [measured, written] = [measured, written].map(|x| x as f64);
            (measured - written).abs() <= TOLERANCE * written
        };
        match written {
            Some(written)
                if written.len() == measured.len() && measured.iter().zip(written).all(near) =>
            {
                None
            }
            _ => Some(format!(
                "docs/firmware.md, {row:?}: measured {measured:?}, written {written:?}"
            )),
        }
    }
}

#[test]
fn two_per_cent_more_are_a_fault() {
    let page =
        "## Cost\n\n| a | b | c |\n|---|---|---|\n| M4F | tick | 1 000 cycles |\n\ntext | 5 |\n";
    let table = Table::from(page, "## Cost");
    assert_eq!(table.fault(["M4F", "tick"], &[1000]), None);
    assert_eq!(table.fault(["M4F", "tick"], &[1020]), None);
    assert!(table.fault(["M4F", "tick"], &[1021]).is_some());
    assert!(table.fault(["M4F", "tick"], &[979]).is_some());
    assert!(table.fault(["M4F", "tick"], &[1000, 1]).is_some());
    assert!(table.fault(["AVR", "tick"], &[1000]).is_some());
}
