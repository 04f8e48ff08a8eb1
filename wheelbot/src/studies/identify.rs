//! The loop on the robot: a robot whose body is off its centre, which its model does not say, is traced
//! from its own instruments; then it balances with what its regulator makes of the model before and
//! after.

use super::push::{DIRECTIONS, survived};
use super::record::{MODEL, written};
use super::study::{Chart, Finding, Motion, Study, StudyError, Table};
use crate::design::{Standing, designed_for};
use crate::excitation::Excitation;
use crate::robot::{PITCH, REACTION, ROLL, WHEEL, Wheelbot, X, Y};
use crate::sensing::Sensing;
use crate::trial::{Outcome, Row, Trial, rms};
use dynamics_codegen::{Library, compile};
use identify::log::Log;
use identify::trace::{Finding as Traced, Request, trace};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use wheelbot_firmware::Gains;

/// How far the centre of mass is off at least and at most, m.
const OFFSET: [f64; 2] = [0.003, 0.006];
/// How long the logs are that are learnt from and judged by, s.
const SECONDS: [f64; 2] = [8.0, 5.0];
/// How long the robot balances afterwards, s, and how much of that counts.
const BALANCE: [f64; 2] = [20.0, 10.0];
/// Standard errors within which an estimate is right.
const RIGHT: f64 = 3.0;

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let truth = Truth::drawn(seed);
    let sensing = Sensing::new(seed)?.calibrated();
    let [train, test] = [0, 1].map(|which| truth.log(which, gains, &mut sensing.clone()));
    let (train, test) = (train?, test?);
    let library = Library::builtin();
    let request = Request {
        test: Some(&test),
        ..Request::new(MODEL.0, MODEL.1, &library, &train)
    };
    let outcome = trace(&request).map_err(Box::new)?;
    let [before, after] =
        [MODEL.1, &outcome.patched_model].map(|text| Balanced::with(text, &truth, &sensing));
    let (before, after) = (before?, after?);
    let named: Vec<String> = outcome.findings.iter().map(described).collect();
    let mut findings = vec![Finding::new(
        "What the model lacks, from its own instruments",
        &format!("{} = {:.2} mm", truth.name, 1e3 * truth.offset),
        if named.is_empty() {
            "nothing".into()
        } else {
            named.join("; ")
        },
        truth.is_found(&outcome.findings),
    )];
    findings.extend(compared(&before, &after, truth.stands()?));
    Ok(Study {
        title: "What a finding is worth to the robot".into(),
        about: vec![
            format!(
                "The body's centre of mass is off by an offset that seed {seed} draws, and the model does not say so. The robot \
                 balances and drives for {} s; its log has four IMUs, calibrated on a bench, two encoders and both torques.",
                SECONDS[0]
            ),
            "Before and after: the regulator for the model as given and as repaired, each with the tilt at which its \
             model stands still as (6.22)'s bias, on the robot as it is."
                .into(),
            format!(
                "Errors of the model's accelerations on a log that nothing was fitted to, as a share of their size: \
                 {:.3} before, {:.3} after, {:.3} if it were exactly right.",
                outcome.before.acceleration.total,
                outcome.after.acceleration.total,
                outcome.noise_floor.acceleration.total
            ),
        ],
        findings,
        tables: vec![pushes(&before, &after)],
        charts: shown(&before, &after),
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion::of(&after.outcome.rows),
    })
}

/// The robot as it is, in what its model does not say.
struct Truth {
    /// The parameter, `b_x` or `b_y`.
    name: &'static str,
    /// Its value, m.
    offset: f64,
    plant: Wheelbot<f64>,
}

impl Truth {
    fn drawn(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (size, is_left, is_aside) = (
            random.random_range(OFFSET[0]..OFFSET[1]),
            random.random(),
            random.random(),
        );
        let offset = if is_left { size } else { -size };
        let mut plant = Wheelbot::nominal();
        let name = match is_aside {
            true => {
                plant.parameters.b_y = offset;
                "b_y"
            }
            false => {
                plant.parameters.b_x = offset;
                "b_x"
            }
        };
        Self {
            name,
            offset,
            plant,
        }
    }

    /// Roll and pitch at which it stands still, rad.
    fn stands(&self) -> Result<[f64; 2], StudyError> {
        let mut compiled = compile(MODEL.0, MODEL.1, &Library::builtin())?;
        let own = compiled
            .model
            .parameters
            .iter_mut()
            .find(|p| p.name == self.name);
        own.expect("the model has both offsets").nominal = self.offset;
        Ok(Standing::of(compiled)?.tilt)
    }

    /// Whether the offset and nothing else was found, and right.
    fn is_found(&self, findings: &[Traced]) -> bool {
        let [found] = findings else { return false };
        let own = found.parameters.get(self.name);
        own.is_some_and(|own| (own.value - self.offset).abs() < RIGHT * own.std)
    }

    /// A log as the robot writes it while it balances and swings.
    fn log(
        &self,
        which: usize,
        gains: Gains<f64>,
        sensing: &mut Sensing,
    ) -> Result<Log, StudyError> {
        let mut trial = Trial::new(SECONDS[which], gains);
        trial.plant = self.plant;
        trial.excitations = swings(which);
        let rows = trial.run(sensing)?.rows;
        written(
            ["train.csv", "test.csv"][which],
            &self.plant,
            &rows,
            sensing,
        )
    }
}

/// Torques that move all that the instruments could show: both wheels, at frequencies of which none is a
/// multiple of another.
fn swings(which: usize) -> Vec<Excitation> {
    let tones = [[0.31, 0.83, 1.9, 3.3], [0.37, 0.71, 2.3, 2.9]][which];
    let swing = |(place, frequency): (usize, f64)| Excitation {
        at: 0.0,
        seconds: f64::INFINITY,
        frequency,
        phase: place as f64,
        torque: [0.04, 0.02],
        turning_point: 1.0,
    };
    tones.into_iter().enumerate().map(swing).collect()
}

/// The true robot on the regulator of a model.
struct Balanced {
    outcome: Outcome,
    /// Impulses that are survived, N·s, by direction.
    pushes: Vec<f64>,
}

impl Balanced {
    fn with(text: &str, truth: &Truth, sensing: &Sensing) -> Result<Self, StudyError> {
        let standing = Standing::of(compile(MODEL.0, text, &Library::builtin())?)?;
        let mut trial = Trial::new(BALANCE[0], designed_for(&standing)?);
        trial.plant = truth.plant;
        trial.bias = standing.tilt;
        let outcome = trial.run(&mut sensing.clone())?;
        let pushes = DIRECTIONS
            .par_iter()
            .map(|&direction| survived(&trial, direction, sensing));
        Ok(Self {
            outcome,
            pushes: pushes.collect::<Result<_, _>>()?,
        })
    }

    fn settled(&self) -> impl Iterator<Item = &Row> + Clone {
        self.outcome
            .rows
            .iter()
            .filter(|row| row.t >= BALANCE[0] - BALANCE[1])
    }

    /// The largest of something while it has settled.
    fn most(&self, value: impl Fn(&Row) -> f64) -> f64 {
        self.settled()
            .map(value)
            .fold(0.0, |most, x| most.max(x.abs()))
    }

    /// How far it stands from where it began, m.
    fn away(&self) -> f64 {
        self.most(|row| row.state.q[X].hypot(row.state.q[Y]))
    }

    /// How far a wheel has turned against the body: the feedback trades what the tilt is thought to be off for it, rad.
    fn strayed(&self) -> f64 {
        let rolling = self.most(|row| row.state.q[WHEEL] - row.state.q[PITCH]);
        rolling.max(self.most(|row| row.state.q[REACTION]))
    }

    /// Root mean square of the tilt beside where it stands still, degrees.
    fn tilt(&self, stands: [f64; 2]) -> f64 {
        let aside =
            |row: &Row| (row.state.q[ROLL] - stands[0]).hypot(row.state.q[PITCH] - stands[1]);
        rms(self.settled().map(aside)).to_degrees()
    }

    /// The largest push that it survives from every direction, N·s.
    fn least_push(&self) -> f64 {
        self.pushes.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// A finding in one line.
fn described(found: &Traced) -> String {
    let numbers = found.parameters.iter().map(|(name, estimate)| {
        format!(
            "{name} = {:.3e} ± {:.1e} {}",
            estimate.value, estimate.std, estimate.unit
        )
    });
    let numbers: Vec<String> = numbers.collect();
    format!(
        "{} {}: {}",
        found.effect,
        found.on.join(", "),
        numbers.join(", ")
    )
}

/// What the robot does on either regulator; it stands still where `stands` says.
fn compared(before: &Balanced, after: &Balanced, stands: [f64; 2]) -> Vec<Finding> {
    let line = |what: &str, of: &dyn Fn(&Balanced) -> f64, unit: &str| {
        let [first, second] = [before, after].map(of);
        Finding::only_here(
            what,
            format!("{first:.3} {unit} before, {second:.3} {unit} after"),
        )
    };
    let is_better = after.strayed() < before.strayed() && !after.outcome.fell;
    vec![
        Finding::new(
            "Farthest turn of a wheel from where it began",
            "less after than before",
            format!(
                "{:.2} rad before, {:.2} rad after",
                before.strayed(),
                after.strayed()
            ),
            is_better,
        ),
        line("Farthest from where it began", &Balanced::away, "m"),
        line(
            "Tilt beside the true balance, rms",
            &|balanced| balanced.tilt(stands),
            "°",
        ),
        line(
            "Largest push survived from every direction",
            &Balanced::least_push,
            "N·s",
        ),
    ]
}

fn pushes(before: &Balanced, after: &Balanced) -> Table {
    let row = |(k, direction): (usize, &f64)| {
        vec![
            format!("{direction:.0}°"),
            format!("{:.2}", before.pushes[k]),
            format!("{:.2}", after.pushes[k]),
        ]
    };
    Table {
        title: "Largest push survived, N·s, by direction (0°: from behind, 90°: from the right)"
            .into(),
        header: ["", "before", "after"].map(String::from).to_vec(),
        rows: DIRECTIONS.iter().enumerate().map(row).collect(),
    }
}

/// The motion after the repair, with the same run before it beside each curve.
fn shown(before: &Balanced, after: &Balanced) -> Vec<Chart> {
    let chart = |title: &str, value: &dyn Fn(&Row) -> f64| {
        let of = |balanced: &Balanced| balanced.outcome.rows.iter().map(value).collect();
        Chart {
            title: title.into(),
            curves: vec![("before".into(), of(before)), ("after".into(), of(after))],
        }
    };
    vec![
        chart("roll [°]", &|row| row.state.q[ROLL].to_degrees()),
        chart("pitch [°]", &|row| row.state.q[PITCH].to_degrees()),
        chart("rolled [m]", &|row| row.state.q[X].hypot(row.state.q[Y])),
        chart("turn of the reaction wheel [rad]", &|row| {
            row.state.q[REACTION]
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the true number in the model the robot stands where it should; with none it runs away.
    #[test]
    fn a_robot_off_its_centre_is_balanced_by_who_knows_it() {
        let truth = Truth::drawn(1);
        let sensing = Sensing::new(1).unwrap().calibrated();
        let known = format!("parameter {}: m = 0;", truth.name);
        assert!(MODEL.1.contains(&known));
        let repaired = MODEL.1.replace(
            &known,
            &format!("parameter {}: m = {};", truth.name, truth.offset),
        );
        let [before, after] =
            [MODEL.1, &repaired].map(|text| Balanced::with(text, &truth, &sensing).unwrap());
        assert!(!after.outcome.fell && after.least_push() > 0.3);
        assert!(after.strayed() < 0.2 * before.strayed());
        assert!(after.tilt(truth.stands().unwrap()) < 1.0);
    }

    #[test]
    fn seeds_draw_different_robots() {
        let [one, two] = [1, 2].map(Truth::drawn);
        assert!(one.offset != two.offset);
        assert!(one.offset.abs() >= OFFSET[0] && one.offset.abs() < OFFSET[1]);
    }
}
