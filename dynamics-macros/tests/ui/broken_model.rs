//! A model with mistakes: all are shown, with their lines.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/broken.model")]
struct Broken {
    m: f64,
}

fn main() {}
