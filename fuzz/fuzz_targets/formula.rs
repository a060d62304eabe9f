//! Any text as a formula: read it, and evaluate it with derivatives where it is one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_candidates::{Catalogue, Here, Surroundings};
use rijke_numerics::{C64, JetSpace, Order};
use rijke_rig::{OperatingPoint, Rig};

fuzz_target!(|text: &str| {
    if text.contains('\'') || text.contains(|c: char| c.is_control()) {
        return;
    }
    let file = format!(
        "[[candidate]]\nid = 'a'\nrole = 'heater'\nname = 'a'\ncite = ['a']\n\
         parameters.k1 = {{ symbol = 'k', unit = '1', prior = {{ normal = {{ mean = 1.0, sd = 1.0 }} }} }}\n\
         [[candidate.effect]]\nacts_at = 'heater'\neu = '{text}'\n"
    );
    let Ok(catalogue) = Catalogue::from_toml(&file, "candidates.toml") else { return };
    let rig = Rig::juniper_yoko_2022();
    let point = OperatingPoint {
        id: "H".into(),
        row: "H".into(),
        position: Some(0.25),
        heater: true,
        thermocouples: false,
        power: 100.0,
        repeats: 1,
    };
    let around = Surroundings::new(&rig, &point, &rig.gas.at(400.0, rig.pressure), 293.0, [0.3, 0.3]);
    let space = JetSpace::new(2, Order::Second);
    let (s, k1) = (space.seed(1, C64::new(-10.0, 1000.0)), space.seed(0, C64::ONE));
    let wall = [space.real(1.0), space.real(1.0)];
    let here = Here {
        space,
        surroundings: &around,
        s: &s,
        wall: Some([&wall[0], &wall[1]]),
        levine_schwinger: None,
    };
    for effect in catalogue.candidates().iter().flat_map(|c| &c.effects) {
        let _ = effect.law.evaluate(&here, std::slice::from_ref(&k1));
    }
});
