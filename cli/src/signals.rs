//! What an interrupt and a request to end do: files under construction are removed, and the program
//! ends; but a job that can end with what it has is asked to at the first interrupt.

use crate::{output, pending};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Whether signals are waited for.
static WATCHED: Mutex<bool> = Mutex::new(false);
/// Whether a job that can end early is running.
static PATIENT: AtomicBool = AtomicBool::new(false);
/// Whether it is to end.
static ASKED: AtomicBool = AtomicBool::new(false);

/// As long as it lives, the first interrupt only asks to end early.
#[derive(Debug)]
pub struct Patient(());

impl Patient {
    /// Waits for signals.
    ///
    /// # Errors
    /// If the system will not let us.
    pub fn begin() -> io::Result<Self> {
        watch()?;
        PATIENT.store(true, Ordering::SeqCst);
        Ok(Self(()))
    }
}

impl Drop for Patient {
    fn drop(&mut self) {
        PATIENT.store(false, Ordering::SeqCst);
    }
}

/// Whether a job that can end early was asked to.
pub fn asked_to_end() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// Waits for an interrupt or a request to end, from now on.
///
/// # Errors
/// If the system will not let us.
pub fn watch() -> io::Result<()> {
    let mut watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
    if !*watched {
        spawn()?;
        *watched = true;
    }
    Ok(())
}

#[cfg(unix)]
fn spawn() -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let waiting = move || {
        for signal in signals.forever() {
            let patient = signal == SIGINT && PATIENT.load(Ordering::SeqCst);
            if patient && !ASKED.swap(true, Ordering::SeqCst) {
                output::complain("Ending with what there is; interrupt again to end at once.");
                continue;
            }
            // Kept: no file is begun any more.
            let _pending = pending::remove_all();
            emulate_default_handler(signal).ok();
        }
    };
    std::thread::Builder::new().spawn(waiting)?;
    Ok(())
}

#[cfg(not(unix))]
fn spawn() -> io::Result<()> {
    Ok(())
}
