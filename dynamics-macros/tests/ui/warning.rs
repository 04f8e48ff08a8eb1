//! A model's warning is a warning of the compiler, which may be denied.
#![deny(deprecated)]

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/massless.model")]
struct Massless;

fn main() {}
