//! The struct that is to become a system.

use crate::attribute::parameter_of;
use syn::ext::IdentExt;
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Error, Field, Fields, GenericParam, Ident, Result, Type};

/// What the fields are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Number {
    /// The struct's type parameter, by this name.
    Generic(Ident),
    /// `f64` and `f32`, or no field at all.
    Floats,
}

/// A field, which is a parameter of the model.
pub struct Variable {
    /// The field.
    pub field: Ident,
    /// The parameter's name.
    pub parameter: String,
    /// Its type.
    pub ty: Type,
    /// Whether that is `f32`.
    pub single: bool,
}

/// The struct.
pub struct Input {
    pub number: Number,
    pub variables: Vec<Variable>,
}

impl Input {
    /// Reads it; all that is wrong with it is said at once.
    pub fn of(item: &DeriveInput) -> Result<Self> {
        let fields = match &item.data {
            Data::Struct(data) => &data.fields,
            Data::Enum(data) => return Err(not_a_struct(data.enum_token.span())),
            Data::Union(data) => return Err(not_a_struct(data.union_token.span())),
        };
        if let Fields::Unnamed(fields) = fields {
            return Err(Error::new(
                fields.span(),
                "the fields need names: those of the parameters that stay variable",
            ));
        }
        let number = number(item)?;
        let mut variables: Vec<Variable> = Vec::new();
        let mut wrong: Option<Error> = None;
        for field in fields {
            match variable(field, &number) {
                Ok(found) => match variables.iter().find(|v| v.parameter == found.parameter) {
                    None => variables.push(found),
                    Some(first) => add(
                        &mut wrong,
                        Error::new(
                            field.span(),
                            format!("the field `{}` is this parameter already", first.field),
                        ),
                    ),
                },
                Err(error) => add(&mut wrong, error),
            }
        }
        match wrong {
            Some(errors) => Err(errors),
            None => Ok(Self { number, variables }),
        }
    }
}

/// Collects errors.
pub fn add(errors: &mut Option<Error>, error: Error) {
    match errors {
        Some(errors) => errors.combine(error),
        None => *errors = Some(error),
    }
}

fn not_a_struct(place: proc_macro2::Span) -> Error {
    Error::new(
        place,
        "a model becomes a struct, whose fields are the parameters that stay variable",
    )
}

/// The number type: the only type parameter, if there is one.
fn number(item: &DeriveInput) -> Result<Number> {
    let mut parameters = item.generics.params.iter();
    let number = match parameters.next() {
        None => return Ok(Number::Floats),
        Some(GenericParam::Type(parameter)) => parameter.ident.clone(),
        Some(other) => return Err(surplus(other)),
    };
    match parameters.next() {
        None => Ok(Number::Generic(number)),
        Some(other) => Err(surplus(other)),
    }
}

fn surplus(parameter: &GenericParam) -> Error {
    Error::new(
        parameter.span(),
        "the struct may have one type parameter, the type of its numbers, and no other",
    )
}

fn variable(field: &Field, number: &Number) -> Result<Variable> {
    let ident = field
        .ident
        .clone()
        .ok_or_else(|| Error::new(field.span(), "the field has no name"))?;
    let named = parameter_of(field)?;
    let is = |ident: &Ident| matches!(&field.ty, Type::Path(path) if path.path.is_ident(ident));
    let [double, single] = ["f64", "f32"].map(|name| Ident::new(name, field.ty.span()));
    let fits = match number {
        Number::Generic(number) => is(number),
        Number::Floats => is(&double) || is(&single),
    };
    if !fits {
        let expected = match number {
            Number::Generic(number) => {
                format!("expected `{number}`, as the struct's type parameter says")
            }
            Number::Floats => "expected `f64`, `f32`, or a type parameter of the struct".into(),
        };
        let message = format!("a parameter is a number: {expected}");
        return Err(Error::new(field.ty.span(), message));
    }
    Ok(Variable {
        parameter: named.map_or_else(|| ident.unraw().to_string(), |name| name.value()),
        field: ident,
        ty: field.ty.clone(),
        single: *number == Number::Floats && is(&single),
    })
}
