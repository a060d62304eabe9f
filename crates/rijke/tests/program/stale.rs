//! Results of files that are others now.

use crate::{copy, example, rijke, scratch};
use std::fs;

#[test]
fn message_results_of_other_files_are_said() {
    let folder = scratch("stale");
    copy(&example("quarter-wave"), &folder.join("study"));
    let run = |words: &str| {
        let output = rijke(&folder, &words.split(' ').collect::<Vec<_>>());
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (code, said) = run("rank study --until tube --one-start");
    assert!(code == Some(0) && !said.contains("changed since"), "{said}");
    let (code, said) = run("predict study --stage tube");
    assert!(code == Some(0) && !said.contains("changed since"), "{said}");
    let rig = folder.join("study/rig.toml");
    let text = fs::read_to_string(&rig).unwrap();
    fs::write(&rig, format!("{text}\n# measured again\n")).unwrap();
    let (code, said) = run("predict study --stage tube");
    assert!(
        code == Some(0) && said.contains("results is not of these files: rig.toml changed since"),
        "{said}"
    );
}
