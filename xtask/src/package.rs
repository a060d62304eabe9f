//! `cargo xtask package`: packs every public crate as for a registry, and checks that the packed trees
//! compile against each other with nothing else of the repository at hand. Tests stay: they read its
//! fixtures.

use crate::workspace::{Outcome, cargo, root, succeed};
use std::{fmt::Write as _, fs, path::Path, process::Command};

/// Packs, unpacks and checks, all below `target/package`.
pub(crate) fn run() -> Outcome {
    let packages = root().join("target/package");
    let old = crates_in(&packages).unwrap_or_default();
    for name in old {
        fs::remove_file(packages.join(&name)).map_err(|error| format!("{name}: {error}"))?;
    }
    let pack = ["package", "--workspace", "--exclude", "xtask", "--no-verify", "--allow-dirty"];
    succeed(cargo().args(pack))?;
    let together = packages.join("together");
    let _ = fs::remove_dir_all(&together);
    fs::create_dir_all(&together).map_err(|error| format!("{}: {error}", together.display()))?;
    let packed = crates_in(&packages)?;
    for name in &packed {
        succeed(Command::new("tar").arg("-xzf").arg(packages.join(name)).arg("-C").arg(&together))?;
    }
    let manifest = workspace(&packed);
    let write = |name: &str, text: &[u8]| {
        fs::write(together.join(name), text).map_err(|error| format!("{name}: {error}"))
    };
    write("Cargo.toml", manifest.as_bytes())?;
    write(
        "Cargo.lock",
        &fs::read(root().join("Cargo.lock")).map_err(|error| format!("Cargo.lock: {error}"))?,
    )?;
    succeed(
        cargo()
            .current_dir(&together)
            .args(["check", "--workspace", "--bins", "--lib", "--examples", "--target-dir"])
            .arg(packages.join("check")),
    )?;
    println!("package: {} crates are complete", packed.len());
    Ok(())
}

/// Names of the packed crates in a folder, sorted.
fn crates_in(folder: &Path) -> Result<Vec<String>, String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".crate")).collect();
    names.sort();
    Ok(names)
}

/// A workspace of the unpacked crates, which find each other in the place of the registry.
fn workspace(packed: &[String]) -> String {
    let mut text = "[workspace]\nresolver = \"3\"\nmembers = [\"*-*\"]\n\n[patch.crates-io]\n".to_owned();
    for folder in packed.iter().filter_map(|name| name.strip_suffix(".crate")) {
        if let Some((name, _)) = folder.rsplit_once('-') {
            let _ = writeln!(text, "{name} = {{ path = \"{folder}\" }}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_crate_takes_the_place_of_its_like_in_the_registry() {
        let text = workspace(&["rijke-0.1.0.crate".into(), "rijke-rig-0.1.0.crate".into()]);
        let manifest: toml::Table = text.parse().unwrap_or_default();
        assert_eq!(manifest["patch"]["crates-io"]["rijke-rig"]["path"].as_str(), Some("rijke-rig-0.1.0"));
    }
}
