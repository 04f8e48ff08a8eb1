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

/// Effects, channels, outputs, priors, one-sided bounds: what the models do not have.
#[test]
fn everything_a_model_can_have() {
    let compiled = models::read(models::EVERYTHING);
    let sheet = emit::review(&compiled, models::EVERYTHING);
    insta::assert_snapshot!("everything", sheet);
}
