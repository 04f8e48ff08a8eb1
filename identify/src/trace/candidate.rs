//! What might be missing from a model.

use super::subject::Subject;

/// Something that might be missing.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// What it is.
    pub subject: Subject,
    /// Indices of its parameters in the extended model.
    pub parameters: Vec<usize>,
    /// Which of them change the motion when they leave their default: the others
    /// give the effect its shape.
    pub strengths: Vec<usize>,
    /// Values to try for the shape parameters, all combinations.
    pub shapes: Vec<Vec<(usize, f64)>>,
    /// Whether it is about a channel: an input or a sensor.
    pub channel: bool,
    /// Whether it is a loss that a robot description states.
    pub is_loss: bool,
    /// Bodies on which it would be the same law: a load on what its own is rigidly connected with.
    pub same_on: Vec<String>,
}

impl Candidate {
    /// With these parameters, of which none is a strength yet.
    pub fn new(subject: Subject, parameters: Vec<usize>) -> Self {
        Self {
            subject,
            parameters,
            strengths: Vec::new(),
            shapes: vec![Vec::new()],
            channel: false,
            is_loss: false,
            same_on: Vec::new(),
        }
    }

    /// How many parameters it has.
    pub fn size(&self) -> usize {
        self.parameters.len()
    }
}
