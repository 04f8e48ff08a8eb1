//! Machines with contacts against what is known of them in closed form.

#[path = "contacts/case.rs"]
mod case;
#[path = "contacts/flat.rs"]
mod flat;
#[path = "contacts/impacts.rs"]
mod impacts;
#[path = "contacts/kinematics.rs"]
mod kinematics;
#[path = "contacts/mujoco.rs"]
mod mujoco;
#[path = "contacts/robots.rs"]
mod robots;
#[path = "contacts/rolling.rs"]
mod rolling;
#[path = "contacts/sliding.rs"]
mod sliding;
#[path = "contacts/struck_while_pressed.rs"]
mod struck_while_pressed;
#[path = "contacts/thrown.rs"]
mod thrown;
