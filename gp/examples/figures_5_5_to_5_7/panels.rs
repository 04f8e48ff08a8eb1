//! The panels of the three figures, each with the numbers behind it.

use crate::chart::{Axis, BLACK_INK, BLUE_INK, GREEN_INK, GREY, Layer, Mark, ORANGE, Panel, layer};
use crate::fits::{
    OTHER, OTHER_PARTICLE, PARTICLE, SURFACE, System, UNICYCLE, fit, on_surface, plain, prior,
};
use dynamics::integrate::{DormandPrince, State};
use gp::{GpError, Inputs, Posterior, Prediction, Quantity, Result, sample_prior};
use std::f64::consts::PI;

const CONSTRAINED: Quantity = Quantity::Acceleration;
const UNCONSTRAINED: Quantity = Quantity::UnconstrainedAcceleration;

fn line(x: &[f64], y: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y).collect()
}

/// Entry `d` of a quantity with three rows per point.
fn entry(values: &[f64], d: usize) -> impl Iterator<Item = f64> {
    values.chunks(3).map(move |v| v[d])
}

fn band(x: &[f64], p: &Prediction, d: usize) -> Vec<(f64, f64, f64)> {
    let (low, high) = p.band95();
    x.iter()
        .zip(entry(&low, d).zip(entry(&high, d)))
        .map(|(x, (l, h))| (*x, l, h))
        .collect()
}

fn truth(system: &System, states: &[Vec<f64>], quantity: Quantity) -> Result<Vec<f64>> {
    let values: Result<Vec<_>> = states.iter().map(|x| system.truth(x, quantity)).collect();
    Ok(values?.concat())
}

fn grid(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| low + (high - low) * i as f64 / (count - 1) as f64)
        .collect()
}

/// Panels and the largest `|A a − b|` over all samples of GP², m/s².
pub fn samples(observations: usize) -> Result<(Vec<Panel>, f64)> {
    let angles = grid(-PI, PI, 121);
    let states: Vec<Vec<f64>> = angles
        .iter()
        .map(|a| vec![0.5 * a.cos(), 0.5 * a.sin(), *a, 0.0, 0.0, 0.0])
        .collect();
    let degrees: Vec<f64> = angles.iter().map(|a| a.to_degrees()).collect();
    let inputs = Inputs::from_rows(&states)?;
    let (x, y) = UNICYCLE.observe(observations, 3)?;
    let start = || prior(&UNICYCLE, 6, 0.04);
    let mut panels = Vec::new();
    let mut worst = 0.0f64;
    for structured in [true, false] {
        let (name, data, at) = if structured {
            let at = UNICYCLE.at(&states, CONSTRAINED)?;
            ("GP²", UNICYCLE.at(&x, CONSTRAINED)?, at)
        } else {
            ("SE-GP", plain(&x)?, plain(&states)?)
        };
        let posterior = fit(start()?, &data, &y, 1)?;
        let before = sample_prior(&start()?, &inputs, 12, 5)?.quantity(&at)?;
        let after = posterior.sample(&inputs, 12, 6)?.quantity(&at)?;
        for a in before.iter().chain(&after).filter(|_| structured) {
            for (x, a) in states.iter().zip(a.chunks(3)) {
                worst = worst.max(UNICYCLE.violation(x, a));
            }
        }
        for (when, draws) in [("prior", before), ("posterior", after)] {
            let limit = if when == "prior" { 0.9 } else { 0.3 };
            let mut layers: Vec<Layer> = draws
                .iter()
                .enumerate()
                .map(|(i, a)| {
                    let name = if i == 0 { "samples" } else { "" };
                    layer(name, BLUE_INK, Mark::Thin(line(&degrees, entry(a, 0))))
                })
                .collect();
            if when == "posterior" {
                let true_a = truth(&UNICYCLE, &states, CONSTRAINED)?;
                let curve = line(&degrees, entry(&true_a, 0));
                layers.push(layer("truth", BLACK_INK, Mark::Dashed(curve)));
            }
            panels.push(Panel {
                title: format!("{name}, {when}: 2-D unicycle at 0.5 m/s"),
                x: Axis::new("heading q3 / °").within(-180.0, 180.0),
                y: Axis::new("acceleration of q1 / (m/s²)").within(-limit, limit),
                layers,
            });
        }
    }
    Ok((panels, worst))
}

/// A particle at rest along the line `q2 = 0.5` on a surface.
fn along(q1: &[f64], surface: &[f64]) -> Vec<Vec<f64>> {
    q1.iter()
        .map(|q| {
            let mut x = vec![0.0; 9];
            (x[0], x[1]) = (*q, 0.5);
            on_surface(x, surface)
        })
        .collect()
}

/// The trained models of the particle.
pub struct Particle {
    pub structured: Posterior,
    pub plain: Posterior,
}

/// Train GP² and the SE-GP on the same observations.
pub fn particle(observations: usize) -> Result<Particle> {
    let (x, y) = PARTICLE.observe(observations, 11)?;
    Ok(Particle {
        structured: fit(
            prior(&PARTICLE, 9, 10.0)?,
            &PARTICLE.at(&x, CONSTRAINED)?,
            &y,
            2,
        )?,
        plain: fit(prior(&PARTICLE, 9, 10.0)?, &plain(&x)?, &y, 2)?,
    })
}

/// What figure 5.6a measures.
pub struct Reach {
    /// RMSE over `|q1| < 6`, data within ±2: GP², SE-GP, GP² on the other surface; m/s².
    pub rmse: [f64; 3],
    pub panels: Vec<Panel>,
}

fn rmse(p: &[f64], truth: &[f64]) -> f64 {
    let squares: f64 = p.iter().zip(truth).map(|(p, t)| (p - t).powi(2)).sum();
    (squares / truth.len() as f64).sqrt()
}

/// Extrapolation beyond the data, and transfer to a surface without data (thesis 5.25).
pub fn reach(models: &Particle) -> Result<Reach> {
    let q1 = grid(-6.0, 6.0, 241);
    let (here, there) = (along(&q1, &SURFACE), along(&q1, &OTHER));
    let own = models
        .structured
        .predict(&PARTICLE.at(&here, CONSTRAINED)?)?;
    let se = models.plain.predict(&plain(&here)?)?;
    let moved = models
        .structured
        .predict(&OTHER_PARTICLE.at(&there, CONSTRAINED)?)?;
    let (true_here, true_there) = (
        truth(&PARTICLE, &here, CONSTRAINED)?,
        truth(&OTHER_PARTICLE, &there, CONSTRAINED)?,
    );
    let panel = |title: &str, p: &Prediction, t: &[f64], color| Panel {
        title: title.into(),
        x: Axis::new("q1 / m (data within ±2)").within(-6.0, 6.0),
        y: Axis::new("acceleration of q1 / (m/s²)").within(-7.0, 7.0),
        layers: vec![
            layer("95 % band", color, Mark::Band(band(&q1, p, 0))),
            layer(
                "prediction",
                color,
                Mark::Line(line(&q1, entry(&p.mean, 0))),
            ),
            layer("truth", BLACK_INK, Mark::Dashed(line(&q1, entry(t, 0)))),
        ],
    };
    let panels = vec![
        panel("GP² on the surface of the data", &own, &true_here, BLUE_INK),
        panel("SE-GP on the surface of the data", &se, &true_here, ORANGE),
        panel(
            "GP² on another surface, same data",
            &moved,
            &true_there,
            GREEN_INK,
        ),
    ];
    Ok(Reach {
        rmse: [
            rmse(&own.mean, &true_here),
            rmse(&se.mean, &true_here),
            rmse(&moved.mean, &true_there),
        ],
        panels,
    })
}

/// A path of the particle: times, coordinates, distance to the surface.
pub struct Path {
    pub t: Vec<f64>,
    pub q: Vec<[f64; 3]>,
    pub gap: Vec<f64>,
}

fn path(a: impl Fn(&[f64]) -> Result<Vec<f64>>, seconds: f64) -> Result<Path> {
    let mut x = vec![0.0; 9];
    (x[0], x[1], x[4]) = (1.6, 1.2, -0.4);
    let x = on_surface(x, &SURFACE);
    let start = State::<f64, 3, 0> {
        q: [x[0], x[1], x[2]],
        v: [x[3], x[4], x[5]],
        z: [],
    };
    let input = |s: &State<f64, 3, 0>| [&s.q[..], &s.v[..], &[0.0; 3]].concat();
    let mut out = Path {
        t: Vec::new(),
        q: Vec::new(),
        gap: Vec::new(),
    };
    let rate = |_t: f64, s: &State<f64, 3, 0>| -> Result<State<f64, 3, 0>> {
        let a = a(&input(s))?;
        Ok(State {
            q: s.v,
            v: [a[0], a[1], a[2]],
            z: [],
        })
    };
    let solver = DormandPrince {
        relative: 1e-8,
        absolute: 1e-8,
        ..Default::default()
    };
    solver
        .sample(rate, 0.0, &start, seconds, 0.05, |t, s| {
            out.t.push(t);
            out.q.push(s.q);
            out.gap
                .push(crate::systems::surface_gap(&input(s), &SURFACE).abs());
        })
        .map_err(|e| GpError::Structure {
            theta: Vec::new(),
            message: format!("integration: {e}"),
        })?;
    Ok(out)
}

/// Paths of the truth, GP² and the SE-GP from the same state, no stabilisation.
pub fn paths(models: &Particle, seconds: f64) -> Result<[Path; 3]> {
    let structured = |x: &[f64]| {
        let rows = PARTICLE.rows(x, CONSTRAINED)?;
        models.structured.mean_at(x, &rows.h, &rows.mean)
    };
    let se = |x: &[f64]| models.plain.mean(&plain(&[x.to_vec()])?);
    Ok([
        path(|x| PARTICLE.truth(x, CONSTRAINED), seconds)?,
        path(structured, seconds)?,
        path(se, seconds)?,
    ])
}

/// Figure 5.6b.
pub fn path_panels(paths: &[Path; 3]) -> Vec<Panel> {
    let inks = [("truth", BLACK_INK), ("GP²", BLUE_INK), ("SE-GP", ORANGE)];
    let layers = |f: &dyn Fn(&Path) -> Vec<(f64, f64)>| -> Vec<Layer> {
        paths
            .iter()
            .zip(inks)
            .map(|(p, (name, ink))| {
                let mark = match name {
                    "truth" => Mark::Dashed(f(p)),
                    _ => Mark::Line(f(p)),
                };
                layer(name, ink, mark)
            })
            .collect()
    };
    let coordinate =
        |d: usize| layers(&|p| p.t.iter().zip(&p.q).map(|(t, q)| (*t, q[d])).collect());
    vec![
        Panel {
            title: "Path by Dormand–Prince".into(),
            x: Axis::new("time / s"),
            y: Axis::new("q1 / m").within(-2.5, 4.0),
            layers: coordinate(0),
        },
        Panel {
            title: "The same, vertical".into(),
            x: Axis::new("time / s"),
            y: Axis::new("q3 / m").within(-2.0, 1.0),
            layers: coordinate(2),
        },
        Panel {
            title: "Distance to the surface".into(),
            x: Axis::new("time / s"),
            y: Axis::new("|c(q)| / m").logarithmic().within(1e-12, 100.0),
            layers: layers(&|p| {
                let gap = p.gap.iter().map(|g| g.max(1e-12));
                p.t.iter().copied().zip(gap).collect()
            }),
        },
    ]
}

/// Figure 5.7, and the RMSE of the inferred unconstrained accelerations: particle, unicycle.
pub fn unconstrained(models: &Particle, observations: usize) -> Result<(Vec<Panel>, [f64; 2])> {
    let q1 = grid(-2.0, 2.0, 81);
    let rest = along(&q1, &SURFACE);
    let (x, y) = UNICYCLE.observe(observations, 3)?;
    let unicycle = fit(
        prior(&UNICYCLE, 6, 0.04)?,
        &UNICYCLE.at(&x, CONSTRAINED)?,
        &y,
        1,
    )?;
    let speed = grid(0.0, 1.0, 81);
    let rolling: Vec<Vec<f64>> = speed
        .iter()
        .map(|s| vec![s * 0.6, s * 0.8, 0.8f64.atan2(0.6), 0.0, 0.0, 0.0])
        .collect();
    let (first, rest_error) = inferred(
        "Particle at rest",
        (&PARTICLE, &models.structured),
        (&q1, &rest),
        Axis::new("q1 / m"),
        Axis::new("ā / (m/s²)").within(-12.0, 2.0),
    )?;
    let (second, rolling_error) = inferred(
        "Unicycle, heading 53°",
        (&UNICYCLE, &unicycle),
        (&speed, &rolling),
        Axis::new("speed / (m/s)"),
        Axis::new("ā / (m/s²; q3: rad/s²)").within(-0.5, 0.1),
    )?;
    Ok((vec![first, second], [rest_error, rolling_error]))
}

/// One panel of figure 5.7: states along an axis, and the RMSE there.
fn inferred(
    title: &str,
    (system, model): (&System, &Posterior),
    (axis, states): (&[f64], &[Vec<f64>]),
    x: Axis,
    y: Axis,
) -> Result<(Panel, f64)> {
    let p = model.predict(&system.at(states, UNCONSTRAINED)?)?;
    let t = truth(system, states, UNCONSTRAINED)?;
    let mut layers = Vec::new();
    for (d, ink) in [BLUE_INK, ORANGE, GREEN_INK].into_iter().enumerate() {
        let name = format!("ā{} | data, 95 %", d + 1);
        layers.push(layer("", ink, Mark::Band(band(axis, &p, d))));
        layers.push(layer(&name, ink, Mark::Line(line(axis, entry(&p.mean, d)))));
        let (name, ink) = match d {
            2 => ("truth", BLACK_INK),
            _ => ("", GREY),
        };
        layers.push(layer(name, ink, Mark::Dashed(line(axis, entry(&t, d)))));
    }
    let panel = Panel {
        title: format!("{title}: unconstrained acceleration"),
        x,
        y,
        layers,
    };
    Ok((panel, rmse(&p.mean, &t)))
}
