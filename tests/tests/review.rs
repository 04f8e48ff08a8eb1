//! One review sheet per model, under `generated/review/`: what to read when a model
//! changes. `cargo insta review`, or `INSTA_UPDATE=always`, accepts a change.

use dynamics_codegen::emit;
use integration_tests::models;

#[test]
fn every_model_has_a_current_sheet() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../../generated/review");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for model in models::all() {
            let sheet = models::emission(&model).review();
            insta::assert_snapshot!(model.1.model.name.as_str(), sheet);
        }
    });
}

/// Effects, channels, outputs, one-sided bounds: what the models do not have.
#[test]
fn everything_a_model_can_have() {
    let compiled = models::read(models::EVERYTHING);
    let sheet = emit::review(&compiled, models::EVERYTHING);
    insta::assert_snapshot!("everything", sheet);
}

#[test]
fn sensors_of_all_kinds() {
    let sheet = emit::review(&models::read(models::SENSED), models::SENSED);
    insta::assert_snapshot!("sensed", sheet);
}

/// What the sheets say of two arms is no more than the goals, which are another generator's
/// figures for the same robots (Panda: with both fingers free).
#[test]
fn operations_are_at_or_below_the_goals() {
    let functions = [
        "mass_matrix",
        "bias_force",
        "mass_matrix_and_bias_force",
        "forward_dynamics",
        "inverse_dynamics_derivatives",
        "forward_dynamics_derivatives",
    ];
    let goals = [
        ("iiwa7.urdf", [285, 450, 720, 950, 3500, 5500]),
        ("panda.urdf", [638, 822, 1444, 1869, 8000, 13662]),
    ];
    for (file, goals) in goals {
        let model = (format!("models/{file}"), models::one(file));
        let counts = models::emission(&model).operation_counts();
        for (function, goal) in functions.into_iter().zip(goals) {
            let found = counts.iter().find(|(name, _)| name == function);
            let (_, count) = found.unwrap_or_else(|| panic!("{file}: no {function}"));
            println!("{file}: {function} {}, goal {goal}", count.total());
            assert!(
                count.total() <= goal,
                "{file}: {function} {}",
                count.total()
            );
        }
    }
}
