//! Parts that are in the rig and have no law.

use super::{PLAN, two_points};
use crate::common::tube::TUBE;
use rijke_engine::run::{Beyond, Run, Trusted, beyond};
use rijke_study::Study;

/// A gauze that a factor puts into the tube needs a law; one that is always there may be a place only.
#[test]
fn message_a_part_without_a_law_is_said_where_it_is_there() {
    let rig = |present: &str| {
        format!("{TUBE}[[element]]\nname = \"gauze\"\ntype = \"device\"\nat = \"0.4 m\"\n{present}")
    };
    let campaign = "point,x [cm],g,T_amb [degC]\na,100,1,20\nb,80,0,20\n";
    let law = "[[candidate]]\nid = \"drag\"\nrole = \"drag\"\nname = \"drag\"\ncite = [\"own judgement\"]\n\
               [[candidate.effect]]\nacts_at = \"gauze\"\nmu = \"0.1*rho*c\"\n";
    let opened = |name: &str, present: &str, more: &str| {
        let (rig, plan) = (rig(present), PLAN.replace("points = {}\n", &format!("points = {{}}\n{more}")));
        let files = [
            ("rig.toml", rig.as_str()),
            ("campaign.csv", campaign),
            ("candidates/drag.toml", law),
            ("study.toml", &plan),
        ];
        let folder = two_points(name, &files);
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        (study, observations)
    };
    let with = |name: &str, present: &str, more: &str| opened(name, present, more).0.unused().join("; ");
    let said = with("lawless", "present = \"g\"\n", "");
    assert!(
        said.contains("`gauze` is in the rig at 1 point of stage `s` (`g` is not 0), and no candidate of"),
        "{said}"
    );
    assert_eq!(with("lawful", "present = \"g\"\n", "compete = \"drag\"\n"), "");
    assert!(!with("place", "", "").contains("is in the rig"));
    // A model that was trained without it is asked for a point with it.
    let (study, observations) = opened("alone", "present = \"g\"\n", "");
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    run.next_stage().unwrap();
    let mut saved = run.saved("s").unwrap();
    saved.trained_on.retain(|id| id == "b");
    let said: Vec<String> = beyond(&study, &saved.trained_on, &[0], &[]).iter().map(Beyond::words).collect();
    assert!(said.iter().any(|s| s.starts_with("a: gauze is present (g = 1) but was absent")), "{said:?}");
}

/// An end that the rig leaves free reflects what a candidate says, and a stage without one has no models.
#[test]
fn message_a_stage_whose_models_leave_an_end_free_is_refused() {
    let free = TUBE.replace(
        "[downstream]\ntype = \"constant\"\nmodulus = \"$r\"\nangle = \"180 deg\"",
        "[downstream]\ntype = \"free\"",
    );
    assert_ne!(free, TUBE);
    let law = "[[candidate]]\nid = \"mouth\"\nrole = \"mouth\"\nname = \"mouth\"\ncite = [\"own judgement\"]\n\
               [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"-0.9\"\n";
    let opened = |name: &str, plan: &str| {
        let files = [("rig.toml", free.as_str()), ("candidates/mouth.toml", law), ("study.toml", plan)];
        Study::open(&two_points(name, &files).0)
    };
    let compete = PLAN.replace("points = {}\n", "points = {}\ncompete = \"mouth\"\n");
    assert!(opened("mouth", &compete).is_ok());
    let said = opened("no-mouth", PLAN).unwrap_err().to_string();
    assert!(said.contains("study.toml, line 2: stage `s`: the downstream end is \"free\""), "{said}");
    assert!(said.contains("name mouth in `compete` or `with`"), "{said}");
    // A later stage has it from the one on which it stands, and not without.
    let two = |more: &str| format!("{compete}[[stage]]\nid = \"later\"\npoints = {{}}\n{more}");
    assert!(opened("on-mouth", &two("on = \"s\"\n")).is_ok());
    let said = opened("not-on", &two("")).unwrap_err().to_string();
    assert!(said.contains("stage `later`: the downstream end"), "{said}");
}

/// A factor in a law counts as exact until the campaign states its errors; whether a part is there is no
/// reading, and a factor that no law uses does not matter.
#[test]
fn message_factors_without_stated_errors_are_said_to_count_as_exact() {
    let rig =
        format!("{TUBE}[[element]]\nname = \"gauze\"\ntype = \"device\"\nat = \"0.4 m\"\npresent = \"g\"\n");
    let law = |number: &str| {
        format!(
            "[[candidate]]\nid = \"drag\"\nrole = \"drag\"\nname = \"drag\"\ncite = [\"own judgement\"]\n\
             parameters.k = {{ symbol = \"k\", unit = \"1/W\", prior = {{ normal = {{ mean = 1e-3, sd = 1e-3 }} }} }}\n\
             [[candidate.effect]]\nacts_at = \"gauze\"\nmu = \"{number}\"\n"
        )
    };
    let said = |name: &str, columns: [&str; 3], number: &str| {
        let [head, a, b] = columns;
        let campaign = format!("point,x [cm],g,T_amb [degC]{head}\na,100,1,20{a}\nb,80,0,20{b}\n");
        let (law, plan) = (law(number), PLAN.replace("points = {}\n", "points = {}\ncompete = \"drag\"\n"));
        let files = [
            ("rig.toml", rig.as_str()),
            ("campaign.csv", &campaign),
            ("candidates/drag.toml", &law),
            ("study.toml", &plan),
        ];
        Study::open(&two_points(name, &files).0).unwrap().taken_as_exact()
    };
    let two = [",Q [W],q [W]", ",20,1", ",30,2"];
    let exact = said("exact", two, "k*(Q + g*q)*rho*c").unwrap();
    assert!(exact.starts_with("Q, q have no stated errors and count as exact: "), "{exact}");
    assert!(exact.contains("state Q_sd, q_sd in the campaign, and name them in `common_errors`"), "{exact}");
    let one = said("exact-one", two, "k*Q*g*rho*c").unwrap();
    assert!(one.starts_with("Q has no stated error and counts as exact: "), "{one}");
    let stated = [",Q [W],Q_sd [W]", ",20,1", ",30,1"];
    assert_eq!(said("exact-none", stated, "k*Q*g*rho*c"), None);
}
