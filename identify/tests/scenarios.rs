//! Sensor noise recovered from the simulated machines' logs, against the
//! figures their READMEs state.

use identify::log::Log;
use identify::smooth::{Smoothed, savgol_states, smooth};
use std::path::{Path, PathBuf};

/// Quantum and noise of a column as its README states them.
#[derive(Debug)]
struct Stated {
    column: String,
    quantum: f64,
    sd: f64,
}

fn scenarios() -> Option<Vec<PathBuf>> {
    let root = left_out::shared("data/scenarios")?;
    let entries = std::fs::read_dir(&root).unwrap();
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("README.md").is_file())
        .collect();
    found.sort();
    assert_eq!(found.len(), 12);
    Some(found)
}

/// Rows such as `| q_j1 | rad | position, quantum 2e-05, noise sd 3e-05 |`.
fn stated(folder: &Path) -> Vec<Stated> {
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let number = |text: &str, label: &str| -> Option<f64> {
        let (_, rest) = text.split_once(label)?;
        rest.trim().split([',', ' ', '|']).next()?.parse().ok()
    };
    let rows = readme.lines().filter_map(|line| {
        let column = line.strip_prefix("| ")?.split(' ').next()?.to_owned();
        Some(Stated {
            quantum: number(line, "quantum ").unwrap_or(0.0),
            sd: number(line, "noise sd ")?,
            column,
        })
    });
    rows.collect()
}

fn names(stated: &[Stated]) -> Vec<String> {
    let names = stated
        .iter()
        .filter_map(|row| row.column.strip_prefix("q_"));
    names.map(str::to_owned).collect()
}

fn found(smoothed: &Smoothed, column: &str) -> Option<f64> {
    match column.split('_').next()? {
        "q" => Some(smoothed.noise.sd_q),
        "dq" => smoothed.noise.sd_dq,
        _ => smoothed.noise.sd_ddq,
    }
}

#[test]
fn stated_noise_is_recovered() {
    let Some(folders) = scenarios() else { return };
    for folder in folders {
        let log = ["train.csv", "train.csv.gz"].map(|name| folder.join(name));
        let path = log.iter().find(|path| path.is_file()).unwrap();
        let stated = stated(&folder);
        let names = names(&stated);
        let record = Log::read(path).unwrap().select(&names, &[]).unwrap();
        let smoothed = smooth(&record).unwrap();
        println!("{}", folder.file_name().unwrap().display());
        for warning in &record.warnings {
            println!("  {warning}");
        }
        for row in &stated {
            let (_, name) = row.column.split_once('_').unwrap();
            let i = names.iter().position(|other| other == name).unwrap();
            let sd = found(&smoothed[i], &row.column).unwrap();
            let expected = row.sd.hypot(row.quantum / 12_f64.sqrt());
            let ratio = sd / expected;
            println!(
                "  {:8} {sd:.3e} / {expected:.3e} = {ratio:.3}, order {}, {:?}",
                row.column, smoothed[i].smoother.order, smoothed[i].smoother.converged
            );
            assert!((0.9..1.1).contains(&ratio), "{}: {ratio}", row.column);
        }
        let reference = savgol_states(&record).unwrap();
        assert_eq!(reference.a.len(), names.len());
    }
}
