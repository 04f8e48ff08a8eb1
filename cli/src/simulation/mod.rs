//! The motion of a model over time, open-loop or under sampled feedback, and the log of it.

mod control_file;
mod controller;
mod gauges;
mod impacts;
mod mover;
mod readings;
mod recorder;
mod run;
mod signal;

pub use controller::Controller;
pub use impacts::ImpactList;
pub use recorder::Recorder;
pub use run::Run;
pub use signal::Signal;
