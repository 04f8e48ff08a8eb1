//! What must hold of the three benchmark systems of thesis 5.2.1.

mod constraints;
mod gradients;
mod kernels;
mod oracle;
mod quantities;
mod sparse;
mod states;
mod systems;
