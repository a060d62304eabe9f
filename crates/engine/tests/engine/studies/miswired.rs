//! Microphones that were exchanged, or have the other polarity, at all points.

use super::{CAMPAIGN, ORIGIN, run};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_numerics::C64;
use std::f64::consts::PI;

/// Places of the microphones, m.
const AT: [f64; 4] = [0.15, 0.3, 0.5, 0.7];
/// Reflection coefficient, with the other sign, of both ends.
const R: f64 = 0.85;

/// What is said of the model if `wrong` makes of the pressures at all microphones what was recorded.
fn said(name: &str, reference: usize, wrong: impl Fn(&mut [C64; 4])) -> String {
    let mut head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]".to_owned();
    let others = || (0..4).filter(|m| *m != reference);
    others().for_each(|m| head += &format!(",m{m}_re,m{m}_re_sd,m{m}_im,m{m}_im_sd"));
    let mut modes = head + "\n";
    for (point, length) in [("a", 1.0), ("b", 0.8)] {
        let k = C64::new(R.ln(), PI) / length;
        let mut all = AT.map(|x| (k * x).exp() - R * (-k * x).exp());
        wrong(&mut all);
        let s = speed() * k;
        modes += &format!("{point},{:.6},0.5,{:.6},0.05", s.re, s.im / (2.0 * PI));
        for p in others().map(|m| all[m] / all[reference]) {
            modes += &format!(",{:.6},2e-3,{:.6},2e-3", p.re, p.im);
        }
        modes += "\n";
    }
    let microphones = format!(
        "[microphones]\nat = {AT:?}\nnames = [\"m0\", \"m1\", \"m2\", \"m3\"]\nreference = \"m{reference}\"\n[upstream]"
    );
    let plan = "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n";
    let files = [
        ("rig.toml", TUBE.replace("[upstream]", &microphones)),
        ("campaign.csv", CAMPAIGN.to_owned()),
        ("study.toml", plan.to_owned()),
        ("observations/observations.toml", ORIGIN.to_owned()),
        ("observations/modes.csv", modes),
    ];
    let folder = Folder::new(name, &files.each_ref().map(|(name, text)| (*name, text.as_str())));
    run(&folder.0).unwrap()[0].models[0].remark.clone().unwrap_or_default()
}

#[test]
fn message_exchanged_and_reversed_microphones_are_named() {
    let right = said("wired", 0, |_| ());
    assert!(!right.contains("microphone"), "{right}");
    for (k, reference, pair) in [(0, 0, [1, 2]), (1, 1, [1, 3]), (2, 2, [0, 1])] {
        let found = said(&format!("exchanged-{k}"), reference, |all| all.swap(pair[0], pair[1]));
        let words = format!(
            "with microphones m{} and m{} exchanged at all points this model gains",
            pair[0], pair[1]
        );
        assert!(found.contains(&words), "{found}");
    }
    for (k, reference, turned) in [(0, 0, 3), (1, 2, 2)] {
        let found = said(&format!("reversed-{k}"), reference, |all| all[turned] = -all[turned]);
        let words = format!("with the sign of microphone m{turned} turned at all points this model gains");
        assert!(found.contains(&words), "{found}");
    }
}
