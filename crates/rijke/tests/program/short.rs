//! A short campaign on the rig of Juniper & Yoko 2022 as a study of five stages, some seconds from records to
//! page.

use crate::{copy, example, rijke};
use std::{fs, path::Path};

/// Rows of the campaign, for the laboratory: prongs, heater, thermocouples, and the hot heater.
const ROWS: [(&str, bool, bool, u32); 4] =
    [("C3", false, false, 0), ("C1", true, false, 0), ("H0", true, true, 0), ("H50", true, true, 50)];

/// Positions in cm.
const POSITIONS: [u32; 4] = [25, 45, 60, 75];

const STUDY: &str = r#"name = "A short campaign"
question = "By which law does the heater drive the tube?"
[base.states]
points = { where = { Q_h = { above = 0 } } }

[[stage]]
id = "empty-tube"
title = "The empty tube"
points = { where = { X_h = "absent" } }
with = { wall = "wall.rayleigh", ends = "ends.calibrated" }
channels = true
[stage.noise]
growth_rate = 0.1
angular_frequency = 1.0
pressure = { median = 1e-3, ln_sd = 1.0 }
varying = [{ parameter = "k_r", sd = 7e-5 }, { parameter = "k_i", sd = 0.0031 }]

[[stage]]
id = "prongs"
title = "The prongs"
points = { where = { X_h = "given", heater = false } }
on = "empty-tube"
compete = "prongs"
among = ["prongs.1", "prongs.5", "prongs.6"]

[[stage]]
id = "heater"
title = "The cold heater"
points = { where = { Q_h = 0, heater = true, thermometers = false } }
on = "prongs"
compete = "heater"

[[stage]]
id = "thermocouples"
title = "The thermocouples"
points = { where = { Q_h = 0, thermometers = true } }
on = "heater"
with = { thermocouples = "thermocouples.paper" }

[[stage]]
id = "heat-release"
title = "The hot heater"
points = { where = { Q_h = { above = 0 } } }
on = "thermocouples"
compete = "heat-release"
among = ["heat-release.1", "heat-release.2", "heat-release.8"]
base_errors = true
[stage.noise]
measured = false

[[ask]]
id = "cold"
title = "All cold points"
ask = "prediction"
stage = "thermocouples"
points = { where = { Q_h = 0 } }
over = "X_h"
"#;

/// The whole study of the paper, without data that somebody may have put there.
pub(crate) fn paper(folder: &Path) {
    let from = example("juniper-yoko-2022");
    copy(&from.join("candidates"), &folder.join("candidates"));
    for file in ["rig.toml", "campaign.csv", "study.toml", "paper.toml"] {
        fs::copy(from.join(file), folder.join(file)).unwrap();
    }
}

/// The short study without data.
pub(crate) fn write(folder: &Path) {
    paper(folder);
    fs::remove_file(folder.join("paper.toml")).unwrap();
    let mut campaign =
        "point,row,X_h [m],heater,thermometers,Q_h [W],installation\nC3-E,C3,,0,0,0,empty\n".to_owned();
    for (row, heater, thermocouples, power) in ROWS {
        for x in POSITIONS {
            let (heater, thermocouples) = (u8::from(heater), u8::from(thermocouples));
            let place = f64::from(x) / 100.0;
            campaign += &format!("{row}-{x},{row},{place},{heater},{thermocouples},{power},{row}-{x}\n");
        }
    }
    fs::write(folder.join("campaign.csv"), campaign).unwrap();
    fs::write(folder.join("study.toml"), STUDY).unwrap();
}

/// The study with two records of each kind for every point.
pub(crate) fn record(folder: &Path) {
    write(folder);
    let row = |(id, heater, thermocouples, power): (&str, bool, bool, u32)| {
        let empty = id == "C3";
        format!(
            "[[row]]\nid = \"{id}\"\nplates = {heater}\nthermometers = {thermocouples}\npower_w = {power}.0\nrepeats = 2\n\
             empty_tube = {empty}\npositions_cm = {POSITIONS:?}\n"
        )
    };
    fs::write(folder.join("lab.toml"), format!("name = \"short\"\n{}", ROWS.map(row).concat())).unwrap();
    let output = rijke(folder, &["lab", "--campaign", "lab.toml", "--out", "records"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
