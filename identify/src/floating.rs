//! Bodies that float by their twists, held against logs by the rates of their poses.
//!
//! A log is read against positions that each have a velocity of their own. A body that floats by its twist
//! (`velocities: twist`) has seven positions for six velocities; with `velocities: rates` the same machine has
//! seven of each, and a constraint holds its quaternion at unit length. Logs are read against that, and what is
//! found is written into the model as it was given, where it can be said there.

use crate::log::Log;
use crate::robot_options::with_choice;
use dynamics_codegen::model::{POSE, Pose, TWIST};
use dynamics_codegen::{Compiled, Library, Model, Report, compile};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3, Vector4};
use std::collections::BTreeMap;

/// The option that says which velocities a floating body has.
const OPTION: &str = "velocities";

/// A model and its logs, by the rates of poses.
#[derive(Debug)]
pub(crate) struct ByRates {
    /// The model's text.
    pub text: String,
    /// The same, compiled.
    pub compiled: Compiled,
    /// The log to learn from, with rates of poses beside twists.
    pub train: Log,
    /// The log to judge by, if there is one, likewise.
    pub test: Option<Log>,
}

/// Why a model whose bodies float by their twists cannot be held against a log.
#[derive(Debug)]
pub(crate) struct Unrated {
    /// A body that does.
    pub body: String,
    /// What the compiler says of the model by rates.
    pub report: Report,
}

impl ByRates {
    /// A model, as text and compiled, and its logs, if bodies in it float by their twists.
    ///
    /// # Errors
    /// If the model says what it can say of a twist alone, such as an effect on one of its components.
    pub fn of(
        (name, text, library): (&str, &str, &Library),
        model: &Model,
        (train, test): (&Log, Option<&Log>),
    ) -> Result<Option<Self>, Unrated> {
        let Some(first) = model.poses.first() else {
            return Ok(None);
        };
        let text = with_choice(text, OPTION, "rates");
        let compiled = compile(name, &text, library).map_err(|report| Unrated {
            body: first.name.clone(),
            report,
        })?;
        let rated = |log: &Log| {
            let mut log = log.clone();
            for pose in &model.poses {
                add_rates(&mut log, pose);
            }
            log
        };
        Ok(Some(Self {
            text,
            compiled,
            train: rated(train),
            test: test.map(rated),
        }))
    }

    /// Values of the parameters of a model with the same ones, in the order of this one.
    pub fn values(&self, of: &Model, values: &[f64]) -> Vec<f64> {
        let given = of.parameters.iter().map(|p| &p.name).zip(values);
        let given: BTreeMap<&String, &f64> = given.collect();
        let own = &self.compiled.model.parameters;
        let own = own
            .iter()
            .map(|p| given.get(&p.name).map_or(p.nominal, |&&x| x));
        own.collect()
    }
}

/// A model that something was written into, whose bodies floated by their twists: as it was, or by rates if what was
/// written cannot be said of twists, such as an effect on a coordinate of the pose.
///
/// # Errors
/// If it compiles neither way.
pub(crate) fn as_given(name: &str, text: &str, library: &Library) -> Result<String, Report> {
    let by_twists = with_choice(text, OPTION, "twist");
    match compile(name, &by_twists, library) {
        Ok(_) => Ok(by_twists),
        Err(_) => {
            let by_rates = with_choice(text, OPTION, "rates");
            compile(name, &by_rates, library).map(|_| by_rates)
        }
    }
}

/// Adds columns of the rates of a pose to a log that has its twist, or its linear or its angular velocity alone:
/// `ẋ = R v` and `η̇ = ½ η ⊗ (ω, 0)`; and of their rates, `ẍ = R (v̇ + ω × v)` and
/// `η̈ = ½ (η ⊗ (ω̇, 0) + η̇ ⊗ (ω, 0))`. Columns that are there stay.
fn add_rates(log: &mut Log, pose: &Pose) {
    let name = |prefix: &str, ending: &str| format!("{prefix}_{}_{ending}", pose.name);
    let columns = |log: &Log, prefix: &str, endings: &[(&str, &str)]| {
        let column = |(ending, _): &(&str, &str)| log.channels.get(&name(prefix, ending)).cloned();
        endings.iter().map(column).collect::<Option<Vec<_>>>()
    };
    let Some(quaternion) = columns(log, "q", &POSE[3..]) else {
        return;
    };
    let samples = 0..log.t.len();
    let [linear, angular] = [&TWIST[..3], &TWIST[3..]].map(|endings| {
        ["dq", "ddq"].map(|prefix| {
            let columns = columns(log, prefix, endings)?;
            let vector = |k: usize| Vector3::from_fn(|i, _| columns[i][k]);
            Some(samples.clone().map(vector).collect::<Vec<_>>())
        })
    });
    let eta = |k: usize| Quaternion::from(Vector4::from_fn(|i, _| quaternion[i][k]));
    let turned = |k: usize, vector: Vector3<f64>| UnitQuaternion::new_normalize(eta(k)) * vector;
    let spun =
        |quaternion: Quaternion<f64>, w: Vector3<f64>| 0.5 * quaternion * Quaternion::from_imag(w);
    let ([v, dv], [w, dw]) = (&linear, &angular);
    let mut keep = |prefix: &str, endings: &[(&str, &str)], columns: Vec<Vec<f64>>| {
        for ((ending, _), column) in endings.iter().zip(columns) {
            log.channels.entry(name(prefix, ending)).or_insert(column);
        }
    };
    if let Some(v) = v {
        let each = samples.clone().map(|k| turned(k, v[k]));
        keep("dq", &POSE[..3], transposed(each));
    }
    if let Some(w) = w {
        let each = samples.clone().map(|k| spun(eta(k), w[k]).coords);
        keep("dq", &POSE[3..], transposed(each));
    }
    if let (Some(v), Some(w), Some(dv)) = (v, w, dv) {
        let each = samples
            .clone()
            .map(|k| turned(k, dv[k] + w[k].cross(&v[k])));
        keep("ddq", &POSE[..3], transposed(each));
    }
    if let (Some(w), Some(dw)) = (w, dw) {
        let each = samples.map(|k| (spun(eta(k), dw[k]) + spun(spun(eta(k), w[k]), w[k])).coords);
        keep("ddq", &POSE[3..], transposed(each));
    }
}

/// A column per component of vectors.
fn transposed<const N: usize>(vectors: impl Iterator<Item = SVector<f64, N>>) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); N];
    for vector in vectors {
        let pairs = columns.iter_mut().zip(vector.iter());
        pairs.for_each(|(column, &x)| column.push(x));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    const HULL: &str = include_str!("../tests/floating/hull.urdf");
    const MODEL: &str = include_str!("../tests/floating/hull.model");

    fn library() -> Library {
        let mut library = Library::builtin();
        library.add_file("hull.urdf", "hull.urdf", HULL);
        library
    }

    /// On a circle of radius 2, forwards and turning by one radian per second.
    #[test]
    fn a_twist_says_what_a_pose_changes_by() {
        let pose: [fn(f64) -> f64; 7] = [
            |t| 2.0 * t.sin(),
            |t| 2.0 - 2.0 * t.cos(),
            |_| 0.0,
            |_| 0.0,
            |_| 0.0,
            |t| (0.5 * t).sin(),
            |t| (0.5 * t).cos(),
        ];
        let times = || (0..60).map(|k| 0.1 * f64::from(k));
        let mut columns = vec![("t".to_string(), times().collect::<Vec<f64>>())];
        for ((ending, _), at) in POSE.iter().zip(pose) {
            columns.push((format!("q_hull_{ending}"), times().map(at).collect()));
        }
        for (k, (ending, _)) in TWIST.iter().enumerate() {
            let value = [2.0, 0.0, 0.0, 0.0, 0.0, 1.0][k];
            columns.push((format!("dq_hull_{ending}"), vec![value; 60]));
            columns.push((format!("ddq_hull_{ending}"), vec![0.0; 60]));
        }
        let compiled = compile("hull.model", MODEL, &library()).unwrap();
        let pose = &compiled.model.poses[0];
        let rated = |columns: Vec<(String, Vec<f64>)>| {
            let mut log = Log::from_columns("circle", columns, None).unwrap();
            add_rates(&mut log, pose);
            log
        };
        let log = rated(columns.clone());
        // A gyroscope alone says how the quaternion changes.
        columns.retain(|(name, _)| !name.starts_with("dq_hull_v"));
        let turning = rated(columns);
        let rates_of =
            |log: &Log| ["dq_hull_qz", "ddq_hull_qw"].map(|name| log.channels[name].clone());
        assert_eq!(rates_of(&turning), rates_of(&log));
        assert!(!turning.channels.contains_key("dq_hull_x"));
        let rates: [fn(f64) -> [f64; 2]; 4] = [
            |t| [2.0 * t.cos(), -2.0 * t.sin()],
            |t| [2.0 * t.sin(), 2.0 * t.cos()],
            |t| [0.5 * (0.5 * t).cos(), -0.25 * (0.5 * t).sin()],
            |t| [-0.5 * (0.5 * t).sin(), -0.25 * (0.5 * t).cos()],
        ];
        for (ending, expected) in ["x", "y", "qz", "qw"].iter().zip(rates) {
            for (k, t) in times().enumerate() {
                let at = |prefix| log.channels[&format!("{prefix}_hull_{ending}")][k];
                let [rate, change] = expected(t);
                assert!((at("dq") - rate).abs() < 1e-12, "{ending} at {t}");
                assert!((at("ddq") - change).abs() < 1e-12, "{ending} at {t}");
            }
        }
    }

    /// A spring between hull and world pulls at a position, which a twist has no name for.
    #[test]
    fn what_acts_on_a_pose_is_written_with_rates() {
        let library = library();
        let written = |effect: &str| {
            let text = format!("{MODEL}effect {effect};\n");
            as_given("hull.model", &text, &library).unwrap()
        };
        assert!(written("viscous(wheel)").starts_with(MODEL));
        assert!(written("spring(hull_x)").contains("velocities: rates;"));
    }
}
