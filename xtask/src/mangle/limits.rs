//! The program under test, bounded in time and memory.

use crate::child::{peak_memory_mib, processor};
use crate::workspace::at;
use std::{
    fs::{self, File},
    path::Path,
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

/// What one case may take. Time is that of the processor, because other work may share the machine.
pub(super) struct Limits {
    /// Seconds of processor, of all threads.
    pub(super) processor: f64,
    /// Seconds of the clock, for a program that waits for ever.
    pub(super) clock: f64,
}

/// The limits of all cases.
pub(super) const LIMITS: Limits = Limits { processor: 10.0, clock: 300.0 };
/// Address space that one case may take: 1 GiB, and what threads and the program itself reserve, KiB.
pub(super) const KIB: u64 = 1_200_000;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// Status 0.
    Done,
    /// Status 2: the input is wrong.
    Refused,
    /// Another status, a signal, or a panic.
    Other,
    /// Longer than [`LIMITS`] allow.
    Time,
    /// It asked for more than [`KIB`].
    Memory,
}

impl End {
    /// All of them, in the order of the table.
    pub(super) const ALL: [Self; 5] = [Self::Done, Self::Refused, Self::Other, Self::Time, Self::Memory];

    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Done => "0",
            Self::Refused => "2",
            Self::Other => "other",
            Self::Time => "time",
            Self::Memory => "memory",
        }
    }

    /// Whether the input was neither taken nor refused.
    pub(super) fn failed(self) -> bool {
        !matches!(self, Self::Done | Self::Refused)
    }
}

/// What a run did.
pub(super) struct Run {
    pub(super) end: End,
    /// Seconds of processor, as last seen: 0 for runs of a few milliseconds.
    pub(super) seconds: f64,
    /// Largest resident memory that was seen, MiB; 0 for runs of a few milliseconds.
    pub(super) mib: u64,
    /// Standard error.
    pub(super) error: String,
}

/// Runs a program in a folder. The shell sets the limits, that of processor time in case this task dies
/// first. What it prints goes into files beside the folder: `FOLDER.out` and `FOLDER.err`.
pub(super) fn run(program: &Path, words: &[&str], folder: &Path, limits: &Limits) -> Result<Run, String> {
    let beside = |ending: &str| folder.with_extension(ending);
    let file = |ending: &str| File::create(beside(ending)).map_err(at(&beside(ending)));
    let script =
        format!("ulimit -v {KIB}; ulimit -t {:.0}; ulimit -c 0; exec \"$0\" \"$@\"", 4.0 * limits.processor);
    let mut command = Command::new("/bin/sh");
    command.args(["-c", &script]).arg(program).args(words).current_dir(folder).env_remove("RIJKE_MEASURED");
    command.stdin(Stdio::null()).stdout(file("out")?).stderr(file("err")?);
    let cannot = |e| format!("/bin/sh, which sets the limits, cannot be started: {e}");
    let (mut child, started, mut mib, mut over) =
        (command.spawn().map_err(cannot)?, Instant::now(), 0, false);
    let mut seconds: f64 = 0.0;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(cannot)? {
            break status;
        }
        mib = mib.max(peak_memory_mib(child.id()).unwrap_or(0));
        seconds = processor(&child.id().to_string(), 11).max(seconds);
        let clock = started.elapsed().as_secs_f64();
        if (seconds > limits.processor || clock > limits.clock) && !over {
            over = true;
            child.kill().map_err(cannot)?;
        }
        thread::sleep(Duration::from_millis(if started.elapsed().as_millis() < 100 { 2 } else { 20 }));
    };
    let bytes = fs::read(beside("err")).unwrap_or_default();
    let error =
        String::from_utf8_lossy(bytes.get(..bytes.len().min(100_000)).unwrap_or_default()).into_owned();
    Ok(Run { end: if over { End::Time } else { judged(status, &error) }, seconds, mib, error })
}

fn judged(status: ExitStatus, error: &str) -> End {
    let memory = ["memory allocation of", "out of memory", "Cannot allocate memory", "std::bad_alloc"];
    if memory.iter().any(|words| error.contains(words)) {
        return End::Memory;
    }
    match status.code() {
        _ if error.contains("panicked at") => End::Other,
        Some(0) => End::Done,
        Some(2) => End::Refused,
        _ => End::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::{End, Limits, judged, run};
    use std::{fs, os::unix::process::ExitStatusExt, path::Path, process::ExitStatus};

    #[test]
    fn exact_children_over_the_limits_are_reported() {
        let folder = std::env::temp_dir().join(format!("xtask-limits-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let limits = Limits { processor: 0.5, clock: 2.0 };
        let shell = |script: &str| run(Path::new("/bin/sh"), &["-c", script], &folder, &limits).unwrap();
        assert_eq!(shell("exit 0").end, End::Done);
        assert_eq!(shell("exit 2").end, End::Refused);
        assert_eq!(shell("echo thread main panicked at src/lib.rs >&2; exit 2").end, End::Other);
        assert_eq!(shell("kill -SEGV $$").end, End::Other);
        assert_eq!(shell("sleep 60").end, End::Time);
        let busy = shell("while :; do :; done");
        assert!(busy.end == End::Time && busy.seconds > 0.2, "{} s", busy.seconds);
        // The limits hold in the child: what it may take of the address space, KiB.
        let told = shell("[ $(ulimit -v) = 1200000 ] && exit 2");
        assert_eq!(told.end, End::Refused);
        // 2 GB in one piece, of a program that says so.
        let large = shell(
            "dd if=/dev/zero of=/dev/null bs=2000000000 count=1 2>&1 || { echo out of memory >&2; exit 1; }",
        );
        assert_eq!(large.end, End::Memory);
        assert_eq!(judged(ExitStatus::from_raw(6), "memory allocation of 8 bytes failed"), End::Memory);
        fs::remove_dir_all(folder).unwrap();
    }
}
