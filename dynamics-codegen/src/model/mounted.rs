//! Where inertial sensors are: `mounted board = board * rotate_x(tilt);`.

use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::syntax::{Expr, Name};
use std::collections::BTreeMap;

/// The functions that read what is mounted at a frame.
const INERTIAL: [&str; 2] = ["gyroscope", "accelerometer"];

/// Whether a function shows what a sensor does that is mounted at a frame.
pub(super) fn is_inertial(function: &str) -> bool {
    INERTIAL.contains(&function)
}

/// Where sensors are mounted in truth.
#[derive(Debug, Clone, Default)]
pub(super) struct Mounts {
    /// Per frame of the tree that somebody says it of, the frame that its sensors are at.
    moved: BTreeMap<usize, usize>,
    /// The frame that is being mounted: its name stands for where it has come to so far.
    mounting: Option<usize>,
}

impl Mounts {
    /// Where the sensors of a frame are.
    fn of(&self, frame: usize) -> usize {
        self.moved.get(&frame).copied().unwrap_or(frame)
    }

    /// What a frame stands for as the beginning of a product.
    pub fn parent(&self, frame: usize) -> usize {
        match self.mounting == Some(frame) {
            true => self.of(frame),
            false => frame,
        }
    }
}

impl Builder<'_> {
    /// `mounted f = value`: gyroscopes and accelerometers at `f` are there.
    pub(super) fn lower_mounted(&mut self, name: &Name, value: &Expr) -> Option<()> {
        let frame = self.find_frame(&name.text, name.span)?;
        if frame == 0 {
            let message = "`world` is the frame that does not move";
            let help = "give the sensors a frame of their own, `frame board = …;`, and mount that";
            return self.report(Diagnostic::error(name.span, message).help(help));
        }
        self.mounts.mounting = Some(frame);
        let label = format!("{}_mounted", name.text);
        let there = self.lower_frame(value, &label);
        self.mounts.mounting = None;
        self.mounts.moved.insert(frame, there?);
        Some(())
    }

    /// The frame that the inertial sensors of `frame` are at, which is called `name`.
    pub(super) fn board(&mut self, frame: usize, name: &str) -> usize {
        if !self.model.boards.iter().any(|known| known == name) {
            self.model.boards.push(name.to_string());
        }
        self.mounts.of(frame)
    }
}
