//! `dynamics simulate`: motion as a log, open-loop or with a controller in the loop.

use crate::inputs::Inputs;
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::noise::{Channel, Noise};
use crate::output;
use crate::simulation::{Controller, ImpactList, Recorder, Run, Signal};
use crate::start;
use crate::state::State;
use clap::Args;
use dynamics_codegen::Model;
use identify::machine::Machine;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics simulate models/pendulum2.model --init '{\"q\": [1, 0]}' --duration 10 --out log.csv
  dynamics simulate models/cartpole.model --init start.json --inputs force.csv \\
    --duration 5 --rate 500 --noise q=1e-4 --noise dq=2e-3 --seed 7 --out log.csv
  dynamics simulate models/cartpole.model --init up.json --control balance.toml \\
    --duration 10 --out balanced.csv")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The initial state: a JSON file, or the JSON itself; fields as in `eval`
    #[arg(long, value_name = "STATE")]
    init: String,

    /// How long to simulate, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    duration: f64,

    /// Rows per second in the log
    #[arg(long, value_name = "HZ", default_value = "100", value_parser = positive, allow_negative_numbers = true)]
    rate: f64,

    /// Inputs over time: a CSV file with `t` and `u_<input>` columns, linear in between;
    /// without it they stay as in the initial state
    #[arg(long, value_name = "FILE.csv")]
    inputs: Option<PathBuf>,

    /// A controller in the loop: a TOML file with its rate, delay, gains, reference and limits
    /// (docs/control.md)
    #[arg(long, value_name = "FILE.toml")]
    control: Option<PathBuf>,

    /// Measurement noise to add to what the log shows: a standard deviation for the columns
    /// `q`, `dq`, `ddq` or `u`, or for one column by its name; may be repeated
    #[arg(long, value_name = "COLUMNS=SD")]
    noise: Vec<Noise>,

    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// The largest integration step, in seconds
    #[arg(long, value_name = "SECONDS", default_value = "0.00025", value_parser = positive, allow_negative_numbers = true)]
    max_step: f64,

    /// Show the contacts' impulses, too: columns `impulse_<contact>_<axis>`, N s since the row
    /// before
    #[arg(long)]
    impulses: bool,

    /// Let impacts that end free motion happen at their instants, found to round-off, and list them
    /// in this file: `t,contact,approach,impulse_x,impulse_y,impulse_z`
    #[arg(long, value_name = "FILE.csv")]
    impacts: Option<PathBuf>,

    /// Where the log goes
    #[arg(long, value_name = "LOG.csv")]
    out: PathBuf,
}

/// A log may have this many rows, and the integration this many steps.
const MAX_ROWS: f64 = 1e7;
const MAX_STEPS: f64 = 1e9;

/// Runs the command.
///
/// # Errors
/// If the model, the initial state or the inputs are faulty, or the motion ends on the way.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let rows = rows(arguments.duration, arguments.rate, arguments.max_step)?;
    let mut state = start::read("--init", &arguments.init, model, &loaded.parameters)?;
    let inputs = match &arguments.inputs {
        Some(path) => arguments.read_inputs(path, model, &state)?,
        None => Inputs::constant(
            state
                .u
                .clone()
                .unwrap_or_else(|| vec![0.0; model.inputs.len()]),
        ),
    };
    let control = arguments.control.as_deref();
    let controller = control
        .map(|path| Controller::read(path, model))
        .transpose()?;
    if let Some(controller) = &controller {
        let samples = arguments.duration / controller.interval;
        within(samples, "lower the `rate` of the controller")?;
    }
    for sensor in &model.sensors {
        let readings = arguments.duration * sensor.rate.unwrap_or(0.0);
        within(
            readings,
            &format!("lower the `rate` of the sensor `{}`", sensor.name),
        )?;
    }
    let noise = Channel::of_log(model, &arguments.noise, arguments.seed)?;
    let machine = Machine::new(loaded.compiled.clone());
    let u = inputs.at(state.t);
    if let Some(moved) = start::settle(&machine, &mut state, &u)? {
        output::complain(&moved);
    }
    let mut signal = Signal::open(inputs, machine.delays(&state.parameters));
    if let Some(controller) = &controller {
        signal = signal.commanded(controller.inputs.clone(), controller.interval);
    }
    arguments.check_contacts(model)?;
    let mut log = Recorder::create(&arguments.out, model, arguments.impulses)?;
    let impacts = arguments.impacts.as_deref();
    let mut impacts = impacts.map(ImpactList::create).transpose()?;
    let run = Run {
        machine: &machine,
        parameters: &state.parameters,
        signal,
        controller,
        noise,
        seed: arguments.seed,
        rate: arguments.rate,
        max_step: arguments.max_step,
        impulses: arguments.impulses,
        exact_impacts: impacts.is_some(),
    };
    let progress = progress(rows);
    run.rows(&state, rows, |t, values, hits| {
        progress.inc(1);
        if let Some(impacts) = &mut impacts {
            impacts.add(model, hits)?;
        }
        log.row(t, values)
    })?;
    progress.finish_and_clear();
    log.finish()?;
    impacts.map(ImpactList::finish).transpose()?;
    let name = arguments.out.display();
    let noisy = model.sensors.iter().any(|sensor| sensor.noise > 0.0);
    let seed = if arguments.noise.is_empty() && !noisy {
        String::new()
    } else {
        format!(", noise with seed {}", arguments.seed)
    };
    output::complain(&format!(
        "wrote {name}: {rows} rows at {} Hz{seed}",
        arguments.rate
    ));
    Ok(())
}

/// A positive finite number.
///
/// # Errors
/// What was expected.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        Ok(_) => Err("expected a positive finite number".to_string()),
        Err(_) => Err("expected a number".to_string()),
    }
}

/// Not more steps than can be taken; `cause` is what makes them so many.
fn within(steps: f64, cause: &str) -> Result<(), Mistake> {
    if steps <= MAX_STEPS {
        return Ok(());
    }
    let message = format!("the simulation would take {steps:.1e} steps");
    Err(Mistake::new(message).help(format!("shorten the duration or {cause}")))
}

/// Rows of a log over `duration` s: one at the start, then `rate` per second to the end.
///
/// # Errors
/// If there are too many, or too many steps of at most `max_step` s between them.
pub fn rows(duration: f64, rate: f64, max_step: f64) -> Result<usize, Mistake> {
    // A little more, so that 0.3 s at 10 Hz are three intervals and not two.
    let rows = (duration * rate * (1.0 + 1e-12)).floor() + 1.0;
    if rows > MAX_ROWS {
        let message = format!("the log would have {rows:.1e} rows; it may have {MAX_ROWS:.0e}");
        return Err(Mistake::new(message).help("shorten the duration or lower the rate"));
    }
    within((duration / max_step).max(rows), "raise the largest step")?;
    Ok(rows as usize)
}

fn progress(rows: usize) -> ProgressBar {
    let bar = ProgressBar::new(rows as u64);
    // The default style stands in if the template were ever wrong.
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar
}

impl Arguments {
    /// What is asked of contacts can be given.
    fn check_contacts(&self, model: &Model) -> Result<(), Mistake> {
        let asked = [
            ("--impulses", self.impulses),
            ("--impacts", self.impacts.is_some()),
        ];
        let asked = asked.iter().find(|(_, asked)| *asked);
        if let (Some((option, _)), true) = (asked, model.contacts.is_empty()) {
            let message = format!("`{option}` shows contacts, and the model has none");
            return Err(Mistake::new(message).help("declare what may touch: `contact`"));
        }
        if self.impacts.as_ref() == Some(&self.out) {
            let mistake = Mistake::new("`--impacts` and `--out` name the same file");
            return Err(mistake.help("give the impacts a file of their own"));
        }
        Ok(())
    }

    fn read_inputs(&self, path: &Path, model: &Model, state: &State) -> Result<Inputs, Mistake> {
        if state.u.is_some() {
            let message = "the inputs are given twice: by `--inputs` and by `u` in `--init`";
            return Err(Mistake::new(message).help("drop one of them"));
        }
        let names: Vec<&str> = model.inputs.iter().map(|u| u.name.as_str()).collect();
        let inputs = Inputs::read(path, &names)?;
        let (first, last) = inputs.range();
        let (start, end) = (state.t, state.t + self.duration);
        // The end of a log is one row early: no word about that.
        if start < first || end > last + 1.5 / self.rate {
            let message = format!(
                "`{}` covers {first} s to {last} s, the simulation {start} s to {end} s",
                path.display()
            );
            let help = "the first and the last values are held before and after";
            output::warn(&Mistake::new(message).help(help));
        }
        Ok(inputs)
    }
}
