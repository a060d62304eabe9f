//! What a page with sliders is given.

use super::{closed_form, two_points};
use crate::common::folder::Folder;
use crate::common::tube::speed;
use rijke_engine::run::{Run, Trusted, sliders};
use rijke_study::Study;

/// What a page is held against: eigenvalues of the tube at settings between its points, for other parameters.
#[test]
fn exact_settings_of_sliders_have_the_closed_form() {
    let given = |folder: &Folder| {
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        let record = run.next_stage().unwrap().unwrap();
        sliders(&study, &observations, &record, &run.saved("s").unwrap())
    };
    let found = given(&two_points("sliders", &[])).unwrap();
    let c = speed();
    let closed = |r: f64, x: f64| [c * r.ln() / x, std::f64::consts::PI * c / x];
    let same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9 * b[1];
    let r = found.parameters[0].value;
    for (node, x) in found.nodes.iter().zip([0.8, 1.0]) {
        assert!(same(node.modes[0].as_ref().unwrap().s, closed(r, x)), "{node:?}");
    }
    assert!(found.checks.len() == 1000 && found.tabulated.iter().all(|v| *v < 1e-9), "{:?}", found.tabulated);
    let [mut least, mut most] = [f64::INFINITY, 0.0_f64];
    for check in &found.checks {
        let [_, x, r, sigma, omega] = check[..] else { panic!("{check:?}") };
        assert!(same([sigma, omega], closed(r, x)), "{check:?}");
        (least, most) = (least.min(r), most.max(r));
    }
    let [low, high] = found.parameters[0].range;
    assert!(least < low + 0.01 * (high - low) && most > high - 0.01 * (high - low), "{least} {most}");

    // Three corners of a square.
    let campaign = "point,x [cm],y,T_amb [degC]\na,100,1,20\nb,80,1,20\nc,100,2,20\n";
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let row = |(id, x): (&str, f64)| format!("{id},{},0.1,{},0.05\n", closed_form(x)[0], closed_form(x)[1]);
    let modes: String = [("a", 1.0), ("b", 0.8), ("c", 1.0)].map(row).concat();
    let files = [("campaign.csv", campaign), ("observations/modes.csv", &(head.to_owned() + &modes))];
    let said = given(&two_points("sliders-corners", &files)).unwrap_err();
    assert!(said.contains("no grid of their factors"), "{said}");

    // A mode that was measured at one value of the factor only cannot be followed to the other.
    let row = |(id, mode, x): (&str, &str, f64)| {
        format!("{id},{mode},{},0.1,{},0.05\n", closed_form(x)[0], closed_form(x)[1])
    };
    let head = head.replace("point,", "point,mode,");
    let modes = head + &[("a", "open", 1.0), ("b", "closed", 0.8)].map(row).concat();
    let said = given(&two_points("sliders-apart", &[("observations/modes.csv", &modes)])).unwrap_err();
    assert!(said.contains("no mode was measured at neighbouring values"), "{said}");
}
