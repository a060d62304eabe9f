//! When the page first shows something to a reader who opens it.

use super::browser::{between, command};
use crate::workspace::write;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::{path::Path, thread, time::Duration};

const HARNESS: &str = include_str!("paint.html");

/// How long the browser may take to paint.
const PATIENCE: Duration = Duration::from_secs(30);

/// Time from the start of the navigation to the first content that is painted, ms, by the browser's own
/// clock.
pub(super) fn first(browser: &str, scratch: &Path, page: &Path) -> Result<f64, String> {
    let harness = scratch.join("paint.html");
    let address = held().map_err(|e| format!("no port on the loopback address: {e}"))?;
    let text = HARNESS.replace("@PAGE@", &format!("file://{}", page.display())).replace("@HELD@", &address);
    write(&harness, text)?;
    let mut command = command(browser, scratch);
    command.args(["--allow-file-access-from-files", "--disable-background-networking", "--dump-dom"]);
    let output = command.arg(&harness).output().map_err(|e| format!("cannot start {browser}: {e}"))?;
    let found = between(&String::from_utf8_lossy(&output.stdout)).unwrap_or_default();
    let found: Value = serde_json::from_str(&found).unwrap_or_default();
    found["painted"].as_f64().ok_or_else(|| {
        let said = String::from_utf8_lossy(&output.stderr);
        format!("{browser} painted nothing of {} within {} s\n{said}", page.display(), PATIENCE.as_secs())
    })
}

/// Address of a picture that does not come. The browser writes down the page of the harness once all of it is
/// loaded; the harness waits for this picture until the page in its frame has been painted.
fn held() -> std::io::Result<String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let address = format!("http://{}/held.png", listener.local_addr()?);
    thread::spawn(move || {
        let Ok((mut stream, _)) = listener.accept() else { return };
        // The request, and then the end of the connection: the harness has dropped the picture.
        let _ = stream.set_read_timeout(Some(PATIENCE));
        let mut bytes = [0; 4096];
        while stream.read(&mut bytes).is_ok_and(|n| n > 0) {}
        let _ = stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
    });
    Ok(address)
}
