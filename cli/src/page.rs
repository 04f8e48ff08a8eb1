//! Plain-text layout for people.

/// Rows of cells, printed in columns that line up.
#[derive(Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
    right: Vec<bool>,
}

impl Table {
    /// An empty table. `alignment` has one letter per column: `<` or `>`.
    pub fn new(alignment: &str) -> Self {
        Self {
            rows: Vec::new(),
            right: alignment.chars().map(|c| c == '>').collect(),
        }
    }

    /// Adds a row.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The rows as text, indented by two; columns that are empty throughout are left out.
    pub fn render(&self) -> String {
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.right.len()).map(width).collect();
        let mut page = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for ((cell, &width), &right) in row.iter().zip(&widths).zip(&self.right) {
                if width == 0 {
                    continue;
                }
                line.push_str("  ");
                let gap = " ".repeat(width - cell.chars().count());
                let (before, after) = if right {
                    (gap.as_str(), "")
                } else {
                    ("", gap.as_str())
                };
                line.push_str(before);
                line.push_str(cell);
                line.push_str(after);
            }
            page.push_str(line.trim_end());
            page.push('\n');
        }
        page
    }
}

/// `1 coordinate`, `2 coordinates`
pub fn count(n: usize, what: &str) -> String {
    match n {
        0 => format!("no {what}s"),
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}

/// The first line of a doc comment.
pub fn first_line(doc: &str) -> &str {
    doc.lines().next().unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_and_empty_ones_vanish() {
        let mut table = Table::new("<><<");
        table.row(["m1", "1.2", "", "kg"]);
        table.row(["mass_of_it", "10", "", "kg"]);
        assert_eq!(
            table.render(),
            "  m1          1.2  kg\n  mass_of_it   10  kg\n"
        );
    }
}
