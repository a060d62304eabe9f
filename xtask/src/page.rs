//! `cargo xtask page`: opens the page of results in headless Chromium as a reader would, wide, narrow and on
//! paper.

use crate::python::program;
use crate::workspace::{Outcome, root, succeed};
use browser::{between, command, told};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

mod browser;
mod live;

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

/// A frame while a slider is dragged, ms: sixty a second are 16.7. Six times that is refused, because others
/// may use the machine; how long it took is printed.
const SLOWEST: f64 = 100.0;

/// Examples whose models their pages must solve too: gas at rest that is heated in a forced flow, one duct
/// and three.
const EXAMPLES: [&str; 2] = ["quarter-wave", "ducted-flame-stages"];

/// Bytes of a page at most.
const LARGEST: u64 = 1_000_000;

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
    fs::create_dir_all(&scratch).map_err(|e| format!("{}: {e}", scratch.display()))?;
    let drawn = files_of(&page.with_file_name("figures"), "svg")?;
    let mut faults = Vec::new();
    let size = fs::metadata(&page).map_err(|e| format!("{}: {e}", page.display()))?.len();
    if size > LARGEST {
        faults.push(format!("it has {size} bytes, more than {LARGEST}"));
    }
    let axe = axe(&scratch);
    let mut said_of_sliders = Vec::new();
    for look in &LOOKS {
        let (found, console) = open(browser, &scratch, &page, look, axe)?;
        if look.timed {
            said_of_sliders.push(format!("the paper: {}", found["sliders"].as_str().unwrap_or_default()));
        }
        let figures = found["figures"].as_u64().unwrap_or(0);
        if figures != drawn as u64 {
            faults.push(format!("{}: {figures} figures on the page, {drawn} drawn", look.name));
        }
        faults.extend(told(look.name, &found, console));
    }
    for name in EXAMPLES {
        let example = example(name, &scratch)?;
        for look in LOOKS.iter().filter(|look| look.timed) {
            let (found, console) = open(browser, &scratch, &example, look, false)?;
            said_of_sliders.push(format!("{name}: {}", found["sliders"].as_str().unwrap_or_default()));
            faults.extend(told(name, &found, console));
        }
    }
    faults.extend(live::faults(browser, &scratch)?);
    let pages = print(browser, &scratch, &page)?;
    if faults.is_empty() {
        println!(
            "page: {drawn} figures in order at 1280 px, at 360 px, dark, and on {pages} sheets of paper; {size} bytes"
        );
        println!("page: the page of `rijke watch` shows a record that came while it was open");
        said_of_sliders.iter().for_each(|said| println!("page: {said}"));
        println!(
            "page: axe-core: {}",
            if axe { "no violations" } else { "not looked at, because npm could not get it" }
        );
        return Ok(());
    }
    Err(format!("the page has {} faults\n  {}", faults.len(), faults.join("\n  ")))
}

/// The page of an example of the repository, made anew in the scratch folder.
fn example(name: &str, scratch: &Path) -> Result<PathBuf, String> {
    let folder = scratch.join(name);
    // Of an earlier run.
    let _ = fs::remove_dir_all(&folder);
    succeed(Command::new("cp").arg("-r").arg(root().join("examples").join(name)).arg(&folder))?;
    succeed(Command::new(program()?).args(["run", "--one-start"]).arg(&folder))?;
    Ok(folder.join("results/index.html"))
}

/// The first browser of the kind that is installed.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()))
}

/// What the harness found, and the console's lines.
fn open(
    browser: &str,
    scratch: &Path,
    page: &Path,
    look: &Look,
    axe: bool,
) -> Result<(Value, Vec<String>), String> {
    let harness = scratch.join("harness.html");
    // Settings of the model and what the engine says of them, to which the page's own solver is held.
    let checks = page.with_file_name("tables").join("sliders.csv");
    let checks = fs::read_to_string(&checks).unwrap_or_default();
    let text = HARNESS
        .replace("@CHECKS@", &checks)
        .replace("@AXE@", &(axe && !look.timed && !look.print).to_string())
        .replace("@SLOWEST@", &SLOWEST.to_string())
        .replace("@PAGE@", &format!("file://{}", page.display()))
        .replace("@WIDTH@", &look.width.to_string())
        .replace("@SMALLEST@", &look.smallest.to_string())
        .replace("@PRINT@", &look.print.to_string());
    fs::write(&harness, text).map_err(|e| format!("{}: {e}", harness.display()))?;
    let mut command = command(browser, scratch);
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

/// Puts axe-core, which looks for barriers to readers with disabilities, beside the harness; false where npm
/// cannot get it.
fn axe(scratch: &Path) -> bool {
    let file = scratch.join("axe.min.js");
    if !file.is_file() {
        let pack = ["pack", "--silent", "--pack-destination", ".", "axe-core@4"];
        let got = Command::new("npm").args(pack).current_dir(scratch).output();
        let Some(archive) = got.ok().filter(|o| o.status.success()).map(|o| o.stdout) else { return false };
        let name = String::from_utf8_lossy(&archive).trim().to_owned();
        let unpack = ["-xf", &name, "--strip-components=1", "package/axe.min.js"];
        let _ = Command::new("tar").args(unpack).current_dir(scratch).status();
    }
    file.is_file()
}

/// Number of files with an ending.
fn files_of(folder: &Path, ending: &str) -> Result<usize, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(entries.flatten().filter(|e| e.path().extension().is_some_and(|x| x == ending)).count())
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
