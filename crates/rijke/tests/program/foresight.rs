//! What `rijke check` says of the models before anything is measured.

use crate::{copy, example, rijke, scratch, short};
use std::{fs, path::Path};

fn said(folder: &Path, command: &str) -> (Option<i32>, String) {
    let output = rijke(folder, &command.split(' ').collect::<Vec<_>>());
    let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    (output.status.code(), text)
}

#[test]
fn behaviour_a_plan_is_checked_before_anything_is_measured() {
    let folder = scratch("plan");
    short::write(&folder.join("rig"));
    let (code, text) = said(&folder, "check rig");
    assert_eq!(code, Some(0), "{text}");
    for part in [
        "17 operating points",
        "5 stages, 1 question",
        "nothing is measured yet",
        "The cold heater (4 operating points)",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
    // Prongs alone, three models of four points each; the losses of ends and wall are known from all of them.
    let line = text.lines().find(|line| line.trim_start().starts_with("prongs.6:")).unwrap();
    assert!(line.contains("alpha 0.") && line.contains("beta 0."), "{line}");
}

#[test]
fn behaviour_what_no_measurement_can_tell_is_named() {
    let folder = scratch("unidentified");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let (code, sound) = said(&folder, "check rig");
    assert!(code == Some(0) && !sound.contains("gauze.twice"), "{sound}");
    // Two factors of which the data see the product.
    let candidate = "[[candidate]]\nid = 'gauze.twice'\nrole = 'gauze'\nname = 'two factors'\ncite = ['none']\n\
        parameters.a = { symbol = 'a', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
        parameters.b = { symbol = 'b', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
        [[candidate.effect]]\nacts_at = 'gauze'\nmu = '0.005*a*b*rho*c'\n";
    fs::write(folder.join("rig/candidates/twice.toml"), candidate).unwrap();
    let (code, text) = said(&folder, "check rig");
    assert_eq!(code, Some(0), "{text}");
    let mut lines = text.lines().skip_while(|line| !line.contains("gauze.twice:"));
    let (widths, direction) = (lines.next().unwrap(), lines.next().unwrap());
    // Of a and b together the data say much, of their ratio nothing: each keeps 1/sqrt(2) of its width.
    assert!(widths.contains("a 0.71, b 0.71"), "{text}");
    assert!(
        direction.contains("not identified: ") && direction.contains("keeps 100 % of its prior width"),
        "{text}"
    );
}

/// A wall or an end that the file of the rig and a candidate both bring counts twice.
#[test]
fn message_what_rig_and_candidate_both_bring_is_named() {
    let folder = scratch("doubled");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let path = folder.join("rig/rig.toml");
    let sound = fs::read_to_string(&path).unwrap();
    assert!(!said(&folder, "check rig").1.contains("adds to that"));
    for (from, to, says) in [
        (
            "wall = \"none\"",
            "wall = \"kirchhoff\"",
            "at tube (`wall`): 2.0 times that together. Write wall = \"none\"",
        ),
        (
            "no flange; candidates say what it reflects\ntype = \"free\"",
            "\ntype = \"unflanged\"",
            "|R| is 1.99 together. Write type = \"free\"",
        ),
    ] {
        assert!(sound.contains(from), "{from}");
        fs::write(&path, sound.replacen(from, to, 1)).unwrap();
        let (code, text) = said(&folder, "check rig");
        assert!(code == Some(0) && text.contains(says), "{text}");
        assert_eq!(text.matches(says).count(), text.matches("adds to that").count(), "{text}");
    }
}

/// The unit of a coefficient is checked before a model is trained.
#[test]
fn message_a_formula_of_another_unit_is_refused() {
    let folder = scratch("wrong-unit");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let path = folder.join("rig/candidates/gauze.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("mu = \"drag*rho*c\""));
    fs::write(path, text.replacen("mu = \"drag*rho*c\"", "mu = \"drag*rho\"", 1)).unwrap();
    let (code, text) = said(&folder, "check rig");
    assert_eq!(code, Some(2), "{text}");
    for part in ["rig/candidates/gauze.toml, line 15", "`mu` at gauze", "kg m^-2 s^-1", "correct the formula"]
    {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

/// A candidate that cannot be trained is told with its reason; the others compete.
#[test]
fn behaviour_a_candidate_that_cannot_act_has_no_evidence() {
    let folder = scratch("no-evidence");
    copy(&example("quarter-wave"), &folder.join("rig"));
    let own = |id: &str, parameter: &str, law: &str| {
        format!(
            "[[candidate]]\nid = '{id}'\nrole = 'gauze'\nname = 'my own'\ncite = ['none']\n\
             parameters.{parameter} = {{ symbol = 'k', unit = '1', prior = {{ normal = {{ mean = 1.0, sd = 0.3 }} }} }}\n\
             [[candidate.effect]]\nacts_at = 'gauze'\nmu = '{law}'\n"
        )
    };
    let both = own("gauze.clash", "eta", "eta*rho*c") + &own("gauze.pole", "k_p", "k_p*rho*c*Q/Q");
    fs::write(folder.join("rig/candidates/own.toml"), both).unwrap();
    let (code, text) = said(&folder, "rank rig --until gauze --one-start");
    assert_eq!(code, Some(0), "{text}");
    let line = |id: &str| {
        text.lines().find(|line| line.trim_start().starts_with("no evidence") && line.contains(id)).unwrap()
    };
    let clash = line("gauze.clash: ");
    assert!(clash.contains("the parameter `eta`") && clash.contains("rename one"), "{clash}");
    assert!(line("gauze.pole: ").contains("cannot be evaluated"), "{text}");
    assert!(text.contains("<- goes on"), "{text}");
}
