//! The Wheelbot of chapter 6 of the thesis, simulated on its own firmware.
//!
//! ```text
//! robot ──▶ design ──▶ gains ─┐
//!   └─────▶ sensing ──▶ wheelbot-firmware ──▶ motors ──▶ robot        trial: once around, 1 kHz
//!                                                          └──▶ studies ──▶ report
//! ```
//!
//! A [`trial`] is one simulated run; a [`jump`] one on the floor, from lying on a side; [`studies`] are the
//! programs, each of which repeats a figure of the thesis; [`report`] makes a page of what a study found.

#![forbid(unsafe_code)]

pub mod design;
pub mod excitation;
pub mod feed_forward;
pub mod firmware;
pub mod jump;
pub mod motors;
pub mod report;
pub mod robot;
pub mod sensing;
pub mod studies;
pub mod trial;
