//! Every subcommand explains itself.

use crate::{rijke, scratch};

fn subcommands() -> Vec<String> {
    let help = String::from_utf8(rijke(&scratch("help"), &["--help"]).stdout).unwrap();
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let (list, _) = list.split_once("\n\n").unwrap();
    let names = list.lines().filter_map(|l| l.split_whitespace().next());
    names.filter(|n| *n != "help").map(String::from).collect()
}

#[test]
fn exact_every_subcommand_has_help_with_an_example() {
    let names = subcommands();
    assert!(names.iter().any(|n| n == "report"), "{names:?}");
    for name in names {
        let output = rijke(&scratch("help"), &[&name, "--help"]);
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && help.contains("Example"), "rijke {name} --help:\n{help}");
        assert!(help.contains(&format!("rijke {name}")), "the example of {name} does not show it:\n{help}");
    }
}

#[test]
fn exact_wrong_options_end_with_2() {
    for arguments in [&["no-such-command"][..], &["report", "--no-such-option"], &["report"]] {
        let output = rijke(&scratch("wrong-options"), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty(), "{arguments:?}");
    }
}
