//! What can be used but should be known.

use crate::number::short;
use serde::Serialize;
use std::fmt;

/// A property of a log that does not prevent its use but may explain a result.
/// Stamps are in seconds of the log's own time.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Warning {
    /// Rows that repeat the one before in every column were dropped.
    RepeatedRows {
        /// How many.
        rows: usize,
        /// Line of the first.
        line: u64,
    },
    /// A log that begins with what is no text.
    DroppedStart {
        /// How many bytes were dropped.
        bytes: usize,
        /// Line of the file on which the text begins.
        line: u64,
    },
    /// A log that ends with what is no text.
    DroppedEnd {
        /// How many bytes were dropped.
        bytes: usize,
        /// Line of the first of them.
        line: u64,
    },
    /// A last row that breaks off was dropped.
    CutRow {
        /// Its line.
        line: u64,
        /// What stands there.
        text: String,
    },
    /// A file of messages that breaks off: what stands in front of that was read.
    BreaksOff {
        /// What is missing, or wrong, and where.
        reason: String,
    },
    /// Bytes in a file of messages that are none were stepped over.
    SkippedBytes {
        /// Where the first of them stands.
        at: usize,
        /// How many they are.
        bytes: usize,
    },
    /// A recording whose stamps start anew was put behind the one before.
    Shifted {
        /// The recording.
        file: String,
        /// What was added to its stamps \[s\].
        by: f64,
    },
    /// Of a log longer than a trace goes through, stretches that are evenly spread over it are used.
    Shortened {
        /// What there is.
        samples: usize,
        /// What is used.
        used: usize,
        /// In how many stretches.
        stretches: usize,
    },
    /// A column without a name was set aside.
    NamelessColumn {
        /// Its position, counted from 1.
        position: usize,
    },
    /// A column that is no measurement holds something else than numbers.
    IgnoredColumn {
        /// Its name.
        column: String,
        /// Line of the first such cell.
        line: u64,
        /// That cell.
        text: String,
    },
    /// The sampling step is not constant.
    IrregularSampling {
        /// Median step \[s\].
        step: f64,
        /// Share of steps more than 5 % away from it, gaps not counted.
        share: f64,
        /// Largest of these deviations \[s\].
        largest: f64,
    },
    /// The stamps look as if they were not seconds.
    StrangeRate {
        /// Median step as read \[s\].
        step: f64,
    },
    /// Steps longer than five median steps: nothing is joined across them.
    Gaps {
        /// How many.
        count: usize,
        /// The first: stamp before it and its length.
        first: (f64, f64),
        /// The longest: stamp before it and its length.
        longest: (f64, f64),
    },
    /// An angle that jumped by a turn was made continuous.
    Unwrapped {
        /// The column.
        column: String,
        /// Jumps removed.
        jumps: usize,
        /// Stamp of the first.
        first: f64,
    },
    /// Single samples that their neighbours contradict: what these say stands in their place.
    Wild {
        /// The column.
        column: String,
        /// The file, if the log has several.
        file: Option<String>,
        /// Line of the first.
        line: u64,
        /// What stands there.
        value: f64,
        /// What its neighbours say.
        beside: f64,
        /// How many there are.
        samples: usize,
    },
    /// Single samples that the machine contradicts, as the model has it: what all other samples say stands in
    /// their place.
    Contradicted {
        /// The column.
        column: String,
        /// The file, if the log has several.
        file: Option<String>,
        /// Line of the first.
        line: u64,
        /// What stands there.
        value: f64,
        /// What all other samples say.
        beside: f64,
        /// How many there are.
        samples: usize,
    },
    /// A sensor whose errors are like those just before.
    LastingErrors {
        /// The column.
        column: String,
        /// Correlation of an error with that of the sample before.
        memory: f64,
    },
    /// An input with noise that the machine did not feel: it is taken without.
    InputNoise {
        /// The column.
        column: String,
        /// Standard deviation of the noise, in the input's unit.
        noise: f64,
        /// The same as a share of the input's own deviation.
        share: f64,
    },
    /// A coordinate that no column shows was estimated from the model's sensors.
    Unmeasured {
        /// Which.
        coordinate: String,
        /// How well it is known, as a standard deviation; `None` where nothing measured depends on it.
        sd: Option<f64>,
        /// Its unit.
        unit: String,
    },
    /// A velocity or acceleration that somebody filtered before it was logged.
    Filtered {
        /// The column.
        column: String,
    },
    /// An input of the model that the log does not have.
    AssumedZero {
        /// The column.
        column: String,
    },
    /// Joints that the log calls by their numbers.
    Numbered {
        /// What the log calls each, and its name in the model.
        joints: Vec<(String, String)>,
    },
    /// Cells without a measurement were filled, as the log's map asks.
    Filled {
        /// The column.
        column: String,
        /// How many cells.
        cells: usize,
        /// Whether by a straight line; else by the value before.
        linear: bool,
    },
    /// A topic of messages was brought to the stamps of another.
    Resampled {
        /// The topic.
        topic: String,
        /// Its median step \[s\].
        from: f64,
        /// The topic whose stamps are used, and its median step \[s\].
        onto: (String, f64),
    },
    /// A topic whose messages cannot be read.
    IgnoredTopic {
        /// The topic.
        topic: String,
        /// Its encoding, or what is wrong with its messages.
        reason: String,
    },
    /// A channel never changes.
    Constant {
        /// The column.
        column: String,
        /// Its value.
        value: f64,
    },
    /// Two channels say the same in every row.
    Repeated {
        /// The columns.
        columns: [String; 2],
    },
    /// A channel stands still for long while its machine moves.
    Stuck {
        /// The column.
        column: String,
        /// Stamps of the first and last sample of the longest such run.
        span: (f64, f64),
        /// Samples in it.
        samples: usize,
    },
    /// A sensor froze while its coordinate moved: these samples are left out.
    Frozen {
        /// The column.
        column: String,
        /// Stamps of the first and last of them.
        span: (f64, f64),
        /// How many.
        samples: usize,
    },
    /// A channel repeats each value: it was recorded at a lower rate and held.
    Held {
        /// The column.
        column: String,
        /// Samples per value.
        repeats: usize,
    },
    /// The quantisation step is coarse against the channel's noise or motion.
    Quantised {
        /// The column.
        column: String,
        /// The step.
        step: f64,
        /// Share of samples equal to the one before.
        unchanged: f64,
    },
    /// An input stays at its extreme value.
    Saturated {
        /// The column.
        column: String,
        /// The value.
        limit: f64,
        /// Share of the samples exactly there.
        share: f64,
    },
}

/// Two numbers with as many digits as it takes to see them apart.
fn apart(a: f64, b: f64) -> [String; 2] {
    let few = [a, b].map(short);
    if few[0] != few[1] || a == b {
        return few;
    }
    let digits = (a.abs().max(b.abs()) / (a - b).abs()).log10().ceil();
    [a, b].map(|value| format!("{value:.0$e}", digits.clamp(4.0, 16.0) as usize))
}

/// Samples of a column that are set aside, with what the first is and what is said in its place, and by whom.
fn write_wild(
    f: &mut fmt::Formatter<'_>,
    (column, file, line, samples): (&str, &Option<String>, u64, usize),
    [value, beside]: [f64; 2],
    say: &str,
) -> fmt::Result {
    let [value, beside] = apart(value, beside);
    if let Some(file) = file {
        write!(f, "{file}, ")?;
    }
    write!(f, "line {line}: `{column}` is {value} where {say} {beside}")?;
    match samples {
        1 => write!(f, "; this sample is set aside"),
        _ => write!(f, "; {samples} such samples of `{column}` are set aside"),
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RepeatedRows { rows, line } => write!(
                f,
                "{rows} rows repeat the row before them and were dropped, the first on line {line}"
            ),
            Self::DroppedStart { bytes, line } => write!(
                f,
                "the log begins with {bytes} bytes that are no text: they were dropped, it is read from line {line} on"
            ),
            Self::DroppedEnd { bytes, line } => write!(
                f,
                "the log ends with {bytes} bytes that are no text, from line {line} on: they were dropped"
            ),
            Self::CutRow { line, text } => write!(
                f,
                "line {line}, the last one, breaks off (`{text}`): it was dropped"
            ),
            Self::BreaksOff { reason } => {
                write!(
                    f,
                    "the file breaks off: {reason}; what stands before that was read"
                )
            }
            Self::SkippedBytes { at, bytes } => write!(
                f,
                "{bytes} bytes of the file are no messages, the first at byte {at}: they were stepped over"
            ),
            Self::Shifted { file, by } => write!(
                f,
                "the stamps of `{file}` start anew: {by:.6} s were added to them; nothing is joined across the gap"
            ),
            Self::Shortened {
                samples,
                used,
                stretches,
            } => write!(
                f,
                "of {samples} samples {used} are used, in {stretches} stretches spread over all: a trace goes through \
                 them many times"
            ),
            Self::NamelessColumn { position } => {
                write!(f, "column {position} has no name and was ignored")
            }
            Self::IgnoredColumn { column, line, text } => write!(
                f,
                "column `{column}` was ignored: line {line} holds `{text}`, not a finite number"
            ),
            Self::IrregularSampling {
                step,
                share,
                largest,
            } => write!(
                f,
                "irregular sampling: {:.1} % of the steps are more than 5 % away from the median of {step:.6} s, by up to {largest:.6} s",
                100.0 * share
            ),
            Self::StrangeRate { step } => {
                write!(
                    f,
                    "the median step is {step} s; is `t` in seconds? the log is used as it is"
                )?;
                if *step <= 1.0 {
                    return Ok(());
                }
                let unit = super::health::likely_unit(*step);
                write!(f, "; its map says otherwise by `[time] unit = \"{unit}\"`")
            }
            Self::Gaps {
                count,
                first,
                longest,
            } => write!(
                f,
                "{count} gaps of more than five steps: the first of {:.6} s after t = {:.6} s, the longest of {:.6} s after t = {:.6} s; nothing is joined across them",
                first.1, first.0, longest.1, longest.0
            ),
            Self::Unwrapped {
                column,
                jumps,
                first,
            } => write!(
                f,
                "`{column}` jumps by a full turn {jumps} times, first at t = {first:.6} s; it was unwrapped"
            ),
            Self::Wild {
                column,
                file,
                line,
                value,
                beside,
                samples,
            } => {
                let sample = (column.as_str(), file, *line, *samples);
                write_wild(f, sample, [*value, *beside], "its neighbours say")
            }
            Self::Contradicted {
                column,
                file,
                line,
                value,
                beside,
                samples,
            } => {
                let sample = (column.as_str(), file, *line, *samples);
                write_wild(f, sample, [*value, *beside], "model and log beside it say")
            }
            Self::LastingErrors { column, memory } => write!(
                f,
                "the errors of `{column}` follow one another, each {:.0} % like the one before: its samples are \
                 given as much less weight",
                100.0 * memory
            ),
            Self::InputNoise {
                column,
                noise,
                share,
            } => write!(
                f,
                "`{column}` carries noise of {noise:.3} ({:.1} % of its deviation) that the machine did not feel, \
                 as its motion says: its motion is judged without that noise",
                100.0 * share
            ),
            Self::Unmeasured {
                coordinate,
                sd: Some(sd),
                unit,
            } => write!(
                f,
                "no column shows coordinate `{coordinate}`: it was estimated from the sensors \
                 through the model, to {} {unit}",
                short(*sd)
            ),
            Self::Unmeasured {
                coordinate,
                sd: None,
                ..
            } => write!(
                f,
                "no column shows where coordinate `{coordinate}` is, and nothing that is measured depends \
                 on it: it counts from where the log begins"
            ),
            Self::Filtered { column } => write!(
                f,
                "the errors of `{column}` follow one another, as after a filter: it is left out, \
                 for the position says more"
            ),
            Self::AssumedZero { column } => write!(
                f,
                "there is no column `{column}`: that joint is taken to be undriven"
            ),
            Self::Numbered { joints } => {
                let pair = |(column, name): &(String, String)| format!("`{column}` for `{name}`");
                let pairs: Vec<String> = joints.iter().map(pair).collect();
                write!(
                    f,
                    "joints of the log are taken by their numbers: {}; a map says otherwise",
                    pairs.join(", ")
                )
            }
            Self::Filled {
                column,
                cells,
                linear,
            } => write!(
                f,
                "{cells} cells of `{column}` hold no measurement and were filled {}",
                if *linear {
                    "by straight lines"
                } else {
                    "with the value before"
                }
            ),
            Self::Resampled { topic, from, onto } => write!(
                f,
                "topic `{topic}` comes every {from:.6} s and was brought to the stamps of `{}`, every {:.6} s: \
                 commands by the value before, measurements by straight lines",
                onto.0, onto.1
            ),
            Self::IgnoredTopic { topic, reason } => {
                write!(f, "topic `{topic}` was ignored: {reason}")
            }
            Self::Constant { column, value } => {
                write!(
                    f,
                    "`{column}` is constant ({value}): it carries no information"
                )
            }
            Self::Repeated { columns: [a, b] } => write!(
                f,
                "`{a}` and `{b}` say the same in every row: one of them is probably the other's column"
            ),
            Self::Stuck {
                column,
                span,
                samples,
            } => write!(
                f,
                "`{column}` stands still from t = {:.6} s to {:.6} s ({samples} samples) while the machine moves",
                span.0, span.1
            ),
            Self::Frozen {
                column,
                span,
                samples,
            } => write!(
                f,
                "`{column}` is frozen from t = {:.6} s to {:.6} s while its coordinate moves: these {samples} \
                 samples are left out",
                span.0, span.1
            ),
            Self::Held { column, repeats } => write!(
                f,
                "`{column}` repeats each value {repeats} times: it was recorded at a lower rate and held"
            ),
            Self::Quantised {
                column,
                step,
                unchanged,
            } => write!(
                f,
                "`{column}` is quantised in steps of {step:.4e}; {:.0} % of its samples equal the one before",
                100.0 * unchanged
            ),
            Self::Saturated {
                column,
                limit,
                share,
            } => write!(
                f,
                "`{column}` sits at its limit of {limit} in {:.1} % of the samples",
                100.0 * share
            ),
        }
    }
}
