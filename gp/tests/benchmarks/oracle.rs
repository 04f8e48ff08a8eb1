//! Every number of the 60-digit reference, to 1e-8 relative.

use crate::systems::{self, State};
use gp::{
    Functionals, GaussPoint, Kernel, LatentPrior, Layout, Model, Posterior, Quantity, Tangent,
    Workspace, evidence,
};
use serde_json::Value;

const TOLERANCE: f64 = 1e-8;

fn numbers(v: &Value) -> Vec<f64> {
    match v {
        Value::Array(a) => a.iter().flat_map(numbers).collect(),
        Value::Number(n) => vec![n.as_f64().unwrap()],
        other => panic!("not a number: {other}"),
    }
}

fn rows(v: &Value) -> Vec<Vec<f64>> {
    v.as_array().unwrap().iter().map(numbers).collect()
}

/// Largest difference relative to the largest reference entry.
fn difference(got: &[f64], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    let scale = want.iter().fold(0.0f64, |m, w| m.max(w.abs())).max(1e-12);
    got.iter()
        .zip(want)
        .map(|(g, w)| (g - w).abs())
        .fold(0.0, f64::max)
        / scale
}

type System = fn(&[f64], &[f64]) -> State;

struct Case<'a> {
    system: System,
    /// The system under the constraint of the transfer experiment.
    other: System,
    reference: &'a Value,
    known: bool,
    layout: Layout,
}

impl Case<'_> {
    fn state(&self, x: &[f64], p: &[f64]) -> State {
        let s = (self.system)(x, p);
        if self.known { s } else { s.without_known() }
    }

    fn functionals(&self, x: &[Vec<f64>], p: &[f64], quantity: Quantity) -> Functionals {
        let mut out = Functionals::new(
            x[0].len(),
            self.layout.n_latent(self.state(&x[0], p).known.len()),
        );
        for x in x {
            let s = self.state(x, p);
            let r = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known)
                .unwrap()
                .rows(quantity, self.layout)
                .unwrap();
            out.push(x, &r.h, &r.mean).unwrap();
        }
        out
    }

    fn tangents(&self, x: &[Vec<f64>], p: &[f64]) -> Vec<Tangent> {
        let mut out = vec![Tangent::default(); p.len()];
        for x in x {
            let s = self.state(x, p);
            let point = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known).unwrap();
            for (out, d) in out.iter_mut().zip(&s.tangents) {
                let t = point
                    .tangent(d, Quantity::Acceleration, self.layout)
                    .unwrap();
                out.rows.extend(t.rows);
                out.mean.extend(t.mean);
            }
        }
        out
    }

    fn model(&self) -> Model {
        let hyper = &self.reference["hyper"];
        let kernels = rows(&hyper["ell"])
            .iter()
            .zip(numbers(&hyper["sf2"]))
            .map(|(l, s)| Kernel::squared_exponential(l, s))
            .collect();
        Model::new(LatentPrior::independent(kernels), &numbers(&hyper["sn2"])).unwrap()
    }

    /// Our order: per kernel `ln l, ln σ²`; the file's: all `ln l`, then all `ln σ²`.
    fn gradient(&self, model: &Model, e: &gp::Evidence) -> Vec<f64> {
        let (n, d) = (
            model.prior.n_latent(),
            numbers(&self.reference["hyper"]["ell"]).len() / model.prior.n_latent(),
        );
        let mut out: Vec<f64> = (0..n)
            .flat_map(|i| e.gradient[i * (d + 1)..i * (d + 1) + d].to_vec())
            .collect();
        out.extend((0..n).map(|i| e.gradient[i * (d + 1) + d]));
        out.extend(&e.gradient[n * (d + 1)..]);
        out.extend(&e.theta);
        out
    }
}

fn check(name: &str, got: &[f64], want: &Value, worst: &mut f64) {
    let d = difference(got, &numbers(want));
    assert!(d < TOLERANCE, "{name}: relative difference {d:e}");
    *worst = worst.max(d);
}

fn run(case: &Case, want: &Value, name: &str) -> f64 {
    let r = case.reference;
    let (p, x) = (numbers(&r["p"]), rows(&r["X_train"]));
    let y: Vec<f64> = rows(&r["Y_train"]).concat();
    let model = case.model();
    let data = case.functionals(&x, &p, Quantity::Acceleration);
    let mut worst = 0.0;
    let mut work = Workspace::default();
    let full = evidence(&model, &data, &y, &case.tangents(&x, &p), &mut work).unwrap();
    let half = evidence(&model, &data, &y, &[], &mut work).unwrap();
    check(
        &format!("{name} evidence"),
        &[full.nll],
        &want["nll"],
        &mut worst,
    );
    check(
        &format!("{name} gradient"),
        &case.gradient(&model, &full),
        &want["nll_grad"],
        &mut worst,
    );
    let d = difference(&half.gradient, &full.gradient);
    assert!(
        d < TOLERANCE,
        "{name}: the two gradient routes differ by {d:e}"
    );
    let posterior = Posterior::new(&model, &data, &y).unwrap();
    assert_eq!(posterior.jitter(), 0.0);
    let test = rows(&r["X_test"]);
    for (key, quantity) in [
        ("qdd", Quantity::Acceleration),
        ("lambda", Quantity::Multiplier),
        ("abar", Quantity::UnconstrainedAcceleration),
        ("Qbar", Quantity::TotalForce),
        ("QI", Quantity::ConstraintForce),
    ] {
        let at = case.functionals(&test, &p, quantity);
        compare(
            &posterior,
            &at,
            &want[key],
            &format!("{name} {key}"),
            &mut worst,
        );
    }
    let moved = Case {
        system: case.other,
        ..*case
    };
    let at = moved.functionals(
        &rows(&r["X_transfer"]),
        &numbers(&r["p_transfer"]),
        Quantity::Acceleration,
    );
    compare(
        &posterior,
        &at,
        &want["transfer_qdd"],
        &format!("{name} transfer"),
        &mut worst,
    );
    baumgarte(case, &posterior, want, name, &mut worst);
    worst
}

fn compare(posterior: &Posterior, at: &Functionals, want: &Value, name: &str, worst: &mut f64) {
    let prediction = posterior.predict(at).unwrap();
    let covariance = posterior.covariance(at).unwrap();
    let n = at.n_rows();
    let flat: Vec<f64> = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .map(|(i, j)| covariance[(i, j)])
        .collect();
    check(
        &format!("{name} mean"),
        &prediction.mean,
        &want["mean"],
        worst,
    );
    check(&format!("{name} covariance"), &flat, &want["cov"], worst);
    let diagonal: Vec<f64> = (0..n).map(|i| covariance[(i, i)]).collect();
    assert!(
        difference(&prediction.variance, &diagonal) < 1e-9,
        "{name}: variance and covariance disagree"
    );
}

/// `b̃` replaces `b` in the mean of states off the constraint.
fn baumgarte(case: &Case, posterior: &Posterior, want: &Value, name: &str, worst: &mut f64) {
    let p = numbers(&case.reference["p"]);
    let x = rows(&case.reference["X_off"]);
    let b_tilde = rows(&want["baumgarte"]["b_tilde"]);
    let mut at = Functionals::new(x[0].len(), posterior.model().prior.n_latent());
    for (x, b) in x.iter().zip(&b_tilde) {
        let s = case.state(x, &p);
        let point = GaussPoint::new(&s.mass, &s.a, b, &s.known).unwrap();
        let r = point.rows(Quantity::Acceleration, case.layout).unwrap();
        at.push(x, &r.h, &r.mean).unwrap();
    }
    let mean = posterior.mean(&at).unwrap();
    check(
        &format!("{name} Baumgarte"),
        &mean,
        &want["baumgarte"]["mean"],
        worst,
    );
}

#[test]
fn every_number_of_the_reference() {
    let text = include_str!("../data/gp2.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let systems: [(&str, System, System); 3] = [
        ("surface", systems::surface, systems::surface),
        ("unicycle", systems::unicycle, systems::skewed_unicycle),
        ("duffing", systems::duffing, systems::duffing),
    ];
    for (system, f, other) in systems {
        for (model, layout, known) in [
            ("force_zero", Layout::Force, false),
            ("force_QK", Layout::Force, true),
            ("accel_zero", Layout::Acceleration, false),
            ("accel_QK", Layout::Acceleration, true),
        ] {
            let reference = &file["systems"][system];
            let case = Case {
                system: f,
                other,
                reference,
                known,
                layout,
            };
            let worst = run(
                &case,
                &reference["models"][model],
                &format!("{system} {model}"),
            );
            println!("{system:>9} {model:<11} largest relative difference {worst:.1e}");
        }
    }
}
