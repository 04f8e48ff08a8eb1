//! Measurement noise for simulated logs.

use crate::mistake::Mistake;
use crate::parameters;
use dynamics_codegen::Model;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::str::FromStr;

/// `q=1e-4`: a standard deviation for a group of columns, or for one.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    columns: String,
    sd: f64,
}

impl FromStr for Noise {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((columns, sd)) = text.split_once('=') else {
            return Err("expected `columns=sd`, such as `q=1e-4` or `dq_j1=0.002`".to_string());
        };
        match sd.trim().parse::<f64>() {
            Ok(sd) if sd.is_finite() && sd >= 0.0 => Ok(Self {
                columns: columns.trim().to_string(),
                sd,
            }),
            _ => Err(format!(
                "`{sd}` is not a standard deviation: a finite number from 0 up"
            )),
        }
    }
}

/// The columns of a log behind `t`: positions, velocities, accelerations, inputs.
pub fn columns(model: &Model) -> Vec<String> {
    let positions = model.positions();
    let of = |group: &str, names: Vec<&String>| -> Vec<String> {
        names.iter().map(|name| format!("{group}_{name}")).collect()
    };
    let coordinates = || model.coordinates.iter().map(|c| &c.name).collect();
    let inputs = model.inputs.iter().map(|u| &u.name).collect();
    [
        of("q", positions.iter().map(|p| &p.name).collect()),
        of("dq", coordinates()),
        of("ddq", coordinates()),
        of("u", inputs),
    ]
    .concat()
}

/// The noise of one column: a stream of its own, so that noise on one column does not
/// change that of another.
#[derive(Debug)]
pub struct Channel {
    sd: f64,
    random: ChaCha8Rng,
}

impl Channel {
    /// One channel per column of the log. Later entries of `noise` win.
    ///
    /// # Errors
    /// If an entry names a column that the log does not have.
    pub fn of_log(model: &Model, noise: &[Noise], seed: u64) -> Result<Vec<Self>, Mistake> {
        let columns = columns(model);
        let mut deviations = vec![0.0; columns.len()];
        for Noise { columns: meant, sd } in noise {
            let is_group = ["q", "dq", "ddq", "u"].contains(&meant.as_str());
            let is_meant = |column: &String| match column.split_once('_') {
                Some((group, _)) if is_group => group == meant,
                _ => column == meant,
            };
            if !is_group && !columns.iter().any(is_meant) {
                let mistake =
                    Mistake::new(format!("the log has no column `{meant}` to add noise to"));
                let known = columns
                    .iter()
                    .map(String::as_str)
                    .chain(["q", "dq", "ddq", "u"]);
                return Err(parameters::suggest(mistake, meant, known));
            }
            for (deviation, column) in deviations.iter_mut().zip(&columns) {
                if is_meant(column) {
                    *deviation = *sd;
                }
            }
        }
        let deviations = deviations.into_iter().enumerate();
        let channel = |(index, sd): (usize, f64)| Self::new(sd, seed, index as u64);
        Ok(deviations.map(channel).collect())
    }

    /// Noise of this standard deviation; `stream` tells it from others of the same seed.
    pub fn new(sd: f64, seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self { sd, random }
    }

    /// The next value.
    pub fn draw(&mut self) -> f64 {
        if self.sd == 0.0 {
            return 0.0;
        }
        let normal: f64 = StandardNormal.sample(&mut self.random);
        self.sd * normal
    }
}
