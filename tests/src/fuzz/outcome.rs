//! What became of an input.

use super::input::Input;
use super::targets;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Mutex, Once, PoisonError};

/// What became of an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// It was read, and worked with.
    Accepted,
    /// It was refused, with a message.
    Refused,
    /// The program panicked, or broke a promise.
    Failed(Failure),
}

/// A panic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The file and line that panicked.
    pub place: String,
    /// What it said.
    pub message: String,
}

/// Runs an input.
pub fn outcome(input: &Input) -> Outcome {
    match caught(|| targets::run(input)) {
        Ok(true) => Outcome::Accepted,
        Ok(false) => Outcome::Refused,
        Err(failure) => Outcome::Failed(failure),
    }
}

/// The panic that is on its way through [`caught`]; `None` while there is none.
static PANIC: Mutex<Option<Failure>> = Mutex::new(None);
/// One at a time: a panic of a thread pool belongs to whoever runs.
static RUNNING: Mutex<()> = Mutex::new(());
thread_local! {
    /// Whether panics of this thread are kept without being printed.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `f` and catches its panic, also of threads that it waits for.
pub(super) fn caught<T>(f: impl FnOnce() -> T) -> Result<T, Failure> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            keep(info);
            if !QUIET.get() {
                others(info);
            }
        }));
    });
    let _one_at_a_time = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = None;
    QUIET.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(f));
    QUIET.set(false);
    let panic = PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
    result.map_err(|_| {
        panic.unwrap_or_else(|| Failure {
            place: "nowhere".to_string(),
            message: "unwound without a panic".to_string(),
        })
    })
}

/// Keeps the first panic: others follow when it travels.
fn keep(info: &PanicHookInfo<'_>) {
    let place = info.location().map_or_else(String::new, |l| {
        format!("{}:{}", from_the_root(l.file()), l.line())
    });
    let (said, made) = (
        info.payload().downcast_ref::<&str>(),
        info.payload().downcast_ref::<String>(),
    );
    let message = said.map_or_else(
        || made.cloned().unwrap_or_default(),
        |said| (*said).to_string(),
    );
    let mut panic = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
    panic.get_or_insert(Failure { place, message });
}

/// A path without what is in front of the workspace or of a library's name.
fn from_the_root(path: &str) -> &str {
    let in_registry = path.split_once("/registry/src/").and_then(|(_, behind)| {
        let (_, library) = behind.split_once('/')?;
        Some(library)
    });
    in_registry.unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_caught_with_its_place() {
        assert_eq!(caught(|| 3), Ok(3));
        let list: Vec<usize> = Vec::new();
        let failure = caught(|| list[std::hint::black_box(3)]).unwrap_err();
        assert!(failure.place.contains("fuzz/outcome.rs:"), "{failure:?}");
        assert!(failure.message.contains("out of bounds"), "{failure:?}");
        let elsewhere = || {
            let there = std::thread::spawn(|| assert!(std::hint::black_box(false), "there"));
            assert!(there.join().is_ok(), "here");
        };
        assert_eq!(caught(elsewhere).unwrap_err().message, "there");
        assert_eq!(
            from_the_root("/x/registry/src/index-1/faer-0.24/src/lib.rs"),
            "faer-0.24/src/lib.rs"
        );
    }
}
