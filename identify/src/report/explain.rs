//! How a force is best seen: in which coordinate, and against which variable. What a law depends
//! on its own values along the log say; no effect is known by name here.

use crate::log::rms;
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

/// A force in one coordinate against a variable that it depends on.
pub(super) struct View<'a> {
    pub coordinate: &'a CoordinateSeries,
    pub variable: Variable<'a>,
    /// What is to be explained, at the stamps of the series.
    pub missing: &'a [f64],
    /// What is said to explain it.
    pub law: Option<Vec<f64>>,
}

/// How the force that the model as given lacks is best seen: where it is hardest to explain by
/// chance, against what explains most of it. `None` without coordinates.
pub(super) fn unexplained(series: &Series) -> Option<View<'_>> {
    let each = series.coordinates.iter().map(|coordinate| {
        let (variable, share) = best_seen(series, coordinate, &coordinate.force_before);
        (coordinate, variable, share)
    });
    let (coordinate, variable, _) = each.max_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(View {
        coordinate,
        variable,
        missing: &coordinate.force_before,
        law: None,
    })
}

/// How a finding is best seen: in the coordinate where it is most of what is missing without it,
/// against what it depends on there. `None` where nothing is known of the log without it.
pub(super) fn explaining<'a>(series: &'a Series, finding: &Finding) -> Option<View<'a>> {
    let explained = series.explained.iter().find(|explained| {
        explained.effect == finding.effect && finding.places.contains(&explained.on)
    })?;
    let each = series.coordinates.iter().zip(&explained.without);
    let each = each.map(|(coordinate, without)| {
        let both = without.iter().zip(&coordinate.force_after);
        let law: Vec<f64> = both.map(|(without, with)| without - with).collect();
        let [own, all] = [&law, without].map(|force| rms(force));
        (coordinate, without, law, own / all)
    });
    let (coordinate, without, law, _) = each.max_by(|a, b| a.3.total_cmp(&b.3))?;
    // What a channel does is said of the channel.
    let channel = series
        .inputs
        .iter()
        .position(|input| finding.on.contains(&input.name));
    let is_joint = series
        .coordinates
        .iter()
        .any(|c| finding.on.contains(&c.name));
    let variable = match channel.filter(|_| !is_joint) {
        Some(input) => Variable::Input(input),
        None => best_seen(series, coordinate, &law).0,
    };
    Some(View {
        coordinate,
        variable,
        missing: without,
        law: Some(law),
    })
}

/// The variable that explains most of a force, with the share of its variance. Of those that explain it
/// alike one of the force's own coordinate comes first.
fn best_seen<'a>(
    series: &'a Series,
    coordinate: &'a CoordinateSeries,
    force: &[f64],
) -> (Variable<'a>, f64) {
    let own = of_coordinate(coordinate).into_iter();
    let others = series
        .coordinates
        .iter()
        .filter(|c| c.name != coordinate.name);
    let inputs = (0..series.inputs.len()).map(Variable::Input);
    let all = own.chain(inputs).chain(others.flat_map(of_coordinate));
    let seen = all.map(|variable| (variable, explained(variable.values(series), force)));
    let best = seen.reduce(|best, next| if next.1 > best.1 + ALIKE { next } else { best });
    best.unwrap_or((Variable::Position(coordinate), 0.0))
}

/// Shares of a variance that are alike.
const ALIKE: f64 = 0.01;

fn of_coordinate(coordinate: &CoordinateSeries) -> [Variable<'_>; 3] {
    [
        Variable::Velocity(coordinate),
        Variable::Position(coordinate),
        Variable::Acceleration(coordinate),
    ]
}

/// Correlation ratio `η²`: share of the variance of `y` that lies between groups of
/// samples with like `x` (groups of one size).
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

const GROUPS: usize = 20;

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
        let view = unexplained(&series).unwrap();
        assert!(matches!(view.variable, Variable::Velocity(c) if c.name == "x"));
    }
}
