//! The tables that are printed.

use crate::driver::Precision;
use crate::kernels::SAMPLES;
use std::fmt::Write as _;

/// A function's times, nanoseconds per evaluation.
#[derive(Debug, Clone)]
pub struct Row {
    /// What it computes.
    pub name: &'static str,
    /// The ratio that is to be reached.
    pub goal: f64,
    /// CasADi's C.
    pub casadi: f64,
    /// Our C.
    pub c: f64,
    /// Our Rust.
    pub rust: f64,
}

impl Row {
    fn ratio(&self) -> f64 {
        self.rust / self.casadi
    }
}

/// What is compared.
pub fn heading() -> String {
    let lanes = std::any::type_name::<dynamics::batch::WideF64>();
    format!(
        "KUKA iiwa, 7 joints; nanoseconds per evaluation, the fastest of many rounds.\n\
         CasADi: C of CasADi 3.8.2 from Pinocchio's model, snapped, `cc -O3 -march=native`.\n\
         C and Rust: ours; Rust with `-C target-cpu=native`, lanes of {lanes}.\n\
         Rust: sines by lanes (feature `simd`). ∂ forward dynamics: ours gives a and ∂a/∂u too."
    )
}

/// Times at one state after another.
pub fn table(precision: Precision, rows: &[Row]) -> String {
    let mut out = String::new();
    let (title, note) = match precision {
        Precision::Double => ("f64", ""),
        Precision::Single => (
            "f32",
            " (CasADi's float computes sines in double; unsnapped, its products are subnormal)",
        ),
    };
    let _ = writeln!(
        out,
        "\n{title}, one state{note}\n{:<22}{:>9}{:>9}{:>9}{:>12}{:>14}{:>8}",
        "", "CasADi", "C", "Rust", "C/CasADi", "Rust/CasADi", "goal"
    );
    for row in rows {
        let met = match (precision, row.ratio() <= row.goal) {
            (Precision::Single, _) => "",
            (_, true) => "  met",
            (_, false) => "  missed",
        };
        let _ = writeln!(
            out,
            "{:<22}{:>9.1}{:>9.1}{:>9.1}{:>12.2}{:>14.2}{:>8.2}{met}",
            row.name,
            row.casadi,
            row.c,
            row.rust,
            row.c / row.casadi,
            row.ratio(),
            row.goal
        );
    }
    out
}

/// Mass matrix and bias force of many states, nanoseconds per state.
#[derive(Debug, Clone, Copy)]
pub struct Batched {
    /// CasADi's C, snapped.
    pub snapped: f64,
    /// CasADi's C as it comes.
    pub unsnapped: f64,
    /// Ours, in lanes, for each of [`SAMPLES`] per call.
    pub ours: [f64; SAMPLES.len()],
}

/// How many times as many states per second as CasADi's C as it comes are to be reached.
const TIMES: f64 = 10.0;

/// Rates and their ratios.
pub fn batched(precision: Precision, times: &Batched) -> String {
    let (title, goal) = match precision {
        Precision::Double => ("f64", 40.0),
        Precision::Single => ("f32", 80.0),
    };
    let met = |met: bool| if met { "met" } else { "missed" };
    let mut out = format!(
        "{title}, mass matrix and bias force of many states, million states per second\n\
         CasADi's C, one state after another: {:.1} as it comes, {:.1} snapped",
        1e3 / times.unsnapped,
        1e3 / times.snapped,
    );
    for (samples, ours) in SAMPLES.into_iter().zip(times.ours) {
        let (rate, times_as_many) = (1e3 / ours, times.unsnapped / ours);
        let _ = write!(
            out,
            "\nours, in lanes, {samples:>3} states per call {rate:>6.1} (goal {goal:.0}: {}), \
             {times_as_many:.1} times as many as it comes (goal {TIMES:.0}: {}), {:.1} as snapped",
            met(rate >= goal),
            met(times_as_many >= TIMES),
            times.snapped / ours,
        );
    }
    out
}

/// Which goals are missed.
pub fn verdict(rows: &[Row]) -> String {
    let missed: Vec<&str> = rows
        .iter()
        .filter(|r| r.ratio() > r.goal)
        .map(|r| r.name)
        .collect();
    if missed.is_empty() {
        "\nEvery goal for one state is met.".to_string()
    } else {
        format!("\nGoals missed for one state: {}.", missed.join(", "))
    }
}
