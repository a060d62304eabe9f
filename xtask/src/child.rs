//! Programs that a task starts, one at a time: whatever ends the task ends them too.

use std::{
    io,
    process::{Child, Command, ExitStatus},
    sync::{Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

/// The program that runs now. Its standard input, if it is a pipe, is open as long as this task lives.
static RUNNING: Mutex<Option<Child>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Child>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a program to its end, and looks at it every 10 ms.
pub(crate) fn run(command: &mut Command, mut look: impl FnMut(&Child)) -> io::Result<ExitStatus> {
    *running() = Some(command.spawn()?);
    loop {
        if let Some(child) = &mut *running() {
            look(child);
            if let Some(status) = child.try_wait()? {
                return Ok(status);
            }
        }
        thread::sleep(Duration::from_millis(10));
    }
}

/// From now on SIGINT and SIGTERM end the running program first, then this task, as each of them does by
/// default. SIGKILL cannot be seen, and SIGHUP is left alone because of nohup: then the pipe to the program
/// closes (`rijke --until-stdin-closes`).
#[cfg(unix)]
pub(crate) fn end_with_signals() -> Result<(), String> {
    use signal_hook::{consts, iterator::Signals, low_level::emulate_default_handler};
    let mut signals = Signals::new([consts::SIGINT, consts::SIGTERM])
        .map_err(|error| format!("signals cannot be caught: {error}"))?;
    thread::spawn(move || {
        for signal in signals.forever() {
            // Held to the end, so that no further program is started.
            let mut running = running();
            if let Some(child) = &mut *running {
                let _ = child.kill().and_then(|()| child.wait());
            }
            let _ = emulate_default_handler(signal);
        }
    });
    Ok(())
}

/// Elsewhere a terminal ends all programs of a task, and the pipe does the rest.
#[cfg(not(unix))]
pub(crate) fn end_with_signals() -> Result<(), String> {
    Ok(())
}
