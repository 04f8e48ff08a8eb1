//! A value that cannot be folded in.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/stopped.model")]
struct Stopped {
    m: f64,
}

fn main() {}
