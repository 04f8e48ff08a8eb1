//! Kinematic state estimation.
