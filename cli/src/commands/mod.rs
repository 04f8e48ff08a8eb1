//! One command per file.

pub mod check;
pub mod eval;
pub mod simulate;

use clap::Subcommand;

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show what a model contains
    Check(check::Arguments),
    /// Evaluate a model's equations at given states
    Eval(eval::Arguments),
    /// Simulate a model and write a log
    Simulate(simulate::Arguments),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Whatever went wrong; a [`Mistake`](crate::mistake::Mistake) if the user can mend it.
    pub fn run(self) -> anyhow::Result<()> {
        match self {
            Self::Check(arguments) => check::run(&arguments),
            Self::Eval(arguments) => eval::run(&arguments),
            Self::Simulate(arguments) => simulate::run(&arguments),
        }
    }
}
