//! Figures 5.9 to 5.14 of the thesis.

use crate::Failure;
use crate::arm::{N, TRUE_END};
use crate::chart::{
    Axis, BLACK_INK, BLUE_INK, BROWN, GREEN_INK, GREY, Layer, Mark, ORANGE, PURPLE, Panel, RED_INK,
    TEAL, draw, layer,
};
use crate::inertia::Estimate;
use crate::models::{Fit, Kind};
use crate::motion::Motion;
use crate::record::{RATE, Sample};
use crate::study::{Data, NetworkScore, Score, analytical};
use gp::{Prediction, Quantity};
use plotters::style::RGBColor;
use std::path::Path;

/// Seconds that the figures over time show.
const WINDOW: f64 = 6.0;

fn ink(kind: Kind) -> RGBColor {
    match kind {
        Kind::Se => ORANGE,
        Kind::Icm => RED_INK,
        Kind::Lmc => PURPLE,
        Kind::AccelerationPrior => GREY,
        Kind::ForcePrior => GREEN_INK,
        Kind::ForcePriorMean => BLUE_INK,
        Kind::TipForceMean => TEAL,
    }
}

/// Consecutive samples of the test run.
pub fn window(data: &Data, seconds: f64) -> &[Sample] {
    let all = &data.test_run.samples;
    let count = ((seconds * RATE) as usize + 1).min(all.len());
    let first = (all.len() - count) / 3;
    &all[first..first + count]
}

fn over(samples: &[Sample], y: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    let start = samples[0].t;
    let each = samples.iter().enumerate();
    each.map(|(k, s)| (s.t - start, y(k))).collect()
}

fn strip(samples: &[Sample], p: &Prediction, rows: usize, row: usize) -> Vec<(f64, f64, f64)> {
    let (low, high) = p.band95();
    let start = samples[0].t;
    samples
        .iter()
        .enumerate()
        .map(|(k, s)| (s.t - start, low[rows * k + row], high[rows * k + row]))
        .collect()
}

/// Fig. 5.9: the tip over time.
pub fn task_space(folder: &Path, data: &Data) -> Result<(), Failure> {
    let tip = data
        .test_run
        .tip
        .iter()
        .take((4.0 * WINDOW * RATE) as usize);
    let tip: Vec<&(f64, [f64; 3])> = tip.collect();
    let rate = |d: usize| -> Vec<(f64, f64)> {
        let pairs = tip.windows(2);
        pairs
            .map(|w| (w[0].0, (w[1].1[d] - w[0].1[d]) * RATE))
            .collect()
    };
    let place = |d: usize| tip.iter().map(|(t, p)| (*t, p[d])).collect::<Vec<_>>();
    let both = |f: &dyn Fn(usize) -> Vec<(f64, f64)>| {
        vec![
            layer("x", BLUE_INK, Mark::Line(f(0))),
            layer("y", ORANGE, Mark::Line(f(1))),
        ]
    };
    let panels = [
        Panel {
            title: "Tip on the plane".into(),
            x: Axis::new("time / s"),
            y: Axis::new("position / m"),
            layers: both(&place),
        },
        Panel {
            title: "Its velocity: trapezoids".into(),
            x: Axis::new("time / s"),
            y: Axis::new("velocity / (m/s)"),
            layers: both(&rate),
        },
    ];
    draw(&folder.join("figure_5_9.svg"), 2, &panels)
}

/// Fig. 5.10: errors over the size of the training set.
pub fn data_efficiency(
    folder: &Path,
    scores: &[Score],
    networks: &[NetworkScore],
    analytical: f64,
) -> Result<(), Failure> {
    let curve = |kind: Kind, f: &dyn Fn(&Score) -> f64| -> Layer {
        let of_kind = scores.iter().filter(|s| s.kind == kind);
        let points = of_kind.map(|s| (s.size as f64, f(s))).collect();
        layer(kind.name(), ink(kind), Mark::Knots(points))
    };
    let sizes = || scores.iter().map(|s| s.size as f64);
    let (low, high) = (
        sizes().fold(f64::MAX, f64::min),
        sizes().fold(0.0, f64::max),
    );
    let axis = || {
        Axis::new("training points")
            .logarithmic()
            .within(0.9 * low, 1.1 * high)
    };
    let mut errors: Vec<Layer> = Kind::ALL.map(|k| curve(k, &|s| s.error)).into();
    let network = |f: &dyn Fn(&NetworkScore) -> f64| -> Layer {
        // The network of many points is no part of the curves.
        let shown = networks.iter().filter(|n| n.size as f64 <= high);
        let points = shown.map(|n| (n.size as f64, f(n))).collect();
        layer("network", BROWN, Mark::Knots(points))
    };
    errors.push(network(&|n| n.error));
    let mut constraints: Vec<Layer> = Kind::ALL.map(|k| curve(k, &|s| s.constraint)).into();
    constraints.push(network(&|n| n.constraint));
    let flat = vec![(0.9 * low, analytical), (1.1 * high, analytical)];
    errors.push(layer("analytical model", BLACK_INK, Mark::Dashed(flat)));
    let panels = [
        Panel {
            title: "Mean absolute error of the acceleration".into(),
            x: axis(),
            y: Axis::new("error / (rad/s²)")
                .logarithmic()
                .within(0.005, 1.0),
            layers: errors,
        },
        Panel {
            title: "Largest constraint error".into(),
            x: axis(),
            y: Axis::new("|A a − b| / (m/s²)")
                .logarithmic()
                .within(1e-17, 1e2),
            layers: constraints,
        },
    ];
    draw(&folder.join("figure_5_10.svg"), 2, &panels)
}

/// Fig. 5.11: acceleration of one joint over time, and errors.
pub fn accelerations(folder: &Path, data: &Data, fits: &[&Fit]) -> Result<(), Failure> {
    let joint = 5;
    let samples = window(data, WINDOW);
    let known = analytical(&data.arm, TRUE_END, samples)?;
    let truth = || over(samples, |k| samples[k].truth[joint]);
    let noisy = || over(samples, |k| samples[k].measured[joint]);
    let beside = |title: &str, name: &str, curve: &[f64]| Panel {
        title: title.into(),
        x: Axis::new("time / s"),
        y: Axis::new("acceleration of joint 6 / (rad/s²)").within(-5.0, 5.0),
        layers: vec![
            layer("measured", GREY, Mark::Thin(noisy())),
            layer(
                name,
                BLUE_INK,
                Mark::Line(over(samples, |k| curve[N * k + joint])),
            ),
            layer("truth", BLACK_INK, Mark::Dashed(truth())),
        ],
    };
    let mut top = vec![beside("Analytical model", "model", &known)];
    let mut bottom = vec![Panel {
        title: "Its error".into(),
        x: Axis::new("time / s"),
        y: Axis::new("error / (rad/s²)"),
        layers: vec![layer(
            "",
            BLUE_INK,
            Mark::Line(over(samples, |k| {
                known[N * k + joint] - samples[k].truth[joint]
            })),
        )],
    }];
    for fit in fits {
        let p = fit.predict(&data.arm, samples, Quantity::Acceleration)?;
        top.push(beside(fit.kind.name(), "mean", &p.mean));
        let zero = Prediction {
            mean: error_of(&p, samples),
            variance: p.variance.clone(),
        };
        bottom.push(Panel {
            title: "Its error, 95 % band".into(),
            x: Axis::new("time / s"),
            y: Axis::new("error / (rad/s²)").within(-0.15, 0.15),
            layers: vec![
                layer("", BLUE_INK, Mark::Band(strip(samples, &zero, N, joint))),
                layer(
                    "",
                    BLUE_INK,
                    Mark::Line(over(samples, |k| zero.mean[N * k + joint])),
                ),
                layer("", BLACK_INK, Mark::Dashed(over(samples, |_| 0.0))),
            ],
        });
    }
    let columns = top.len();
    top.extend(bottom);
    draw(&folder.join("figure_5_11.svg"), columns, &top)
}

/// Predicted minus true accelerations.
fn error_of(p: &Prediction, samples: &[Sample]) -> Vec<f64> {
    let truth = samples.iter().flat_map(|s| s.truth);
    p.mean.iter().zip(truth).map(|(p, t)| p - t).collect()
}

/// Fig. 5.12: estimates of the last link over the evaluations.
pub fn end_link(
    folder: &Path,
    analytical: &Estimate,
    structured: &Estimate,
) -> Result<(), Failure> {
    let names = ["mass / kg", "x / m", "y / m", "z / m"];
    let ranges = [(1.4, 3.2), (-0.11, 0.15), (-0.11, 0.15), (-0.11, 0.15)];
    let longest = analytical.tried.len().max(structured.tried.len()) as f64;
    let panels: Vec<Panel> = (0..4)
        .map(|i| {
            let curve = |e: &Estimate| -> Vec<(f64, f64)> {
                let each = e.tried.iter().enumerate();
                let mut out: Vec<_> = each.map(|(k, theta)| (k as f64, theta[i])).collect();
                out.push((longest, e.theta[i]));
                out
            };
            let (low, high) = ranges[i];
            let truth = vec![(0.0, TRUE_END[i]), (longest, TRUE_END[i])];
            Panel {
                title: match i {
                    0 => "Mass of the last link".into(),
                    _ => "Its centre of gravity".into(),
                },
                x: Axis::new("evaluations of the objective"),
                y: Axis::new(names[i]).within(low, high),
                layers: vec![
                    layer("without friction", GREY, Mark::Line(curve(analytical))),
                    layer("GP²", BLUE_INK, Mark::Line(curve(structured))),
                    layer("truth", BLACK_INK, Mark::Dashed(truth)),
                ],
            }
        })
        .collect();
    draw(&folder.join("figure_5_12.svg"), 2, &panels)
}

/// Fig. 5.13: multipliers over time.
pub fn multipliers(folder: &Path, data: &Data, fit: &Fit) -> Result<(), Failure> {
    let samples = window(data, WINDOW);
    let p = fit.predict(&data.arm, samples, Quantity::Multiplier)?;
    let error = Prediction {
        mean: (0..samples.len())
            .map(|k| p.mean[k] - samples[k].lambda)
            .collect(),
        variance: p.variance.clone(),
    };
    let panels = [
        Panel {
            title: "Force of the plane on the tip".into(),
            x: Axis::new("time / s"),
            y: Axis::new("λ / N"),
            layers: vec![
                layer("95 % band", BLUE_INK, Mark::Band(strip(samples, &p, 1, 0))),
                layer(
                    "mean | accelerations",
                    BLUE_INK,
                    Mark::Line(over(samples, |k| p.mean[k])),
                ),
                layer(
                    "truth",
                    BLACK_INK,
                    Mark::Dashed(over(samples, |k| samples[k].lambda)),
                ),
            ],
        },
        Panel {
            title: "Error of the mean, 95 % band".into(),
            x: Axis::new("time / s"),
            y: Axis::new("error of λ / N"),
            layers: vec![
                layer("", BLUE_INK, Mark::Band(strip(samples, &error, 1, 0))),
                layer("", BLUE_INK, Mark::Line(over(samples, |k| error.mean[k]))),
                layer("", BLACK_INK, Mark::Dashed(over(samples, |_| 0.0))),
            ],
        },
    ];
    draw(&folder.join("figure_5_13.svg"), 2, &panels)
}

/// Fig. 5.14: motions over seconds.
pub fn long_term(folder: &Path, motions: &[Motion]) -> Result<(), Failure> {
    let inks = [BLACK_INK, ORANGE, GREY, BLUE_INK];
    let layers = |f: &dyn Fn(&Motion, usize) -> f64| -> Vec<Layer> {
        let each = motions.iter().zip(inks).enumerate();
        each.map(|(i, (m, ink))| {
            let points = (0..m.t.len()).map(|k| (m.t[k], f(m, k))).collect();
            let mark = if i == 0 {
                Mark::Dashed(points)
            } else {
                Mark::Line(points)
            };
            layer(m.name, ink, mark)
        })
        .collect()
    };
    let panels = [
        Panel {
            title: "Joint 4 under recorded torques".into(),
            x: Axis::new("time / s"),
            y: Axis::new("angle of joint 4 / rad"),
            layers: layers(&|m, k| m.q[k][3]),
        },
        Panel {
            title: "Tip above the plane".into(),
            x: Axis::new("time / s"),
            y: Axis::new("|c(q)| / m").logarithmic().within(1e-12, 1.0),
            layers: layers(&|m, k| m.height[k].abs().max(1e-12)),
        },
    ];
    draw(&folder.join("figure_5_14.svg"), 2, &panels)
}
