//! What a folder asks for that its laws, its points or its table do not hold for.

use super::{CAMPAIGN, PLAN, closed_form, run, two_points};
use crate::common::tube::TUBE;

/// The first error of opening a study and running it.
fn refused(name: &str, more: &[(&str, &str)]) -> String {
    run(&two_points(name, more).0).unwrap_err().to_string()
}

/// Network files refused such holes; studies extrapolated the fits, to 3.4 times no end correction.
#[test]
fn message_holes_that_no_law_holds_for_are_refused() {
    for (keys, said) in [
        ("type = \"orifice\"\ndiameter = 0.09\nthickness = 0.001", "`plate: diameter` is `0.09 m`"),
        ("type = \"side-hole\"\ndiameter = 0.06\nlength = 0.01", "`plate: diameter` is `0.06 m`"),
        (
            "type = \"orifice\"\ndiameter = 0.02\nthickness = 0.001\nporosity = 0.05",
            "of which one hole has 0.160",
        ),
    ] {
        let rig = format!("{TUBE}[[element]]\nname = \"plate\"\nat = \"0.4 m\"\n{keys}\n");
        let error = refused("holes", &[("rig.toml", &rig)]);
        assert!(error.contains(said), "{keys}: {error}");
    }
}

/// Before, all combinations of the candidates were none, and the stage trained one model without a word.
#[test]
fn message_among_names_a_candidate_of_every_role_that_competes() {
    let law = |id: &str, role: &str| {
        format!(
            "[[candidate]]\nid = \"{id}\"\nrole = \"{role}\"\nname = \"{id}\"\ncite = [\"own judgement\"]\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"0.001\"\n"
        )
    };
    let laws = [law("a", "mouth"), law("b", "mouth"), law("c", "foot")].concat();
    let plan = PLAN
        .replace("points = {}\n", "points = {}\ncompete = [\"mouth\", \"foot\"]\namong = [\"a\", \"b\"]\n");
    let error = refused("among", &[("candidates/laws.toml", &laws), ("study.toml", &plan)]);
    assert!(error.contains("`among` is `without a candidate of role foot`"), "{error}");
}

/// Two units of one number are one column too many.
#[test]
fn message_a_number_in_two_columns_is_refused() {
    let modes = "point,frequency [Hz],angular_frequency [rad/s],frequency_sd [Hz]\na,171.6,2000,0.05\n";
    let error = refused("columns", &[("observations/modes.csv", modes)]);
    assert!(error.contains("modes.csv, line 1") && error.contains("angular_frequency [rad/s]"), "{error}");
}

/// The first points of the campaign, with all of their modes; the others are not meant, though measured.
#[test]
fn exact_the_first_points_are_those_of_the_campaign() {
    let row = |id: &str, mode: &str, length: f64, n: f64| {
        let [sigma, hertz] = closed_form(length);
        format!("{id},{mode},{sigma:.12},0.1,{:.12},0.05\n", n * hertz)
    };
    let head = "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let campaign = format!("{CAMPAIGN}c,60,20\n");
    let plan = PLAN.replace("points = {}", "points = { first = 2 }");
    let trained = |name: &str, rows: &[String]| {
        let modes = format!("{head}{}", rows.concat());
        let files =
            [("observations/modes.csv", modes.as_str()), ("campaign.csv", &campaign), ("study.toml", &plan)];
        let folder = two_points(name, &files);
        let stage = run(&folder.0).unwrap().remove(0);
        let of = |m: &rijke_engine::run::MeasuredRecord| format!("{}{}", m.point, m.mode);
        let ln = stage.models[0].evidence.unwrap().ln_marginal;
        (stage.measured.iter().map(of).collect::<Vec<_>>(), ln)
    };
    let all = ["a", "b", "c"]
        .iter()
        .zip([1.0, 0.8, 0.6])
        .flat_map(|(id, length)| [row(id, "1", length, 1.0), row(id, "2", length, 2.0)]);
    let all: Vec<String> = all.collect();
    let (points, evidence) = trained("first", &all);
    assert_eq!(points, ["a1", "a2", "b1", "b2"]);
    // A table that is sorted by mode holds the same.
    let by_mode: Vec<String> = [0, 2, 4, 1, 3, 5].iter().map(|k| all[*k].clone()).collect();
    let (points, other) = trained("by-mode", &by_mode);
    assert_eq!(points, ["a1", "a2", "b1", "b2"]);
    assert_eq!(evidence.to_bits(), other.to_bits());
}

/// Both ends of one candidate were added up: |R| = 1.8 of ends that reflect 0.9.
#[test]
fn message_ends_that_one_candidate_describes_are_two() {
    let free = TUBE
        .replace("type = \"constant\"\nmodulus = \"$r\"\nangle = \"180 deg\"", "type = \"free\"")
        .replace("[unknown.r]\nprior = { normal = { mean = 0.9, sd = 0.2 } }\n", "");
    let law = "[[candidate]]\nid = \"mouth\"\nrole = \"mouth\"\nname = \"mouth\"\ncite = [\"own judgement\"]\n\
               parameters.q = { symbol = \"q\", unit = \"1\", prior = { normal = { mean = 0.9, sd = 0.2 } } }\n\
               [[candidate.effect]]\nacts_at = \"ends\"\nreflection = \"-q\"\n";
    let plan = PLAN.replace("points = {}\n", "points = {}\nwith = { mouth = \"mouth\" }\n");
    let folder =
        two_points("ends", &[("rig.toml", &free), ("candidates/mouth.toml", law), ("study.toml", &plan)]);
    let stages = run(&folder.0).unwrap();
    let remark = stages[0].models[0].remark.clone().unwrap_or_default();
    assert!(!remark.contains("feeds the modes"), "{remark}");
}

/// A screen's loss K rho U and waves in the mean flow are of a flow from upstream: with the other sign the
/// screen fed the mode as much as it should take from it, and the mean flow was left out.
#[test]
fn message_gas_that_flows_to_the_upstream_end_is_refused_where_it_matters() {
    let states = "{\"points\": {\"a\": {\"mass_flow\": -0.001, \"numbers\": {}, \"places\": [0.0, 1.0], \"temperature\": [293.15, 293.15], \
                  \"kinks\": [], \"errors\": []}}}";
    let flowing = "[[candidate]]\nid = \"flow\"\nrole = \"flow\"\nname = \"waves in the flow\"\ncite = [\"closed form\"]\n\
                   mean_flow = \"without-entropy\"\n";
    let base = "name = \"t\"\nbase = { states = { points = { points = [\"a\"] } } }";
    let plain = PLAN.replace("name = \"t\"", base);
    let in_flow = format!("{plain}[stage.with]\nflow = \"flow\"\n");
    let screen = format!("{TUBE}[[element]]\nname = \"net\"\ntype = \"screen\"\nat = \"0.4 m\"\nloss = 5\n");
    let of = |name: &str, plan: &str, rig: &str| {
        let files = [
            ("candidates/flow.toml", flowing),
            ("study.toml", plan),
            ("base/states.json", states),
            ("rig.toml", rig),
        ];
        run(&two_points(name, &files).0).map_err(|error| error.to_string())
    };
    let error = of("against-mean-flow", &in_flow, TUBE).unwrap_err();
    assert!(error.contains("a: the gas flows from downstream to upstream (-0.4"), "{error}");
    let error = of("against-screen", &plain, &screen).unwrap_err();
    assert!(error.contains("a law at net names the velocity"), "{error}");
    assert!(of("against-nothing", &plain, TUBE).is_ok());
}
