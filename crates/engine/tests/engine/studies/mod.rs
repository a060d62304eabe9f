//! Studies of rigs that have nothing in common with the paper's, from their files.

mod asked;
mod columns;
mod conjugated;
mod delayed;
mod handed_on;
mod installations;
mod judged;
mod lawless;
mod lengths;
mod meant;
mod misfit;
mod miswired;
mod parts;
mod questions;
mod sliders;
mod together;

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::EngineError;
use rijke_engine::run::{Run, StageRecord, Trusted, forecast, modes_at, verdicts, with_points};
use rijke_rig::DataKind;
use rijke_study::Study;
use std::collections::BTreeMap;
use std::path::Path;

fn run(folder: &Path) -> Result<Vec<StageRecord>, EngineError> {
    let study = Study::open(folder)?;
    let observations = study.observations()?;
    let mut run = Run::new(study, &observations, Trusted::Laplace)?;
    let mut stages = Vec::new();
    while let Some(stage) = run.next_stage()? {
        stages.push(stage);
    }
    Ok(stages)
}

fn parameter(stage: &StageRecord, name: &str) -> [f64; 2] {
    let model = stage.models.iter().find(|m| m.id == stage.chosen).unwrap();
    let found = model.parameters.iter().find(|p| p.name == name).unwrap();
    [found.value, found.sd]
}

const CAMPAIGN: &str = "point,x [cm],T_amb [degC]\na,100,20\nb,80,20\n";
const ORIGIN: &str = "kind = \"virtual\"\nsource = \"closed form\"\n";
const PLAN: &str = "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";

fn tube(name: &str, modes: &str) -> Folder {
    let files = [
        ("rig.toml", TUBE),
        ("campaign.csv", CAMPAIGN),
        ("study.toml", PLAN),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", modes),
    ];
    Folder::new(name, &files)
}

#[test]
fn exact_an_unknown_of_the_rig_file_is_found_from_frequencies_and_growth_rates() {
    let c = speed();
    let row = |id: &str, length: f64| {
        let (sigma, hertz) = (c * 0.85_f64.ln() / length, 0.5 * c / length);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let folder = tube("closed-form", &format!("{head}{}{}", row("a", 1.0), row("b", 0.8)));
    let stages = run(&folder.0).unwrap();
    // A model without candidates has a name too.
    assert_eq!(stages[0].chosen, "the rig");
    let [r, sd] = parameter(&stages[0], "r");
    // Each point tells r to 0.1 L r/c; the prior pulls by (0.05/0.2) sd/0.2.
    let expected = 0.1 * 0.85 / c / (1.0_f64 / 1.0 + 1.0 / 0.64).sqrt();
    assert!((sd / expected - 1.0).abs() < 1e-3, "{sd} {expected}");
    assert!((r - 0.85).abs() < 2e-3 * sd, "{r} +- {sd}");
}

#[test]
fn message_an_end_that_feeds_the_modes_is_said() {
    let c = speed();
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let said = |r: f64| {
        let row = |id: &str, length: f64| {
            format!("{id},{:.9},0.1,{:.9},0.05\n", c * r.ln() / length, 0.5 * c / length)
        };
        let folder = tube("feeding", &format!("{head}{}{}", row("a", 1.0), row("b", 0.8)));
        run(&folder.0).unwrap()[0].models[0].remark.clone().unwrap_or_default()
    };
    let remark = said(1.2);
    assert!(
        remark.contains(" is 1.200 at 1") && remark.contains("above 1: this end feeds the modes"),
        "{remark}"
    );
    assert!(!said(0.95).contains("feeds"), "{}", said(0.95));
}

#[test]
fn behaviour_growth_rates_or_frequencies_alone_are_enough() {
    let folder = tube("alone", "point,frequency [Hz],frequency_sd [Hz]\na,171.6,0.05\n");
    let stages = run(&folder.0).unwrap();
    // A frequency says nothing of losses that move the growth rate alone.
    let [_, sd] = parameter(&stages[0], "r");
    assert!(sd > 0.19, "{sd}");
}

#[test]
fn message_a_mode_that_the_rig_does_not_have_is_refused() {
    let folder = tube("other-mode", "point,frequency [Hz],frequency_sd [Hz]\na,265.0,0.05\n");
    let refused = run(&folder.0).unwrap_err().to_string();
    assert!(
        refused.contains(
            "265.0 Hz was measured, and the nearest mode of this model at the centre of its priors has"
        ),
        "{refused}"
    );
}

#[test]
fn message_two_modes_of_a_point_must_be_two() {
    let rows = "point,mode,frequency [Hz],frequency_sd [Hz]\na,1,171.6,0.05\na,2,174.0,0.05\n";
    let folder = tube("twins", rows);
    let refused = run(&folder.0).unwrap_err().to_string();
    assert!(refused.contains("174.0 Hz was measured, and the nearest mode of this model at the centre of its priors has 343.2 Hz"), "{refused}");
    // The second mode lies more than the distance between modes above both.
    let folder = tube("one-mode", &rows.replace("171.6", "160.0").replace("174.0", "165.0"));
    let refused = run(&folder.0).unwrap_err().to_string();
    assert!(refused.contains("160.0") && refused.contains("165.0") && refused.contains("171.6"), "{refused}");
}

/// Growth rate and frequency (Hz) of the first mode of a tube of r = 0.85, from s = c (ln r + i pi)/L.
fn closed_form(length: f64) -> [f64; 2] {
    let c = speed();
    [c * 0.85_f64.ln() / length, 0.5 * c / length]
}

fn two_points(name: &str, more: &[(&str, &str)]) -> Folder {
    let row = |id: &str, length: f64| {
        let [sigma, hertz] = closed_form(length);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = format!("{head}{}{}", row("a", 1.0), row("b", 0.8));
    let mut files = vec![
        ("rig.toml", TUBE),
        ("campaign.csv", CAMPAIGN),
        ("study.toml", PLAN),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", modes.as_str()),
    ];
    files.retain(|(name, _)| more.iter().all(|(other, _)| other != name));
    files.extend(more);
    Folder::new(name, &files)
}

#[test]
fn behaviour_rows_of_both_tables_count() {
    let row = |id: &str, length: f64| {
        let [sigma, hertz] = closed_form(length);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let pings = format!("{head}{}", row("b", 0.8));
    let by_hand = |id| format!("{head}{}", row(id, 1.0));
    let files = [("observations/pings.csv", pings.as_str()), ("observations/modes.csv", &by_hand("a"))];
    let stages = run(&two_points("both-tables", &files).0).unwrap();
    let points: Vec<&str> = stages[0].measured.iter().map(|m| m.point.as_str()).collect();
    assert_eq!(points, ["a", "b"]);
    let files = [("observations/pings.csv", pings.as_str()), ("observations/modes.csv", &by_hand("b"))];
    let refused = run(&two_points("twice", &files).0).unwrap_err().to_string();
    let said = "pings.csv, line 2: operating point `b` stands in modes.csv, too; delete one of the two rows";
    assert!(refused.contains(said), "{refused}");
}

/// The figure of a question, the saved model and the modes at a point are of one posterior.
#[test]
fn exact_predictions_are_one_posterior_and_the_closed_form() {
    let plan = format!("{PLAN}[[ask]]\nid = \"p\"\nask = \"prediction\"\nstage = \"s\"\n");
    let folder = two_points("one-posterior", &[("study.toml", &plan)]);
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    run.next_stage().unwrap();
    let answer = run.answer(&study.plan.questions[0]).unwrap();
    let frame = &answer.frames[0];
    let number = |row: usize, name: &str| frame.rows[row].values[frame.column(name).unwrap()].unwrap();
    let saved = run.saved("s").unwrap();
    let text = serde_json::to_string(&saved).unwrap();
    let saved = serde_json::from_str(&text).unwrap();
    let found = forecast(&study, &observations, &saved, &[], &[0, 1]).unwrap().0;
    for (k, f) in found.iter().enumerate() {
        let same = |a: f64, name: &str| (a / number(k, name) - 1.0).abs() < 1e-9;
        assert!(same(f.growth_rate[0], "predicted_growth_rate"));
        assert!(same(f.growth_rate[1], "predicted_growth_rate_sd"));
        assert!(same(f.growth_rate[2], "model_growth_rate_sd"));
        let (_, spectrum, ..) =
            modes_at(&study, Some(&observations), Some(&saved), k, [None, Some(250.0)]).unwrap();
        let first = spectrum.modes.modes[0].s;
        assert!((first.re - f.growth_rate[0]).abs() < 1e-6 && spectrum.details[0].budget.mismatch() < 1e-9);
    }
    // At a length that was not measured.
    let asked = [BTreeMap::from([("x".to_owned(), 0.9)])];
    let (wider, places) = with_points(&study, &study.plan.stages[0].points, &asked).unwrap();
    let between = forecast(&wider, &observations, &saved, &[], &places).unwrap().0.remove(0);
    let [sigma, hertz] = closed_form(0.9);
    assert!((between.growth_rate[0] - sigma).abs() < 0.05 * between.growth_rate[1], "{between:?}");
    assert!((between.angular_frequency[0] / std::f64::consts::TAU - hertz).abs() < 1e-3);
    assert!(between.unstable < 1e-9 && between.point == "x=0.9");
    let wrong = [BTreeMap::from([("y".to_owned(), 0.9)])];
    assert_eq!(
        with_points(&study, &study.plan.stages[0].points, &wrong).unwrap_err().to_string(),
        "there is no factor called `y`; the factors are x"
    );
}

/// What is not asked is that of the nearest point of the campaign, whatever else is asked beside it.
#[test]
fn behaviour_points_that_are_asked_together_do_not_lend_each_other_factors() {
    let campaign = "point,x [cm],y [1],T_amb [degC]\na,100,1,20\nb,80,2,20\n";
    let folder = two_points("asked-together", &[("campaign.csv", campaign)]);
    let study = Study::open(&folder.0).unwrap();
    let of = |all: &[(&str, f64)]| -> BTreeMap<String, f64> {
        all.iter().map(|(name, v)| ((*name).to_owned(), *v)).collect()
    };
    let asked = [of(&[("x", 0.9), ("y", 5.0)]), of(&[("x", 0.81)]), of(&[("x", 0.9)])];
    let every = &study.plan.stages[0].points;
    let (wider, places) = with_points(&study, every, &asked).unwrap();
    let y = |k: usize| wider.campaign.points[places[k]].factors[1];
    assert_eq!([y(0), y(1)], [5.0, 2.0]);
    let (alone, place) = with_points(&study, every, &asked[2..]).unwrap();
    assert_eq!(y(2), alone.campaign.points[place[0]].factors[1]);
}

/// `noise.installation` says what points of one installation share; without errors that are shared nothing
/// counts it.
#[test]
fn message_noise_of_installations_without_effect_is_said() {
    let with = |more: &str| {
        let plan = format!("{PLAN}installation = [0.5, 6.0]\n")
            .replace("points = {}\n", &format!("points = {{}}\n{more}"));
        let folder = two_points(&format!("idle-{}", more.len()), &[("study.toml", &plan)]);
        Study::open(&folder.0).unwrap().unused()
    };
    let said = with("");
    assert!(
        said.len() == 1 && said[0].contains("`noise.installation` of stage `s` has no effect"),
        "{said:?}"
    );
    assert!(with("base_errors = true\n").is_empty());
}

#[test]
fn message_damaged_base_states_name_line_and_point() {
    let plan = PLAN.replace("name = \"t\"", "name = \"t\"\nbase = \"states\"");
    let state = "{\"mass_flow\": 0.0, \"numbers\": {}, \"places\": [0.0, 1.0], \"temperature\": [293.15, 293.15], \
                 \"kinks\": [], \"errors\": []}";
    let states = format!("{{\"points\": {{\n\"a\": {state},\n\"b\":\n{state}}}}}");
    let folder = two_points("damaged-states", &[("study.toml", &plan)]);
    let file = folder.0.join("base/states.json");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let refused = |text: &str| {
        std::fs::write(&file, text).unwrap();
        Run::new(study.clone(), &observations, Trusted::Laplace).err().unwrap().to_string()
    };
    let (first, second) = states.split_at(states.find("\"b\"").unwrap());
    for (from, to, says) in [
        ("[293.15, 293.15]", "[293.15, -3.0]", "-3.0000 K"),
        ("[293.15, 293.15]", "[293.15]", "2 places"),
        ("\"mass_flow\": 0.0", "\"mass_flow\": \"none\"", "invalid type: string"),
        ("\"numbers\": {}", "\"numbers\": {\"U_h\": 1.0}", "called `U_h`"),
    ] {
        let said = refused(&(first.to_owned() + &second.replace(from, to)));
        let place = "states.json, line 3: operating point `b`: ";
        assert!(said.contains(place) && said.contains(says), "{said}");
    }
    let said = refused(&states[..states.len() - 4]);
    assert!(said.contains("states.json, line 4") && said.contains("column"), "{said}");
}

/// In a uniform flow of Mach number M a tube with |R| = r at both ends has s = c (1 - M^2) (ln r + i pi)/L.
#[test]
fn exact_waves_in_a_mean_flow_have_the_closed_form() {
    let flowing = "[[candidate]]\nid = \"flow\"\nrole = \"flow\"\nname = \"waves in the flow\"\ncite = [\"closed form\"]\n\
                   mean_flow = \"without-entropy\"\n";
    let plan = format!(
        "{}[stage.with]\nflow = \"flow\"\n",
        PLAN.replace("name = \"t\"", "name = \"t\"\nbase = { states = { points = { points = [\"a\"] } } }")
    );
    // 0.1 kg/s through 50 mm at 1.2 kg/m^3 is M = 0.12.
    let states = "{\"points\": {\"a\": {\"mass_flow\": 0.1, \"numbers\": {}, \"places\": [0.0, 1.0], \"temperature\": [293.15, 293.15], \
                  \"kinks\": [], \"errors\": []}}}";
    let folder = two_points(
        "mean-flow",
        &[("candidates/flow.toml", flowing), ("study.toml", &plan), ("base/states.json", states)],
    );
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let s = |k: usize| {
        modes_at(&study, Some(&observations), None, k, [None, Some(250.0)]).unwrap().1.modes.modes[0].s
    };
    let c = speed();
    let density = 101_325.0 / (287.05 * 293.15);
    let mach = 0.1 / (density * std::f64::consts::PI * 0.025 * 0.025) / c;
    let expected = |length: f64, mach: f64| c * (1.0 - mach * mach) * 0.9_f64.ln() / length;
    assert!(mach > 0.1 && (s(0).re - expected(1.0, mach)).abs() < 1e-6, "{} {}", s(0), expected(1.0, mach));
    assert!((s(1).re - expected(0.8, 0.0)).abs() < 1e-6, "nothing flows at b: {}", s(1));
}

#[test]
fn behaviour_a_point_whose_gas_is_not_known_is_left_out_and_said() {
    let plan = PLAN.replace("name = \"t\"", "name = \"t\"\nbase = \"states\"");
    let states = "{\"points\": {\"a\": {\"mass_flow\": 0.0, \"numbers\": {}, \"places\": [0.0, 1.0], \"temperature\": [293.15, 293.15], \
                  \"kinks\": [], \"errors\": []}}}";
    let folder = two_points("left-out", &[("study.toml", &plan), ("base/states.json", states)]);
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    assert_eq!(run.left_out, ["b"]);
    assert!(run.next_stage().unwrap().unwrap().measured.iter().all(|m| m.point == "a"));
    // Without any state there is nothing to stand on.
    std::fs::remove_file(folder.0.join("base/states.json")).unwrap();
    let refused = Run::new(study, &observations, Trusted::Laplace).err().unwrap().to_string();
    assert!(
        refused.contains("base/states.json has no state of it. `rijke flow DIR --out DIR/base` infers it"),
        "{refused}"
    );
}

#[test]
fn exact_claims_are_judged_by_their_numbers_and_refused_with_their_line() {
    let paper = "source = \"us\"\n[[claim]]\nof = \"s\"\nstatement = \"r is near 0.85\"\nlet.r = { column = \"r\" }\nlet.sd = { column = \"r_sd\" }\n\
                 holds = \"0.85 - 3*sd < r < 0.85 + 3*sd\"\n[[claim]]\nof = \"s\"\nstatement = \"r is above 1\"\nlet.r = { column = \"r\" }\n\
                 holds = \"r > 1\"\nexplanation = \"the virtual end is shorter\"\n[[claim]]\nof = \"s\"\nstatement = \"of what is not there nothing is said\"\nlet.q = { column = \"q\" }\nholds = \"q > 1\"\n";
    let folder = two_points("claims", &[("paper.toml", paper)]);
    let stages = run(&folder.0).unwrap();
    let study = Study::open(&folder.0).unwrap();
    let judged = |kind: DataKind| verdicts(&study.claims, kind, &stages, &[]);
    let holds: Vec<bool> = judged(DataKind::Virtual).iter().map(|v| v.holds).collect();
    assert_eq!(holds, [true, false]);
    // What is known of the laboratory explains nothing that was measured.
    let explained = |kind: DataKind| judged(kind)[1].explanation.clone();
    assert_eq!(explained(DataKind::Virtual).as_deref(), Some("the virtual end is shorter"));
    assert_eq!(explained(DataKind::Measured), None);
    let refused = |from: &str, to: &str| {
        std::fs::write(folder.0.join("paper.toml"), paper.replacen(from, to, 1)).unwrap();
        Study::open(&folder.0).unwrap_err().to_string()
    };
    assert!(
        refused("of = \"s\"", "of = \"z\"")
            .contains("line 2: there is no stage, question or map called `z`; known: s")
    );
    assert!(refused("\"r > 1\"", "\"r\"").contains("joined by < or by >"));
    assert!(refused("let.sd", "let.exp").contains("cannot be the name of a number"));
}

/// The data come from an integrator of its own, with a truth that no candidate equals (truth.toml of the
/// example): Lighthill's delay with a spread over the wires, and King's law in the form of Collis and
/// Williams.
#[test]
fn lab_quarter_wave_tube_finds_the_form_of_its_law() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    let stages = run(&folder).unwrap();
    let heat = stages.last().unwrap();
    // The truth has the mean flow.
    assert_eq!(
        (heat.measured.len(), heat.chosen.as_str()),
        (48, "heat.king-lighthill + mean-flow.without-entropy")
    );
    let total =
        |id: &str| heat.models.iter().find(|m| m.id == id).and_then(|m| m.evidence).unwrap().ln_marginal;
    assert!(total(&heat.chosen) > total("heat.king-lighthill") + 3.0);
    assert!(total("heat.king-lighthill") > total("heat.king") + 20.0);
    assert!(total("heat.king") > total("heat.constant") + 20.0);
}
