//! The robot-arm study of thesis 5.3: iiwa with its tool tip sliding on a plane.
//!
//! `cargo run --release -p eqmotion-gp --example robot_arm -- [folder] [--quick] [--seed=N]`
//! simulates two runs (seeds `N`, 21 unless given, and `N + 1`), trains seven models and
//! a network on ever more points, prints and draws Figs. 5.9 to 5.14
//! into the folder (`target/figures` when none is given), and fails when what must
//! hold does not ([`study::faults`]). `--quick` does the same on a tenth of the data.
//!
//! Both runs follow trapezoidal trajectories between random points of the plane, by
//! inverse dynamics in task space with a posture in its null space, 240 samples per
//! second. Sensors show angles (noise 5e-6 rad) and torques; both pass the same
//! low-pass filter, velocity and acceleration come from differences, and the
//! acceleration gets noise of 0.1 rad/s². Training points are the farthest of one
//! run; the states held out are farthest points of the other run, with another
//! seed, and a second set of its states at equal distances in time. Errors are
//! against the noise-free truth at these states.

mod arm;
#[path = "../shared/chart.rs"]
mod chart;
mod control;
mod figures;
mod inertia;
mod models;
mod motion;
mod network;
mod record;
mod study;
#[cfg(test)]
mod tests;
mod training;

use models::{Fit, Kind};
use study::{Data, Plan, Score};
use training::Effort;

/// Length of the predicted motions, s. The arm falls away from its posture under
/// recorded torques, and any error grows with it.
const SECONDS: f64 = 0.8;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn plan(quick: bool, seeds: (u64, u64)) -> Plan {
    if quick {
        return Plan {
            train: (20, seeds.0),
            test: (10, seeds.1),
            sizes: vec![25, 50, 100],
            held_out: 200,
            network: (1000, 1000),
            link: 100,
            effort: Effort {
                iterations: 60,
                further: 20,
                anew: 300,
            },
        };
    }
    Plan {
        train: (300, seeds.0),
        test: (100, seeds.1),
        sizes: vec![50, 100, 200, 300, 500, 1000],
        held_out: 1000,
        network: (10_000, network::ITERATIONS),
        link: 300,
        effort: Effort {
            iterations: 60,
            further: 20,
            anew: 300,
        },
    }
}

fn print(score: &Score, seconds: f64) {
    let joints: Vec<String> = score.joints.iter().map(|j| format!("{j:.3}")).collect();
    println!(
        "{:>5}  {:<24} {:.4}  [{}]  {:.4}  {:.1e}  ({seconds:.0} s)",
        score.size,
        score.kind.name(),
        score.error,
        joints.join(" "),
        score.even,
        score.constraint
    );
}

/// Fig. 5.12 in words; the estimates.
fn inertia(data: &Data, plan: &Plan, folder: &std::path::Path) -> Result<(), Failure> {
    let count = plan.link.min(data.train.len());
    let samples = &data.train[..count];
    let estimate =
        |structured| inertia::estimate(&data.arm, &data.scaling, samples, plan.effort, structured);
    let (plain, structured) = rayon::join(|| estimate(false), || estimate(true));
    let (plain, structured) = (plain?, structured?);
    println!("last link from {count} points: mass / kg, centre of gravity / m; error / (rad/s²)");
    let show = |name: &str, t: [f64; 4], error: f64| {
        println!(
            "  {name:<18} {:.3}  [{:7.4} {:7.4} {:7.4}]  {error:.4}",
            t[0], t[1], t[2], t[3]
        );
    };
    let error = |theta| -> Result<f64, Failure> {
        let a = study::analytical(&data.arm, theta, &data.test)?;
        Ok(study::mean(&study::errors(&a, &data.test)))
    };
    show("truth", arm::TRUE_END, error(arm::TRUE_END)?);
    show("start", inertia::START, error(inertia::START)?);
    show("without friction", plain.theta, error(plain.theta)?);
    if let Some(fit) = &structured.fit {
        let a = fit.mean(&data.arm.known(structured.theta), &data.test)?;
        let e = study::mean(&study::errors(&a, &data.test));
        show("GP²", structured.theta, e);
    }
    figures::end_link(folder, &plain, &structured)
}

fn motion(data: &Data, se: &Fit, ours: &Fit, folder: &std::path::Path) -> Result<(), Failure> {
    let samples = figures::window(data, SECONDS);
    let motions = motion::motions(&data.arm, samples, se, ours, 31)?;
    let end = |m: &motion::Motion| m.tip[m.tip.len() - 1];
    let truth = end(&motions[0]);
    println!(
        "after {:.1} s of symplectic Euler, {} s steps:",
        SECONDS,
        motion::STEP
    );
    for m in &motions[1..] {
        let tip = end(m);
        let away: f64 = tip.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
        println!(
            "  {:<16} tip {:.1} mm from the true one, {:+.4} mm above the plane",
            m.name,
            1e3 * away.sqrt(),
            1e3 * m.height[m.height.len() - 1]
        );
    }
    figures::long_term(folder, &motions)
}

fn main() -> Result<(), Failure> {
    let clock = std::time::Instant::now();
    let quick = std::env::args().any(|a| a == "--quick");
    let named = std::env::args().find_map(|a| a.strip_prefix("--seed=").map(str::to_owned));
    let seed: u64 = named.map_or(Ok(21), |seed| seed.parse())?;
    let (plan, folder) = (plan(quick, (seed, seed + 1)), chart::folder()?);
    let data = study::data(&plan)?;
    println!(
        "train: seed {}, {} segments, {} samples; test: seed {}, {} segments, {} of {} samples; tip within {:.0e} m of the plane",
        plan.train.1,
        plan.train.0,
        data.recorded,
        plan.test.1,
        plan.test.0,
        data.test.len(),
        data.test_run.samples.len(),
        data.violation
    );
    let known = study::analytical(&data.arm, arm::TRUE_END, &data.test)?;
    let known = study::mean(&study::errors(&known, &data.test));
    println!(
        "noise of the accelerations: {:.4} rad/s² from encoders and differences, {} rad/s² added",
        study::sensor_noise(&data.train),
        record::NOISE
    );
    println!(
        "mean absolute error at farthest points / (rad/s²) [by joint], at equal distances in time, and largest |A a - b| / (m/s²)"
    );
    println!("       {:<24} {known:.4}", "analytical model");
    let told = |s: &Score| print(s, clock.elapsed().as_secs_f64());
    let (scores, fits) = study::curves(&data, &plan, &told)?;
    let networks = study::networks(&data, &plan)?;
    for n in &networks {
        println!(
            "{:>5}  {:<24} {:.4}  in time {:.4}  {:.1e}",
            n.size, "network", n.error, n.even, n.constraint
        );
    }
    let of = |kind: Kind| {
        fits.iter()
            .find(|f| f.kind == kind)
            .ok_or("a model is missing")
    };
    let (se, ours) = (of(Kind::Se)?, of(Kind::ForcePriorMean)?);
    let at_tip = of(Kind::TipForceMean)?;
    let multipliers = [
        study::multipliers(&data, ours)?,
        study::multipliers(&data, at_tip)?,
    ];
    for m in &multipliers {
        println!(
            "λ at held-out states, {}: inside the 95 % band {:.1} %; mean absolute error {:.3} N, half width {:.3} N, standard deviation of the true λ {:.2} N",
            m.kind.name(),
            100.0 * m.coverage,
            m.error,
            m.half_width,
            m.spread
        );
    }
    inertia(&data, &plan, &folder)?;
    motion(&data, se, ours, &folder)?;
    figures::task_space(&folder, &data)?;
    figures::data_efficiency(&folder, &scores, &networks, known)?;
    figures::accelerations(&folder, &data, &[se, ours])?;
    figures::multipliers(&folder, &data, ours)?;
    println!(
        "figures in {}; {:.0} s in all",
        folder.display(),
        clock.elapsed().as_secs_f64()
    );
    let faults = study::faults(&scores, &networks, &multipliers, !quick);
    if faults.is_empty() {
        println!("all that must hold does");
        return Ok(());
    }
    Err(faults.join("\n").into())
}
