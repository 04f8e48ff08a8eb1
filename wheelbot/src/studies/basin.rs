//! From which tilts the robot comes back.

use super::study::{Map, StudyError};
use crate::robot::leaning;
use crate::sensing::Sensing;
use crate::trial::Trial;
use rayon::prelude::*;
use wheelbot_firmware::Gains;

/// Starting tilts along each axis: every third degree to 36° either way.
const COUNT: i32 = 12;
const STEP: f64 = 3.0;
/// Who stands so long has come back, s.
const SECONDS: f64 = 2.0;

/// The map of rolls and pitches from which the robot, released at rest, stands, without noise.
///
/// # Errors
/// [`StudyError`].
pub fn basin(title: &str, gains: Gains<f64>) -> Result<Map, StudyError> {
    let degrees: Vec<f64> = (-COUNT..=COUNT).map(|k| STEP * f64::from(k)).collect();
    let sensing = Sensing::new(0)?.without_noise();
    let row = |pitch: &f64| -> Result<Vec<bool>, StudyError> {
        let stands = |roll: &f64| {
            let mut trial = Trial::new(SECONDS, gains);
            trial.start = leaning(roll.to_radians(), pitch.to_radians());
            let outcome = trial.run(&mut sensing.clone())?;
            Ok(!outcome.fell)
        };
        degrees.iter().map(stands).collect()
    };
    Ok(Map {
        title: title.into(),
        axes: ["roll [°]".into(), "pitch [°]".into()],
        stood: degrees.par_iter().map(row).collect::<Result<_, _>>()?,
        values: degrees,
    })
}

/// The share of the map from which the robot stands.
pub fn share(map: &Map) -> f64 {
    let cells = map.stood.iter().flatten();
    let standing = cells.clone().filter(|stood| **stood).count();
    standing as f64 / cells.count().max(1) as f64
}
