//! Writing findings into the model file: one line each, the rest untouched.

use super::described::with_described;
use super::finding::{Finding, ParameterEstimate};
use dynamics_codegen::model::Described;
use dynamics_codegen::parts::value_in_use;
use dynamics_codegen::source::Sources;
use dynamics_codegen::syntax::{Expr, Name, Statement, StatementKind};
use dynamics_codegen::syntax::{effect_prefix, parse, written_name};

/// The model's text with the findings written in; `described` are the parameters that a robot
/// description has the values of. `provenance` is said in a comment beside each finding. New
/// lines end as the first of the text does.
pub fn patch(
    text: &str,
    findings: &[Finding],
    described: &[Described],
    provenance: &str,
) -> String {
    let mut patched = text.to_string();
    let end = line_end(text);
    // A comment must stay on its line.
    let provenance: String = provenance.chars().filter(|c| !c.is_control()).collect();
    for finding in findings {
        if finding.effect == "parameter" {
            patched = with_parameters(&patched, finding, described, &provenance);
        } else {
            if !patched.ends_with('\n') {
                patched.push_str(end);
            }
            for place in &finding.places {
                let lines = effect_lines(finding, place, &provenance);
                patched.push_str(&lines.replace('\n', end));
            }
        }
    }
    patched
}

/// How the lines of a text end.
fn line_end(text: &str) -> &'static str {
    match text.split_once('\n') {
        Some((first, _)) if first.ends_with('\r') => "\r\n",
        _ => "\n",
    }
}

fn effect_lines(finding: &Finding, place: &[String], provenance: &str) -> String {
    let values: Vec<String> = finding
        .parameters
        .iter()
        .map(|(name, p)| format!("{name} = {}", number(p)))
        .collect();
    let on: Vec<String> = place.iter().map(|name| written_name(name)).collect();
    format!(
        "\n// {provenance}; evidence {:.0} nats.\neffect {}({}) {{ {} }}\n",
        finding.evidence,
        finding.effect,
        on.join(", "),
        values.join(", ")
    )
}

/// The declarations' values replaced, with a comment behind each statement; what the model does
/// not state itself, its robot description does: that is stated anew, at the end.
fn with_parameters(
    text: &str,
    finding: &Finding,
    described: &[Described],
    provenance: &str,
) -> String {
    let said = format!("{provenance}; evidence {:.0} nats.", finding.evidence);
    let mut text = text.to_string();
    let mut anew = String::new();
    for (name, estimate) in &finding.parameters {
        if let Some(changed) = with_parameter(&text, (name, estimate), &said) {
            text = changed;
            continue;
        }
        let number_of = described.iter().find(|number| number.parameter == *name);
        if let Some(number) = number_of {
            text = with_described(&text, number);
        }
        let end = line_end(&text);
        anew += &format!("parameter {name} = {};{end}", number(estimate));
    }
    if anew.is_empty() {
        return text;
    }
    let end = line_end(&text);
    let line = if text.ends_with('\n') { "" } else { end };
    format!("{text}{line}{end}// {said}{end}{anew}")
}

/// A declaration's value replaced, with a comment behind the statement; nothing if the text has
/// none.
fn with_parameter(
    text: &str,
    (name, estimate): (&String, &ParameterEstimate),
    said: &str,
) -> Option<String> {
    let mut sources = Sources::new();
    let id = sources.add("model", text);
    let file = parse(&sources, id).0?;
    let statements = file.statements.clone();
    for statement in &statements {
        match &statement.kind {
            StatementKind::Parameter {
                name: declared,
                nominal: Some(nominal),
                ..
            } if declared.text == *name => {
                let old = &text[nominal.span.start..nominal.span.end];
                return Some(format!(
                    "{}{}{} // was {old}: {said}{}",
                    &text[..nominal.span.start],
                    number(estimate),
                    &text[nominal.span.end..statement.span.end],
                    rest_of_line(&text[statement.span.end..], line_end(text)),
                ));
            }
            StatementKind::Effect { values, .. } => {
                // Inside the use of a part a place is written as a path.
                let called: [fn(&str) -> String; 2] = [str::to_string, |on| on.replace('.', "_")];
                let mut prefixes = called
                    .iter()
                    .filter_map(|c| effect_prefix(&statement.kind, c));
                let own = prefixes.find_map(|prefix| name.strip_prefix(&prefix));
                if let Some(own) = own {
                    return Some(with_own_value(text, statement, values, (own, estimate)));
                }
            }
            _ => {}
        }
    }
    let (used, key) = value_in_use(file, &sources, name)?;
    statements
        .iter()
        .find_map(|statement| match &statement.kind {
            StatementKind::Use(found) if found.name.text == used => Some(with_own_value(
                text,
                statement,
                &found.values,
                (&key, estimate),
            )),
            _ => None,
        })
}

/// A value in the braces of an effect, or of the use of a part, replaced or added.
fn with_own_value(
    text: &str,
    statement: &Statement,
    values: &[(Name, Expr)],
    (own, estimate): (&str, &ParameterEstimate),
) -> String {
    let same = |key: &str| key.replace('.', "_") == own.replace('.', "_");
    let given = values.iter().find(|(key, _)| same(&key.text));
    if let Some((_, expr)) = given {
        let (before, after) = (&text[..expr.span.start], &text[expr.span.end..]);
        return format!("{before}{}{after}", number(estimate));
    }
    let (start, end) = (statement.span.start, statement.span.end);
    let value = format!("{own} = {}", number(estimate));
    let changed = with_value(&text[start..end], values.is_empty(), &value);
    format!("{}{changed}{}", &text[..start], &text[end..])
}

/// A statement with one more value in its braces, `first` if there is none yet.
fn with_value(statement: &str, first: bool, value: &str) -> String {
    let statement = statement.trim_end().trim_end_matches(';').trim_end();
    match statement.strip_suffix('}') {
        Some(open) if first => format!("{}{{ {value} }}", open.trim_end().trim_end_matches('{')),
        Some(open) => {
            let open = open.trim_end().trim_end_matches([',', ';']);
            format!("{open}, {value} }}")
        }
        None => format!("{statement} {{ {value} }}"),
    }
}

/// What follows a statement; if it shares the line, it moves to the next one, out
/// of the comment.
fn rest_of_line(rest: &str, end: &str) -> String {
    let line = rest.split('\n').next().unwrap_or("");
    if line.trim().is_empty() || line.trim_start().starts_with("//") {
        rest.to_string()
    } else {
        format!("{end}{rest}")
    }
}

/// As many digits as the estimate is good for, and one more.
fn number(estimate: &ParameterEstimate) -> String {
    let ParameterEstimate { value, std, .. } = estimate;
    if !(std.is_finite() && *std > 0.0) || *value == 0.0 {
        return format!("{value}");
    }
    let digits = (value.abs() / std).log10().ceil().clamp(0.0, 12.0) as usize + 2;
    let text = format!("{value:.precision$e}", precision = digits - 1);
    text.parse::<f64>()
        .map_or_else(|_| format!("{value}"), |rounded| format!("{rounded}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn finding(effect: &str, on: &str, name: &str, value: f64, std: f64) -> Finding {
        let estimate = ParameterEstimate {
            value,
            std,
            unit: String::new(),
        };
        Finding {
            effect: effect.into(),
            on: vec![on.into()],
            places: vec![vec![on.into()]],
            parameters: BTreeMap::from([(name.into(), estimate)]),
            evidence: 12.3,
            confounded_with: Vec::new(),
            same_on: Vec::new(),
            is_measured: false,
        }
    }

    #[test]
    fn an_effect_becomes_a_line_at_the_end() {
        let patched = patch(
            "model a;",
            &[finding("viscous", "j2", "d", 0.019_98, 1e-4)],
            &[],
            "log\nx",
        );
        assert_eq!(
            patched,
            "model a;\n\n// logx; evidence 12 nats.\neffect viscous(j2) { d = 0.01998 }\n"
        );
    }

    /// Every line of a text with Windows line ends, old or new, ends like the others.
    #[test]
    fn new_lines_end_as_the_others_do() {
        let text = "model a;\r\nparameter m: kg = 1.0; parameter l: m = 2;\r\nurdf \"a.urdf\";\r\n";
        let described = [Described {
            parameter: "rod_mass".into(),
            option: "parameters",
            of: "rod".into(),
        }];
        let found = [
            finding("parameter", "m", "m", 1.2, 0.01),
            finding("parameter", "rod_mass", "rod_mass", 1.25, 0.01),
            finding("viscous", "j2", "d", 0.02, 1e-4),
        ];
        let patched = patch(text, &found, &described, "log");
        assert_eq!(patched.matches('\n').count(), 10, "{patched}");
        assert_eq!(patched.matches("\r\n").count(), 10, "{patched:?}");
    }

    #[test]
    fn an_effect_gets_the_value_that_it_had_by_default() {
        let found = finding("parameter", "viscous_j_d", "viscous_j_d", 0.25, 0.01);
        for (effect, changed) in [
            ("effect viscous(j);", "effect viscous(j) { d = 0.25 }"),
            ("effect viscous(j) {}", "effect viscous(j) { d = 0.25 }"),
        ] {
            let text = |effect: &str| {
                format!(
                    "model a;\ncoordinate j: m;\nparameter m: kg = 1;\nkinetic m/2*dot(j)^2;\n{effect}\n"
                )
            };
            let patched = patch(&text(effect), std::slice::from_ref(&found), &[], "log");
            assert_eq!(patched, text(changed));
            let library = dynamics_codegen::Library::builtin();
            assert!(dynamics_codegen::compile("a", &patched, &library).is_ok());
        }
    }

    /// What one use of a part has for itself stands in its braces, and the others keep theirs.
    #[test]
    fn a_use_gets_the_value_that_its_part_had_for_all() {
        let text = |left: &str| {
            format!(
                "model a;\npart leg() {{\n    coordinate j: m;\n    parameter m: kg = 1;\n    \
                 kinetic m/2*dot(j)^2;\n    effect viscous(j) {{ d = 1 }}\n}}\n\
                 {left}\nuse right = leg();\neffect spring(left.j) {{ k = 2 }}\n"
            )
        };
        let library = dynamics_codegen::Library::builtin();
        let written =
            |changed: &str| text("use left = leg();").replace("use left = leg();", changed);
        let cases = [
            (
                "left_m",
                "use left = leg();",
                written("use left = leg() { m = 0.25 }"),
            ),
            (
                "left_m",
                "use left = leg() { m = 3 }",
                written("use left = leg() { m = 0.25 }"),
            ),
            (
                "viscous_left_j_d",
                "use left = leg();",
                written("use left = leg() { viscous_j_d = 0.25 }"),
            ),
            (
                "spring_left_j_k",
                "use left = leg();",
                text("use left = leg();").replace("k = 2", "k = 0.25"),
            ),
        ];
        for (name, before, after) in cases {
            let found = finding("parameter", name, name, 0.25, 0.01);
            let patched = patch(&text(before), &[found], &[], "log");
            assert_eq!(patched, after, "{name}");
            let compiled = dynamics_codegen::compile("a", &patched, &library).unwrap();
            let parameters = &compiled.model.parameters;
            let changed = parameters.iter().find(|p| p.name == name).unwrap();
            assert_eq!(changed.nominal, 0.25);
        }
    }

    #[test]
    fn what_only_a_robot_description_says_is_stated_anew() {
        let found = finding("parameter", "rod_mass", "rod_mass", 1.25, 0.01);
        let described = [Described {
            parameter: "rod_mass".into(),
            option: "parameters",
            of: "rod".into(),
        }];
        for (given, changed) in [
            ("{ parameters: all; }", "{ parameters: all; }"),
            (";", " { parameters: rod; }"),
        ] {
            let text = format!("model a;\nurdf \"a.urdf\"{given}");
            let patched = patch(&text, std::slice::from_ref(&found), &described, "log");
            let expected = format!(
                "model a;\nurdf \"a.urdf\"{changed}\n\n\
                 // log; evidence 12 nats.\nparameter rod_mass = 1.25;\n"
            );
            assert_eq!(patched, expected);
        }
    }

    #[test]
    fn a_parameter_is_changed_where_it_stands() {
        let text = "model a;\nparameter m: kg = 1.0 in 0..; // mass\n";
        let patched = patch(
            text,
            &[finding("parameter", "m", "m", 1.234_56, 0.01)],
            &[],
            "log",
        );
        assert_eq!(
            patched,
            "model a;\nparameter m: kg = 1.2346 in 0..; // was 1.0: log; evidence 12 nats. // mass\n"
        );
    }
}
