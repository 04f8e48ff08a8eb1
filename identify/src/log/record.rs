//! The channels of a log that belong to a model.

use super::doubt::{self, Doubt};
use super::error::{LogError, ProblemKind, Problems};
use super::seen::Missing;
use super::{
    Aside, Gauge, Log, MINIMUM_SAMPLES, Reading, Sensed, Warning, health, is_aside, median,
};
use std::collections::BTreeSet;
use std::ops::Range;

/// A step longer than this many median steps is a gap.
pub(super) const GAP: f64 = 5.0;

/// The channels of a model, in the model's order.
///
/// Shapes: n samples, m coordinates, p inputs. `q`, `dq`, `ddq` have m
/// channels, `u` has p, each of length n.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Names of the coordinates (m).
    pub coordinates: Vec<String>,
    /// Names of the inputs (p).
    pub inputs: Vec<String>,
    /// Time stamps \[s\], strictly increasing (n).
    pub t: Vec<f64>,
    /// Measured positions \[rad or m\], angles unwrapped (m × n).
    pub q: Vec<Vec<f64>>,
    /// Measured velocities \[rad/s or m/s\], where logged (m × n).
    pub dq: Vec<Option<Vec<f64>>>,
    /// Measured accelerations \[rad/s² or m/s²\], where logged (m × n).
    pub ddq: Vec<Option<Vec<f64>>>,
    /// Inputs \[N or N·m\] (p × n).
    pub u: Vec<Vec<f64>>,
    /// The inputs as commanded \[N or N·m\], where that was logged, `ucmd_<input>` (p × n).
    pub commanded: Vec<Option<Vec<f64>>>,
    /// Samples that are no measurements.
    pub aside: Aside,
    /// Samples of inputs that may be none.
    pub doubts: Vec<Doubt>,
    /// What the model's sensors showed; `None` where all coordinates are measured, and the log has no
    /// other sensor.
    pub sensed: Option<Sensed>,
    /// What should be known about these channels.
    pub warnings: Vec<Warning>,
}

impl Record {
    /// Number of samples n.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Whether a column of the log shows the position of coordinate `i`.
    pub fn is_measured(&self, i: usize) -> bool {
        let sensed = self.sensed.as_ref();
        !sensed.is_some_and(|sensed| sensed.unmeasured[i])
    }

    /// Whether columns of the log show all positions.
    pub fn is_wholly_measured(&self) -> bool {
        (0..self.q.len()).all(|i| self.is_measured(i))
    }

    /// What the model's sensors showed that the log has.
    pub fn readings(&self) -> &[Reading] {
        let sensed = self.sensed.as_ref();
        sensed.map_or(&[], |sensed| &sensed.readings)
    }

    /// Whether a position was measured at other samples and not at this one.
    pub fn is_set_aside(&self, i: usize, sample: usize) -> bool {
        self.is_measured(i) && is_aside(&self.aside.q[i], sample)
    }

    /// Median sampling step \[s\]; 0 with fewer than two samples.
    pub fn step(&self) -> f64 {
        median_step(&self.t)
    }

    /// Whether a channel that is late, or early, by `time` s is so by half a sample at most: what inputs do between
    /// two samples is not in a log.
    pub fn hides(&self, time: f64) -> bool {
        time.abs() <= 0.5 * self.step()
    }

    /// Stretches without a gap, as ranges of samples: cut where the step is
    /// longer than five median steps. They cover all samples in order.
    pub fn segments(&self) -> Vec<Range<usize>> {
        segments(&self.t)
    }

    /// Every `stride`-th sample, from the first on.
    #[must_use]
    pub fn thinned(&self, stride: usize) -> Record {
        let stride = stride.max(1);
        let thin = |values: &Vec<f64>| values.iter().step_by(stride).copied().collect::<Vec<f64>>();
        let thin_optional = |values: &Option<Vec<f64>>| values.as_ref().map(thin);
        Record {
            coordinates: self.coordinates.clone(),
            inputs: self.inputs.clone(),
            t: thin(&self.t),
            q: self.q.iter().map(thin).collect(),
            dq: self.dq.iter().map(thin_optional).collect(),
            ddq: self.ddq.iter().map(thin_optional).collect(),
            u: self.u.iter().map(thin).collect(),
            commanded: self.commanded.iter().map(thin_optional).collect(),
            aside: self.aside.thinned(stride),
            doubts: doubt::thinned(&self.doubts, stride),
            sensed: self.sensed.as_ref().map(|sensed| sensed.thinned(stride)),
            warnings: self.warnings.clone(),
        }
    }

    /// The samples of a range as a record of their own, for blocks and
    /// splits. The range is cut to the samples there are.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Record {
        self.stretches(&[range])
    }

    /// The samples of some ranges, one after the other. Each is cut to the samples there are.
    #[must_use]
    pub fn stretches(&self, ranges: &[Range<usize>]) -> Record {
        let cut = |values: &Vec<f64>| stretches(values, ranges);
        let cut_optional = |values: &Option<Vec<f64>>| values.as_ref().map(cut);
        Record {
            coordinates: self.coordinates.clone(),
            inputs: self.inputs.clone(),
            t: cut(&self.t),
            q: self.q.iter().map(cut).collect(),
            dq: self.dq.iter().map(cut_optional).collect(),
            ddq: self.ddq.iter().map(cut_optional).collect(),
            u: self.u.iter().map(cut).collect(),
            commanded: self.commanded.iter().map(cut_optional).collect(),
            aside: self.aside.stretches(ranges),
            doubts: doubt::stretches(&self.doubts, ranges),
            sensed: self.sensed.as_ref().map(|sensed| sensed.stretches(ranges)),
            warnings: self.warnings.clone(),
        }
    }
}

/// The values of some ranges, one after the other.
pub(crate) fn stretches<T: Copy>(values: &[T], ranges: &[Range<usize>]) -> Vec<T> {
    let there = |range: &Range<usize>| {
        let end = range.end.min(values.len());
        values[range.start.min(end)..end].iter().copied()
    };
    ranges.iter().flat_map(there).collect()
}

/// So many ranges of a `length` each, evenly spread over `all` samples.
pub(crate) fn evenly_spread(all: usize, count: usize, length: usize) -> Vec<Range<usize>> {
    let starts = (0..count).map(|i| i * (all - length) / (count - 1));
    starts.map(|start| start..start + length).collect()
}

/// The longest step that is no gap.
pub(crate) fn longest_step(t: &[f64]) -> f64 {
    GAP * median_step(t)
}

/// Median of the sampling steps; 0 with fewer than two stamps.
pub(crate) fn median_step(t: &[f64]) -> f64 {
    let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    median(&steps).unwrap_or(0.0)
}

/// Ranges of samples between gaps.
pub(crate) fn segments(t: &[f64]) -> Vec<Range<usize>> {
    let longest = longest_step(t);
    let mut found = Vec::new();
    let mut start = 0;
    for k in 1..t.len() {
        if t[k] - t[k - 1] > longest {
            found.push(start..k);
            start = k;
        }
    }
    if start < t.len() {
        found.push(start..t.len());
    }
    found
}

/// Collects the channels and checks their health.
pub(super) fn select(
    log: &Log,
    coordinates: &[String],
    inputs: &[String],
    gauges: &[Gauge],
) -> Result<Record, LogError> {
    let mut problems = Problems::default();
    let step = median_step(&log.t);
    if step > health::LONGEST_STEP {
        problems.push(None, Some("t"), ProblemKind::NotSeconds { step });
    }
    let absent = missing(log, coordinates, inputs, gauges);
    if !absent.is_empty() {
        let found = log.seen();
        let missing = absent;
        problems.push(None, None, ProblemKind::MissingColumns { missing, found });
    }
    if !problems.is_empty() {
        return Err(problems.into_error(&log.path));
    }
    let is_measured = |name: &&String| log.channels.contains_key(&column(log, "q_", name));
    let measured: Vec<String> = coordinates.iter().filter(is_measured).cloned().collect();
    let mut record = channels(log, &measured, inputs);
    let readings = Sensed::of(log, gauges);
    if measured.len() < coordinates.len() || !readings.is_empty() {
        record.sensed = Some(Sensed {
            readings,
            ..Sensed::default()
        });
    }
    health::examine(&mut record, log);
    record.fill_in(coordinates);
    // The log itself was long enough, or it would not have been read.
    if record.len() < MINIMUM_SAMPLES {
        let frozen = record.warnings.iter().filter_map(|warning| match warning {
            Warning::Frozen { column, .. } => Some(column),
            _ => None,
        });
        for column in frozen.collect::<BTreeSet<_>>() {
            let (left, minimum) = (record.len(), MINIMUM_SAMPLES);
            problems.push(None, Some(column), ProblemKind::Frozen { left, minimum });
        }
        return Err(problems.into_error(&log.path));
    }
    Ok(record)
}

/// The channels of coordinates that are all measured.
fn channels(log: &Log, coordinates: &[String], inputs: &[String]) -> Record {
    let channel = |column: &String| log.channels.get(column).cloned().unwrap_or_default();
    let q = positions(log, coordinates)
        .map(|column| channel(&column))
        .collect();
    let u = inputs
        .iter()
        .map(|name| channel(&log.input_column(name)))
        .collect();
    let optional = |prefix: &str, names: &[String]| {
        let column = |name: &String| log.channels.get(&column(log, prefix, name)).cloned();
        names.iter().map(column).collect()
    };
    Record {
        coordinates: coordinates.to_vec(),
        inputs: inputs.to_vec(),
        t: log.t.clone(),
        q,
        dq: optional("dq_", coordinates),
        ddq: optional("ddq_", coordinates),
        u,
        commanded: optional("ucmd_", inputs),
        aside: Aside::nothing(coordinates.len()),
        doubts: Vec::new(),
        sensed: None,
        warnings: log.warnings.clone(),
    }
}

impl Record {
    /// With estimates taken for measurements of positions.
    #[must_use]
    pub(crate) fn taken_as_measured(mut self) -> Self {
        let unmeasured = self
            .sensed
            .take()
            .map_or_else(Vec::new, |sensed| sensed.unmeasured);
        for i in (0..unmeasured.len()).filter(|&i| unmeasured[i]) {
            self.dq[i] = None;
            self.aside.q[i].clear();
            self.aside.dq[i].clear();
        }
        self
    }

    /// Puts those of `coordinates` that are not in the record in their places among the others:
    /// at zero, with all samples set aside.
    fn fill_in(&mut self, coordinates: &[String]) {
        let Some(sensed) = &mut self.sensed else {
            return;
        };
        let samples = self.t.len();
        for (i, name) in coordinates.iter().enumerate() {
            let is_measured = self.coordinates.get(i) == Some(name);
            sensed.unmeasured.push(!is_measured);
            if !is_measured {
                self.coordinates.insert(i, name.clone());
                self.q.insert(i, vec![0.0; samples]);
                self.dq.insert(i, Some(vec![0.0; samples]));
                self.ddq.insert(i, None);
                self.aside.q.insert(i, vec![true; samples]);
                self.aside.dq.insert(i, vec![true; samples]);
                self.aside.ddq.insert(i, Vec::new());
            }
        }
        sensed.sd = vec![[0.0; 2]; coordinates.len()];
    }
}

impl Log {
    /// The column that holds a channel (`q_`, `dq_`, …) of a coordinate, as [`Log::select`] finds
    /// it.
    pub(crate) fn column(&self, prefix: &str, name: &str) -> String {
        column(self, prefix, name)
    }

    /// The column that holds an input: what was measured, else what was commanded.
    pub(crate) fn input_column(&self, name: &str) -> String {
        let commanded = column(self, "ucmd_", name);
        let measured = column(self, "u_", name);
        match self.channels.contains_key(&measured) {
            false if self.channels.contains_key(&commanded) => commanded,
            _ => measured,
        }
    }
}

/// The column of a name: `q_arm` for the coordinate `arm`. A coordinate may also
/// bear the whole name of its column, where what follows the prefix is no name by
/// itself: `q_1`, with the velocity `dq_1`; likewise an input `u_1`.
fn column(log: &Log, prefix: &str, name: &str) -> String {
    let plain = format!("{prefix}{name}");
    let own = if prefix.starts_with('u') { "u_" } else { "q_" };
    match name.strip_prefix(own).map(|rest| format!("{prefix}{rest}")) {
        Some(whole) if !log.channels.contains_key(&plain) => whole,
        _ => plain,
    }
}

/// The columns of the positions.
fn positions(log: &Log, coordinates: &[String]) -> impl Iterator<Item = String> {
    coordinates.iter().map(|name| column(log, "q_", name))
}

/// The columns of a model that a log does not have. Where it has one of the model's sensors, a
/// position may be estimated.
pub(super) fn missing(
    log: &Log,
    coordinates: &[String],
    inputs: &[String],
    gauges: &[Gauge],
) -> Vec<Missing> {
    let is_there = |gauge: &Gauge| log.channels.contains_key(&gauge.name);
    let estimated = gauges.iter().any(is_there);
    let instead = match gauges.first() {
        Some(gauge) => format!(", or sensors that show it (`{}`, …)", gauge.name),
        None => String::new(),
    };
    let named = positions(log, coordinates).zip(coordinates);
    let q = named.filter(|_| !estimated).map(|(column, name)| {
        let role = format!("the position of coordinate `{name}`{instead}");
        (column, "q_", name, role)
    });
    // What nobody measured is as it was commanded.
    let u = inputs.iter().map(|name| {
        let role = format!("the input `{name}`");
        (log.input_column(name), "u_", name, role)
    });
    let absent = q
        .chain(u)
        .filter(|(column, ..)| !log.channels.contains_key(column));
    let missing = absent.map(|(column, prefix, name, role)| Missing {
        column,
        role,
        nearest: nearest(log, prefix, name),
    });
    missing.collect()
}

/// The column most likely meant: the name without its prefix, in other
/// letters, or the most similar of the same prefix, then of all.
fn nearest(log: &Log, prefix: &str, name: &str) -> Option<String> {
    let wanted = format!("{prefix}{name}");
    let unread = log.unread.iter();
    let mut names: Vec<&str> = log
        .channels
        .keys()
        .chain(unread)
        .map(String::as_str)
        .collect();
    let same = |found: &&&str| found.eq_ignore_ascii_case(&wanted) || **found == name;
    if let Some(found) = names.iter().find(same) {
        return Some((*found).to_owned());
    }
    names.sort_by_key(|found| !found.starts_with(prefix));
    let (alike, others) = names.split_at(names.partition_point(|found| found.starts_with(prefix)));
    let close = |among: &[&str]| {
        let found = similar::get_close_matches(wanted.as_str(), among, 1, 0.6);
        found.first().map(|found| (*found).to_owned())
    };
    close(alike).or_else(|| close(others))
}
