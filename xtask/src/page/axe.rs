//! axe-core, which looks for barriers to readers with disabilities: one version of it, from the registry that
//! npm is set up with.

use crate::workspace::write;
use std::{fs, path::Path, process::Command};

/// The version that is looked with.
pub(super) const VERSION: &str = "4.14.1";

/// Digest of its archive, as npm states it.
const INTEGRITY: &str =
    "sha512-FHfa+lmNjQZfJz1q8wKqIDwC6DExcHt/pkjNQb09a3NPjCKg2rhu5qb2S4r76ASyFNNtuFooJpZe37OgudVGtQ==";

/// Puts it beside the harness; false, and said, where there is no npm.
pub(super) fn put_into(scratch: &Path) -> Result<bool, String> {
    let file = scratch.join("axe.min.js");
    let known = scratch.join("axe.version");
    if file.is_file() && fs::read_to_string(&known).is_ok_and(|text| text == VERSION) {
        return Ok(true);
    }
    // Of another version.
    let _ = fs::remove_file(&file);
    let package = format!("axe-core@{VERSION}");
    let pack = ["pack", "--silent", "--json", "--pack-destination", ".", &package];
    let Ok(output) = Command::new("npm").args(pack).current_dir(scratch).output() else {
        eprintln!("page: axe-core did not look at it, because there is no npm (Debian: apt-get install npm)");
        return Ok(false);
    };
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let remedy = "set up the registry of npm, or run it once where there is one: target/page keeps it";
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(format!("npm cannot get {package}: {said}{why}; {remedy}"));
    }
    let told: serde_json::Value =
        serde_json::from_str(&said).map_err(|e| format!("`npm pack --json` is not understood: {e}"))?;
    // A list, or by the name of the package.
    let packed = told.get(0).or_else(|| told.get("axe-core")).unwrap_or(&told);
    let (name, digest) = (packed["filename"].as_str().unwrap_or(""), packed["integrity"].as_str());
    if digest != Some(INTEGRITY) {
        return Err(format!(
            "{package} has the digest {digest:?}, not {INTEGRITY}: it is not what was tried"
        ));
    }
    let unpack = ["-xf", name, "--strip-components=1", "package/axe.min.js"];
    let unpacked = Command::new("tar").args(unpack).current_dir(scratch).status();
    if !(unpacked.is_ok_and(|status| status.success()) && file.is_file()) {
        return Err(format!("{name} cannot be unpacked by tar in {}", scratch.display()));
    }
    write(&known, VERSION)?;
    Ok(true)
}
