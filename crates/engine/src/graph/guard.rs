//! A panic in a computation becomes an error of one line.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::{Mutex, Once, PoisonError};

thread_local! {
    /// Computations of this thread that are guarded, one inside the other.
    static GUARDED: Cell<usize> = const { Cell::new(0) };
}

/// Keeps guarded panics off the terminal.
static QUIET: Once = Once::new();
/// Where the latest guarded panic was: what it carries does not say it.
static PLACE: Mutex<Option<String>> = Mutex::new(None);

/// The result of `work`; a panic in it, or in what it has other threads of the pool do, becomes an error that names `what`.
pub fn guarded<T, E: From<String>>(what: &str, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    QUIET.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| note(panic, &usual)));
    });
    GUARDED.set(GUARDED.get() + 1);
    // What a panic leaves half done is dropped with `work`; locks are taken whether poisoned or not.
    let result = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(GUARDED.get() - 1);
    result.unwrap_or_else(|panic| Err(line(what, &*panic).into()))
}

/// Keeps the place of a guarded panic, or reports another one as usual.
fn note(panic: &PanicHookInfo<'_>, usual: &dyn Fn(&PanicHookInfo<'_>)) {
    // A thread of the pool hands its panic on to the thread that waits for it.
    if GUARDED.get() > 0 || rayon::current_thread_index().is_some() {
        let place = panic.location().map(|place| format!("{}:{}", crate_path(place.file()), place.line()));
        *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = place;
    } else {
        usual(panic);
    }
}

/// Path of a source file from the folder of its crate on, whatever machine built the program.
fn crate_path(file: &str) -> &str {
    let source = file.rfind("src").unwrap_or(0);
    let folder = file[..source].trim_end_matches(['/', '\\']);
    &file[folder.rfind(['/', '\\']).map_or(0, |at| at + 1)..]
}

/// The error of a panic.
fn line(what: &str, panic: &(dyn Any + Send)) -> String {
    let message = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    let message = message.unwrap_or("panic").lines().next().unwrap_or_default();
    let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default();
    format!("{what}: internal error of doublet at {place}: {message}; report it with the session and its recordings")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_one_line_with_its_place() {
        let empty: Vec<f64> = Vec::new();
        let found: Result<f64, String> = guarded("path of 'a'", || Ok(empty[empty.len()]));
        let error = found.unwrap_err();
        assert!(error.starts_with("path of 'a': internal error of doublet at engine/src/graph/guard.rs:"), "{error}");
        assert!(error.contains("index out of bounds") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn a_panic_of_the_pool_becomes_an_error_too() {
        let found: Result<(), String> = guarded("windows", || {
            rayon::join(|| (), || assert!(std::hint::black_box(false), "second half"));
            Ok(())
        });
        assert!(found.unwrap_err().contains("second half"));
        assert_eq!(guarded::<_, String>("windows", || Ok(1)), Ok(1));
    }
}
