//! The tilt estimator with and without the pivot's acceleration (Fig. 6.11), term by term, and beside
//! the alternative that the text names.

use super::pirouette;
use super::record::smoother_errors;
use super::replay::{Bench, Met, low_passed, replayed};
use super::study::{Chart, Finding, Motion, Study, StudyError, Table, charts};
use super::terms;
use crate::robot::{self, WHEEL, Wheelbot, X};
use crate::sensing::Sensing;
use crate::trial::{Push, Row, Trial, calm};
use wheelbot_firmware::pivot::{Term, Terms};
use wheelbot_firmware::{Accelerometers, Gains, INTERVAL, Settings};

/// Length of the motions of Fig. 6.11, s.
const SECONDS: f64 = 8.0;
/// The hand that moves the robot: m/s² and Hz.
const HAND: (f64, f64) = (2.0, 0.5);
/// At most, error with the pivot's acceleration over that without.
const SHARE: f64 = 1.0 / 3.0;

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let mut sensing = Sensing::new(seed)?;
    let bench = Bench::new(&calm(gains, &mut sensing)?);
    let held = held(&mut sensing);
    let pushed = pushed(gains, &mut sensing)?;
    let turning = pirouette::run(gains, &mut sensing)?.rows;
    let met = [held, Met::in_run(&pushed), Met::in_run(&turning)];
    let [left, right, _] = &met;
    let mut findings = vec![
        compared(
            "Held upright and moved by hand (Fig. 6.11, left)",
            &bench,
            left,
        ),
        compared(
            "Pushed back while balancing (Fig. 6.11, right)",
            &bench,
            right,
        ),
    ];
    findings.push(significance(&turning));
    let calibrated = sensing.calibrated();
    let smoothed = [&pushed, &turning].map(|rows| {
        let plant = Wheelbot::nominal();
        smoother_errors(&plant, rows, &mut calibrated.clone())
    });
    let [on_push, on_pirouette] = smoothed;
    let smoothed = [on_push?, on_pirouette?];
    let mut curves = pitch_by_accelerometers(&pushed, right);
    curves.extend(charts(&crate::trial::Outcome {
        rows: pushed.clone(),
        fell: false,
    }));
    Ok(Study {
        title: "The tilt estimator".into(),
        about: vec![
            "Errors are those of Fig. 6.11: of the tilt from the accelerometers behind a low-pass of \
             0.32 Hz, against the true tilt, less the bias from ten seconds of balancing."
                .into(),
            "The smoother is the reference: it knows a whole run, its model and its torques, and has instruments that were \
             calibrated on a bench. What pushes the robot it does not know."
                .into(),
            "The view and the curves show the push.".into(),
        ],
        findings,
        tables: vec![
            ways(&bench, &met, smoothed),
            terms::table("Terms of [6.17] on the pirouette", &bench, &turning),
            terms::table("Terms of [6.17] on the push", &bench, &pushed),
        ],
        charts: curves,
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion::of(&pushed),
    })
}

/// Upright, held and rolled to and fro: `ẍ = a sin ωt`.
fn held(sensing: &mut Sensing) -> Vec<Met> {
    let plant = Wheelbot::nominal();
    let radius = plant.parameters.r_w;
    let (size, omega) = (HAND.0, std::f64::consts::TAU * HAND.1);
    let at = |tick: usize| {
        let t = tick as f64 * INTERVAL;
        let (sin, cos) = (omega * t).sin_cos();
        let way = size / omega * (t - sin / omega);
        let (speed, acceleration) = (size / omega * (1.0 - cos), size * sin);
        let mut state = robot::leaning(0.0, 0.0);
        let mut rates = [0.0; 7];
        for (place, per) in [(X, 1.0), (WHEEL, 1.0 / radius)] {
            state.q[place] = per * way;
            state.v[place] = per * speed;
            rates[place] = per * acceleration;
        }
        Met {
            tilt: [0.0; 2],
            readings: sensing.read(&robot::shown_at(&plant, &state, rates)),
        }
    };
    (0..(SECONDS / INTERVAL) as usize).map(at).collect()
}

/// Balancing and pushed back, so that pitch turns negative.
fn pushed(gains: Gains<f64>, sensing: &mut Sensing) -> Result<Vec<Row>, StudyError> {
    let mut trial = Trial::new(SECONDS, gains);
    trial.pushes = vec![Push {
        at: 2.0,
        seconds: 0.1,
        force: [-2.0, 0.0],
    }];
    Ok(trial.run(sensing)?.rows)
}

fn settings(terms: Terms, accelerometers: Accelerometers) -> Settings<f32> {
    Settings {
        terms,
        accelerometers,
        ..Settings::published()
    }
}

fn compared(what: &str, bench: &Bench, motion: &[Met]) -> Finding {
    let [without, with] = [Terms::NONE, Terms::PUBLISHED].map(|terms| {
        let settings = settings(terms, Accelerometers::LeastSquares);
        bench.errors(settings, motion).felt[1]
    });
    Finding::new(
        &format!("{what}: pitch error with and without the pivot's acceleration"),
        "at most a third",
        format!(
            "{with:.2}° and {without:.2}°, {:.0} %",
            100.0 * with / without
        ),
        with <= SHARE * without,
    )
}

/// The text: only the term with `q̈₄` contributes significantly.
fn significance(rows: &[Row]) -> Finding {
    let size = |term| crate::trial::rms(terms::sizes(term, rows).into_iter());
    let others = Term::ALL.into_iter().filter(|term| *term != Term::Wheel);
    let (largest, next) =
        others
            .map(|term| (term, size(term)))
            .fold(
                (Term::Pitch, 0.0),
                |most, one| if one.1 > most.1 { one } else { most },
            );
    let wheel = size(Term::Wheel);
    Finding::new(
        "Pirouette: size of the wheel's term, and the largest other",
        "only q̈₄ contributes significantly",
        format!("{wheel:.2} m/s²; {next:.2} m/s², {}", largest.equation()),
        wheel > 3.0 * next,
    )
}

/// Every way to estimate on every motion, and the smoother on the last two of them.
fn ways(bench: &Bench, motions: &[Vec<Met>; 3], smoothed: [[f64; 2]; 2]) -> Table {
    use Accelerometers::{LeastSquares, Sphere};
    let ways = [
        ("no pivot's acceleration", Terms::NONE, LeastSquares),
        ("as the robot: q̈₄ᴱ alone", Terms::PUBLISHED, LeastSquares),
        (
            "q̈₄ with the body's share",
            Terms::PUBLISHED.with(Term::Pitch),
            LeastSquares,
        ),
        ("all terms", Terms::ALL, LeastSquares),
        ("gravity on its sphere, q̈₄ᴱ alone", Terms::PUBLISHED, Sphere),
        ("gravity on its sphere, all terms", Terms::ALL, Sphere),
    ];
    let line = |(name, terms, accelerometers): (&str, Terms, Accelerometers)| {
        let mut line = vec![name.to_string()];
        for motion in motions {
            let errors = bench.errors(settings(terms, accelerometers), motion);
            for [roll, pitch] in [errors.felt, errors.fused] {
                line.push(format!("{roll:.2}, {pitch:.2}"));
            }
        }
        line
    };
    let mut reference = vec!["Kalman smoother through the model".to_string()];
    reference.extend(["–", "–"].map(String::from));
    for [roll, pitch] in smoothed {
        reference.extend(["–".into(), format!("{roll:.3}, {pitch:.3}")]);
    }
    let header = [
        "",
        "held: accelerometers",
        "held: fused",
        "push: accelerometers",
        "push: fused",
        "pirouette: accelerometers",
        "pirouette: fused",
    ];
    Table {
        title: "Error of roll, pitch by estimator and motion, °".into(),
        header: header.map(String::from).to_vec(),
        rows: ways.map(line).into_iter().chain([reference]).collect(),
    }
}

/// Fig. 6.11: above the pivot's acceleration, below the pitch.
fn pitch_by_accelerometers(rows: &[Row], motion: &[Met]) -> Vec<Chart> {
    let felt = |terms| {
        let settings = settings(terms, Accelerometers::LeastSquares);
        let tilts = replayed(settings, motion);
        let felt = tilts
            .iter()
            .map(|tilt| f64::from(tilt.felt[1]).to_degrees());
        low_passed(felt)
    };
    let truth = low_passed(motion.iter().map(|met| met.tilt[1].to_degrees()));
    vec![
        Chart::of(
            rows,
            "acceleration of the wheel ahead [m/s²]",
            &[
                ("estimated", &|row| f64::from(row.tilt.pivot[0])),
                ("true", &|row| super::study::pivot(row)[0]),
            ],
        ),
        Chart {
            title: "pitch behind the low-pass [°]".into(),
            curves: vec![
                ("true".into(), truth),
                (
                    "with the pivot's acceleration".into(),
                    felt(Terms::PUBLISHED),
                ),
                ("without".into(), felt(Terms::NONE)),
            ],
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pivot_acceleration_takes_two_thirds_of_the_error() {
        for seed in [1, 2, 3] {
            let mut sensing = Sensing::new(seed).unwrap();
            let bench = Bench::new(&calm(Gains::PUBLISHED, &mut sensing).unwrap());
            let left = held(&mut sensing);
            assert_eq!(
                compared("left", &bench, &left).holds,
                Some(true),
                "seed {seed}"
            );
            let right = Met::in_run(&pushed(Gains::PUBLISHED, &mut sensing).unwrap());
            assert_eq!(
                compared("right", &bench, &right).holds,
                Some(true),
                "seed {seed}"
            );
        }
    }
}
