//! A page on the loopback address: files of one folder, nothing else, to nobody else.

use rijke_numerics::{Classify, Failed};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::thread;
use std::time::Duration;

/// Longest request that is read, bytes.
const LONGEST: u64 = 8192;

/// Serves `folder` from a thread of its own, until the program ends. Port 0 takes a free one.
pub(super) fn serve(port: u16, folder: PathBuf) -> Result<SocketAddr, Failed> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).or_bad_input().map_err(|f| {
        f.remedy(format!("Port {port} cannot be taken; give --serve another one, or 0 for any."))
    })?;
    let address = listener.local_addr().or_failed()?;
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            // Whoever goes away in the middle of an answer needs none.
            let _ = answer(stream, &folder);
        }
    });
    Ok(address)
}

fn answer(mut stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(2)))?;
    stream.set_write_timeout(Some(Duration::from_secs(2)))?;
    let mut lines = BufReader::new(stream.try_clone()?.take(LONGEST)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    // A page of somebody else's that names this address would send its own host.
    let host = lines.map_while(Result::ok).take_while(|line| !line.is_empty()).find_map(|line| {
        let (key, value) = line.split_once(':')?;
        key.eq_ignore_ascii_case("host").then(|| value.trim().to_owned())
    });
    let local = host.is_some_and(|h| {
        let name = h.rsplit_once(':').map_or(&*h, |(name, _)| name);
        matches!(name, "127.0.0.1" | "localhost")
    });
    let found = if local { file_of(&request, folder) } else { None };
    let (status, kind, body) = match found.and_then(|path| Some((kind_of(&path), fs::read(path).ok()?))) {
        Some((kind, body)) => ("200 OK", kind, body),
        None => ("404 Not Found", "text/plain", b"not here\n".to_vec()),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)
}

/// The file that a request names, inside the folder.
fn file_of(request: &str, folder: &Path) -> Option<PathBuf> {
    let mut words = request.split_whitespace();
    let ("GET", Some(target)) = (words.next()?, words.next()) else { return None };
    let name = target.split(['?', '#']).next()?.strip_prefix('/')?;
    let name = if name.is_empty() { "index.html" } else { name };
    // Hidden files are the program's own: what is half written, and what trainings read.
    let shown =
        |c: Component<'_>| matches!(c, Component::Normal(n) if !n.as_encoded_bytes().starts_with(b"."));
    let inside = Path::new(name).components().all(shown);
    let path = folder.join(name);
    (inside && path.is_file()).then_some(path)
}

fn kind_of(path: &Path) -> &'static str {
    match path.extension().and_then(|e| e.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("json") => "application/json",
        Some("csv") => "text/csv; charset=utf-8",
        _ => "application/octet-stream",
    }
}
