//! Jumping up: standing up by the reaction wheel (Fig. 6.13), rolling up by the rolling wheel (Fig. 6.14); once as the
//! figure shows it, then 200 times on other floors with other robots.

use super::interval::Rate;
use super::study::{
    Chart, Chassis, Cloud, Finding, Motion, Study, StudyError, Table, charts, largest_torque,
};
use crate::jump::plans::{FIRST, SPUN, Steps, found, published};
use crate::jump::{Conditions, Floor, Jumped, Ready, Way, draw};
use crate::motors::{FREE_SPEED, STALL_TORQUE};
use crate::robot::{PITCH, ROLL};
use crate::sensing::Sensing;
use crate::trial::{Outcome, wheel_rates};
use rayon::prelude::*;
use wheelbot_firmware::{Gains, INTERVAL};

/// Trials.
const TRIALS: usize = 200;
/// How long a robot balances behind the second pulse, s.
const BALANCED: f64 = 1.6;
/// Who is within this tilt over the last half second stands, rad: 5°.
const UPRIGHT: f64 = 0.087;
const LAST: f64 = 0.5;
/// Friction from which on it has to succeed, and how often.
const GRIP: f64 = 0.6;
const OFTEN: f64 = 0.95;
/// How long a step may take, s.
const MOST_SECONDS: f64 = 1.0;
/// By how much an angle of the text may be missed, degrees.
const CLOSE: f64 = 2.0;
/// Within this of upright the second step is over, rad: 2°.
const UP: f64 = 0.035;
/// Who turns slower than this rests, rad/s.
const RESTS: f64 = 0.1;
/// Bounds of the table's rows.
const FRICTIONS: [f64; 6] = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// What the text says of a way up.
struct Stated {
    title: &'static str,
    figure: &'static str,
    /// Turn of both steps, degrees.
    steps: [f64; 2],
    /// Which angle turns.
    place: usize,
}

fn stated(way: Way) -> Stated {
    match way {
        Way::Roll => Stated {
            title: "Standing up by the reaction wheel",
            figure: "Fig. 6.13",
            steps: [60.0, 30.0],
            place: ROLL,
        },
        Way::Pitch => Stated {
            title: "Rolling up by the rolling wheel",
            figure: "Fig. 6.14",
            steps: [55.0, 35.0],
            place: PITCH,
        },
    }
}

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(way: Way, gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let floor = Floor::new()?;
    let bench = Bench {
        way,
        gains,
        floor: &floor,
    };
    let shown = bench.run(found(way), Conditions::NOMINAL, seed)?;
    let trials = bench.trials(seed)?;
    let robot = bench.run(published(way), Conditions::NOMINAL, seed)?;
    let said = stated(way);
    let steps = found(way);
    let mut findings = turns(&shown, &steps, &said);
    findings.extend(limits(&shown, &steps));
    findings.extend(successes(&trials));
    findings.push(Finding::only_here(
        "With the robot's own currents, on the masses of Table 6.1",
        told(&robot, &said),
    ));
    Ok(Study {
        title: format!("{} ({})", said.title, said.figure),
        about: vec![
            format!(
                "From lying on a side: the wheel is brought to {SPUN} rad/s against the first pulse, which begins at \
                 {FIRST} s; the second at {} s. The controllers take over near upright.",
                steps.second()
            ),
            "The edges of the chassis and both wheels touch the floor, stick, slide and lift off. The chassis has the \
             width and height with which it rests at the text's angles between the steps."
                .into(),
        ],
        findings,
        tables: vec![by_friction(&trials)],
        charts: shown_charts(&shown),
        maps: Vec::new(),
        clouds: clouds(&trials),
        motion: Motion {
            lifts: shown.lifts.clone(),
            chassis: Some(Chassis::PUBLISHED),
            ..Motion::of(&shown.rows)
        },
    })
}

/// What every run shares.
struct Bench<'a> {
    way: Way,
    gains: Gains<f64>,
    floor: &'a Floor,
}

/// A trial: where, and whether the robot stood in the end.
struct Tried {
    conditions: Conditions,
    stood: bool,
    /// Whether the contacts had no solution on the way; it counts as not standing.
    unsolved: bool,
}

impl Bench<'_> {
    /// One way up, by a robot that knows its bias.
    fn run(&self, steps: Steps, conditions: Conditions, seed: u64) -> Result<Jumped, StudyError> {
        let ready = Ready::new(conditions, self.gains, Sensing::new(seed)?)?;
        Ok(ready.run(self.floor, &steps, steps.second() + BALANCED)?)
    }

    fn trials(&self, seed: u64) -> Result<Vec<Tried>, StudyError> {
        let drawn = draw::conditions(TRIALS, seed);
        let tried = (1..).zip(drawn).collect::<Vec<(u64, _)>>();
        let trial = |(k, conditions): &(u64, Conditions)| {
            let noise = seed.wrapping_mul(TRIALS as u64).wrapping_add(*k);
            let jumped = self.run(found(self.way), conditions.clone(), noise);
            let (stood, unsolved) = match jumped {
                Ok(jumped) => (stood(&jumped), false),
                Err(StudyError::Contact(_)) => (false, true),
                Err(other) => return Err(other),
            };
            Ok(Tried {
                conditions: conditions.clone(),
                stood,
                unsolved,
            })
        };
        tried.par_iter().map(trial).collect()
    }
}

/// Whether the robot balances in the end.
fn stood(jumped: &Jumped) -> bool {
    let ticks = (LAST / INTERVAL).round() as usize;
    let last = jumped.rows.len().saturating_sub(ticks)..jumped.rows.len();
    let balanced = jumped.balanced.iter().all(Option::is_some);
    !jumped.fell && balanced && last.clone().count() > 0 && {
        let mut tilts = last.map(|tick| jumped.pose(tick).tilt());
        tilts.all(|tilt| tilt < UPRIGHT)
    }
}

/// The angle that turns, degrees from upright, at a tick.
fn angle(jumped: &Jumped, said: &Stated, tick: usize) -> f64 {
    jumped.rows[tick].state.q[said.place].to_degrees()
}

/// When something first is so from a time on, s; `None` if never.
fn first(jumped: &Jumped, from: f64, is: impl Fn(usize) -> bool) -> Option<f64> {
    let mut ticks = (0..jumped.rows.len()).filter(|&k| jumped.rows[k].t >= from);
    ticks.find(|&k| is(k)).map(|k| jumped.rows[k].t)
}

/// How far and how long both steps turn.
fn turns(jumped: &Jumped, steps: &Steps, said: &Stated) -> Vec<Finding> {
    let tick = |t: f64| ((t / INTERVAL).round() as usize).min(jumped.rows.len() - 1);
    let paused = angle(jumped, said, tick(steps.second()));
    let turned = [angle(jumped, said, tick(FIRST)) - paused, paused];
    let at_rest = |k: usize| {
        let state = &jumped.rows[k].state;
        let near = (state.q[said.place].to_degrees() - paused).abs() < CLOSE;
        near && state.v[said.place].abs() < RESTS
    };
    let ends = [
        first(jumped, FIRST, at_rest),
        first(jumped, steps.second(), |k| {
            jumped.rows[k].state.q[said.place].abs() < UP
        }),
    ];
    let begins = [FIRST, steps.second()];
    let finding = |k: usize| {
        let name = ["First step", "Second step"][k];
        let turn = Finding::new(
            &format!("{name}: turn ({})", said.figure),
            &format!("{:.0}°", said.steps[k]),
            format!("{:.1}°", turned[k].abs()),
            (turned[k].abs() - said.steps[k]).abs() < CLOSE,
        );
        let took = ends[k].map(|end| end - begins[k]);
        let time = Finding::new(
            &format!("{name}: time"),
            &format!("below {MOST_SECONDS} s"),
            took.map_or("never there".into(), |took| format!("{took:.2} s")),
            took.is_some_and(|took| took < MOST_SECONDS),
        );
        [turn, time]
    };
    [finding(0), finding(1)].concat()
}

/// Torque and speed, at most.
fn limits(jumped: &Jumped, steps: &Steps) -> Vec<Finding> {
    let torque = largest_torque(&jumped.rows);
    let rates = jumped.rows.iter().flat_map(|row| wheel_rates(&row.state));
    let rate = rates.fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let driving = usize::from(steps.way == Way::Pitch);
    let before = jumped.rows.iter().take_while(|row| row.t <= FIRST);
    let spun = before.map(|row| wheel_rates(&row.state)[driving].abs());
    let spun = spun.fold(0.0, f64::max);
    vec![
        Finding::new(
            "Wheel's rate before the first step",
            &format!("{SPUN} rad/s"),
            format!("{spun:.0} rad/s"),
            (spun - SPUN).abs() < 0.02 * SPUN,
        ),
        Finding::new(
            "Largest torque",
            &format!("{STALL_TORQUE} N·m at stall"),
            format!("{torque:.2} N·m"),
            torque <= STALL_TORQUE,
        ),
        Finding::new(
            "Largest rate of a wheel (Table 6.1)",
            &format!("{FREE_SPEED} rad/s"),
            format!("{rate:.0} rad/s"),
            rate <= FREE_SPEED,
        ),
    ]
}

/// How often it stands.
fn successes(trials: &[Tried]) -> Vec<Finding> {
    let gripping = trials.iter().filter(|t| t.conditions.friction >= GRIP);
    let rate = Rate::of(gripping.map(|trial| trial.stood));
    let all = Rate::of(trials.iter().map(|trial| trial.stood));
    vec![
        Finding::new(
            &format!("Stands, at friction {GRIP} and above"),
            &format!("at least {:.0} %", 100.0 * OFTEN),
            rate.to_string(),
            rate.share() >= OFTEN,
        ),
        Finding::only_here("Stands, of all", all.to_string()),
        Finding::only_here(
            "Trials whose contacts had no solution, counted as not standing",
            trials
                .iter()
                .filter(|trial| trial.unsolved)
                .count()
                .to_string(),
        ),
    ]
}

fn by_friction(trials: &[Tried]) -> Table {
    let row = |bounds: &[f64]| {
        let within = trials.iter().filter(|trial| {
            let friction = trial.conditions.friction;
            (bounds[0]..bounds[1]).contains(&friction)
        });
        let rate = Rate::of(within.map(|trial| trial.stood));
        vec![format!("{} to {}", bounds[0], bounds[1]), rate.to_string()]
    };
    Table {
        title: "Trials that stand in the end, by friction (95 % interval of Wilson)".into(),
        header: vec!["friction".into(), "stand".into()],
        rows: FRICTIONS.windows(2).map(row).collect(),
    }
}

fn clouds(trials: &[Tried]) -> Vec<Cloud> {
    let cloud = |title: &str, label: &str, other: &dyn Fn(&Conditions) -> f64| Cloud {
        title: title.into(),
        axes: ["friction".into(), label.into()],
        points: trials
            .iter()
            .map(|trial| [trial.conditions.friction, other(&trial.conditions)])
            .collect(),
        stood: trials.iter().map(|trial| trial.stood).collect(),
    };
    vec![
        cloud(
            "Trials by friction and weight (open: did not stand)",
            "mass of all, share of the published",
            &|conditions| {
                let [wheel, body, reaction] = conditions.masses;
                (0.3 * wheel + 0.75 * body + 0.3 * reaction) / 1.35
            },
        ),
        cloud(
            "Trials by friction and start (open: did not stand)",
            "held above flat, negative on the other side [°]",
            &|conditions| {
                let side = if conditions.positive { 1.0 } else { -1.0 };
                side * conditions.tilt.to_degrees()
            },
        ),
    ]
}

fn shown_charts(jumped: &Jumped) -> Vec<Chart> {
    let outcome = Outcome {
        rows: jumped.rows.clone(),
        fell: jumped.fell,
    };
    let mut charts = charts(&outcome);
    charts.push(Chart {
        title: "height of the rolling wheel's lowest point [mm]".into(),
        curves: vec![(
            "above the floor".into(),
            jumped.lifts.iter().map(|lift| 1e3 * lift).collect(),
        )],
    });
    charts
}

/// How far somebody got.
fn told(jumped: &Jumped, said: &Stated) -> String {
    let end = jumped.rows.len() - 1;
    match stood(jumped) {
        true => "stands".into(),
        false => {
            let angles = (0..=end).map(|tick| angle(jumped, said, tick).abs());
            let nearest = angles.fold(f64::INFINITY, f64::min);
            format!(
                "does not stand: {nearest:.1}° from upright at best, {:.1}° in the end",
                angle(jumped, said, end)
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the robot's own currents it falls, and its contacts have a solution on all the way.
    #[test]
    fn the_published_currents_do_not_do() {
        let floor = Floor::new().unwrap();
        for way in [Way::Roll, Way::Pitch] {
            let bench = Bench {
                way,
                gains: Gains::PUBLISHED,
                floor: &floor,
            };
            let jumped = bench.run(published(way), Conditions::NOMINAL, 1);
            assert!(!stood(&jumped.unwrap()), "{way:?}");
        }
    }

    /// From either side, by either wheel; without the second pulse it stays on its edge.
    #[test]
    fn it_gets_up_from_either_side() {
        let floor = Floor::new().unwrap();
        for way in [Way::Roll, Way::Pitch] {
            let gains = Gains::PUBLISHED;
            let bench = Bench {
                way,
                gains,
                floor: &floor,
            };
            for positive in [true, false] {
                let conditions = Conditions {
                    positive,
                    ..Conditions::NOMINAL
                };
                let jumped = bench.run(found(way), conditions, 1).unwrap();
                assert!(stood(&jumped), "{way:?}, {positive}");
            }
            let mut lame = found(way);
            lame.pulses[1].current = 0.0;
            let jumped = bench.run(lame, Conditions::NOMINAL, 1).unwrap();
            assert!(!stood(&jumped) && !jumped.fell, "{way:?}");
            let said = stated(way);
            let rests = angle(&jumped, &said, jumped.rows.len() - 1);
            assert!((rests - said.steps[1]).abs() < 1.0, "{way:?}: {rests}");
        }
    }
}
