//! One case: a copy of a seed, changed in a few places.

use super::{
    binary,
    folder::{copy, linked},
    seeds::Seed,
    stream::Stream,
    text,
};
use crate::workspace::files;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// A case as it was made.
pub(super) struct Case<'a> {
    /// The seed it was made of.
    pub(super) seed: &'a Seed,
    /// Arguments of the program.
    pub(super) words: Vec<&'a str>,
    /// What was changed.
    pub(super) told: String,
}

/// Makes case `number` of the seeds of one kind in `folder`, which is replaced.
pub(super) fn make<'a>(
    seeds: &[&'a Seed],
    seed: u64,
    number: u64,
    folder: &Path,
) -> Result<Case<'a>, String> {
    let told = |e: io::Error| format!("{}: {e}", folder.display());
    let kind = seeds.first().map_or("", |s| s.kind);
    let mut stream = Stream::new(seed, &format!("{kind}/{number}"));
    let from = *stream.pick(seeds).ok_or("no seed")?;
    let command = stream.pick(&from.commands).map_or("", String::as_str);
    let _ = fs::remove_dir_all(folder);
    copy(&from.folder, folder).map_err(told)?;
    let mut all = files(folder).map_err(told)?;
    all.retain(|f| from.changed.is_empty() || from.changed.iter().any(|c| f.starts_with(c)));
    let times = [1, 1, 1, 1, 1, 1, 2, 2, 3, 4][stream.below(10)];
    let mut done = Vec::new();
    for _ in 0..times {
        done.push(change(folder, &all, times == 1, &mut stream).map_err(told)?);
    }
    Ok(Case { seed: from, words: command.split(' ').collect(), told: done.join("; ") })
}

/// Changes one file or, where it is the only change, which files there are.
fn change(folder: &Path, all: &[PathBuf], only: bool, stream: &mut Stream) -> io::Result<String> {
    let (Some(name), Some(other)) = (stream.pick(all), stream.pick(all)) else {
        return Ok("nothing to change".into());
    };
    let path = folder.join(name);
    let Ok(bytes) = fs::read(&path) else { return Ok(format!("{}: gone", name.display())) };
    let large = linked(name) || bytes.len() > 300_000;
    let (new, told) = match stream.below(100) {
        0..5 if only => return gone(&path, name, stream),
        5..10 if only => {
            (fs::read(folder.join(other)).unwrap_or_default(), format!("is {}", other.display()))
        }
        _ if large => binary::change(&bytes, stream),
        _ => text::change(&bytes, stream),
    };
    // Not written over: the file may be a link.
    fs::remove_file(&path)?;
    fs::write(&path, new)?;
    Ok(format!("{}: {told}", name.display()))
}

fn gone(path: &Path, name: &Path, stream: &mut Stream) -> io::Result<String> {
    fs::remove_file(path)?;
    if stream.chance(70) {
        return Ok(format!("{}: left out", name.display()));
    }
    fs::create_dir(path)?;
    Ok(format!("{}: a folder", name.display()))
}

#[cfg(test)]
mod tests {
    use super::make;
    use crate::mangle::seeds::Seed;
    use crate::workspace::files;
    use std::{fs, path::Path, path::PathBuf};

    /// Every file of a folder, and what it holds.
    fn content(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        files(folder).unwrap().into_iter().map(|f| (f.clone(), fs::read(folder.join(f)).unwrap())).collect()
    }

    #[test]
    fn exact_a_case_is_repeatable_and_leaves_its_seed_alone() {
        let place = std::env::temp_dir().join(format!("xtask-case-{}", std::process::id()));
        let seed = Seed::new("kind", "seed", place.join("seed"), &["check .", "rank ."]);
        fs::create_dir_all(seed.folder.join("deep")).unwrap();
        fs::write(seed.folder.join("a.toml"), "# a tube\nlength = 0.8\ndiameter = \"50 mm\"\n").unwrap();
        fs::write(seed.folder.join("deep/b.csv"), "point,x [m]\na,1\nb,2\n").unwrap();
        fs::write(seed.folder.join("c.wav"), [7; 600]).unwrap();
        let before = content(&seed.folder);
        let seeds = [&seed];
        let mut different = 0;
        for number in 0..200 {
            let [one, two] = ["one", "two"].map(|f| place.join(f));
            let [a, b] = [&one, &two].map(|f| make(&seeds, 1, number, f).unwrap());
            assert_eq!((&a.told, &a.words, content(&one)), (&b.told, &b.words, content(&two)));
            different += usize::from(content(&one) != before);
            // Another seed, another case.
            let other = make(&seeds, 2, number, &two).unwrap();
            different += usize::from(other.told != a.told);
        }
        assert!(different > 390, "{different} of 400");
        assert!(content(&seed.folder) == before);
        fs::remove_dir_all(place).unwrap();
    }
}
