//! The program `wheelbot`: one study by its name, printed, and as a page on request.

use clap::{Parser, ValueEnum};
use cli::output;
use cli::whole_file::{self, WholeFile};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use wheelbot::jump::Way;
use wheelbot::studies::{
    Study, StudyError, balance, estimator, identify, jump, pirouette, plan, push,
};
use wheelbot::{design, report};
use wheelbot_firmware::Gains;

/// Simulates the Wheelbot at 1 kHz on its own firmware at 100 Hz: what comes out stands beside what
/// the thesis states.
#[derive(Parser)]
#[command(name = "wheelbot")]
struct Arguments {
    /// What the robot does.
    program: Program,
    /// Writes a page with the robot in motion to this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Of the sensors' noise and biases.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The balancing controllers.
    #[arg(long, value_enum, default_value_t = Controllers::Published)]
    gains: Controllers,
}

#[derive(Clone, Copy, ValueEnum)]
enum Program {
    /// Stands for a minute.
    Balance,
    /// Is pushed from eight sides (Fig. 6.12).
    Push,
    /// Turns three times in four seconds (Fig. 6.9).
    Pirouette,
    /// Stands up from a side by its reaction wheel (Fig. 6.13).
    StandUp,
    /// Rolls up from a side by its rolling wheel (Fig. 6.14).
    RollUp,
    /// Finds the pulses of standing up on the simulation.
    PlanStandUp,
    /// Finds those of rolling up.
    PlanRollUp,
    /// Estimates its tilt with and without the wheel's acceleration (Fig. 6.11).
    Estimator,
    /// Finds in its own log what its model does not say, and balances with and without it.
    Identify,
}

#[derive(Clone, Copy, ValueEnum)]
enum Controllers {
    /// Those of the thesis, (6.22).
    Published,
    /// A regulator for the model.
    Designed,
}

impl Program {
    fn run(self, gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
        match self {
            Self::Balance => balance::study(gains, seed),
            Self::Push => push::study(gains, seed),
            Self::Pirouette => pirouette::study(gains, seed),
            Self::StandUp => jump::study(Way::Roll, gains, seed),
            Self::RollUp => jump::study(Way::Pitch, gains, seed),
            Self::PlanStandUp => plan::up(Way::Roll, gains, seed),
            Self::PlanRollUp => plan::up(Way::Pitch, gains, seed),
            Self::Estimator => estimator::study(gains, seed),
            Self::Identify => identify::study(gains, seed),
        }
    }
}

impl Arguments {
    fn run(&self) -> anyhow::Result<()> {
        if let Some(folder) = &self.report {
            whole_file::make_folder(folder)?;
        }
        let gains = match self.gains {
            Controllers::Published => Gains::PUBLISHED,
            Controllers::Designed => design::designed()?,
        };
        let study = self.program.run(gains, self.seed)?;
        let mut out = output::stdout();
        out.write_all(report::text(&study).as_bytes())?;
        if let Some(folder) = &self.report {
            let path = folder.join(format!("{}.html", self.word()));
            WholeFile::write(&path, &report::page(&study, &self.command())?)?;
            writeln!(out, "\nwrote {}", path.display())?;
        }
        out.flush()?;
        Ok(())
    }

    /// The program's name on the command line.
    fn word(&self) -> String {
        name(self.program)
    }

    fn command(&self) -> String {
        format!(
            "cargo run --release -p wheelbot -- {} --seed {} --gains {}",
            self.word(),
            self.seed,
            name(self.gains)
        )
    }
}

/// A value as the command line has it.
fn name(value: impl ValueEnum) -> String {
    let possible = value.to_possible_value();
    possible.map_or_else(String::new, |value| value.get_name().to_string())
}

fn main() -> ExitCode {
    cli::conclude(Arguments::parse().run())
}
