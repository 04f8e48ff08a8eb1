//! What cannot become a system.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
enum Choice {
    One,
}

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Tuple(f64);

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Two<T, S> {
    mc: T,
    l: S,
}

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Text {
    mc: String,
    l: i32,
}

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Mixed<T> {
    mc: T,
    l: f64,
}

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Doubled<T> {
    mc: T,
    #[dynamics(parameter = "mc")]
    mass: T,
}

fn main() {}
