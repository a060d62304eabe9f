//! `cargo xtask page`: opens the page of results, and those of the examples, in headless Chromium as a reader
//! would, wide, narrow and on paper.

use crate::workspace::{Outcome, at, entries, root, write};
use browser::{between, command, told};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    thread,
};

mod axe;
mod browser;
mod examples;
mod live;
mod paint;

const HARNESS: &str = include_str!("page/harness.html");

/// A way to look at the page.
struct Look {
    name: &'static str,
    /// Width of the window, CSS pixels.
    width: u32,
    /// Height of the smallest letters that are still read, CSS pixels.
    smallest: f64,
    /// As it is printed.
    print: bool,
    /// With light letters on a dark ground.
    dark: bool,
    /// By the clock; else time passes as the page asks for it, so that what comes late is waited for.
    timed: bool,
}

/// A desk by day and by night, a telephone, and a sheet of A4 between margins of 1 cm.
const LOOKS: [Look; 5] = [
    Look { name: "1280 px", width: 1280, smallest: 7.5, print: false, dark: false, timed: false },
    Look { name: "1280 px, dark", width: 1280, smallest: 7.5, print: false, dark: true, timed: false },
    Look { name: "1280 px, timed", width: 1280, smallest: 7.5, print: false, dark: false, timed: true },
    Look { name: "360 px", width: 360, smallest: 7.0, print: false, dark: false, timed: false },
    Look { name: "paper", width: 718, smallest: 4.5, print: true, dark: false, timed: false },
];

/// The median frame while a slider is dragged, ms: sixty a second are 16.7. Six times that is refused,
/// because others may use the machine. How long it took is printed.
const FRAME: f64 = 100.0;

/// First paint, ms: the goal is 1000. Three times that is refused, for the same reason.
const PAINTED: f64 = 3000.0;

/// Bytes of a page at most: that of the whole paper, with its model and figures, has a million.
const LARGEST: u64 = 1_050_000;

/// Fails with everything that is wrong with the page. Without Chromium says so and passes.
pub(crate) fn run() -> Outcome {
    let made = |size: &str| root().join("virtual-rig").join(size).join("results/index.html");
    let Some(page) = ["quick", "full"].map(made).into_iter().find(|page| page.is_file()) else {
        return Err("there is no page in virtual-rig/: run `cargo xtask reproduce` first".to_owned());
    };
    let Some(browser) = browser() else {
        eprintln!("page: not opened, because there is no Chromium (Debian: apt-get install chromium)");
        return Ok(());
    };
    let scratch = root().join("target/page");
    fs::create_dir_all(&scratch).map_err(at(&scratch))?;
    let mut faults = Vec::new();
    let size = fs::metadata(&page).map_err(at(&page))?.len();
    if size > LARGEST {
        faults.push(format!("it has {size} bytes, more than {LARGEST}"));
    }
    let axe = axe::put_into(&scratch)?;
    let mut opened = vec![("the paper".to_owned(), page.clone())];
    opened.extend(examples::pages(&scratch)?);
    let looks = opened.iter().flat_map(|page| LOOKS.iter().map(move |look| (page, look)));
    // The sheets are those of the paper's page, the largest.
    let looks: Vec<_> = looks.filter(|(page, look)| !look.print || page.0 == "the paper").collect();
    let mut said = Vec::new();
    for ((opened, look), seen) in looks.iter().zip(all(browser, &scratch, &looks, axe)) {
        let ((name, page), (found, console)) = (opened, seen?);
        let name = format!("{name}, {}", look.name);
        if look.timed {
            said.push(format!("{name}: {}", found["sliders"].as_str().unwrap_or_default()));
        }
        let figures = found["figures"].as_u64().unwrap_or(0);
        let drawn = files_of(&page.with_file_name("figures"), "svg")?;
        if figures != drawn as u64 {
            faults.push(format!("{name}: {figures} figures on the page, {drawn} drawn"));
        }
        faults.extend(told(&name, &found, console));
    }
    let painted = paint::first(browser, &scratch, &page)?;
    if painted > PAINTED {
        faults.push(format!("it is first painted after {painted:.0} ms"));
    }
    faults.extend(live::faults(browser, &scratch)?);
    let pages = print(browser, &scratch, &page)?;
    if faults.is_empty() {
        println!(
            "page: {} pages in order at 1280 px, at 360 px and dark, that of the paper on {pages} sheets; it has {size} bytes",
            opened.len()
        );
        println!("page: the page of `rijke watch` shows a record that came while it was open");
        println!("page: that of the paper is first painted {painted:.0} ms after it is asked for");
        said.iter().for_each(|said| println!("page: {said}"));
        if axe {
            println!("page: axe-core {}: no violations", axe::VERSION);
        }
        return Ok(());
    }
    Err(format!("the pages have {} faults\n  {}", faults.len(), faults.join("\n  ")))
}

/// The first browser of the kind that is installed.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()))
}

/// What is seen in each look, in order: several browsers at once, because each waits more than it works.
fn all(browser: &str, scratch: &Path, looks: &[(&(String, PathBuf), &Look)], axe: bool) -> Vec<Seen> {
    const BROWSERS: usize = 4;
    let each = |k: usize, part: &[(&(String, PathBuf), &Look)]| -> Vec<Seen> {
        part.iter().map(|((_, page), look)| open(browser, scratch, page, look, axe, k)).collect()
    };
    let parts = looks.chunks(looks.len().div_ceil(BROWSERS).max(1)).enumerate();
    thread::scope(|scope| {
        let started: Vec<_> = parts.map(|(k, part)| scope.spawn(move || each(k, part))).collect();
        let failed = |_| vec![Err("a thread that looks at pages has failed".to_owned())];
        started.into_iter().flat_map(|part| part.join().unwrap_or_else(failed)).collect()
    })
}

/// What the harness found, and the console's lines.
type Seen = Result<(Value, Vec<String>), String>;

/// Looks at a page with the browser number `k`.
fn open(browser: &str, scratch: &Path, page: &Path, look: &Look, axe: bool, k: usize) -> Seen {
    let harness = scratch.join(format!("harness-{k}.html"));
    // Settings of the model and what the engine says of them, to which the page's own solver is held.
    let checks = page.with_file_name("tables").join("sliders.csv");
    let checks = fs::read_to_string(&checks).unwrap_or_default();
    let text = HARNESS
        .replace("@CHECKS@", &checks)
        .replace("@AXE@", &(axe && !look.timed && !look.print).to_string())
        .replace("@FRAME@", &FRAME.to_string())
        .replace("@PAGE@", &format!("file://{}", page.display()))
        .replace("@WIDTH@", &look.width.to_string())
        .replace("@SMALLEST@", &look.smallest.to_string())
        .replace("@PRINT@", &look.print.to_string());
    write(&harness, text)?;
    let mut command = command(browser, &scratch.join(format!("browser-{k}")));
    // The frame of the harness is a file of its own, into which it may look only with this option.
    command.args(["--allow-file-access-from-files", "--dump-dom"]);
    if !look.timed {
        command.arg("--virtual-time-budget=20000");
    }
    if look.dark {
        command.arg("--blink-settings=preferredColorScheme=0");
    }
    let output = command.arg(&harness).output().map_err(|e| format!("cannot start {browser}: {e}"))?;
    let (dom, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let found =
        between(&dom).ok_or_else(|| format!("{browser} did not load the page at {}\n{said}", look.name))?;
    let found = serde_json::from_str(&found).map_err(|e| format!("{}: {e}", look.name))?;
    let console = said.lines().filter(|l| l.contains("CONSOLE")).map(String::from);
    Ok((found, console.collect()))
}

/// Prints the page and counts the sheets.
fn print(browser: &str, scratch: &Path, page: &Path) -> Result<usize, String> {
    let sheets: PathBuf = scratch.join("page.pdf");
    // Of an earlier run.
    let _ = fs::remove_file(&sheets);
    let output = command(browser, scratch)
        .arg(format!("--print-to-pdf={}", sheets.display()))
        .arg(page)
        .output()
        .map_err(|e| format!("cannot start {browser}: {e}"))?;
    let said = || String::from_utf8_lossy(&output.stderr).into_owned();
    let bytes = fs::read(&sheets).map_err(|e| format!("the page cannot be printed: {e}\n{}", said()))?;
    let text = String::from_utf8_lossy(&bytes);
    let count = text.matches("/Type /Page").count() - text.matches("/Type /Pages").count();
    if count == 0 { Err(format!("printed no sheet\n{}", said())) } else { Ok(count) }
}

/// Number of files with an ending.
fn files_of(folder: &Path, ending: &str) -> Result<usize, String> {
    Ok(entries(folder)?.iter().filter(|path| path.extension().is_some_and(|x| x == ending)).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_report_of_the_harness_is_read_from_the_page() {
        let dom =
            "<script>... 'FOUND' + ...</script><pre>FOUND{\"figures\":2,\"faults\":[\"a &lt; b\"]}END</pre>";
        let found: Value = serde_json::from_str(&between(dom).unwrap()).unwrap();
        assert_eq!((&found["figures"], &found["faults"][0]), (&Value::from(2), &Value::from("a < b")));
        assert_eq!(between("<html></html>"), None);
    }
}
