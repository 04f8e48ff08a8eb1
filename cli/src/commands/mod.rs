//! One command per file.

pub mod check;
pub mod completions;
pub mod eval;
pub mod fit;
pub mod generate;
pub mod linearise;
pub mod man;
pub mod simulate;
pub mod trace;
pub mod view;

use clap::Subcommand;

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show what a model contains
    ///
    /// Coordinates, inputs, parameters, constraints, effects, outputs; how many
    /// operations the equations cost; and what is worth a warning.
    Check(check::Arguments),

    /// Evaluate a model's equations at given states
    ///
    /// Each line of the states' file is one JSON object with the positions `q` and, where
    /// they are not zero or nominal, the velocities `v`, inputs `u`, time `t` and
    /// `parameters`. `q`, `v`, `u` are arrays in model order or objects by name.
    ///
    /// For each line there is one answer, in the same order: the terms of
    /// `M a = Q + A^T lambda`, `A a = b`, and their solution. `Q = bias + applied + B u`,
    /// where `bias` (Q_C) holds the fictitious and conservative forces, with the sign of
    /// the right-hand side.
    Eval(eval::Arguments),

    /// Linearise a model at a state
    ///
    /// `d(xi)/dt = drift + A xi + B du`, `dy = C xi + D du`, where `du` and `dy` are deviations
    /// of the inputs and outputs, and `xi` are free coordinates of the deviation `dx` of
    /// positions, velocities and internal states: `dx = basis xi`, `xi = chart dx`. Without
    /// constraints `xi` is `dx`; holonomic constraints take positions and velocities away,
    /// nonholonomic ones velocities. With `--hold` the matrices lead from one sample to the
    /// next, inputs held in between.
    Linearise(linearise::Arguments),

    /// Turn a model into source code
    ///
    /// Writes files named after the model, with the mass matrix, the forces, the
    /// constraints and what follows from them: straight-line code that allocates nothing.
    /// Each file is there whole or not at all; files that would not change are left alone.
    Generate(generate::Arguments),

    /// Simulate a model and write a log
    ///
    /// The log has the columns `t`, `q_<coordinate>`, `dq_<coordinate>`,
    /// `ddq_<coordinate>` and `u_<input>`, then the model's sensors, in SI units. The motion is integrated by the
    /// classical Runge-Kutta method with stabilised constraints (Baumgarte). The initial
    /// state is first moved onto the constraints by the shortest way; how far it moved is
    /// printed.
    Simulate(simulate::Arguments),

    /// Find what a model lacks, from a measured log
    ///
    /// Every effect of the library is tried at every place, and every parameter of the
    /// model. What earns its place is named, estimated with its uncertainty and written
    /// into a copy of the model; the errors before and after are those on data that
    /// neither fitting nor selection saw.
    Trace(trace::Arguments),
    /// Fit inertias, friction and couplings to measured forces
    ///
    /// Terms are taken in if they predict blocks of the log that they were not fitted to.
    /// With `--compare`, Gaussian processes learn what the model leaves of the
    /// accelerations, as output residual, latent force (GP²) and contact-invariant residual,
    /// with all errors in one table.
    Fit(fit::Arguments),

    /// Look at a log: a page on which the model moves
    ///
    /// One file that works offline, with the bodies, frames and contacts of the model in space beside the log's
    /// columns over time; play, pause, speed, a slider. Of what has no shape the inertia makes one: a body is the box
    /// of even density that has it.
    View(view::Arguments),

    /// Print what a shell completes of this program's command line
    Completions(completions::Arguments),

    /// Write manual pages of this program and its commands
    Man(man::Arguments),
}

impl Command {
    /// Runs the command; `program` is the description of the whole command line.
    ///
    /// # Errors
    /// Whatever went wrong; a [`Mistake`](crate::mistake::Mistake) if the user can mend it.
    pub fn run(self, program: clap::Command) -> anyhow::Result<()> {
        match self {
            Self::Check(arguments) => check::run(&arguments),
            Self::Eval(arguments) => eval::run(&arguments),
            Self::Generate(arguments) => generate::run(&arguments),
            Self::Linearise(arguments) => linearise::run(&arguments),
            Self::Simulate(arguments) => simulate::run(&arguments),
            Self::Trace(arguments) => trace::run(&arguments),
            Self::Fit(arguments) => fit::run(&arguments),
            Self::View(arguments) => view::run(&arguments),
            Self::Completions(arguments) => completions::run(&arguments, program),
            Self::Man(arguments) => man::run(&arguments, program),
        }
    }
}
