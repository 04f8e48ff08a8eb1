//! `Parameters<T>`: a model's named numbers.

use super::Unit;
use super::documentation::{Doc, code};
use super::language::{number, numbers_as_stated};
use super::layout::{Array, Writer};
use crate::dimension::shown_unit;
use crate::emit::naming::{identifier, is_snake_case};
use crate::emit::text::decimal;
use crate::model::Parameter;

impl Unit<'_> {
    /// The struct and how it is made, taken apart and converted.
    pub(super) fn parameters(&self, w: &mut Writer) {
        let parameters = &self.compiled.model.parameters;
        if parameters.is_empty() {
            return no_parameters(w);
        }
        let fields: Vec<String> = parameters.iter().map(|p| identifier(&p.name)).collect();
        w.doc(&Doc::of("The model's parameters."));
        w.line("#[derive(Clone, Copy, Debug, PartialEq)]");
        if !fields.iter().all(|field| is_snake_case(field)) {
            w.line("#[expect(non_snake_case, reason = \"names as the model writes them\")]");
        }
        w.block("pub struct Parameters<T> {", "}", |w| {
            for (parameter, field) in parameters.iter().zip(&fields) {
                w.doc(&self.parameter_doc(parameter));
                w.line(format!("pub {field}: T,"));
            }
        });
        w.blank();
        w.block("impl<T: Copy> Parameters<T> {", "}", |w| {
            conversions(w, &fields)
        });
        w.blank();
        w.block("impl<T: Scalar> Parameters<T> {", "}", |w| {
            nominal(w, parameters, &fields)
        });
    }

    /// A parameter's meaning, unit, nominal value and bounds.
    fn parameter_doc(&self, parameter: &Parameter) -> Doc {
        let mut doc = Doc::default();
        doc.text(&parameter.doc);
        let mut facts = code(&parameter.name);
        if !parameter.unit.is_empty() {
            facts.push_str(&format!(", {}", shown_unit(&parameter.unit)));
        }
        facts.push_str(&format!("; nominal {}", decimal(parameter.nominal)));
        let (lower, upper) = (decimal(parameter.lower), decimal(parameter.upper));
        match (parameter.lower.is_finite(), parameter.upper.is_finite()) {
            (true, true) => facts.push_str(&format!(", from {lower} to {upper}")),
            (true, false) => facts.push_str(&format!(", at least {lower}")),
            (false, true) => facts.push_str(&format!(", at most {upper}")),
            (false, false) => {}
        }
        if let Some(effect) = parameter.effect {
            let effect = &self.compiled.model.effects[effect];
            let places: Vec<&str> = effect.on.iter().map(|(_, name)| name.as_str()).collect();
            let call = format!("{}({})", effect.template, places.join(", "));
            facts.push_str(&format!("; of the effect {}", code(&call)));
        }
        doc.paragraph(facts + ".");
        doc
    }
}

fn conversions(w: &mut Writer, fields: &[String]) {
    let array = format!("[T; {}]", fields.len());
    w.doc(&Doc::of("From values in the order of `PARAMETER_NAMES`."));
    w.function(
        "pub fn from_array",
        &[format!("values: {array}")],
        "Self",
        |w| {
            w.block("Self {", "}", |w| {
                for (index, field) in fields.iter().enumerate() {
                    w.line(format!("{field}: values[{index}],"));
                }
            });
        },
    );
    w.blank();
    w.doc(&Doc::of("The values in the order of `PARAMETER_NAMES`."));
    w.function("pub fn to_array", &["&self".to_string()], &array, |w| {
        let values = fields
            .iter()
            .map(|field| Array::Simple(format!("self.{field}")));
        w.array("", &Array::Row(values.collect()), "");
    });
    w.blank();
    w.doc(&Doc::of(
        "Every value converted, for instance to another number type.",
    ));
    let arguments = [
        "&self".to_string(),
        "convert: impl FnMut(T) -> U".to_string(),
    ];
    w.function("pub fn map<U: Copy>", &arguments, "Parameters<U>", |w| {
        w.line("Parameters::from_array(self.to_array().map(convert))");
    });
}

fn nominal(w: &mut Writer, parameters: &[Parameter], fields: &[String]) {
    w.doc(&Doc::of("The nominal values."));
    let values: Vec<f64> = parameters.iter().map(|p| p.nominal).collect();
    if let Some(attribute) = numbers_as_stated(&values) {
        w.line(attribute);
    }
    w.function("pub fn nominal", &[], "Self", |w| {
        w.block("Self {", "}", |w| {
            for (value, field) in values.iter().zip(fields) {
                w.line(format!("{field}: T::from_f64({}),", number(*value)));
            }
        });
    });
}

/// For a model without parameters: the type is there, so that all models look alike.
fn no_parameters(w: &mut Writer) {
    w.doc(&Doc::of("The model has no parameters."));
    w.line("#[derive(Clone, Copy, Debug, PartialEq)]");
    w.line("pub struct Parameters<T>(core::marker::PhantomData<T>);");
    w.blank();
    w.block("impl<T> Parameters<T> {", "}", |w| {
        w.doc(&Doc::of("The only value."));
        w.function("pub fn nominal", &[], "Self", |w| {
            w.line("Self(core::marker::PhantomData)")
        });
        w.blank();
        w.doc(&Doc::of("From the values of no parameter."));
        let values = ["_values: [T; 0]".to_string()];
        w.function("pub fn from_array", &values, "Self", |w| {
            w.line("Self(core::marker::PhantomData)")
        });
        w.blank();
        w.doc(&Doc::of("The values of no parameter."));
        let myself = ["&self".to_string()];
        w.function("pub fn to_array", &myself, "[T; 0]", |w| w.line("[]"));
        w.blank();
        w.doc(&Doc::of("The same for another number type."));
        let arguments = [
            "&self".to_string(),
            "_convert: impl FnMut(T) -> U".to_string(),
        ];
        w.function("pub fn map<U>", &arguments, "Parameters<U>", |w| {
            w.line("Parameters(core::marker::PhantomData)");
        });
    });
}
