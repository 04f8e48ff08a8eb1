//! Figures 5.5 to 5.7 of the thesis.
//!
//! `cargo run --release -p eqmotion-gp --example figures_5_5_to_5_7 -- [folder]` writes SVG files
//! into the folder (`target/figures` when none is given) and prints what they show:
//!
//! - `figure_5_5.svg`: samples of GP² and of an SE-GP before and after 60
//!   observations of the unicycle; those of GP² obey the constraint;
//! - `figure_5_6a.svg`: the particle beyond its data, and on a surface without data;
//! - `figure_5_6b.svg`: its path over time, without stabilisation;
//! - `figure_5_7.svg`: the unconstrained acceleration, inferred from constrained ones.
//!
//! All models have a zero mean and know `M`, `A`, `b`, as in the thesis.

#[path = "../shared/chart.rs"]
mod chart;
mod fits;
mod panels;
#[path = "../../tests/benchmarks/systems.rs"]
mod systems;
#[cfg(test)]
mod tests;

fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let folder = chart::folder()?;
    let (figure, worst) = panels::samples(60)?;
    chart::draw(&folder.join("figure_5_5.svg"), 2, &figure)?;
    println!("5.5  largest |A a - b| over all samples of GP²: {worst:.1e} m/s²");

    let models = panels::particle(200)?;
    let reach = panels::reach(&models)?;
    chart::draw(&folder.join("figure_5_6a.svg"), 3, &reach.panels)?;
    let [own, se, moved] = reach.rmse;
    println!(
        "5.6a RMSE for |q1| < 6 m, data within 2 m: GP² {own:.2}, SE-GP {se:.2}; GP² on the other surface {moved:.2} m/s²"
    );

    let paths = panels::paths(&models, 10.0)?;
    chart::draw(
        &folder.join("figure_5_6b.svg"),
        3,
        &panels::path_panels(&paths),
    )?;
    let gaps: Vec<String> = paths
        .iter()
        .map(|p| format!("{:.1e}", p.gap.iter().fold(0.0f64, |m, g| m.max(*g))))
        .collect();
    println!(
        "5.6b largest distance to the surface in 10 s: truth {}, GP² {}, SE-GP {} m",
        gaps[0], gaps[1], gaps[2]
    );

    let (figure, [particle, unicycle]) = panels::unconstrained(&models, 60)?;
    chart::draw(&folder.join("figure_5_7.svg"), 2, &figure)?;
    println!(
        "5.7  RMSE of the unconstrained acceleration: particle {particle:.3}, unicycle {unicycle:.3} m/s²"
    );
    println!("figures in {}", folder.display());
    Ok(())
}
