//! Damage to whole columns of a table, and to how it is written.

use super::scraps;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A table with one of its columns changed, or written as another program writes tables.
pub fn changed(rng: &mut ChaCha8Rng, text: &str) -> String {
    match rng.random_range(0..10_u32) {
        0 => text.replace(',', ";"),
        1 => text.replace(',', "\t"),
        2 => text.replace('\n', "\r\n"),
        3 => text.replace(',', " , "),
        4 => text.replace('\n', "\n# a remark, of two cells\n\n"),
        _ => {
            let mut rows: Vec<Vec<String>> = text
                .lines()
                .map(|line| line.split(',').map(str::to_string).collect())
                .collect();
            change_column(rng, &mut rows);
            let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
            lines.join("\n") + "\n"
        }
    }
}

/// Changes one column from some row on, below the header.
fn change_column(rng: &mut ChaCha8Rng, rows: &mut [Vec<String>]) {
    let width = rows.first().map_or(0, Vec::len);
    if width == 0 || rows.len() < 2 {
        return;
    }
    let column = rng.random_range(0..width);
    let other = rng.random_range(0..width);
    let start = if rng.random_bool(0.5) {
        1
    } else {
        rng.random_range(1..rows.len())
    };
    let what = rng.random_range(0..6_u32);
    let value = scraps::number(rng);
    let factor = 10_f64.powi(rng.random_range(-12..13));
    for row in &mut rows[start..] {
        if column.max(other) >= row.len() {
            continue;
        }
        let number = row[column].trim().parse::<f64>();
        match what {
            0 => row[column].clone_from(&value),
            1 => row[column] = number.map_or_else(|_| value.clone(), |x| (x * factor).to_string()),
            2 => row[column] = row[other].clone(),
            3 => row.swap(column, other),
            // From here to there, once around the circle and again.
            4 => row[column] = number.map_or_else(|_| value.clone(), |x| (x % 1.0).to_string()),
            _ => drop(row.remove(column)),
        }
    }
}
