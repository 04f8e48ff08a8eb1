//! `--parameters FILE.json`: values in place of the nominal ones.

use crate::json::{Text, Value};
use crate::mistake::Mistake;
use crate::model;
use dynamics_codegen::Model;
use dynamics_codegen::diagnostic::nearest;
use dynamics_codegen::file::Limit;
use std::path::Path;

/// A file of parameters is a page, not a data set.
const LIMIT: Limit = Limit {
    what: "a file of parameters",
    bytes: 16 << 20,
};

/// Puts the file's values into `values` (in model order); returns warnings: a value out of its
/// parameter's bounds is used.
///
/// # Errors
/// If the file is not a JSON object from parameter names to finite numbers, alone or under
/// the key `parameters` or `nominal` of an object.
pub fn override_from(
    path: &Path,
    model: &Model,
    values: &mut [f64],
) -> Result<Vec<Mistake>, Mistake> {
    let bytes = model::read(path, LIMIT)?;
    let file = path.display().to_string();
    let text = text(&file, &bytes)?;
    let text = Text {
        file: &file,
        first_line: 1,
        text,
        shape: "parameters are an object of numbers by name, such as `{\"m1\": 1.3}`",
    };
    assign(in_a_description(text.value()?), model, values)
}

/// Where a description of a machine holds its parameters among other things.
const KEYS: [&str; 2] = ["parameters", "nominal"];

/// The parameters in a file that may hold them under a key of their own.
fn in_a_description(file: Value<'_>) -> Value<'_> {
    const WHAT: &str = "an object of parameters";
    let members = file.members(WHAT).unwrap_or_default();
    let own = members
        .iter()
        .find(|member| KEYS.contains(&member.name.as_str()) && member.value.members(WHAT).is_ok());
    own.map_or(file, |member| member.value)
}

/// Puts an object's values into `values`; returns warnings.
///
/// # Errors
/// If it is not an object from parameter names to finite numbers.
pub fn assign(
    object: Value<'_>,
    model: &Model,
    values: &mut [f64],
) -> Result<Vec<Mistake>, Mistake> {
    let mut warnings = Vec::new();
    for member in object.members("an object of parameters")? {
        let name = &member.name;
        let Some(index) = model.parameters.iter().position(|p| p.name == *name) else {
            let names = model.parameters.iter().map(|p| p.name.as_str());
            let mistake = member
                .key
                .mistake("", format!("the model has no parameter `{name}`"));
            return Err(suggest(mistake, name, names));
        };
        let value = member.value.number(&format!("parameter `{name}`"))?;
        let parameter = &model.parameters[index];
        if !(parameter.lower..=parameter.upper).contains(&value) {
            let message = format!("{value} is out of the bounds of parameter `{name}`");
            let bounds = bounds(parameter.lower, parameter.upper);
            warnings.push(member.value.mistake("", message).help(format!(
                "the model says `in {bounds}`; the value is used all the same"
            )));
        }
        values[index] = value;
    }
    Ok(warnings)
}

/// Adds the nearest of the known names, or all of them.
pub fn suggest<'a>(
    mistake: Mistake,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Mistake {
    let known: Vec<&str> = known.into_iter().collect();
    match nearest(name, known.iter().copied()) {
        Some(near) => mistake.help(format!("did you mean `{near}`?")),
        None if known.is_empty() => mistake,
        None => mistake.help(format!("there are: {}", known.join(", "))),
    }
}

/// `0..`, `-1..1`, `..5`, as a model writes them; nothing if there are none.
pub fn bounds(lower: f64, upper: f64) -> String {
    let side = |value: f64| {
        if value.is_finite() {
            number(value)
        } else {
            String::new()
        }
    };
    if lower.is_infinite() && upper.is_infinite() {
        return String::new();
    }
    format!("{}..{}", side(lower), side(upper))
}

/// The shortest text that reads back as this number.
pub fn number(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 12 {
        plain
    } else {
        format!("{value:e}")
    }
}

/// Bytes as text.
///
/// # Errors
/// If they are not UTF-8: points at the first byte that is not.
pub fn text<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, Mistake> {
    std::str::from_utf8(bytes)
        .map(|text| text.strip_prefix('\u{feff}').unwrap_or(text))
        .map_err(|error| {
            let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
            let line = valid.matches('\n').count() + 1;
            let message = format!("`{file}` is not UTF-8 text: line {line} holds other bytes");
            Mistake::new(message).help("save it as UTF-8")
        })
}
