//! Long work on a thread of its own, so that Ctrl-C is heard while it is done.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How long an interrupt may wait to be heard.
const PAUSE: Duration = Duration::from_millis(50);
/// As much as the main thread of a program has.
const STACK: usize = 8 << 20;

/// Waits for `work`, with the interpreter free for other threads. At an interrupt it waits no
/// longer, and sets `interrupted`.
///
/// # Errors
/// An interrupt, or if the work did not come to its end.
pub fn wait<T: Send + 'static>(
    py: Python<'_>,
    interrupted: &Arc<AtomicBool>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (done, mut waiting) = channel();
    let job = move || {
        // Nobody waits any more after an interrupt.
        let _ = done.send(work());
    };
    thread::Builder::new().stack_size(STACK).spawn(job)?;
    loop {
        let (outcome, back) = py.detach(move || (waiting.recv_timeout(PAUSE), waiting));
        waiting = back;
        match outcome {
            Ok(found) => return Ok(found),
            Err(RecvTimeoutError::Timeout) => py
                .check_signals()
                .inspect_err(|_| interrupted.store(true, Ordering::SeqCst))?,
            Err(RecvTimeoutError::Disconnected) => {
                let message = "the work ended by an internal failure, which is a bug";
                return Err(PyRuntimeError::new_err(message));
            }
        }
    }
}
