//! A field that is no parameter, beside one that is.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Cart<T> {
    mc: T,
    mq: T,
    stiffness: T,
}

fn main() {}
