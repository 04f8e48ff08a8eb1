//! States as JSON objects: `{"q": …, "v": …, "u": …, "z": …, "t": …, "parameters": …}`.

use crate::json::{Text, Value};
use crate::mistake::Mistake;
use crate::parameters;
use dynamics_codegen::Model;

/// One state of a model, complete.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Positions ([`Model::positions`]).
    pub q: Vec<f64>,
    /// Velocities, one per coordinate.
    pub v: Vec<f64>,
    /// Inputs; `None` if the object says nothing about them.
    pub u: Option<Vec<f64>>,
    /// Internal states; `None` if the object says nothing about them: as at the beginning.
    pub z: Option<Vec<f64>>,
    /// Time, s.
    pub t: f64,
    /// All parameters, in model order.
    pub parameters: Vec<f64>,
}

/// How a state may look, for messages.
pub const SHAPE: &str =
    "a state is one JSON object, such as `{\"q\": [0.1, 0.2], \"v\": {\"j1\": 1}}`";
const FIELDS: [&str; 6] = ["q", "v", "u", "z", "t", "parameters"];

impl State {
    /// Everything zero, internal states as at the beginning.
    pub fn zero(model: &Model, nominal: &[f64]) -> Self {
        Self {
            q: origin(model),
            v: vec![0.0; model.coordinates.len()],
            u: None,
            z: None,
            t: 0.0,
            parameters: nominal.to_vec(),
        }
    }

    /// Reads a state; also returns warnings. What is left out is zero, parameters
    /// are as in `nominal`.
    ///
    /// # Errors
    /// If the text is not a state of this model.
    pub fn read(
        text: Text<'_>,
        model: &Model,
        nominal: &[f64],
    ) -> Result<(Self, Vec<Mistake>), Mistake> {
        let object = text.value()?;
        let coordinates: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
        let places = model.positions();
        let positions: Vec<&str> = places.iter().map(|p| p.name.as_str()).collect();
        let (position, velocity) = if model.poses.is_empty() {
            ("coordinate", "coordinate")
        } else {
            ("position", "velocity")
        };
        let inputs: Vec<&str> = model.inputs.iter().map(|u| u.name.as_str()).collect();
        let states: Vec<&str> = model.states.iter().map(|z| z.name.as_str()).collect();
        let (mut q, mut v, mut u, mut z, mut t) = (None, None, None, None, 0.0);
        let (mut values, mut warnings) = (nominal.to_vec(), Vec::new());
        for member in object.members("a state")? {
            let value = member.value;
            match member.name.as_str() {
                "q" => {
                    q = Some(posed(
                        value,
                        model,
                        complete(value, "q", position, &positions)?,
                    )?)
                }
                "v" => v = Some(zeroed(vector(value, "v", velocity, &coordinates)?)),
                "u" => u = Some(zeroed(vector(value, "u", "input", &inputs)?)),
                "z" => z = Some(complete(value, "z", "internal state", &states)?),
                "t" => t = value.number("time `t`")?,
                "parameters" => warnings = parameters::assign(value, model, &mut values)?,
                other => {
                    let message = format!("a state has no field `{other}`");
                    return Err(parameters::suggest(
                        member.key.mistake("", message),
                        other,
                        FIELDS,
                    ));
                }
            }
        }
        let Some(q) = q else {
            let message = "this state has no positions `q`";
            let help = format!("add `\"q\": [{}]`", positions.join(", "));
            return Err(object.mistake("", message).help(help));
        };
        let state = Self {
            v: v.unwrap_or_else(|| vec![0.0; coordinates.len()]),
            q,
            u,
            z,
            t,
            parameters: values,
        };
        Ok((state, warnings))
    }
}

/// All positions zero; of a quaternion, no turn.
fn origin(model: &Model) -> Vec<f64> {
    let mut q = vec![0.0; model.positions().len()];
    for [position, _] in model.pose_places() {
        q[position + 6] = 1.0;
    }
    q
}

/// A quaternion may be this far from one, as it is written with some digits.
const NEARLY_ONE: f64 = 1e-3;

/// The positions with their quaternions made units.
fn posed(value: Value<'_>, model: &Model, mut q: Vec<f64>) -> Result<Vec<f64>, Mistake> {
    for (pose, [position, _]) in model.poses.iter().zip(model.pose_places()) {
        let quaternion = &mut q[position + 3..position + 7];
        let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() > NEARLY_ONE {
            let name = &pose.name;
            let message = format!(
                "the quaternion `{name}_qx`, `{name}_qy`, `{name}_qz`, `{name}_qw` has length {length:.4}: an orientation has length one"
            );
            let help = "no turn is 0, 0, 0, 1";
            return Err(value.mistake("", message).help(help));
        }
        quaternion.iter_mut().for_each(|x| *x /= length);
    }
    Ok(q)
}

fn zeroed(entries: Vec<Option<f64>>) -> Vec<f64> {
    entries.into_iter().map(Option::unwrap_or_default).collect()
}

/// Positions and internal states have no default: each must be given.
fn complete(
    value: Value<'_>,
    field: &str,
    what: &str,
    names: &[&str],
) -> Result<Vec<f64>, Mistake> {
    let entries = vector(value, field, what, names)?;
    let missing: Vec<&str> = names
        .iter()
        .zip(&entries)
        .filter(|(_, entry)| entry.is_none())
        .map(|(name, _)| *name)
        .collect();
    if missing.is_empty() {
        return Ok(zeroed(entries));
    }
    let message = match field {
        "q" => format!("`q` lacks the position of {}", quoted(&missing)),
        _ => format!("`{field}` lacks {}", quoted(&missing)),
    };
    Err(value
        .mistake("", message)
        .help("velocities and inputs are zero unless given; positions are not"))
}

/// One entry per name: an array in model order, or an object by name.
fn vector(
    value: Value<'_>,
    field: &str,
    what: &str,
    names: &[&str],
) -> Result<Vec<Option<f64>>, Mistake> {
    let mut entries = vec![None; names.len()];
    if value.is_object() {
        for member in value.members("an object")? {
            let Some(index) = names.iter().position(|name| *name == member.name) else {
                let message = format!("the model has no {what} `{}`", member.name);
                let mistake = member.key.mistake("", message);
                return Err(parameters::suggest(
                    mistake,
                    &member.name,
                    names.iter().copied(),
                ));
            };
            entries[index] = Some(member.value.number(&format!("`{field}.{}`", member.name))?);
        }
        return Ok(entries);
    }
    let expected = format!("`{field}` as an array of numbers, or as an object by name");
    let elements = value.elements(&expected)?;
    if elements.len() != names.len() {
        let message = format!(
            "`{field}` needs {} {}, found {}",
            names.len(),
            if names.len() == 1 {
                "number"
            } else {
                "numbers"
            },
            elements.len()
        );
        let help = match names {
            [] => format!("the model has no {what}s: leave `{field}` out"),
            _ => format!("the order is that of the model: {}", names.join(", ")),
        };
        return Err(value.mistake("", message).help(help));
    }
    for (index, element) in elements.iter().enumerate() {
        entries[index] = Some(element.number(&format!("`{field}[{index}]` ({})", names[index]))?);
    }
    Ok(entries)
}

fn quoted(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
