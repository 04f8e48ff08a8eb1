//! Functions of a frame by its name: `frame_jacobian_of_tool`.

use super::axes::Axes;
use super::functions::FunctionError;
use super::naming::snake;
use super::plan::{Entry, Quantity};
use crate::derive::{Expansion, Group, ItemError};
use crate::diagnostic::nearest;
use crate::model::Model;
use crate::tree::{Frame, Mechanism};
use std::fmt;

/// What a function says about a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameTerm {
    /// Of its origin in the world, 3.
    Position,
    /// From its axes to the world's, 3×3.
    Rotation,
    /// `J` of `(velocity, angular velocity) = J v` along the world's axes, 6×n.
    Jacobian,
    /// `J̇ v`, 6.
    Bias,
}

/// A function of a frame that is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FrameWish {
    pub term: FrameTerm,
    /// The frame's name, or what it is in names of functions.
    pub frame: String,
}

impl FrameTerm {
    pub const ALL: [Self; 4] = [Self::Position, Self::Rotation, Self::Jacobian, Self::Bias];

    /// What stands in front of `_of_` and the frame's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "frame_position",
            Self::Rotation => "frame_rotation",
            Self::Jacobian => "frame_jacobian",
            Self::Bias => "frame_bias",
        }
    }

    /// What names of temporaries begin with.
    fn prefix(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Rotation => "rotation",
            Self::Jacobian => "jacobian",
            Self::Bias => "bias",
        }
    }

    fn meaning(self, frame: &str) -> String {
        match self {
            Self::Position => {
                format!("Position of the origin of `{frame}` along the world's axes")
            }
            Self::Rotation => format!(
                "Rotation `R` from `{frame}` to the world: a column is an axis of the frame along the world's"
            ),
            Self::Jacobian => format!(
                "Jacobian `J` of `{frame}`: `J v` is the velocity of its origin, then its angular velocity, along the world's axes"
            ),
            Self::Bias => format!(
                "`J̇ v` of `{frame}`: acceleration of its origin, then its angular acceleration, along the world's axes, where `a` is zero"
            ),
        }
    }

    /// What its rows belong to.
    fn rows(self) -> Vec<Entry> {
        let triple = |names: [&str; 3], unit: &str| {
            names.map(|name| Entry {
                name: name.to_string(),
                unit: unit.to_string(),
            })
        };
        let linear = ["x", "y", "z"];
        let angular = ["about_x", "about_y", "about_z"];
        let [first, second] = match self {
            Self::Position => return triple(linear, "m").to_vec(),
            Self::Rotation => return triple(linear, "").to_vec(),
            Self::Jacobian => [triple(linear, "m/s"), triple(angular, "rad/s")],
            Self::Bias => [triple(linear, "m/s^2"), triple(angular, "rad/s^2")],
        };
        [first, second].concat()
    }
}

impl FrameWish {
    /// The function of this name, if it is one of a frame.
    pub fn parse(name: &str) -> Option<Self> {
        let of = |term: FrameTerm| Some((term, name.strip_prefix(term.name())?));
        let (term, rest) = FrameTerm::ALL.into_iter().find_map(of)?;
        let frame = rest
            .strip_prefix("_of_")
            .filter(|frame| !frame.is_empty())?;
        Some(Self {
            term,
            frame: frame.to_string(),
        })
    }
}

impl fmt::Display for FrameWish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}_of_{}", self.term.name(), self.frame)
    }
}

/// The frames of a model, which are made ready when the first is asked for.
#[derive(Debug, Default)]
pub(super) struct Frames(Option<Mechanism>);

impl Frames {
    /// What a function of a frame computes.
    pub fn quantity(
        &mut self,
        expansion: &mut Expansion,
        wish: &FrameWish,
    ) -> Result<Quantity, FunctionError> {
        if expansion.model.coordinates.is_empty() {
            let (item, lacks) = (wish.to_string(), "coordinate");
            return Err(ItemError::Empty { item, lacks }.into());
        }
        let (name, body) = find(&expansion.model, &wish.frame)?;
        let mut axes = vec![wish.term.rows()];
        match wish.term {
            FrameTerm::Rotation => axes.push(wish.term.rows()),
            FrameTerm::Jacobian => axes.extend(Axes::new(expansion).of_group(Group::Velocity)),
            FrameTerm::Position | FrameTerm::Bias => {}
        }
        let mechanism = match self.0.take() {
            Some(mechanism) => mechanism,
            None => expansion.model.posed().map_err(|error| {
                let reason = error.to_string();
                FunctionError::Tree { reason }
            })?,
        };
        let graph = &mut expansion.model.graph;
        let frame = Frame::of_body(graph, body);
        let entries = match wish.term {
            FrameTerm::Position => mechanism.pose(graph, &frame).position.to_vec(),
            FrameTerm::Rotation => mechanism.pose(graph, &frame).rotation.concat(),
            FrameTerm::Jacobian => mechanism.jacobian(graph, &frame).concat(),
            FrameTerm::Bias => mechanism
                .jacobian_rate_times_velocity(graph, &frame)
                .to_vec(),
        };
        self.0 = Some(mechanism);
        let function = FrameWish {
            frame: name.clone(),
            ..wish.clone()
        };
        let meaning = wish.term.meaning(&name);
        let quantity = Quantity::own(&function.to_string(), &meaning, axes, entries);
        Ok(quantity.with_prefix(wish.term.prefix()))
    }
}

/// The frame of a name, or whose name in functions this is.
fn find(model: &Model, name: &str) -> Result<(String, usize), FunctionError> {
    let frames = model.frames();
    if let Some((name, &body)) = frames.get_key_value(name) {
        return Ok((name.to_string(), body));
    }
    let mut alike = frames.iter().filter(|(known, _)| snake(known) == name);
    match (alike.next(), alike.next()) {
        (Some((name, &body)), None) => Ok((name.to_string(), body)),
        _ => {
            let known = || frames.keys().copied();
            Err(FunctionError::NoFrame {
                name: name.to_string(),
                nearest: nearest(name, known()).map(str::to_string),
                frames: known().map(str::to_string).collect(),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Emission;
    use super::*;
    use crate::{Compiled, Library, Tape, compile};

    fn crane() -> Compiled {
        let text = "
            model crane;
            coordinate sway: rad;
            constant turning: rad/s = 3;
            body Boom { frame: rotate_z(turning*t) * translate(2, 0, 0); mass: 1; }
            frame hook_A = Boom * rotate_y(sway) * translate(0, 0, -0.5);
            frame hook_a = Boom;
            body load { frame: hook_A; mass: 1; }
        ";
        compile("crane.model", text, &Library::empty()).unwrap()
    }

    fn emission<'a>(
        compiled: &'a Compiled,
        functions: &str,
    ) -> Result<Emission<'a>, FunctionError> {
        Emission::new(compiled, "crane.model", &functions.parse()?)
    }

    /// The value of a function of one frame at `t`, `sway` and its rate.
    fn value(function: &str, t: f64, sway: f64, rate: f64) -> Vec<f64> {
        let compiled = crane();
        let emission = emission(&compiled, function).unwrap();
        let (_, quantities) = emission.functions().last().unwrap();
        let tape = Tape::new(
            emission.graph(),
            &quantities[0].entries,
            &emission.arguments(),
        );
        tape.evaluate(&[t, sway, rate, 0.0])
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (x, y) in found.iter().zip(expected) {
            assert!((x - y).abs() < 1e-12, "{found:?} {expected:?}");
        }
    }

    /// A pendulum on a boom that time turns.
    #[test]
    fn what_time_drives_is_in_the_bias_alone() {
        let (s, c) = 0.4_f64.sin_cos();
        let position = value("frame_position_of_hook_A", 0.0, 0.4, 0.0);
        near(&position, &[2.0 - 0.5 * s, 0.0, -0.5 * c]);
        let jacobian = value("frame_jacobian_of_hook_A", 0.0, 0.4, 0.0);
        near(&jacobian, &[-0.5 * c, 0.0, 0.5 * s, 0.0, 1.0, 0.0]);
        let bias = value("frame_bias_of_hook_A", 0.0, 0.4, 0.0);
        near(&bias, &[-9.0 * (2.0 - 0.5 * s), 0.0, 0.0, 0.0, 0.0, 0.0]);
        let quarter = std::f64::consts::FRAC_PI_6;
        let rotation = value("frame_rotation_of_Boom", quarter, 0.4, 0.0);
        near(&rotation, &[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_request_may_have_either_name() {
        let compiled = crane();
        for request in ["frame_jacobian_of_Boom", "frame_jacobian_of_boom"] {
            let emission = emission(&compiled, request).unwrap();
            let (name, _) = emission.functions().last().unwrap();
            assert_eq!(name, "frame_jacobian_of_boom");
        }
        let joined = emission(&compiled, "mass_matrix + frame_bias_of_load").unwrap();
        let (name, quantities) = joined.functions().last().unwrap();
        assert_eq!(name, "mass_matrix_and_frame_bias_of_load");
        assert_eq!(quantities.len(), 2);
    }

    #[test]
    fn mistakes_are_named() {
        let compiled = crane();
        let error = |request: &str| emission(&compiled, request).unwrap_err();
        let unknown = error("frame_jacobian_of_lod");
        assert_eq!(
            unknown.to_string(),
            "there is no frame `lod`; did you mean `load`?"
        );
        let unlike = error("frame_jacobian_of_gripper");
        assert_eq!(
            unlike.help().unwrap(),
            "the frames are: Boom, hook_A, hook_a, load, world"
        );
        let both = "frame_jacobian_of_hook_A, frame_jacobian_of_hook_a";
        assert!(error(both).to_string().contains("twice"));
        let bare = error("frame_jacobian");
        assert!(bare.to_string().contains("frame_jacobian_of_"), "{bare}");
    }
}
