//! What to do next: which motion to record, what to check on the machine, which effect to write.
//!
//! What an effect needs to be seen, and what to look at on a machine that has it, say the lines
//! `Needs:` and `Check:` of its template.

use super::finding::{Finding, Verdict, with_places};
use super::microscope::{Unnamed, UnnamedForce};
use super::outcome::Outcome;
use super::progress::Ended;
use crate::number::short;
use dynamics_codegen::Library;
use dynamics_codegen::dimension::shown_unit;
use serde::Serialize;

/// One thing to do next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Advice {
    /// What to do, in a sentence or two.
    pub text: String,
    /// An effect template to start from, if that is to write one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub template: Option<String>,
}

impl Advice {
    fn to(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            template: None,
        }
    }
}

/// More than this nobody does at once.
const MOST: usize = 2;

/// What to do after an outcome, the most useful first.
pub(super) fn advice(outcome: &Outcome, library: &Library) -> Vec<Advice> {
    if outcome.misread.as_ref().is_some_and(|m| m.is_decisive) && outcome.findings.is_empty() {
        return vec![Advice::to(
            "Read the columns as they are, by a map of the log, and trace again.",
        )];
    }
    let told = outcome.nearest.iter().flat_map(|nearest| &nearest.findings);
    let told: Vec<&Finding> = outcome.findings.iter().chain(told).collect();
    let each = outcome.unfinished.map(unfinished).into_iter();
    let each = each.chain(outcome.unnamed.as_ref().and_then(nameless));
    let each = each.chain(told.iter().find_map(|finding| rival(finding, library)));
    let found = &outcome.findings;
    let each = each.chain(found.iter().filter_map(|finding| check(finding, library)));
    let each = each.chain(found.iter().filter_map(parameter));
    let each = each.chain(told.iter().find_map(|finding| open(finding, library)));
    let steps: Vec<Advice> = each.take(MOST).collect();
    match steps.is_empty() {
        true => vec![otherwise(outcome.verdict)],
        false => steps,
    }
}

fn unfinished(ended: Ended) -> Advice {
    Advice::to(match ended {
        Ended::TimeLimit => {
            "Trace again with more time (--time-limit): what comes last may change the answer."
        }
        Ended::Interrupt => "Trace again to the end: what comes last may change the answer.",
    })
}

/// Where nothing else is to be done.
fn otherwise(verdict: Verdict) -> Advice {
    Advice::to(match verdict {
        Verdict::None => {
            "Nothing. A motion that is faster, slower or wider may show what this one does not."
        }
        Verdict::Unknown => {
            "Record a longer log of a livelier motion, or write the law that you suspect as an \
             effect of your own (--effects)."
        }
        Verdict::Effect | Verdict::Parameter | Verdict::Channel => {
            "Record another motion and trace it with the patched model: what is right holds there, \
             too."
        }
    })
}

/// What to do about forces without a name.
fn nameless(unnamed: &Unnamed) -> Option<Advice> {
    let force = unnamed.forces.first()?;
    let on = &force.coordinate;
    if force.explained < FORETOLD || force.depends_on.is_empty() {
        let lasts = short(force.lasts);
        let follows = match force.explained > 0.0 && !force.depends_on.is_empty() {
            true => format!(
                "follows what was measured in {} % of itself only",
                short(100.0 * force.explained)
            ),
            false => "follows nothing that was measured".into(),
        };
        return Some(Advice::to(format!(
            "Log what else moves or changes there: the force on {on} lasts {lasts} s and {follows}."
        )));
    }
    let template = skeleton(force);
    Some(Advice {
        text: format!(
            "Write the law of the force on {on} as an effect of your own: DIR/unnamed.model, and \
             trace with --effects DIR. To start from:"
        ),
        template: Some(template),
    })
}

/// Share of a force that variables foretell from which a law in them is worth writing.
const FORETOLD: f64 = 0.3;

/// An effect template whose law is a sum over the variables that a force depends on, to be replaced.
fn skeleton(force: &UnnamedForce) -> String {
    // Whether each is an input, which may have a coordinate's name.
    let mut places: Vec<(bool, &str)> = vec![(false, &force.coordinate)];
    let mut terms: Vec<(&str, &str)> = Vec::new();
    for dependence in &force.depends_on {
        let Some((kind, name)) = dependence.variable.split_once('_') else {
            continue;
        };
        let place = (kind == "u", name);
        if !places.contains(&place) {
            places.push(place);
        }
        // A past may stand there several times, forgotten over different ways.
        if !terms.contains(&(kind, name)) {
            terms.push((kind, name));
        }
    }
    // Inputs come last, as in every template.
    places.sort_by_key(|(is_input, _)| *is_input);
    let port = |place: (bool, &str)| match places.iter().position(|p| *p == place) {
        Some(0) | None => "joint".to_string(),
        Some(i) if place.0 => format!("drive{}", numeral(i, places.len())),
        Some(i) => format!("other{}", numeral(i, places.len())),
    };
    let ports = places.iter().map(|&place| match place.0 {
        true => format!("{}: input", port(place)),
        false => port(place),
    });
    let ports: Vec<String> = ports.collect();
    let mut text = format!(
        "/// A force on {} without a name: put the law that you suspect in place of this sum.\n\
         effect unnamed({});\n",
        force.coordinate,
        ports.join(", ")
    );
    let mut law = Vec::new();
    let mut pasts = String::new();
    for (k, (kind, name)) in terms.iter().enumerate() {
        let port = port((*kind == "u", name));
        let (what, variable, unit) = match *kind {
            "dq" => ("velocity", format!("dot({port})"), format!("rate({port})")),
            "past" => ("past", format!("past_{port}"), format!("unit({port})")),
            "u" => ("input", port.clone(), format!("unit({port})")),
            _ => ("position", port.clone(), format!("unit({port})")),
        };
        text.push_str(&format!(
            "\n/// Per {what} of {name}.\nparameter c_{}: torque(joint)/{unit} = 0;",
            k + 1
        ));
        if *kind == "past" {
            pasts.push_str(&format!(
                "\n/// The way after which it has forgotten.\n\
                 parameter reach_{port}: unit({port}) = 0.1 in 1e-3..10;\n\
                 /// Where {name} has come from lately.\n\
                 state {variable}: unit({port});\n\
                 dot({variable}) == dot({port}) - abs(dot({port}))*{variable}/reach_{port};"
            ));
        }
        law.push(format!("c_{}*{variable}", k + 1));
    }
    text.push_str(&pasts);
    text.push_str(&format!("\n\nforce joint = {};\n", law.join(" + ")));
    text
}

/// A number behind the name of a port, where there are several.
fn numeral(place: usize, count: usize) -> String {
    match count {
        ..=2 => String::new(),
        _ => place.to_string(),
    }
}

/// What tells a finding from a rival: a motion, else a look at the machine.
fn rival(finding: &Finding, library: &Library) -> Option<Advice> {
    let name = with_places(&finding.effect, &finding.on);
    let rivals = finding.confounded_with.iter();
    let rivals = rivals.map(|rival| (with_places(&rival.effect, &rival.on), rival));
    let by_motion = rivals.clone().find_map(|(other, rival)| {
        let motion = &rival.separating_motion.as_ref()?.motion;
        Some(format!(
            "Record the same motion {motion}: it tells {name} from {other}."
        ))
    });
    let by_look = || {
        let mut rivals = rivals;
        rivals.find_map(|(other, rival)| {
            let mut either = [&rival.effect, &finding.effect].into_iter();
            let what = either.find_map(|effect| line(&library.describe(effect)?.doc, "Check"))?;
            Some(format!(
                "No simple change of the motion tells {name} from {other}; check {what}"
            ))
        })
    };
    by_motion.or_else(by_look).map(Advice::to)
}

/// What to look at on the machine.
fn check(finding: &Finding, library: &Library) -> Option<Advice> {
    let what = line(&library.describe(&finding.effect)?.doc, "Check")?;
    let name = with_places(&finding.effect, &finding.on);
    Some(Advice::to(format!("For {name} check {what}")))
}

/// A value that can be measured without a log.
fn parameter(finding: &Finding) -> Option<Advice> {
    let [name] = &finding.on[..] else {
        return None;
    };
    let found = finding.parameters.get(name)?;
    let is_parameter = finding.effect == "parameter";
    (is_parameter && found.std.is_finite()).then(|| {
        Advice::to(format!(
            "Weigh or measure {name} if you can: the log says {} ± {} {}.",
            short(found.value),
            short(found.std),
            shown_unit(&found.unit)
        ))
    })
}

/// What it takes to see a parameter that the log does not determine.
fn open(finding: &Finding, library: &Library) -> Option<Advice> {
    let mut parameters = finding.parameters.iter();
    let (name, _) = parameters.find(|(_, parameter)| parameter.is_open())?;
    let needs = line(&library.describe(&finding.effect)?.doc, "Needs")?;
    Some(Advice::to(format!(
        "To determine {name} of {} record {needs}",
        with_places(&finding.effect, &finding.on),
    )))
}

/// What a template's description says after a key, up to the next one.
fn line(doc: &str, key: &str) -> Option<String> {
    let mut lines = doc.lines().map(str::trim);
    let first = lines.find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
    let is_key = |line: &str| {
        let word = line.split(':').next().unwrap_or_default();
        word.len() < line.len()
            && !word.contains(['.', ',', ';'])
            && word.starts_with(char::is_uppercase)
    };
    let rest = lines.take_while(|line| !line.is_empty() && !is_key(line));
    let all: Vec<&str> = [first.trim()].into_iter().chain(rest).collect();
    Some(all.join(" "))
}

#[cfg(test)]
mod tests {
    use super::super::finding::Rival;
    use super::super::microscope::Dependence;
    use super::super::score::Errors;
    use super::*;
    use dynamics_codegen::compile;
    use std::collections::BTreeMap;

    const CART: &str = "model cart;
        coordinate x: m; coordinate angle: rad; input f: N; input angle: N*m;
        body b { frame: translate(x, 0, 0)*rotate_z(angle); mass: 1; inertia: diag(1, 1, 1); }
        force x = input(f); force angle = input(angle);";

    fn force(variables: &[&str]) -> UnnamedForce {
        let dependence = |variable: &&str| Dependence {
            variable: variable.to_string(),
            length_scale: 1.0,
        };
        UnnamedForce {
            coordinate: "x".into(),
            size: 1.0,
            lasts: 0.1,
            depends_on: variables.iter().map(dependence).collect(),
            tried: Vec::new(),
            explained: 0.8,
            dissipation: 0.0,
            odd_in_velocity: 0.0,
            remembers: false,
            saved: String::new(),
        }
    }

    /// What a force hardly follows is not said to be followed by nothing.
    #[test]
    fn a_force_that_follows_little_is_said_to() {
        let said = |explained: f64, variables: &[&str]| {
            let unnamed = Unnamed {
                forces: vec![UnnamedForce {
                    explained,
                    ..force(variables)
                }],
                acceleration_after: Errors {
                    total: 0.1,
                    per_coordinate: BTreeMap::new(),
                },
                recovered: 0.0,
            };
            nameless(&unnamed).unwrap().text
        };
        assert!(
            said(0.07, &["q_x"]).ends_with("follows what was measured in 7.000 % of itself only.")
        );
        assert!(said(0.0, &["q_x"]).ends_with("follows nothing that was measured."));
        assert!(said(0.07, &[]).ends_with("follows nothing that was measured."));
    }

    /// Whatever a force depends on, the template to start from is one, and acts where the force does.
    #[test]
    fn every_skeleton_compiles() {
        let sets: [(&[&str], &str); 6] = [
            (&["dq_x"], "x"),
            (&["q_angle", "u_f"], "x, angle, f"),
            (&["u_f", "dq_angle", "q_x"], "x, angle, f"),
            (&["past_x", "past_x", "dq_x"], "x"),
            (&["past_angle"], "x, angle"),
            (&["u_angle", "dq_angle"], "x, angle, angle"),
        ];
        for (variables, on) in sets {
            let text = skeleton(&force(variables));
            let mut library = Library::builtin();
            library.add("unnamed", "unnamed.model", &*text);
            let model = format!("{CART}\neffect unnamed({on});");
            let compiled = compile("cart", &model, &library);
            assert!(compiled.is_ok(), "{text}\n{}", compiled.unwrap_err());
        }
        insta::assert_snapshot!(skeleton(&force(&["u_f", "past_x", "dq_angle"])));
    }

    /// A bias of the drive and a force on the cart are the same along any motion.
    #[test]
    fn what_no_motion_tells_a_look_at_the_machine_may() {
        let rival = Rival {
            effect: "input_bias".into(),
            on: vec!["x".into()],
            evidence_difference: 0.0,
            separating_motion: None,
        };
        let finding = Finding {
            effect: "constant_force".into(),
            on: vec!["x".into()],
            places: Vec::new(),
            parameters: BTreeMap::new(),
            evidence: 655.0,
            confounded_with: vec![rival],
            same_on: Vec::new(),
            is_measured: false,
        };
        let advice = super::rival(&finding, &Library::builtin()).unwrap();
        insta::assert_snapshot!(advice.text, @"No simple change of the motion tells constant_force (x) from input_bias (x); check what the drive's sensor reads when it is off.");
    }

    #[test]
    fn a_line_of_a_description_ends_at_the_next_key() {
        let doc = "A force.\n\nNeeds: slow motion,\nand reversals.\nConfused with: a spring.\n";
        assert_eq!(line(doc, "Needs").unwrap(), "slow motion, and reversals.");
        assert_eq!(line(doc, "Confused with").unwrap(), "a spring.");
        assert_eq!(line(doc, "Check"), None);
    }
}
