#![no_std]
//! Checked-in code generated from the models, reviewed as it stands.
