//! What can keep a channel from being smoothed.

/// Why states could not be estimated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SmoothError {
    /// A channel is not as long as the time stamps.
    #[error(
        "`{channel}` has {found} samples but there are {expected} time stamps; give one sample per stamp"
    )]
    Length {
        /// The channel.
        channel: &'static str,
        /// Its samples.
        found: usize,
        /// The stamps.
        expected: usize,
    },
    /// A sample is NaN or infinite.
    #[error("`{channel}` is not finite at sample {sample}; remove such samples before smoothing")]
    NotFinite {
        /// The channel.
        channel: &'static str,
        /// Index of the sample.
        sample: usize,
    },
    /// Time does not increase.
    #[error("time does not increase at sample {sample}; sort the samples and drop repeated stamps")]
    Disordered {
        /// Index of the sample.
        sample: usize,
    },
    /// Too few samples to estimate noise and motion.
    #[error("{found} samples are too few to estimate the noise; give at least {minimum}")]
    TooShort {
        /// Samples given.
        found: usize,
        /// Samples needed.
        minimum: usize,
    },
    /// The coordinate is not in the record.
    #[error("the record has {coordinates} coordinates; there is no coordinate {index}")]
    NoCoordinate {
        /// The index asked for, counted from 0.
        index: usize,
        /// Coordinates in the record.
        coordinates: usize,
    },
    /// No setting of the noise gives the data a finite likelihood.
    #[error(
        "no finite likelihood was found for the noise of the sensors; positions span {range:e}: check \
         units and scale"
    )]
    NoLikelihood {
        /// Largest minus smallest position.
        range: f64,
    },
    /// A coordinate of a record cannot be smoothed.
    #[error("column `q_{coordinate}` and those beside it: {source}")]
    Of {
        /// The coordinate.
        coordinate: String,
        /// Why not.
        source: Box<SmoothError>,
    },
    /// A smoother was applied to channels whose noise it does not know.
    #[error("the smoother has no noise level for `{channel}`; fit it on a log that has it")]
    UnknownNoise {
        /// The channel.
        channel: &'static str,
    },
}

impl SmoothError {
    /// With the name of the coordinate that it is about.
    pub(super) fn of(self, coordinate: &str) -> Self {
        Self::Of {
            coordinate: coordinate
                .strip_prefix("q_")
                .unwrap_or(coordinate)
                .to_string(),
            source: Box::new(self),
        }
    }
}
