//! Attributes that are missing, misspelt, doubled, or of the wrong kind.

use dynamics::Dynamics;

#[derive(Dynamics)]
struct Bare;

#[derive(Dynamics)]
#[dynamics(modell = "models/cart.model")]
struct Misspelt;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model", colour = "red")]
struct Unknown;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model", model = "models/cart.model")]
struct Twice;

#[derive(Dynamics)]
#[dynamics(model = 3)]
struct Number;

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model")]
struct Field<T> {
    #[dynamics(name = "mc")]
    mass: T,
}

#[derive(Dynamics)]
#[dynamics(model = "models/cart.model", functions = "inverse_dynamic")]
struct Function;

fn main() {}
