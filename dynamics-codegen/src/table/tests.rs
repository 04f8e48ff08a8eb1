use super::Spline;
use crate::graph::{Graph, SymbolId};

/// Value, slope and curvature of a spline of one argument.
fn at(spline: &Spline, x: f64) -> [f64; 3] {
    let mut graph = Graph::new();
    let symbol = graph.symbol("x");
    let variable = graph.var(symbol);
    let value = spline.express(&mut graph, &[variable]);
    let slope = graph.derivatives(&[value], symbol)[0];
    let curvature = graph.derivatives(&[slope], symbol)[0];
    let found = graph.evaluate(&[value, slope, curvature], &[x]);
    [found[0], found[1], found[2]]
}

fn near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
        "{found} {expected}"
    );
}

/// Four points by hand: curvatures solve `4m₁ + m₂ = 6·(−2)`, `m₁ + 4m₂ = 6·2`.
#[test]
fn a_spline_by_hand() {
    let spline = Spline::through(vec![vec![0.0, 1.0, 2.0, 3.0]], &[0.0, 1.0, 0.0, 1.0]);
    let (m1, m2) = (-4.0, 4.0);
    for (x, value) in [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 1.0)] {
        near(at(&spline, x)[0], value);
    }
    near(at(&spline, 1.0)[2], m1);
    near(at(&spline, 2.0)[2], m2);
    // Slope at the left end: rise less h m₁/6.
    near(at(&spline, 0.0)[1], 1.0 + 4.0 / 6.0);
    near(at(&spline, 1.0)[1], 1.0 + 4.0 / 6.0 + m1 / 2.0);
    near(at(&spline, 1.5)[0], 0.5 - (m1 + m2) / 16.0);
}

/// Beyond its ends it goes on straight, with the slope that it has there.
#[test]
fn beyond_the_ends_it_is_straight() {
    let spline = Spline::through(vec![vec![-1.0, 0.5, 1.0, 4.0]], &[2.0, -1.0, 0.3, 0.7]);
    for end in [-1.0, 4.0] {
        let [value, slope, curvature] = at(&spline, end);
        near(curvature, 0.0);
        for distance in [0.25, 3.0, 1e3] {
            let out = end + distance * end.signum();
            let [far, same, none] = at(&spline, out);
            near(same, slope);
            near(none, 0.0);
            assert!((far - value - slope * (out - end)).abs() < 1e-9);
        }
    }
}

/// At a point itself derivatives are those from either side: nothing is lost to a `min`.
#[test]
fn derivatives_are_continuous_at_the_points() {
    let points = vec![-2.0, -1.5, 0.0, 0.25, 3.0, 3.5];
    let spline = Spline::through(vec![points.clone()], &[1.0, -2.0, 0.5, 0.25, 4.0, 3.0]);
    for point in points {
        let here = at(&spline, point);
        for side in [-1e-9, 1e-9] {
            let beside = at(&spline, point + side);
            for (h, b) in here.iter().zip(beside) {
                assert!((h - b).abs() < 1e-6, "at {point}: {h} {b}");
            }
        }
    }
}

#[test]
fn two_points_are_a_line() {
    let spline = Spline::through(vec![vec![1.0, 3.0]], &[5.0, 9.0]);
    assert_eq!(at(&spline, 2.0), [7.0, 2.0, 0.0]);
    assert_eq!(at(&spline, -1.0), [1.0, 2.0, 0.0]);
}

/// What is a product of two splines on the grid is so everywhere.
#[test]
fn a_product_stays_one() {
    let (xs, ys) = (vec![0.0, 1.0, 2.5, 3.0], vec![-1.0, 0.0, 2.0]);
    let (f, g) = ([1.0, -1.0, 0.5, 2.0], [0.5, 2.0, -1.0]);
    let values: Vec<f64> = f.iter().flat_map(|a| g.map(|b| a * b)).collect();
    let spline = Spline::through(vec![xs.clone(), ys.clone()], &values);
    let one = Spline::through(vec![xs], &f);
    let other = Spline::through(vec![ys], &g);
    let mut graph = Graph::new();
    let symbols: [SymbolId; 2] = ["x", "y"].map(|name| graph.symbol(name));
    let variables = symbols.map(|symbol| graph.var(symbol));
    let value = spline.express(&mut graph, &variables);
    let first = graph.derivatives(&[value], symbols[0])[0];
    let mixed = graph.derivatives(&[first], symbols[1])[0];
    for (x, y) in [(0.3, -0.2), (1.0, 0.0), (2.7, 5.0), (-4.0, 1.1), (2.5, 2.0)] {
        let found = graph.evaluate(&[value, first, mixed], &[x, y]);
        let (a, b) = (at(&one, x), at(&other, y));
        near(found[0], a[0] * b[0]);
        near(found[1], a[1] * b[0]);
        near(found[2], a[1] * b[1]);
    }
}
