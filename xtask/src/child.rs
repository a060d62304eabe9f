//! Programs that a task starts, one at a time: whatever ends the task ends them too.

use std::{
    fs, io,
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

/// A program that ends with what holds it.
pub(crate) struct Ending(pub(crate) Child);

impl Drop for Ending {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

/// The most memory that a running process has held so far, MiB; none where the system does not tell.
pub(crate) fn peak_memory_mib(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib.div_ceil(1024))
}

/// Seconds of processor as Linux counts them, in hundredths (proc(5)): of a process (`utime` and `stime`,
/// from field 11 behind its name), or of the programs that it waited for (`cutime` and `cstime`, from 13); 0
/// where they cannot be read.
pub(crate) fn processor(process: &str, field: usize) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let numbers = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(field).take(2);
    numbers.filter_map(|n| n.parse::<f64>().ok()).sum::<f64>() / 100.0
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
