//! What a finding is about.

/// What a finding is about.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Subject {
    /// A parameter of the model has another value.
    Parameter(String),
    /// An effect acts on these places.
    Effect {
        /// The template's name.
        template: String,
        /// Coordinates or inputs.
        on: Vec<String>,
    },
}

impl Subject {
    /// `parameter`, or the template's name.
    pub fn name(&self) -> &str {
        match self {
            Self::Parameter(_) => "parameter",
            Self::Effect { template, .. } => template,
        }
    }

    /// What the names of its parameters begin with in a model that has it.
    pub fn prefix(&self) -> String {
        match self {
            Self::Parameter(_) => String::new(),
            Self::Effect { template, on } => {
                let places = on.iter().map(|place| format!("{place}_"));
                format!("{template}_{}", places.collect::<String>())
            }
        }
    }

    /// Where it acts.
    pub fn on(&self) -> Vec<String> {
        match self {
            Self::Parameter(name) => vec![name.clone()],
            Self::Effect { on, .. } => on.clone(),
        }
    }
}

impl std::fmt::Display for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}({})", self.name(), self.on().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_called_by_effect_and_places() {
        let effect = |template: &str, on: &[&str]| Subject::Effect {
            template: template.to_string(),
            on: on.iter().map(ToString::to_string).collect(),
        };
        assert_eq!(effect("coulomb", &["x"]).prefix(), "coulomb_x_");
        assert_eq!(
            effect("speed_drag", &["x", "y"]).prefix(),
            "speed_drag_x_y_"
        );
        assert_eq!(effect("gravity_tilt", &[]).prefix(), "gravity_tilt_");
        assert_eq!(Subject::Parameter("m".into()).prefix(), "");
    }
}
