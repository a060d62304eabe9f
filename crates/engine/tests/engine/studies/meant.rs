//! Which mode, and which maximum, is meant where the data do not say.

use super::{CAMPAIGN, ORIGIN, PLAN, parameter, run, tube};
use crate::common::folder::Folder;
use crate::common::tube::speed;
use rijke_engine::run::{AskedPoint, Run, Trusted, forecast, modes_at, with_points};
use rijke_study::Study;

#[test]
fn exact_a_growth_rate_alone_is_of_the_mode_of_its_label_or_of_the_only_one() {
    let c = speed();
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let grows = |length: f64| c * 0.85_f64.ln() / length;
    let both = format!("a,{:.12},0.1,{:.12},0.05\n", grows(1.0), 0.5 * c);
    let alone = |id: &str, length: f64| format!("{id},{:.12},0.1,,\n", grows(length));
    let found = |folder: &Folder| parameter(&run(&folder.0).unwrap()[0], "r");
    // The frequency of the other point tells which mode is meant.
    let of_label = tube("by-label", &format!("{head}{both}{}", alone("b", 0.8)));
    let [r, sd] = found(&of_label);
    assert!((r - 0.85).abs() < 2e-3 * sd && sd < 3e-4, "{r} +- {sd}");
    // Five modes in the region, no frequency; then one.
    let text = format!("{head}{}{}", alone("a", 1.0), alone("b", 0.8));
    let none = tube("by-nothing", &text);
    let said = run(&none.0).unwrap_err().to_string();
    assert!(said.contains("point a: a growth rate without a frequency") && said.contains("narrow"), "{said}");
    let narrow = format!("{}\n[search]\nfrequency_hz = [100, 300]\n", crate::common::tube::TUBE);
    let files = [
        ("rig.toml", narrow.as_str()),
        ("campaign.csv", CAMPAIGN),
        ("study.toml", PLAN),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", &text),
    ];
    let [r, sd] = found(&Folder::new("by-search", &files));
    assert!((r - 0.85).abs() < 2e-3 * sd && sd < 3e-4, "{r} +- {sd}");
}

/// A flame whose delay one length leaves open among aliases.
fn aliased(modes: &str) -> Folder {
    let rig = "name = \"flame\"\n[search]\ngrowth_rate = [-300, 300]\nfrequency_hz = [40, 300]\n[gas]\ntemperature = \"20 degC\"\n\
               [upstream]\ntype = \"closed\"\n[downstream]\ntype = \"constant\"\nmodulus = 0.98\nangle = 3.14159265\n[[element]]\n\
               name = \"cold\"\ntype = \"duct\"\nlength = 0.4\ndiameter = 0.05\n[[element]]\nname = \"flame\"\ntype = \"flame\"\n\
               gain = \"$n\"\ndelay = \"$tau\"\n[[element]]\nname = \"hot\"\ntype = \"duct\"\nlength = \"x\"\ndiameter = 0.05\n\
               temperature = 400\n[unknown.n]\nprior = { normal = { mean = 0.3, sd = 0.05 } }\n[unknown.tau]\nunit = \"s\"\n\
               prior = { normal = { mean = 0.006, sd = 0.008 } }\n";
    let campaign = "point,x [m],T_amb [degC]\na,0.5,20\n";
    let plan = format!("base = \"rig\"\n{PLAN}");
    let files = [
        ("rig.toml", rig),
        ("campaign.csv", campaign),
        ("study.toml", &plan),
        ("observations/observations.toml", ORIGIN),
        ("observations/modes.csv", modes),
    ];
    Folder::new("aliased", &files)
}

#[test]
fn behaviour_predictions_count_the_other_maxima() {
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],angular_frequency [rad/s],angular_frequency_sd [rad/s]\n";
    let study = Study::open(&aliased(&format!("{head}a,-20,1,750,1\n")).0).unwrap();
    // The truth is the model at the centre of its priors.
    let (_, spectrum, ..) = modes_at(&study, None, None, 0, [None; 2]).unwrap();
    let s = spectrum.modes.modes.iter().map(|m| m.s).min_by(|a, b| a.im.total_cmp(&b.im)).unwrap();
    let folder = aliased(&format!("{head}a,{:.9},0.3,{:.9},0.3\n", s.re, s.im));
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Checked).unwrap();
    run.next_stage().unwrap().unwrap();
    let (model, open) = (run.saved("s").unwrap(), run.saved_open("s").unwrap());
    assert!(!open.is_empty() && open.iter().all(|o| o.model.candidates == model.candidates));
    let asked: AskedPoint =
        [("x".to_owned(), 0.8)].into_iter().collect::<std::collections::BTreeMap<_, _>>().into();
    let (wider, places) = with_points(&study, &study.plan.stages[0].points, &[asked]).unwrap();
    let of = |model| forecast(&wider, &observations, model, &[], &places).unwrap().0.remove(0).growth_rate[0];
    let averaged =
        forecast(&wider, &observations, &model, &open, &places).unwrap().0.remove(0).averaged.unwrap();
    // Mean and deviation of the mixture, by hand.
    let all: Vec<(f64, f64)> =
        std::iter::once((1.0, of(&model))).chain(open.iter().map(|o| (o.odds, of(&o.model)))).collect();
    let total: f64 = all.iter().map(|a| a.0).sum();
    let mean: f64 = all.iter().map(|(odds, g)| odds * g).sum::<f64>() / total;
    let between = all.iter().map(|(odds, g)| odds * (g - mean).powi(2)).sum::<f64>() / total;
    assert!((averaged.growth_rate[0] - mean).abs() < 1e-6 * mean.abs(), "{averaged:?} {mean}");
    assert!(averaged.growth_rate[2] >= between.sqrt() && between.sqrt() > 3.0, "{averaged:?} {between}");
}

#[test]
fn oracle_errors_of_a_factor_count_once_for_each_setting() {
    let c = speed();
    let (r, length, of_length) = (0.85_f64, 1.0, 5e-3);
    let [growth, omega] = [c * r.ln() / length, std::f64::consts::PI * c / length];
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],angular_frequency [rad/s],angular_frequency_sd [rad/s]\n";
    let [of_growth, of_omega] = [0.1, 2.0];
    let row = |id: &str| format!("{id},{growth:.12},{of_growth},{omega:.12},{of_omega}\n");
    let found = |name: &str, campaign: &str| {
        let files = [
            ("rig.toml", crate::common::tube::TUBE),
            ("campaign.csv", campaign),
            ("study.toml", PLAN),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", &format!("{head}{}{}", row("a"), row("b"))),
        ];
        parameter(&run(&Folder::new(name, &files).0).unwrap()[0], "r")[1]
    };
    // s = c (ln r + i pi)/L: dg/dr = c/(L r), dg/dL = -g/L, dw/dL = -w/L. Information of r and of the error
    // of each length, whose prior is its standard deviation; r by Schur's complement.
    let slopes = [c / (length * r), -growth / length, -omega / length];
    let expected = |settings: f64, rows_of_each: f64| {
        let (g, w) = (rows_of_each / (of_growth * of_growth), rows_of_each / (of_omega * of_omega));
        let own = g * slopes[0].powi(2);
        let both = g * slopes[0] * slopes[1];
        let of_error = g * slopes[1].powi(2) + w * slopes[2].powi(2) + 1.0 / (of_length * of_length);
        (settings * (own - both * both / of_error) + 1.0 / 0.04_f64).sqrt().recip()
    };
    let head = "point,installation,x [m],x_sd [mm],T_amb [degC]\n";
    let apart = found("two-settings", &format!("{head}a,one,1,5,20\nb,two,1,5,20\n"));
    let alike = found("one-setting", &format!("{head}a,one,1,5,20\nb,one,1,5,20\n"));
    let known = found("known", "point,x [m],T_amb [degC]\na,1,20\nb,1,20\n");
    for (sd, right) in [(apart, expected(2.0, 1.0)), (alike, expected(1.0, 2.0))] {
        assert!((sd / right - 1.0).abs() < 5e-3, "{sd} {right}");
    }
    assert!(apart > 1.3 * known && alike > apart, "{apart} {alike} {known}");
}

#[test]
fn exact_readings_are_the_profile_of_the_gas() {
    // Sound takes the integral of 1/c through gas whose temperature is linear between the ends: modes of a
    // tube whose ends reflect -r are at pi over that time for high modes; the lowest within the reflection at
    // the slope. The same tube in the rig's file, with its temperatures there, has the same mode.
    let both = |name: &str, rig: &str, plan: &str, readings: Option<&str>| {
        // Nothing heats at the point that was not read.
        let campaign = "point,x [m],Q [W],T_amb [K]\na,1,50,300\nb,0.8,0,300\n";
        let plan = format!("{plan}{PLAN}");
        let mut files = vec![
            ("rig.toml", rig),
            ("campaign.csv", campaign),
            ("study.toml", plan.as_str()),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", "point,growth_rate [1/s],growth_rate_sd [1/s]\na,-50,1\n"),
        ];
        files.extend(readings.map(|text| ("observations/readings.csv", text)));
        let folder = Folder::new(name, &files);
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        let of =
            |k: usize| modes_at(&study, Some(&observations), None, k, [None; 2]).unwrap().1.modes.modes[0].s;
        [of(0), of(1)]
    };
    let measured = "base.measured = { offset_sd = 0.5 }\n";
    let readings = "point,at [m],temperature [degC],sd [K]\na,0,26.85,1\na,0.4,76.85,1\na,1,126.85,2\n";
    let [by_readings, unread] = both("readings", crate::common::tube::TUBE, measured, Some(readings));
    let [head, foot] = crate::common::tube::TUBE.split("[[element]]").collect::<Vec<_>>()[..] else {
        panic!()
    };
    let unknown = &foot[foot.find("[unknown").unwrap()..];
    let duct = |name: &str, length: &str, kelvin: &str| {
        format!(
            "[[element]]\nname = \"{name}\"\ntype = \"duct\"\nlength = \"{length}\"\ndiameter = 0.05\n\
             temperatures = {kelvin}\n"
        )
    };
    let ducts = duct("tube", "0.4 m", "[300, 350]") + &duct("rest", "x - 0.4", "[350, 400]");
    let warm = format!("{head}{ducts}{unknown}");
    let [in_file, _] = both("in-file", &warm, "base = \"rig\"\n", None);
    assert!((by_readings - in_file).norm() < 2e-4 * in_file.norm(), "{by_readings} {in_file}");
    let c = (1.4_f64 * 287.05 * 300.0).sqrt();
    assert!((unread.im - std::f64::consts::PI * c / 0.8).abs() < 1e-6 * c, "{unread}");
}
