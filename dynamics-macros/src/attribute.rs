//! `#[dynamics(…)]`, on the struct and on its fields.

use dynamics_codegen::diagnostic::nearest;
use syn::meta::ParseNestedMeta;
use syn::{Attribute, DeriveInput, Error, Field, LitStr, Result};

/// What `#[dynamics(…)]` on the struct says.
pub struct Attributes {
    /// The path of the model or robot description, as written.
    pub model: LitStr,
    /// Folders of effect templates.
    pub effects: Vec<LitStr>,
    /// Functions beside the terms.
    pub functions: Option<LitStr>,
}

const ON_STRUCT: [&str; 5] = ["model", "urdf", "mjcf", "effects", "functions"];
const ON_FIELD: [&str; 1] = ["parameter"];

impl Attributes {
    /// Reads those of a struct.
    pub fn of(item: &DeriveInput) -> Result<Self> {
        let (mut model, mut effects, mut functions) = (None, Vec::new(), None);
        each(&item.attrs, |meta| {
            if ["model", "urdf", "mjcf"]
                .iter()
                .any(|key| meta.path.is_ident(key))
            {
                once(&mut model, &meta)
            } else if meta.path.is_ident("effects") {
                effects.push(text(&meta)?);
                Ok(())
            } else if meta.path.is_ident("functions") {
                once(&mut functions, &meta)
            } else {
                Err(unknown(&meta, &ON_STRUCT))
            }
        })?;
        let model = model.ok_or_else(|| {
            Error::new(
                item.ident.span(),
                "`#[derive(Dynamics)]` needs a model: add `#[dynamics(model = \"path/to/the.model\")]`, or `urdf = \"…\"` or `mjcf = \"…\"`",
            )
        })?;
        Ok(Self {
            model,
            effects,
            functions,
        })
    }
}

/// The parameter that a field is told to stand for.
pub fn parameter_of(field: &Field) -> Result<Option<LitStr>> {
    let mut parameter = None;
    each(&field.attrs, |meta| {
        if meta.path.is_ident("parameter") {
            once(&mut parameter, &meta)
        } else {
            Err(unknown(&meta, &ON_FIELD))
        }
    })?;
    Ok(parameter)
}

/// Every entry of every `#[dynamics(…)]`.
fn each(
    attributes: &[Attribute],
    mut entry: impl FnMut(ParseNestedMeta) -> Result<()>,
) -> Result<()> {
    let ours = attributes
        .iter()
        .filter(|attribute| attribute.path().is_ident("dynamics"));
    for attribute in ours {
        attribute.parse_nested_meta(&mut entry)?;
    }
    Ok(())
}

fn text(meta: &ParseNestedMeta) -> Result<LitStr> {
    let value: LitStr = meta.value()?.parse()?;
    if value.value().is_empty() {
        return Err(Error::new(value.span(), "expected a name, found nothing"));
    }
    Ok(value)
}

fn once(place: &mut Option<LitStr>, meta: &ParseNestedMeta) -> Result<()> {
    if place.is_some() {
        return Err(meta.error("this is stated twice"));
    }
    *place = Some(text(meta)?);
    Ok(())
}

fn unknown(meta: &ParseNestedMeta, known: &[&str]) -> Error {
    let name = meta.path.get_ident().map(ToString::to_string);
    let near = name.and_then(|name| nearest(&name, known.iter().copied()));
    match near {
        Some(near) => meta.error(format!("unknown attribute; did you mean `{near}`?")),
        None => {
            let known: Vec<String> = known.iter().map(|key| format!("`{key} = \"…\"`")).collect();
            meta.error(format!(
                "unknown attribute; expected {}",
                known.join(" or ")
            ))
        }
    }
}
