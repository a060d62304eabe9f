//! Ctrl-C while a crate works.

use crate::fault::Fault;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How often Ctrl-C is looked for.
const POLL: Duration = Duration::from_millis(2);

/// Does `work` in a thread of its own, while this one listens for Ctrl-C and calls `news`. On Ctrl-C, or if
/// `news` raises, it sets `stopped`, upon which `work` has to end.
pub(crate) fn listening<T: Send>(
    py: Python<'_>,
    stopped: &AtomicBool,
    mut news: impl FnMut() -> PyResult<()>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    std::thread::scope(|scope| {
        let work = scope.spawn(work);
        let mut interrupted = None;
        while !work.is_finished() {
            py.detach(|| std::thread::sleep(POLL));
            if interrupted.is_some() {
                continue;
            }
            if let Err(error) = py.check_signals().and_then(|()| news()) {
                stopped.store(true, Ordering::Relaxed);
                interrupted = Some(error);
            }
        }
        match (interrupted, work.join()) {
            (Some(error), _) => Err(error),
            (None, Ok(outcome)) => Ok(outcome),
            (None, Err(_)) => Err(Fault::failed("the work stopped without an answer").into()),
        }
    })
}
