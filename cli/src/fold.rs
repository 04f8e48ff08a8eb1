//! `--fold`: parameters that are constant on this machine become numbers.

use crate::mistake::Mistake;
use crate::model::Loaded;
use dynamics_codegen::diagnostic::nearest;
use dynamics_codegen::{Compiled, Variables, compile_keeping};
use std::collections::BTreeMap;

/// The word for every parameter.
const ALL: &str = "all";

/// The model with the parameters of `list` folded in, at the values of `loaded`.
///
/// # Errors
/// If a name is no parameter's, or an expression is meaningless with the values.
pub fn folded(loaded: &Loaded, list: &str) -> Result<Compiled, Mistake> {
    let values = chosen(loaded, list)?;
    let text = String::from_utf8_lossy(&loaded.bytes);
    let name = loaded.path.display().to_string();
    let variables = Variables::Except(values.clone());
    let mut compiled = compile_keeping(&name, &text, &loaded.library, &variables)?;
    for parameter in &mut compiled.model.fixed {
        parameter.nominal = values[&parameter.name];
    }
    Ok(compiled)
}

/// The named parameters with their values.
fn chosen(loaded: &Loaded, list: &str) -> Result<BTreeMap<String, f64>, Mistake> {
    let parameters = &loaded.compiled.model.parameters;
    if parameters.is_empty() {
        let mistake = Mistake::new("the model has no parameter to fold in");
        return Err(mistake.help("leave `--fold` out: the numbers of the model are in the code"));
    }
    let known: BTreeMap<String, f64> = (parameters.iter().zip(&loaded.parameters))
        .map(|(parameter, &value)| (parameter.name.clone(), value))
        .collect();
    if list.trim() == ALL {
        return Ok(known);
    }
    let names = list.split(',').map(str::trim);
    let chosen = names.filter(|name| !name.is_empty()).map(|name| {
        let value = known.get(name).ok_or_else(|| unknown(name, &known))?;
        Ok((name.to_string(), *value))
    });
    chosen.collect()
}

fn unknown(name: &str, known: &BTreeMap<String, f64>) -> Mistake {
    let mistake = Mistake::new(format!("`--fold`: the model has no parameter `{name}`"));
    let names = || known.keys().map(String::as_str);
    mistake.help(match nearest(name, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => {
            let names: Vec<&str> = names().collect();
            format!("write `{ALL}`, or names among {}", names.join(", "))
        }
    })
}
