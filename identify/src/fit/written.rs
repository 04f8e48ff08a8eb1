//! What a fit found, written into the model: effects, parameters and the numbers of bodies.

use super::groups::Coefficient;
use super::point::of_unit_mass;
use super::{Fit, Inertia, InertialParameter, Request, Term, Value};
use crate::floating::as_given;
use crate::number::short;
use crate::trace::{Finding, ParameterEstimate, patch, with_losses};
use dynamics_codegen::derive::STANDARD;
use dynamics_codegen::emit::identifier;
use dynamics_codegen::model::{Described, RobotBase};
use dynamics_codegen::source::Sources;
use dynamics_codegen::syntax::{BodyStatement, Expr, StatementKind, parse};
use dynamics_codegen::{Library, Report, compile};

/// The model that is fitted, and that a fit is written into.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// What messages call it.
    pub name: &'a str,
    /// Its text; of a robot description that of a model that names it.
    pub text: &'a str,
    /// The effects that it may name; those of a term are tried.
    pub library: &'a Library,
}

/// Why a fit cannot be written into a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unwritable {
    /// Nothing that predicts was found.
    #[error("the fit makes the model worse: nothing of it is written")]
    Worse,
    /// Inertias by linear regression may be those of no body.
    #[error(
        "inertias by linear regression may be those of no body and are not written; \
         `--inertia consistent` gives ones that are, `--inertia fixed` leaves them as they are"
    )]
    Linear,
    /// Inertias of one use of a part, which writes those of all uses.
    #[error(
        "the inertia of `{0}` stands in a part and is that of all its uses: give it as parameters of \
         the model and write it by hand, or leave it with `--inertia fixed`"
    )]
    Part(String),
    /// The model with what was found does not compile.
    #[error("the model with what was found is none: {0}")]
    Model(Box<Report>),
}

/// Digits that corrected inertias are written with: differences of large ones must stay right.
const DIGITS: f64 = 1e-9;

/// The model with what was found written in; as it is, if nothing was. It compiles, and explains
/// the forces as well as [`Fit::after`] says.
///
/// # Errors
/// If nothing of it should, or can, be written.
pub fn written(fit: &Fit, request: &Request<'_>) -> Result<String, Unwritable> {
    let source = &request.source;
    if fit.worse {
        return Err(Unwritable::Worse);
    }
    if fit.inertia == Inertia::Linear {
        return Err(Unwritable::Linear);
    }
    let model = &request.compiled.model;
    let provenance = format!(
        "dynamics fit, {}: held-out force error {} -> {}",
        log_name(request),
        short(fit.before.total),
        short(fit.after.total)
    );
    let mut text = source.text.to_string();
    if let Some(robot) = &model.robot {
        text = without_losses(&text, robot, fit);
    }
    let bodies: Vec<Body> = fit.inertial.chunks(STANDARD.len()).map(Body::of).collect();
    let of_use = |body: &&Body| {
        let mut uses = model.uses.iter();
        uses.any(|used| body.name.starts_with(&format!("{}_", used.name)))
    };
    let stated = stated_bodies(source.text);
    let mut others = bodies.iter().filter(|body| !stated.contains(&body.name));
    if let Some(body) = others.find(of_use) {
        return Err(Unwritable::Part(body.name.clone()));
    }
    text = with_bodies(&text, &bodies);
    let (mut findings, mut described) = (Vec::new(), Vec::new());
    for term in &fit.terms {
        findings.extend(term_findings(term));
    }
    if model.robot.is_some() {
        for body in bodies.iter().filter(|body| !stated.contains(&body.name)) {
            described.extend(body.described());
            findings.push(body.finding(fit.inertia_evidence));
        }
    }
    text = patch(&text, &findings, &described, &provenance);
    if text == source.text {
        return Ok(text);
    }
    let written = match model.poses.is_empty() {
        true => compile(source.name, &text, source.library).map(|_| text),
        false => as_given(source.name, &text, source.library),
    };
    written.map_err(|report| Unwritable::Model(Box::new(report)))
}

fn log_name(request: &Request<'_>) -> String {
    let name = request.train.path.file_name();
    name.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The model in which losses that the description states act in those joints only whose friction
/// was not fitted: of the others it is stated anew, as effects.
fn without_losses(text: &str, robot: &RobotBase, fit: &Fit) -> String {
    let described = |c: &Coefficient| c.holder.is_none() && c.stated != c.default;
    let fitted = |joint: &str| {
        let mut own = fit.terms.iter().filter(|term| term.on == [joint]);
        own.any(|term| term.details.coefficients.iter().any(described))
    };
    let all = robot.losses.iter();
    let kept: Vec<String> = all
        .clone()
        .filter(|losses| losses.follows || !fitted(&losses.joint))
        .map(|losses| losses.joint.clone())
        .collect();
    match kept.len() == robot.losses.len() {
        true => text.to_string(),
        false => with_losses(text, &kept),
    }
}

/// A term's coefficients as effects of the library, or as other values of what the model states.
fn term_findings(term: &Term) -> Vec<Finding> {
    let all = &term.details.coefficients;
    let effects = all.chunk_by(|a, b| a.effect == b.effect);
    let each = effects.flat_map(|own| match own.iter().any(|c| c.holder.is_some()) {
        true => other_values(term, own),
        false => effect_finding(term, own).into_iter().collect(),
    });
    each.collect()
}

fn estimate(term: &Term, coefficient: &Coefficient) -> Value {
    let found = term.coefficients.get(&coefficient.name).copied();
    found.unwrap_or(Value {
        value: 0.0,
        std: f64::NAN,
    })
}

/// Other values of the parameters of an effect that the model has.
fn other_values(term: &Term, own: &[Coefficient]) -> Vec<Finding> {
    let held = own.iter().filter_map(|c| Some((c.holder.as_ref()?, c)));
    let each = held.map(|(holder, coefficient)| {
        let on = std::slice::from_ref(holder);
        let value = (holder.as_str(), estimate(term, coefficient));
        finding("parameter", on, [value], term.evidence)
    });
    each.collect()
}

/// An effect that the model has not; `None` where it would do nothing.
fn effect_finding(term: &Term, own: &[Coefficient]) -> Option<Finding> {
    let effect = &own.first()?.effect;
    if own.iter().all(|c| estimate(term, c).value == c.default) {
        return None;
    }
    let strengths = own
        .iter()
        .map(|c| (c.parameter.as_str(), estimate(term, c)));
    let shapes = term.details.shapes.iter();
    let shapes = shapes
        .filter(|(of, ..)| of == effect)
        .map(|(_, name, value)| {
            let value = Value {
                value: *value,
                std: f64::NAN,
            };
            (name.as_str(), value)
        });
    Some(finding(
        effect,
        &term.on,
        strengths.chain(shapes),
        term.evidence,
    ))
}

fn finding<'a>(
    effect: &str,
    on: &[String],
    values: impl IntoIterator<Item = (&'a str, Value)>,
    evidence: f64,
) -> Finding {
    let estimate = |(name, value): (&str, Value)| {
        let estimate = ParameterEstimate {
            value: value.value,
            std: value.std,
            unit: String::new(),
        };
        (name.to_string(), estimate)
    };
    Finding {
        effect: effect.to_string(),
        on: on.to_vec(),
        places: vec![on.to_vec()],
        parameters: values.into_iter().map(estimate).collect(),
        evidence,
        confounded_with: Vec::new(),
        same_on: Vec::new(),
        is_measured: false,
    }
}

/// A body with other inertias: mass, centre of mass, and the tensor about that, `xx yy zz xy xz yz`.
struct Body {
    name: String,
    mass: f64,
    center: [f64; 3],
    tensor: [f64; 6],
}

impl Body {
    /// From `m, h, I_o`.
    fn of(ten: &[InertialParameter]) -> Self {
        let value = |k: usize| ten[k].estimate.value;
        let mass = value(0);
        let center = [1, 2, 3].map(|k| value(k) / mass);
        let steiner = of_unit_mass(center);
        Self {
            name: ten[0].body.clone(),
            mass,
            center,
            tensor: std::array::from_fn(|k| value(4 + k) - mass * steiner[k]),
        }
    }

    /// What the numbers of a robot description's link are called, with the values.
    fn numbers(&self) -> Vec<(String, f64)> {
        let [x, y, z] = self.center;
        let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
        let first = [("mass", self.mass), ("cx", x), ("cy", y), ("cz", z)];
        let all = first.into_iter().chain(names.into_iter().zip(self.tensor));
        let link = identifier(&self.name);
        all.map(|(what, value)| (format!("{link}_{what}"), value))
            .collect()
    }

    fn described(&self) -> impl Iterator<Item = Described> {
        self.numbers().into_iter().map(|(parameter, _)| Described {
            parameter,
            option: "parameters",
            of: self.name.clone(),
        })
    }

    fn finding(&self, evidence: f64) -> Finding {
        let numbers = self.numbers();
        let values = numbers.iter().map(|(name, value)| {
            let std = DIGITS * value.abs();
            (name.as_str(), Value { value: *value, std })
        });
        finding(
            "parameter",
            std::slice::from_ref(&self.name),
            values,
            evidence,
        )
    }
}

/// Numbers with as many digits as inertias are written with.
fn list(values: &[f64]) -> String {
    let each = values.iter().map(|value| {
        let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(*value);
        format!("{rounded}")
    });
    each.collect::<Vec<String>>().join(", ")
}

fn body_statements(text: &str) -> Vec<BodyStatement> {
    let mut sources = Sources::new();
    let id = sources.add("model", text);
    let (file, _) = parse(&sources, id);
    let statements = file.map(|file| file.statements).unwrap_or_default();
    let body = |kind| match kind {
        StatementKind::Body(body) => Some(*body),
        _ => None,
    };
    statements
        .into_iter()
        .filter_map(|s| body(s.kind))
        .collect()
}

fn stated_bodies(text: &str) -> Vec<String> {
    let statements = body_statements(text).into_iter();
    statements.map(|statement| statement.name.text).collect()
}

/// The text with other numbers in the statements of these bodies.
fn with_bodies(text: &str, bodies: &[Body]) -> String {
    let mut edits: Vec<(usize, usize, String)> = Vec::new();
    for statement in body_statements(text) {
        let Some(body) = bodies.iter().find(|body| body.name == statement.name.text) else {
            continue;
        };
        let mut put = |given: Option<&Expr>, entry: &str, value: String| match given {
            Some(given) => edits.push((given.span.start, given.span.end, value)),
            None => {
                let end = statement.frame.span.end;
                edits.push((end, end, format!("; {entry}: {value}")));
            }
        };
        put(statement.mass.as_ref(), "mass", list(&[body.mass]));
        match &statement.center {
            Some(center) => {
                for (given, value) in center.iter().zip(body.center) {
                    put(Some(given), "center", list(&[value]));
                }
            }
            None => put(None, "center", format!("({})", list(&body.center))),
        }
        let tensor = format!("full({})", list(&body.tensor));
        put(statement.inertia.as_ref(), "inertia", tensor);
    }
    edits.sort_by_key(|(start, ..)| std::cmp::Reverse(*start));
    let mut text = text.to_string();
    for (start, end, value) in edits {
        text.replace_range(start..end, &value);
    }
    text
}
