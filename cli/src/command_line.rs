//! The command line, to be given again.

/// The command line as a shell reads it, with the seed if it has one.
pub fn command(seed: Option<u64>) -> String {
    let given: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let seeded = given
        .iter()
        .any(|word| word == "--seed" || word.starts_with("--seed="));
    let mut line = "dynamics".to_string();
    for word in &given {
        line.push(' ');
        line.push_str(&quoted(word));
    }
    if let Some(seed) = seed.filter(|_| !seeded) {
        line.push_str(&format!(" --seed {seed}"));
    }
    line
}

/// A word for a shell.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
