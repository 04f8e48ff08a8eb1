//! A robot description with mistakes, and a parameter that its links do not have.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(urdf = "models/broken.urdf")]
struct Broken;

#[derive(Dynamics)]
#[dynamics(urdf = "models/arm.urdf")]
struct Arm<T> {
    lower_mas: T,
}

fn main() {}
