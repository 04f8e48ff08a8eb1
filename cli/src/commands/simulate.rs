//! `dynamics simulate`: open-loop motion as a log.

use crate::inputs::Inputs;
use crate::json::Text;
use crate::mistake::Mistake;
use crate::model::{self, ModelArguments};
use crate::noise::{Channel, Noise};
use crate::output;
use crate::parameters;
use crate::state::{SHAPE, State};
use crate::whole_file::WholeFile;
use clap::Args;
use dynamics_codegen::Model;
use dynamics_codegen::file::Limit;
use identify::machine::{
    Machine, Memory, Rollout, RolloutOptions, Sensors, Simulated, SolveError, States,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics simulate models/pendulum2.model --init '{\"q\": [1, 0]}' --duration 10 --out log.csv
  dynamics simulate models/cartpole.model --init start.json --inputs force.csv \\
    --duration 5 --rate 500 --noise q=1e-4 --noise dq=2e-3 --seed 7 --out log.csv")]
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

    /// Where the log goes
    #[arg(long, value_name = "LOG.csv")]
    out: PathBuf,
}

/// A log may have this many rows, and the integration this many steps.
const MAX_ROWS: f64 = 1e7;
const MAX_STEPS: f64 = 1e9;
/// A violation of the constraints that is worth a word, relative to one.
const WORTH_A_WORD: f64 = 1e-9;
/// One takes a few Newton steps; from far away they need more.
const PROJECTIONS: usize = 20;
const INIT: Limit = Limit {
    what: "an initial state",
    bytes: 16 << 20,
};

/// Runs the command.
///
/// # Errors
/// If the model, the initial state or the inputs are faulty, or the motion ends on the way.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let rows = arguments.rows()?;
    let mut state = arguments.initial_state(model, &loaded.parameters)?;
    let inputs = match &arguments.inputs {
        Some(path) => arguments.read_inputs(path, model, &state)?,
        None => Inputs::constant(
            state
                .u
                .clone()
                .unwrap_or_else(|| vec![0.0; model.inputs.len()]),
        ),
    };
    let noise = Channel::of_log(model, &arguments.noise, arguments.seed)?;
    let machine = Machine::new(loaded.compiled.clone());
    project(&machine, &mut state, &inputs)?;
    let mut log = Log {
        file: WholeFile::create(&arguments.out)?,
        noise,
    };
    log.header(model)?;
    let run = Run {
        machine: &machine,
        parameters: &state.parameters,
        inputs: &inputs,
        sensors: machine.clone().sensors(&[]),
        delays: machine.delays(&state.parameters),
        start: state.t,
        rate: arguments.rate,
        max_step: arguments.max_step,
    };
    run.write(&state, rows, &mut log)?;
    log.file.finish()?;
    let name = arguments.out.display();
    let seed = if arguments.noise.is_empty() {
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

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        Ok(_) => Err("expected a positive finite number".to_string()),
        Err(_) => Err("expected a number".to_string()),
    }
}

impl Arguments {
    /// Rows of the log: one at the start, then `rate` per second to the end.
    fn rows(&self) -> Result<usize, Mistake> {
        // A little more, so that 0.3 s at 10 Hz are three intervals and not two.
        let rows = (self.duration * self.rate * (1.0 + 1e-12)).floor() + 1.0;
        if rows > MAX_ROWS {
            let message = format!("the log would have {rows:.1e} rows; it may have {MAX_ROWS:.0e}");
            return Err(Mistake::new(message).help("shorten `--duration` or lower `--rate`"));
        }
        let steps = (self.duration / self.max_step).max(rows);
        if steps > MAX_STEPS {
            let message = format!("the simulation would take {steps:.1e} steps");
            return Err(Mistake::new(message).help("shorten `--duration` or raise `--max-step`"));
        }
        Ok(rows as usize)
    }

    fn initial_state(&self, model: &Model, nominal: &[f64]) -> Result<State, Mistake> {
        let inline = self.init.trim_start().starts_with('{');
        let (file, bytes) = if inline {
            ("--init".to_string(), self.init.clone().into_bytes())
        } else {
            let path = Path::new(&self.init);
            let bytes = model::read(path, INIT)
                .map_err(|mistake| mistake.help("`--init` takes a file, or the JSON itself"))?;
            (self.init.clone(), bytes)
        };
        let text = Text {
            file: &file,
            first_line: 1,
            text: parameters::text(&file, &bytes)?,
            shape: SHAPE,
        };
        let (state, warnings) = State::read(text, model, nominal)?;
        warnings.iter().for_each(output::warn);
        Ok(state)
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

/// Moves the state onto the constraints and says so.
fn project(machine: &Machine, state: &mut State, inputs: &Inputs) -> Result<(), Mistake> {
    let before = state.clone();
    // First as it stands: the projection needs finite terms to begin with.
    violation(machine, state, inputs)?;
    let mut left = f64::INFINITY;
    for _ in 0..PROJECTIONS {
        machine.project(state.t, &mut state.q, &mut state.v, &state.parameters);
        left = violation(machine, state, inputs)?;
        if left <= WORTH_A_WORD {
            break;
        }
    }
    if left > WORTH_A_WORD {
        let message =
            format!("no state near the initial one fulfils the constraints (off by {left:.1e})");
        return Err(Mistake::new(message).help("begin closer to a state that fulfils them"));
    }
    let distance = |a: &[f64], b: &[f64]| {
        let gaps = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        gaps.fold(0.0_f64, f64::max)
    };
    let (dq, dv) = (distance(&state.q, &before.q), distance(&state.v, &before.v));
    if dq.max(dv) > WORTH_A_WORD {
        output::complain(&format!(
            "initial state moved onto the constraints: positions by up to {}, velocities by up to {}",
            short(dq),
            short(dv)
        ));
    }
    Ok(())
}

fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_string(),
        value if (1e-3..1e4).contains(&value) => format!("{value:.4}"),
        value => format!("{value:.2e}"),
    }
}

/// The largest of `|c|` and `|ċ|`.
fn violation(machine: &Machine, state: &State, inputs: &Inputs) -> Result<f64, Mistake> {
    let motion = machine
        .motion(
            &at(state.t, &state.q, &state.v, &inputs.at(state.t)),
            &state.parameters,
        )
        .map_err(|error| stopped(error, state.t))?;
    let terms = &motion[0].terms;
    let all = terms
        .constraint_residual
        .iter()
        .chain(terms.constraint_rate.iter());
    Ok(all.fold(0.0_f64, |largest, c| largest.max(c.abs())))
}

fn at(t: f64, q: &[f64], v: &[f64], u: &[f64]) -> States {
    let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
    States {
        t: vec![t],
        q: column(q),
        v: column(v),
        u: column(u),
        ..States::default()
    }
}

/// The motion cannot go on at time `t`.
fn stopped(error: SolveError, t: f64) -> Mistake {
    match error {
        SolveError::Singular { .. } => Mistake::new(format!(
            "at t = {t} s the mass matrix is singular, and the constraints do not make up for it"
        ))
        .help("give every coordinate some inertia"),
        SolveError::Indefinite { .. } => Mistake::new(format!(
            "at t = {t} s the mass matrix is not positive definite: some motion has negative kinetic energy"
        ))
        .help("correct the masses and inertias, or the signs in `kinetic`"),
        SolveError::Inconsistent { miss, .. } => Mistake::new(format!(
            "at t = {t} s the constraints contradict each other (by {miss:.3e} on acceleration level)"
        ))
        .help("drop or correct one of the constraints, or keep away from singular positions"),
        SolveError::Unsettled { .. } => Mistake::new(format!(
            "at t = {t} s the forces do not settle: they depend on multipliers or states that find no balance"
        ))
        .help("lower friction coefficients: with this much, the contact has no or several motions"),
        SolveError::NotFinite { .. } => {
            Mistake::new(format!("at t = {t} s the motion is not finite"))
                .help("lower `--max-step`, or look for forces that grow without bound")
        }
    }
}

/// One simulation.
struct Run<'a> {
    machine: &'a Machine,
    parameters: &'a [f64],
    inputs: &'a Inputs,
    sensors: Sensors,
    /// Which input each delayed one is of, and its delay, s.
    delays: Vec<(usize, f64)>,
    start: f64,
    rate: f64,
    max_step: f64,
}

impl Run<'_> {
    fn write(&self, state: &State, rows: usize, log: &mut Log) -> anyhow::Result<()> {
        let progress = progress(rows);
        let options = RolloutOptions {
            max_step: self.max_step,
            ..RolloutOptions::default()
        };
        let rollout = Rollout::new(self.machine, self.parameters, options);
        let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
        let mut simulated = Simulated {
            q: column(&state.q),
            v: column(&state.v),
            z: state.z.as_deref().map_or_else(Vec::new, column),
        };
        let mut t = self.start;
        for row in 0..rows {
            let next = self.start + row as f64 / self.rate;
            self.advance(&rollout, &mut simulated, t, next)?;
            t = next;
            self.write_row(&simulated, t, log)?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// From `t` to `end`, with a stop at every corner of the inputs on the way.
    fn advance(
        &self,
        rollout: &Rollout<'_>,
        simulated: &mut Simulated,
        mut t: f64,
        end: f64,
    ) -> Result<(), Mistake> {
        let column = |values: Vec<f64>| values.into_iter().map(|value| vec![value]).collect();
        while t < end {
            let next = self.next_corner(t).min(end);
            let from: Vec<Vec<f64>> = column(self.inputs_at(t));
            let to: Vec<Vec<f64>> = column(self.inputs_at(next));
            rollout
                .advance(simulated, &[t], next - t, &from, &to)
                .map_err(|error| stopped(error, t))?;
            t = next;
        }
        Ok(())
    }

    /// The inputs, then the delayed ones.
    fn inputs_at(&self, t: f64) -> Vec<f64> {
        let mut inputs = self.inputs.at(t);
        let delayed = self
            .delays
            .iter()
            .map(|&(input, tau)| self.inputs.at(t - tau)[input]);
        inputs.extend(delayed.collect::<Vec<_>>());
        inputs
    }

    /// The first time behind `t` at which an input, delayed or not, may change direction.
    fn next_corner(&self, t: f64) -> f64 {
        let delays = self.delays.iter().map(|&(_, tau)| tau).chain([0.0]);
        // Rounding must not find the same corner again.
        let behind = t + 1e-12 * (1.0 + t.abs());
        let corners = delays.filter_map(|tau| Some(self.inputs.next_corner(behind - tau)? + tau));
        corners.fold(f64::INFINITY, f64::min)
    }

    fn write_row(&self, simulated: &Simulated, t: f64, log: &mut Log) -> anyhow::Result<()> {
        let u = self.inputs.at(t);
        let late = self.inputs_at(t).split_off(u.len());
        let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
        let states = States {
            t: vec![t],
            q: simulated.q.clone(),
            v: simulated.v.clone(),
            u: column(&u),
            memory: Memory {
                delay_rate: vec![vec![0.0]; late.len()],
                delayed: column(&late),
                z: simulated.z.clone(),
                ..Memory::default()
            },
            history: None,
        };
        let motions = self
            .machine
            .motion(&states, self.parameters)
            .map_err(|error| stopped(error, t))?;
        let a: Vec<Vec<f64>> = motions[0].acceleration.iter().map(|&a| vec![a]).collect();
        let states = self.machine.at_rest(&states, self.parameters);
        let read = self.sensors.read(&states, &a, self.parameters);
        let positions = read.q.iter().flatten().copied();
        let velocities = read.v.iter().flatten().copied();
        let values = positions
            .chain(velocities)
            .chain(motions[0].acceleration.iter().copied())
            .chain(u);
        log.row(t, values)
    }
}

fn progress(rows: usize) -> ProgressBar {
    let bar = ProgressBar::new(rows as u64);
    // The default style stands in if the template were ever wrong.
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// The log under construction.
struct Log {
    file: WholeFile,
    noise: Vec<Channel>,
}

impl Log {
    fn header(&mut self, model: &Model) -> anyhow::Result<()> {
        let names = crate::noise::columns(model);
        if let Some(name) = names.iter().find(|name| name.trim() != name.as_str()) {
            let message =
                format!("a log cannot have a column `{name}`: spaces at its end are lost");
            return Err(Mistake::new(message)
                .help("rename the coordinate or input")
                .into());
        }
        let names = std::iter::once("t").chain(names.iter().map(String::as_str));
        // A reader counts what else may stand between cells: in a name it stands in quotes.
        let is_odd = names.clone().any(|name| name.contains([';', '\t']));
        let mut line = csv::WriterBuilder::new()
            .quote_style(match is_odd {
                true => csv::QuoteStyle::NonNumeric,
                false => csv::QuoteStyle::Necessary,
            })
            .from_writer(Vec::new());
        line.write_record(names)?;
        Ok(self.file.write_all(&line.into_inner()?)?)
    }

    fn row(&mut self, t: f64, values: impl Iterator<Item = f64>) -> anyhow::Result<()> {
        write!(self.file, "{t:?}")?;
        for (value, channel) in values.zip(&mut self.noise) {
            write!(self.file, ",{:?}", value + channel.draw())?;
        }
        writeln!(self.file)?;
        Ok(())
    }
}
