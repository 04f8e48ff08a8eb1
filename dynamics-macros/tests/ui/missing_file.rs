//! A model, and a folder of effects, that are not there.

use dynamics::Dynamics;

#[derive(Dynamics)]
#[dynamics(model = "models/card.model")]
struct Cart;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model", effects = "models/effect")]
struct Other;

fn main() {}
