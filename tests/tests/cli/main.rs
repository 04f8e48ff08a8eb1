//! The command line, from outside. One program, since each costs a link of everything.

mod bad_input;
mod check;
mod control;
mod eval;
mod fit;
mod fit_compare;
mod generate;
mod interrupt;
mod large;
mod linearise;
mod memory;
mod mjcf;
mod oracle;
mod reading;
mod sensors;
mod simulate;
mod support;
mod terminal;
mod trace;
mod trace_files;
mod view;
