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

    /// Bends a linear step of its parameters from `values`, in their order, to how they act together: a strength `s`,
    /// counted from where it does nothing, and a law `f(x)` of the shape add `s f(x)`, of which the step adds
    /// `δs f + s f' δx`. At the new strength `s/(s + δs) δx` adds as much: a load that becomes heavier has not as far to go.
    pub fn bend(&self, step: &mut [f64], values: &[f64], defaults: &[f64]) {
        let [strength] = self.strengths[..] else {
            return;
        };
        let Some(own) = self.parameters.iter().position(|&p| p == strength) else {
            return;
        };
        let before = values[strength] - defaults[strength];
        let share = before / (before + step[own]);
        if share > 0.0 && share.is_finite() {
            let shape = (0..step.len()).filter(|&i| i != own);
            shape.for_each(|i| step[i] *= share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice as heavy, it has half as far to go, and its first moment is what the linear step makes of it.
    #[test]
    fn a_load_that_becomes_heavier_has_not_as_far_to_go() {
        let load = Candidate {
            strengths: vec![1],
            ..Candidate::new(Subject::Parameter("m".into()), vec![1, 2, 3])
        };
        let (values, defaults) = ([7.0, 0.5, 0.2, -0.1], [7.0, 0.0, 0.0, 0.0]);
        let bent = |step: [f64; 3]| {
            let mut step = step;
            load.bend(&mut step, &values, &defaults);
            step
        };
        assert_eq!(bent([0.5, 0.4, 0.02]), [0.5, 0.2, 0.01]);
        let moment = |[m, x]: [f64; 2]| m * x;
        let linear = moment([0.5, 0.2]) + 0.2 * 0.5 + 0.5 * 0.4;
        assert!((moment([1.0, 0.2 + 0.2]) - linear).abs() < 1e-12);
        // Where it vanishes, or acts the other way, no place of it says anything.
        assert_eq!(bent([-0.5, 0.4, 0.02]), [-0.5, 0.4, 0.02]);
        assert_eq!(bent([-0.9, 0.4, 0.02]), [-0.9, 0.4, 0.02]);
    }
}
