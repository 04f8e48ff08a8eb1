//! What a model wants of a log.

use super::record::missing;
use super::seen::{Missing, Seen};
use super::{Gauge, Log, LogError, Map};
use std::path::Path;

/// A coordinate or an input of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Its unit as the model states it, of an input or a position: `rad`, `m`, `N*m`.
    pub unit: String,
    /// Whether it is zero in a log that says nothing of it.
    pub assumed: bool,
}

/// The channels that a model wants of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wanted {
    /// Its coordinates.
    pub coordinates: Vec<Axis>,
    /// Its inputs.
    pub inputs: Vec<Axis>,
    /// Its sensors, whose columns may stand in the place of positions.
    pub gauges: Vec<Gauge>,
}

fn names(axes: &[Axis]) -> Vec<String> {
    axes.iter().map(|axis| axis.name.clone()).collect()
}

impl Wanted {
    /// Reads a log that is to have these channels. Joints that it numbers are named, where there is
    /// no map, and inputs that may be assumed are.
    ///
    /// # Errors
    /// What is wrong with the log; all columns that it lacks are in one list.
    pub fn read(&self, path: &Path, map: Option<&Map>) -> Result<Log, LogError> {
        self.accept(Log::read_with(path, map), map)
    }

    /// A log that was read with a map and is to have these channels, as [`read`](Self::read) has it.
    ///
    /// # Errors
    /// As there.
    pub fn accept(&self, log: Result<Log, LogError>, map: Option<&Map>) -> Result<Log, LogError> {
        let mut log = log.map_err(|error| self.completed(error, map))?;
        self.fit(&mut log, map);
        let (coordinates, inputs) = (names(&self.coordinates), names(&self.inputs));
        log.select_sensed(&coordinates, &inputs, &self.gauges)?;
        Ok(log)
    }

    fn fit(&self, log: &mut Log, map: Option<&Map>) {
        if map.is_none() {
            log.name_by_number(&names(&self.coordinates), &names(&self.inputs));
        }
        let assumed = self.inputs.iter().filter(|axis| axis.assumed);
        log.assume_no_input(assumed.map(|axis| axis.name.as_str()));
    }

    /// Adds the channels that the log would be found to lack next.
    fn completed(&self, mut error: LogError, map: Option<&Map>) -> LogError {
        let Some((listed, found)) = error.missing() else {
            return error;
        };
        let made = map.iter().flat_map(|map| map.channels()).map(Seen::named);
        let found = found.to_vec();
        let there = found.iter().cloned().chain(made);
        let mut log = Log {
            path: Default::default(),
            t: Vec::new(),
            channels: there.map(|seen| (seen.name, Vec::new())).collect(),
            lines: Vec::new(),
            unread: Vec::new(),
            followed: Vec::new(),
            warnings: Vec::new(),
        };
        self.fit(&mut log, map);
        let (coordinates, inputs) = (names(&self.coordinates), names(&self.inputs));
        let more = missing(&log, &coordinates, &inputs, &self.gauges);
        let is_there = |name: &String| found.iter().any(|seen| seen.name == *name);
        listed.extend(more.into_iter().map(|missing| Missing {
            // What is assumed is no column that could be meant.
            nearest: missing.nearest.filter(is_there),
            ..missing
        }));
        error
    }
}
