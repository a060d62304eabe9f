//! A browser without a window, and what a harness reports from it.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What the harness and the console say against a page.
pub(super) fn told(name: &str, found: &Value, console: Vec<String>) -> Vec<String> {
    let said = found["faults"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let said = said.map(|fault| format!("{name}: {fault}"));
    said.chain(console.iter().map(|line| format!("{name}: console: {line}"))).collect()
}

/// The last thing between the marks of the harness, as the browser writes text.
pub(super) fn between(dom: &str) -> Option<String> {
    let (_, rest) = dom.rsplit_once("FOUND{")?;
    let (found, _) = rest.split_once("}END")?;
    Some(format!("{{{found}}}").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
}

/// A browser that leaves the user's own alone. Only a page that was made here is opened, so no sandbox is
/// needed, which a superuser could not have.
pub(super) fn command(browser: &str, scratch: &Path) -> Command {
    let mut command = Command::new(browser);
    command
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", scratch.join("profile").display()));
    command
}
