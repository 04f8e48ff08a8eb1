//! Delays and lags that several inputs share: a loop has one clock.

use super::finding::{Finding, ParameterEstimate};

/// Findings of one timing effect on several inputs (told by `is_of_input`) as one, where its
/// times agree: with one time for all the log is explained as well for fewer parameters (by Wald's
/// statistic and the price of `rows` readings).
pub(super) fn on_one_clock(
    findings: Vec<Finding>,
    rows: usize,
    is_of_input: impl Fn(&Finding) -> bool,
) -> Vec<Finding> {
    let mut merged: Vec<Finding> = Vec::new();
    for finding in findings {
        let alike = merged
            .iter()
            .position(|known| is_timing(&finding) && known.effect == finding.effect);
        let alike = alike.filter(|_| is_of_input(&finding));
        match alike.and_then(|i| Some((i, common(&merged[i], &finding, rows)?))) {
            Some((i, common)) => merged[i] = common,
            None => merged.push(finding),
        }
    }
    merged.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    merged
}

/// Whether an effect on one place has times only for parameters.
fn is_timing(finding: &Finding) -> bool {
    let mut parameters = finding.parameters.values();
    finding.on.len() == 1 && !finding.parameters.is_empty() && parameters.all(|p| p.unit == "s")
}

/// Two findings as one with the mean of their times, each by its precision; `None` if the
/// times differ by more than chance and price allow.
fn common(a: &Finding, b: &Finding, rows: usize) -> Option<Finding> {
    let mut whole = a.clone();
    let mut misfit = 0.0;
    for (name, own) in &mut whole.parameters {
        let other = b.parameters.get(name)?;
        let [of_a, of_b] = [&*own, other].map(|p| p.std.powi(-2));
        if !(of_a.is_finite() && of_b.is_finite() && of_a > 0.0 && of_b > 0.0) {
            return None;
        }
        misfit += (own.value - other.value).powi(2) / (of_a.recip() + of_b.recip());
        *own = ParameterEstimate {
            value: (of_a * own.value + of_b * other.value) / (of_a + of_b),
            std: (of_a + of_b).sqrt().recip(),
            unit: own.unit.clone(),
        };
    }
    if misfit > a.parameters.len() as f64 * (rows.max(2) as f64).ln() {
        return None;
    }
    whole.on.extend(b.on.iter().cloned());
    whole.on.sort();
    whole.places.extend(b.places.iter().cloned());
    whole.places.sort();
    whole.evidence += b.evidence;
    whole
        .confounded_with
        .extend(b.confounded_with.iter().cloned());
    Some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn delay(on: &str, value: f64, std: f64) -> Finding {
        let unit = "s".to_string();
        let estimate = ParameterEstimate { value, std, unit };
        Finding {
            effect: "input_delay".into(),
            on: vec![on.into()],
            places: vec![vec![on.into()]],
            parameters: BTreeMap::from([("tau".into(), estimate)]),
            evidence: 50.0,
            confounded_with: Vec::new(),
            same_on: Vec::new(),
            is_measured: false,
        }
    }

    #[test]
    fn equal_delays_are_one() {
        let found = on_one_clock(
            vec![
                delay("x", 0.040, 1e-3),
                delay("y", 0.041, 1e-3),
                delay("z", 0.0405, 1e-3),
            ],
            1000,
            |_| true,
        );
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].on, ["x", "y", "z"]);
        assert_eq!(found[0].places.len(), 3);
        let tau = &found[0].parameters["tau"];
        assert!((tau.value - 0.0405).abs() < 1e-6 && tau.std < 6e-4);
    }

    #[test]
    fn delays_that_differ_stay_apart() {
        let apart = vec![delay("x", 0.04, 1e-3), delay("y", 0.06, 1e-3)];
        assert_eq!(on_one_clock(apart, 1000, |_| true).len(), 2);
        // Times of sensors have clocks of their own.
        let sensors = vec![delay("x", 0.04, 1e-3), delay("y", 0.04, 1e-3)];
        assert_eq!(on_one_clock(sensors, 1000, |_| false).len(), 2);
    }
}
