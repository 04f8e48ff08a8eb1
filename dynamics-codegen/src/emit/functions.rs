//! Which functions are emitted besides the terms of the equation of motion.

use super::frames::{FrameTerm, FrameWish};
use super::naming::snake;
use super::plan::MOST_OPERATIONS;
use crate::derive::{Group, Item, ItemError, Term};
use crate::diagnostic::nearest;
use std::fmt;
use std::str::FromStr;

/// A list of functions on request, as `dynamics generate --functions` reads it.
///
/// One function per name; names are separated by commas. Every emitted file holds the
/// terms (`mass_matrix`, `bias_force`, …) and `equation_of_motion` in any case.
///
/// | name | what it computes |
/// |---|---|
/// | a [`Term`], as `inverse_dynamics` | one quantity |
/// | a term `_by_` a [`Group`], as `force_by_velocity` | its derivative |
/// | names joined by `+`, as `mass_matrix+bias_force` | all of them, what they share once; the function is `mass_matrix_and_bias_force` |
/// | `inverse_dynamics_derivatives` | `∂τ/∂q`, `∂τ/∂v` |
/// | `forward_dynamics_derivatives` | `a = M⁻¹Q`, `∂a/∂q`, `∂a/∂v`, `∂a/∂u` |
/// | `constrained_dynamics` | `a` and `λ` |
/// | `constrained_dynamics_derivatives` | `a`, `λ` and their derivatives by `q, v, u` |
/// | `residual_derivatives` | of `R = M a − Q − Aᵀλ` by `q, v, u, t` and of `S = A a − b` by `q, v, t`, at stated `a, λ`: what `dynamics::motion_derivatives` solves with |
/// | `residual_by_parameters` | of `R` and `S` by the parameters |
/// | `frame_jacobian_of_` and a frame's name | `J` of `(velocity, angular velocity) = J v` along the world's axes |
/// | `frame_bias_of_` and a frame's name | `J̇ v` of the same |
/// | `frame_position_of_`, `frame_rotation_of_` and a frame's name | where it is in the world |
/// | `sensor_derivatives` | what sensors show along the motion, and its derivatives by `q, v, u` |
/// | `full` | the functions above that the model can have |
///
/// ```
/// use dynamics_codegen::emit::Functions;
///
/// let functions: Functions = "inverse_dynamics, mass_matrix+bias_force".parse()?;
/// assert_eq!(functions.to_string(), "inverse_dynamics,mass_matrix+bias_force");
/// assert!("mass_matrix+bias".parse::<Functions>().is_err());
/// # Ok::<(), dynamics_codegen::emit::FunctionError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Functions {
    wishes: Vec<Wish>,
}

/// What is wrong with a list of functions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FunctionError {
    /// A name that is not in the table of [`Functions`]; where none is like it,
    /// [`help`](FunctionError::help) lists those that are.
    #[error("there is no function `{name}`{}", suggestion(.nearest))]
    Unknown {
        /// The name.
        name: String,
        /// The known name that is most like it, if any is.
        nearest: Option<String>,
    },
    /// The same function twice.
    #[error("the function `{name}` is asked for twice; leave one out")]
    Twice {
        /// Its name.
        name: String,
    },
    /// More than a compiler of the emitted text can be asked for.
    #[error(
        "the functions are too large: up to `{function}` they take more than {MOST_OPERATIONS} operations"
    )]
    TooLarge {
        /// The function that is too much.
        function: String,
    },
    /// The model cannot have it.
    #[error(transparent)]
    Impossible(#[from] ItemError),
    /// A frame that the model does not have, or whose name in functions several have.
    #[error("there is no frame `{}`{}", shown(.name), suggestion(.nearest))]
    NoFrame {
        /// The frame's name.
        name: String,
        /// The frame whose name is most like it, if any is.
        nearest: Option<String>,
        /// The names of all frames.
        frames: Vec<String>,
    },
    /// The bodies do not form a machine.
    #[error("the bodies do not form a machine: {reason}")]
    Tree {
        /// What is wrong with them.
        reason: String,
    },
}

fn suggestion(nearest: &Option<String>) -> String {
    match nearest {
        Some(name) => format!("; did you mean `{name}`?"),
        None => String::new(),
    }
}

/// A name of the list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wish {
    /// As it was written.
    text: String,
    /// The function's name.
    pub name: String,
    pub items: Vec<Item>,
    /// Functions of frames, behind the items.
    pub frames: Vec<FrameWish>,
    /// Whether items that the model lacks are left out silently.
    pub lenient: bool,
}

impl Wish {
    /// Whether its function returns a struct.
    pub fn is_fused(&self) -> bool {
        self.lenient || self.items.len() + self.frames.len() > 1
    }

    /// Several items under a name of their own, as far as a model has them; no item if there
    /// is no bundle of this name.
    pub fn bundle(name: &str) -> Self {
        let known = bundles().into_iter().find(|(known, _)| *known == name);
        Self {
            text: name.to_string(),
            name: name.to_string(),
            items: known.map_or_else(Vec::new, |(_, items)| items),
            frames: Vec::new(),
            lenient: true,
        }
    }

    fn parse(text: &str) -> Result<Self, FunctionError> {
        let bundle = Self::bundle(text);
        if !bundle.items.is_empty() {
            return Ok(bundle);
        }
        let parts: Vec<&str> = text.split('+').map(str::trim).collect();
        let (mut items, mut frames) = (Vec::new(), Vec::new());
        for (index, &part) in parts.iter().enumerate() {
            if parts[..index].contains(&part) {
                let name = part.to_string();
                return Err(FunctionError::Twice { name });
            }
            match (Item::parse(part), FrameWish::parse(part)) {
                (Some(item), _) => items.push(item),
                (None, Some(frame)) => frames.push(frame),
                (None, None) => return Err(unknown(part)),
            }
        }
        let names: Vec<String> = parts.iter().map(|part| snake(part)).collect();
        Ok(Self {
            text: parts.join("+"),
            name: names.join("_and_"),
            items,
            frames,
            lenient: false,
        })
    }
}

impl FunctionError {
    /// How to mend it, if there is more to say than what is wrong.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Unknown { nearest: None, .. } => {
                Some(format!("the functions are {}", known_names()))
            }
            Self::NoFrame {
                nearest: None,
                frames,
                ..
            } if frames.len() <= 20 => Some(format!("the frames are: {}", frames.join(", "))),
            Self::TooLarge { .. } => Some(
                "ask for fewer functions, for example `--functions inverse_dynamics,forward_dynamics`, or split the model".to_string(),
            ),
            Self::Unknown { .. }
            | Self::Twice { .. }
            | Self::Impossible(_)
            | Self::NoFrame { .. }
            | Self::Tree { .. } => None,
        }
    }
}

/// The names that a list may hold, by kind.
fn known_names() -> String {
    let bundles: Vec<&str> = bundles().into_iter().map(|(name, _)| name).collect();
    let groups = Group::ALL.map(|group| format!("_by_{}", group.name()));
    format!(
        "{FULL}; {}; {}, each also with {} behind it; {}, each with `_of_` and the name of a frame behind it; and any of these joined by `+`",
        bundles.join(", "),
        Term::ALL.map(Term::name).join(", "),
        groups.join(", "),
        FrameTerm::ALL.map(FrameTerm::name).join(", ")
    )
}

impl Functions {
    /// None but the terms.
    pub fn none() -> Self {
        Self::default()
    }

    /// Every bundle, inverse and forward dynamics, and `M` with `Q_C`, as far as a
    /// model can have them.
    pub fn full() -> Self {
        let both = Wish {
            text: FULL.to_string(),
            name: "mass_matrix_and_bias_force".to_string(),
            items: vec![Item::of(Term::MassMatrix), Item::of(Term::BiasForce)],
            frames: Vec::new(),
            lenient: true,
        };
        let singles = [Term::InverseDynamics, Term::ForwardDynamics].map(|term| Wish {
            text: FULL.to_string(),
            name: term.name().to_string(),
            items: vec![Item::of(term)],
            frames: Vec::new(),
            lenient: false,
        });
        let bundles = bundles().into_iter().map(|(name, items)| Wish {
            text: FULL.to_string(),
            name: name.to_string(),
            items,
            frames: Vec::new(),
            lenient: true,
        });
        let wishes = [both].into_iter().chain(singles).chain(bundles).collect();
        Self { wishes }
    }

    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        self.wishes.is_empty()
    }

    pub(super) fn wishes(&self) -> &[Wish] {
        &self.wishes
    }

    /// Whether a wish that finds nothing may be passed over.
    pub(super) fn passes_over(wish: &Wish) -> bool {
        wish.text == FULL
    }
}

/// The word for all of them.
const FULL: &str = "full";

impl FromStr for Functions {
    type Err = FunctionError;

    fn from_str(text: &str) -> Result<Self, FunctionError> {
        let names = text
            .split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty());
        let mut wishes: Vec<Wish> = Vec::new();
        for name in names {
            let new = match name {
                FULL => Self::full().wishes,
                name => vec![Wish::parse(name)?],
            };
            for wish in new {
                let is_term = !wish.is_fused() && wish.items.iter().copied().any(is_always_there);
                if is_term {
                    continue;
                }
                if wishes.iter().any(|known| known.name == wish.name) {
                    return Err(FunctionError::Twice { name: wish.name });
                }
                wishes.push(wish);
            }
        }
        Ok(Self { wishes })
    }
}

impl fmt::Display for Functions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut texts: Vec<&str> = self.wishes.iter().map(|w| w.text.as_str()).collect();
        texts.dedup();
        f.write_str(&texts.join(","))
    }
}

/// Terms that every emitted file holds.
pub(super) const TERMS: [Term; 21] = [
    Term::MassMatrix,
    Term::BiasForce,
    Term::AppliedForce,
    Term::InputMatrix,
    Term::Force,
    Term::ConstraintJacobian,
    Term::ConstraintBias,
    Term::ConstraintResidual,
    Term::ConstraintRate,
    Term::ContactGap,
    Term::ContactVelocity,
    Term::ContactJacobian,
    Term::ContactBias,
    Term::ContactCoefficients,
    Term::PositionRate,
    Term::StateRate,
    Term::InitialState,
    Term::Outputs,
    Term::OutputRates,
    Term::OutputJacobian,
    Term::OutputBias,
];

fn is_always_there(item: Item) -> bool {
    item.by.is_none() && TERMS.contains(&item.term)
}

/// Names for several items at once.
fn bundles() -> Vec<(&'static str, Vec<Item>)> {
    let by = |terms: &[Term], groups: &[Group]| -> Vec<Item> {
        let items = terms
            .iter()
            .flat_map(|&term| groups.iter().map(move |&group| Item::slope(term, group)));
        items.collect()
    };
    let with_values = |terms: &[Term], slopes: Vec<Item>| -> Vec<Item> {
        let values = terms.iter().map(|&term| Item::of(term));
        values.chain(slopes).collect()
    };
    let state = [Group::Position, Group::Velocity];
    let all = [Group::Position, Group::Velocity, Group::Input];
    let forward = [Term::ForwardDynamics];
    let motion = [Term::ConstrainedAcceleration, Term::ConstrainedMultipliers];
    let sensors = [Term::PredictedSensors];
    let residuals = [Term::ForceResidual, Term::AccelerationResidual];
    let mut residual_slopes = by(&residuals[..1], &[&all[..], &[Group::Time]].concat());
    residual_slopes.extend(by(&residuals[1..], &[&state[..], &[Group::Time]].concat()));
    vec![
        (
            "inverse_dynamics_derivatives",
            by(&[Term::InverseDynamics], &state),
        ),
        (
            "forward_dynamics_derivatives",
            with_values(&forward, by(&forward, &all)),
        ),
        ("constrained_dynamics", with_values(&motion, Vec::new())),
        (
            "constrained_dynamics_derivatives",
            with_values(&motion, by(&motion, &all)),
        ),
        ("residual_derivatives", residual_slopes),
        (
            "residual_by_parameters",
            by(&residuals, &[Group::Parameters]),
        ),
        (
            "sensor_derivatives",
            with_values(&sensors, by(&sensors, &all)),
        ),
    ]
}

fn unknown(name: &str) -> FunctionError {
    let slopes = Term::ALL
        .into_iter()
        .flat_map(|term| Group::ALL.map(|group| Item::slope(term, group).to_string()));
    let terms = Term::ALL.map(|term| term.name().to_string());
    let bundles = bundles().into_iter().map(|(name, _)| name.to_string());
    let frames = FrameTerm::ALL.map(|term| format!("{}_of_…", term.name()));
    let known = terms.into_iter().chain(bundles).chain(slopes).chain(frames);
    let known: Vec<String> = known.collect();
    // The time to compare grows with the square of the length.
    let short = name.len() <= 60;
    let near = nearest(name, known.iter().map(String::as_str)).filter(|_| short);
    FunctionError::Unknown {
        name: shown(name),
        nearest: near.map(str::to_string),
    }
}

/// A name that somebody wrote, as a message may show it.
fn shown(name: &str) -> String {
    name.chars().take(60).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_written() {
        let list = "inverse_dynamics,force_by_time,mass_matrix+bias_force,constrained_dynamics";
        let functions: Functions = list.parse().unwrap();
        assert_eq!(functions.to_string(), list);
        let names: Vec<&str> = functions.wishes().iter().map(|w| w.name.as_str()).collect();
        assert_eq!(names[2], "mass_matrix_and_bias_force");
        // What is always there needs no second function.
        assert!(
            "mass_matrix, force,"
                .parse::<Functions>()
                .unwrap()
                .is_empty()
        );
        assert_eq!("full".parse::<Functions>().unwrap(), Functions::full());
        assert_eq!(Functions::full().to_string(), "full");
    }

    #[test]
    fn mistakes_are_named() {
        let error = |text: &str| text.parse::<Functions>().unwrap_err().to_string();
        assert_eq!(
            error("inverse_dynamic"),
            "there is no function `inverse_dynamic`; did you mean `inverse_dynamics`?"
        );
        assert_eq!(
            error("force_by_velocity,force_by_velocity"),
            "the function `force_by_velocity` is asked for twice; leave one out"
        );
        assert!(error("force+force").contains("twice"));
        assert!(error("full,inverse_dynamics").contains("twice"));
        assert!(error("a+,").starts_with("there is no function `a`"));
        assert!(error("\u{1b}").contains("\\u{1b}"));
    }
}
