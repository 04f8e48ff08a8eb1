//! Which variable a residual is best seen against.

use crate::trace::{CoordinateSeries, Finding, Series};

/// A variable along the log.
#[derive(Debug, Clone, Copy)]
pub(super) enum Variable<'a> {
    Position(&'a CoordinateSeries),
    Velocity(&'a CoordinateSeries),
    Acceleration(&'a CoordinateSeries),
    /// The input's index.
    Input(usize),
}

impl Variable<'_> {
    /// Its values at the stamps of the series.
    pub fn values<'s>(&'s self, series: &'s Series) -> &'s [f64] {
        match self {
            Self::Position(c) => &c.position,
            Self::Velocity(c) => &c.velocity,
            Self::Acceleration(c) => &c.acceleration,
            Self::Input(i) => &series.inputs[*i].values,
        }
    }
}

/// The coordinate whose residual a finding is about: the one it names, else the one in
/// which the residual shrinks most.
pub(super) fn coordinate<'a>(
    series: &'a Series,
    finding: Option<&Finding>,
) -> Option<&'a CoordinateSeries> {
    let named = finding.and_then(|finding| {
        let coordinates = series.coordinates.iter();
        coordinates
            .filter(|c| finding.on.contains(&c.name))
            .max_by(|a, b| gain(a).total_cmp(&gain(b)))
    });
    let most = || {
        let coordinates = series.coordinates.iter();
        coordinates.max_by(|a, b| gain(a).total_cmp(&gain(b)))
    };
    named.or_else(most)
}

/// Share of the residual's mean square that the patched model removes.
fn gain(coordinate: &CoordinateSeries) -> f64 {
    let square = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let before = square(&coordinate.force_before);
    if before > 0.0 {
        1.0 - square(&coordinate.force_after) / before
    } else {
        0.0
    }
}

/// The variable that an effect depends on by its nature; where that is not known, the
/// one that explains most of the residual.
pub(super) fn variable<'a>(
    series: &'a Series,
    coordinate: &'a CoordinateSeries,
    finding: Option<&Finding>,
) -> Variable<'a> {
    let all = variables(series);
    let by_nature = finding.and_then(|finding| {
        let own = |c: &CoordinateSeries| c.name == coordinate.name;
        let input = |i: usize| finding.on.contains(&series.inputs[i].name);
        let about = |variable: &&Variable<'_>| match (finding.effect.as_str(), **variable) {
            (
                "viscous" | "coulomb" | "asymmetric_coulomb" | "stribeck" | "load_friction"
                | "quadratic_drag" | "speed_drag" | "joint_coupling" | "contact_friction"
                | "rolling_resistance" | "lugre",
                Variable::Velocity(c),
            )
            | (
                "spring" | "cubic_spring" | "gravity_tilt" | "cogging" | "constant_force",
                Variable::Position(c),
            )
            | ("armature", Variable::Acceleration(c)) => own(c),
            (
                "input_gain" | "input_bias" | "input_delay" | "input_lag" | "dead_band"
                | "backlash" | "saturation",
                Variable::Input(i),
            ) => input(i),
            _ => false,
        };
        all.iter().find(about).copied()
    });
    by_nature.unwrap_or_else(|| {
        let share = |v: &Variable<'_>| explained(v.values(series), &coordinate.force_before);
        let best = all.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        // A series has a coordinate, so a variable, since one was given.
        best.copied().unwrap_or(Variable::Position(coordinate))
    })
}

fn variables(series: &Series) -> Vec<Variable<'_>> {
    let of = |c| {
        [
            Variable::Velocity(c),
            Variable::Position(c),
            Variable::Acceleration(c),
        ]
    };
    let inputs = (0..series.inputs.len()).map(Variable::Input);
    series
        .coordinates
        .iter()
        .flat_map(of)
        .chain(inputs)
        .collect()
}

/// Correlation ratio `η²`: share of the variance of `y` that lies between groups of
/// samples with like `x` (ten groups of one size).
fn explained(x: &[f64], y: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|&a, &b| x[a].total_cmp(&x[b]));
    let varies = order.first().is_some_and(|&low| {
        let high = order[order.len() - 1];
        x[low] < x[high]
    });
    if !varies {
        return 0.0;
    }
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let total: f64 = y.iter().map(|y| (y - mean).powi(2)).sum();
    let between = order.chunks(order.len().div_ceil(GROUPS)).map(|group| {
        let sum: f64 = group.iter().map(|&k| y[k] - mean).sum();
        sum * sum / group.len() as f64
    });
    if total > 0.0 {
        between.sum::<f64>() / total
    } else {
        0.0
    }
}

const GROUPS: usize = 10;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_depends_on_velocity_is_shown_against_velocity() {
        let t = (0..400).map(|k| f64::from(k) * 0.05);
        let position: Vec<f64> = t.clone().map(f64::sin).collect();
        let velocity: Vec<f64> = t.map(f64::cos).collect();
        let coordinate = CoordinateSeries {
            name: "x".into(),
            force_before: velocity.iter().map(|v| -0.3 * v * v * v).collect(),
            force_after: vec![0.0; 400],
            acceleration: position.iter().map(|x| -x).collect(),
            position,
            velocity,
            ..CoordinateSeries::default()
        };
        let series = Series {
            coordinates: vec![coordinate],
            ..Series::default()
        };
        let about = &series.coordinates[0];
        assert!(matches!(
            variable(&series, about, None),
            Variable::Velocity(c) if c.name == "x"
        ));
    }
}
