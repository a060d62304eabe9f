//! `cargo xtask page`: opens the page of results in headless Chromium as a reader would, wide, narrow and on paper.

use crate::workspace::{Outcome, root};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

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
}

/// A desk, a telephone, and a sheet of A4 between margins of 1 cm.
const LOOKS: [Look; 3] = [
    Look { name: "1280 px", width: 1280, smallest: 7.5, print: false },
    Look { name: "400 px", width: 400, smallest: 7.5, print: false },
    Look { name: "paper", width: 718, smallest: 4.5, print: true },
];

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
    for look in &LOOKS {
        let (found, console) = open(browser, &scratch, &page, look)?;
        let figures = found["figures"].as_u64().unwrap_or(0);
        if figures != drawn as u64 {
            faults.push(format!("{}: {figures} figures on the page, {drawn} drawn", look.name));
        }
        let said = found["faults"].as_array().into_iter().flatten().filter_map(Value::as_str);
        faults.extend(said.map(|fault| format!("{}: {fault}", look.name)));
        faults.extend(console.iter().map(|line| format!("{}: console: {line}", look.name)));
    }
    let pages = print(browser, &scratch, &page)?;
    if faults.is_empty() {
        println!("page: {drawn} figures in order at 1280 px, at 400 px and on {pages} sheets of paper");
        return Ok(());
    }
    Err(format!("the page has {} faults\n  {}", faults.len(), faults.join("\n  ")))
}

/// The first browser of the kind that is installed.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()))
}

/// What the harness found, and the console's lines.
fn open(browser: &str, scratch: &Path, page: &Path, look: &Look) -> Result<(Value, Vec<String>), String> {
    let harness = scratch.join("harness.html");
    let text = HARNESS
        .replace("@PAGE@", &format!("file://{}", page.display()))
        .replace("@WIDTH@", &look.width.to_string())
        .replace("@SMALLEST@", &look.smallest.to_string())
        .replace("@PRINT@", &look.print.to_string());
    fs::write(&harness, text).map_err(|e| format!("{}: {e}", harness.display()))?;
    let mut command = command(browser, scratch);
    // The frame of the harness is a file of its own, into which it may look only with this option.
    command.args(["--allow-file-access-from-files", "--virtual-time-budget=20000", "--dump-dom"]);
    let output = command.arg(&harness).output().map_err(|e| format!("cannot start {browser}: {e}"))?;
    let (dom, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let found =
        between(&dom).ok_or_else(|| format!("{browser} did not load the page at {}\n{said}", look.name))?;
    let found = serde_json::from_str(&found).map_err(|e| format!("{}: {e}", look.name))?;
    let console = said.lines().filter(|l| l.contains("CONSOLE")).map(String::from);
    Ok((found, console.collect()))
}

/// The last thing between the marks of the harness, as the browser writes text.
fn between(dom: &str) -> Option<String> {
    let (_, rest) = dom.rsplit_once("FOUND{")?;
    let (found, _) = rest.split_once("}END")?;
    Some(format!("{{{found}}}").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
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

/// A browser that leaves the user's own alone. Only a page that was made here is opened, so no sandbox is needed, which
/// a superuser could not have.
fn command(browser: &str, scratch: &Path) -> Command {
    let mut command = Command::new(browser);
    command
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", scratch.join("profile").display()));
    command
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
