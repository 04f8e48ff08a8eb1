//! Ports that are one thing after the other: `effect input_delay(drive: each input);`.
//!
//! Applied to several, a template says the same of each of them, with one set of parameters for all:
//! drives behind one bus are late by one time.

use super::builder::Builder;
use super::names::{Binding, Scope};
use super::template::follows_port;
use crate::diagnostic::Diagnostic;
use crate::source::Sources;
use crate::syntax::{Name, Port, PortKind, Statement, StatementKind};

/// What of a model a template is applied to.
pub(super) type Places = Vec<(PortKind, String)>;

/// Reports a port for several one after the other that is not the only one.
pub(super) fn refuse_beside_others(builder: &mut Builder<'_>, ports: &[Port]) -> Option<()> {
    match ports.iter().find(|port| port.each && ports.len() > 1) {
        Some(port) => {
            let message = "a port for each of several is the only one";
            builder.report(Diagnostic::error(port.name.span, message))
        }
        None => Some(()),
    }
}

/// Binds a port for each of several to one after the other of the `places`: which these are, and a scope for each.
pub(super) fn bind_each(
    builder: &mut Builder<'_>,
    port: &Port,
    places: &[Name],
) -> Option<(Places, Vec<Scope>)> {
    let (mut bound, mut scopes) = (Places::new(), Vec::new());
    for place in places {
        let (kind, index) = builder.find_port(port.kind, place)?;
        if bound.iter().any(|(_, known)| *known == place.text) {
            let message = format!("`{}` is named twice", place.text);
            return builder.report(Diagnostic::error(place.span, message));
        }
        bound.push((kind, place.text.clone()));
        let mut scope = Scope::default();
        scope.ports.insert(port.name.text.clone(), (kind, index));
        scopes.push(scope);
    }
    Some((bound, scopes))
}

impl Builder<'_> {
    /// What a template that was applied to the first of several says of the `others`: with the
    /// parameters that the scope of the first has.
    pub(super) fn repeat(
        &mut self,
        others: Vec<(&Name, Scope)>,
        statements: &[&Statement],
        sources: &mut Sources,
        library: &super::Library,
    ) {
        let is_parameter = |s: &&Statement| matches!(s.kind, StatementKind::Parameter { .. });
        let (shared, own): (Vec<&Statement>, Vec<&Statement>) =
            statements.iter().copied().partition(is_parameter);
        let mut names = self.scope.names.clone();
        names.retain(|_, declared| matches!(declared.what, Binding::Parameter(_)));
        let findings = self.finding_count();
        for (place, scope) in others {
            self.scope = scope;
            self.scope.names.clone_from(&names);
            self.member = format!("{}_", place.text);
            for statement in shared.iter().filter(|s| follows_port(s)) {
                self.expect_one_unit(statement, place);
            }
            // What is wrong is said once.
            if self.finding_count() > findings {
                return;
            }
            self.declare(&own, sources, library);
            self.lower_statements(&own);
        }
    }

    /// Reports a parameter whose unit is another one there.
    fn expect_one_unit(&mut self, parameter: &Statement, place: &Name) -> Option<()> {
        let StatementKind::Parameter {
            name,
            unit: Some(unit),
            ..
        } = &parameter.kind
        else {
            return None;
        };
        let Binding::Parameter(index) = self.scope.names.get(&name.text)?.what else {
            return None;
        };
        let (first, here) = (
            self.model.parameters[index].dimension?,
            self.dimension(unit)?,
        );
        if first == here {
            return None;
        }
        let message = format!(
            "`{}` is one number for all, in `{first}`; of `{}` it would be in `{here}`",
            name.text, place.text
        );
        let help = "apply the effect to what has one unit";
        self.report(Diagnostic::error(place.span, message).help(help))
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Delay;
    use crate::{Compiled, Library, compile};

    const CART: &str = "model cart; coordinate x: m; input left: N; input right: N; parameter m: kg = 2; \
        kinetic m/2*dot(x)^2; force x = left - 2*right;";

    fn compiled(effects: &str) -> Compiled {
        let text = format!("{CART} {effects}");
        compile("cart.model", &text, &Library::builtin())
            .unwrap_or_else(|report| panic!("{report}"))
    }

    /// What pushes the cart and how its states change, as text.
    fn written(compiled: &Compiled) -> Vec<String> {
        let model = &compiled.model;
        let rates = model.states.iter().map(|state| state.rate);
        let all = model.forces.iter().copied().chain(rates);
        let name = |symbol| model.graph.symbol_name(symbol).to_string();
        all.map(|expr| model.graph.display(expr, name).to_string())
            .collect()
    }

    #[test]
    fn several_share_the_parameters_and_remember_by_themselves() {
        let both = compiled("effect input_lag(left, right) { tau = 0.3 }");
        let parameters = &both.model.parameters;
        let [_, tau] = &parameters[..] else {
            panic!("{parameters:?}")
        };
        assert_eq!(
            (tau.name.as_str(), tau.nominal),
            ("input_lag_left_right_tau", 0.3)
        );
        let states: Vec<&str> = both.model.states.iter().map(|z| z.name.as_str()).collect();
        assert_eq!(
            states,
            [
                "input_lag_left_right_left_late",
                "input_lag_left_right_right_late"
            ]
        );
        let alone = compiled("effect input_lag(left); effect input_lag(right);");
        let as_both = |text: String| {
            let text = text.replace("input_lag_left_", "input_lag_left_right_left_");
            let text = text.replace("input_lag_right_", "input_lag_left_right_right_");
            let text = text.replace("left_right_left_tau", "left_right_tau");
            text.replace("left_right_right_tau", "left_right_tau")
        };
        let alone: Vec<String> = written(&alone).into_iter().map(as_both).collect();
        assert_eq!(written(&both), alone);
    }

    #[test]
    fn one_more_delay_of_one_of_several_adds_up() {
        let model = compiled(
            "effect input_delay(left, right) { tau = 0.3 } effect input_delay(left) { tau = 0.1 }",
        )
        .model;
        let mut values = vec![0.0; model.graph.symbol_count()];
        for parameter in &model.parameters {
            values[parameter.symbol.index()] = parameter.nominal;
        }
        let by = |late: &Delay| (late.input, model.graph.evaluate(&[late.by], &values)[0]);
        let mut late: Vec<(usize, f64)> = model.delays.iter().map(by).collect();
        late.sort_by(|a, b| a.1.total_cmp(&b.1));
        assert_eq!(late, [(1, 0.3), (0, 0.4)]);
    }
}
