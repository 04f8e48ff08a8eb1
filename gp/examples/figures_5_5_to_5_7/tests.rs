//! What figures 5.5 to 5.7 show, from fewer observations, and the files themselves.

use crate::{chart, panels};

/// Draw into a folder of its own and read back.
fn drawn(name: &str, columns: usize, panels: &[chart::Panel]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    chart::draw(&path, columns, panels).unwrap();
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn samples_obey_the_constraint() {
    let (figure, worst) = panels::samples(20).unwrap();
    assert!(worst < 1e-12, "{worst}");
    let svg = drawn("figure_5_5.svg", 2, &figure);
    assert!(
        svg.contains("heading q3 / °") && svg.ends_with("</svg>\n"),
        "{svg}"
    );
}

#[test]
fn the_particle_extrapolates_transfers_and_stays_on_its_surface() {
    let models = panels::particle(60).unwrap();
    let reach = panels::reach(&models).unwrap();
    let [own, se, moved] = reach.rmse;
    println!("RMSE {own:.3}, SE-GP {se:.3}, other surface {moved:.3}");
    assert!(own < 0.1 * se && moved < 0.1 * se, "{:?}", reach.rmse);
    let paths = panels::paths(&models, 1.0).unwrap();
    let gaps: Vec<f64> = paths
        .iter()
        .map(|p| p.gap.iter().fold(0.0, |m: f64, g| m.max(*g)))
        .collect();
    assert!(gaps[1] < 1e-6 && gaps[2] > 1e-3, "{gaps:?}");
    let (figure, [particle, unicycle]) = panels::unconstrained(&models, 40).unwrap();
    assert!(particle < 0.3 && unicycle < 0.05, "{particle} {unicycle}");
    let mut all = reach.panels;
    all.extend(panels::path_panels(&paths));
    all.extend(figure);
    assert!(drawn("figure_5_6_and_5_7.svg", 3, &all).contains("|c(q)| / m"));
}
