//! One data set of Table 5.1: the structured rows against the published range.
//!
//! The whole table is `cargo run --release -p eqmotion-gp --example table_5_1`.

use crate::benchmark::{self, Data, Kind, SYSTEMS};
use crate::fit;

#[test]
fn structured_models_reach_the_published_figures() {
    assert_eq!(benchmark::ROWS.len(), 7);
    if left_out::shared("data/gp2_observations/observations.json").is_none() {
        return;
    }
    let file = benchmark::observations().unwrap();
    // Published: mean over ten sets, largest of ten sets, for surface, unicycle, Duffing.
    let published = [(0.032, 1e-13), (0.15, 6e-13), (0.029, 3e-8)];
    for (system, (rmse, constraint)) in SYSTEMS.iter().zip(published) {
        let data = Data::read(&file, system, 0).unwrap();
        let kind = Kind::Gp2 {
            mean: true,
            estimate: false,
        };
        let score = fit::fit(kind, system, &data, 0, Some(1)).unwrap();
        println!(
            "{}: rmse {:.4}, constraint {:.1e}",
            system.name, score.rmse, score.constraint
        );
        assert!(score.rmse < rmse, "{}: {}", system.name, score.rmse);
        assert!(
            score.constraint < constraint,
            "{}: {}",
            system.name,
            score.constraint
        );
        assert_eq!(score.fitted.jitter, 0.0);
    }
    let data = Data::read(&file, &SYSTEMS[0], 0).unwrap();
    let plain = fit::fit(Kind::Se, &SYSTEMS[0], &data, 0, Some(1)).unwrap();
    assert!(
        plain.constraint > 0.1,
        "a plain GP does not know the constraint"
    );
}
