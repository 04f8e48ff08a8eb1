//! From a measured log to the effect that a model lacks.
//!
//! A model is text in the language of `dynamics-codegen`, a [`Log`](log::Log) a table of what a machine
//! did. [`trace`](trace::trace) compares the two and says what the model lacks, by name and with numbers;
//! [`fit`](fit::fit) learns inertias, friction and loads of a robot from measured torques.
//!
//! # Trace a log
//!
//! A wheel whose bearing brakes with 0.02 N·m·s, which its model does not know:
//!
//! ```
//! use dynamics_codegen::Library;
//! use identify::log::Log;
//! use identify::trace::{Request, Verdict, trace};
//!
//! let model = "\
//! model wheel;
//! coordinate angle: rad;
//! input motor: N*m;
//! parameter i: kg*m^2 = 0.02 in 1e-4..;
//! kinetic i/2*dot(angle)^2;
//! force angle = input(motor);
//! ";
//! // angle = sin 2t + ½ sin 5t, through an encoder with steps of 0.1 mrad, at 100 Hz for 12 s.
//! let mut text = String::from("t,q_angle,u_motor\n");
//! for k in 0..1200 {
//!     let t = 0.01 * f64::from(k);
//!     let q = (2.0 * t).sin() + 0.5 * (5.0 * t).sin();
//!     let v = 2.0 * (2.0 * t).cos() + 2.5 * (5.0 * t).cos();
//!     let a = -4.0 * (2.0 * t).sin() - 12.5 * (5.0 * t).sin();
//!     let read = (1e4 * q).round() / 1e4;
//!     text += &format!("{t},{read},{}\n", 0.02 * a + 0.02 * v);
//! }
//! let log = Log::from_bytes("wheel.csv", text.as_bytes())?;
//! let library = Library::builtin();
//! let outcome = trace(&Request::new("wheel.model", model, &library, &log))?;
//!
//! assert_eq!(outcome.verdict, Verdict::Effect);
//! let finding = &outcome.findings[0];
//! assert_eq!((finding.effect.as_str(), &finding.on[..]), ("viscous", &["angle".to_string()][..]));
//! let damping = &finding.parameters["d"];
//! assert!((damping.value - 0.02).abs() < 3.0 * damping.std);
//! // On the last third of the log, which nothing was fitted to:
//! assert!(outcome.after.acceleration.total < 0.1 * outcome.before.acceleration.total);
//! // The model with the line that it lacked.
//! assert!(outcome.patched_model.contains("effect viscous(angle)"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A file is read by [`Log::read`](log::Log::read), or by [`Wanted`](log::Wanted) where its columns need a
//! map. [`Outcome`](trace::Outcome) has everything that the command line prints; [`summary`](report::summary)
//! is its text, [`html`](report::html) its page. A long search reports where it is and can be ended by
//! [`Progress`](trace::Progress).
//!
//! # Modules, and what each stands on
//!
//! | module | | stands on |
//! |---|---|---|
//! | [`log`] | files to checked channels | |
//! | [`smooth`] | position, velocity, acceleration, with uncertainty | `log` |
//! | [`machine`] | a model on tapes: accelerations, roll-outs, linearisation | `log`, `smooth` |
//! | `regression` | the linear equation of the departure from a log, whitened; least squares | the three above |
//! | `robot_options` | options of a robot description, written anew | |
//! | `floating` | models whose bodies float by their twists, held against logs by rates | `log`, `robot_options` |
//! | [`trace`] | the search for what is missing, and its judgement | all above |
//! | [`fit`] | inertias, friction and loads from measured torques | all above |
//! | [`report`] | summaries, changes to the model, pages | all above |

pub mod fit;
mod floating;
pub mod log;
pub mod machine;
mod number;
mod regression;
pub mod report;
mod robot_options;
pub mod smooth;
pub mod trace;
