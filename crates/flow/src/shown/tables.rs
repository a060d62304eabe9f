//! Tables of what was found: a head, then rows.

use crate::infer::report::{PowerReport, RunReport, UnknownReport};

/// The unknowns of every run with two standard deviations on either side.
#[must_use]
pub fn unknowns_table(runs: &[RunReport]) -> Vec<Vec<String>> {
    let head = ["heater [m]", "unknown", "unit", "value", "low_2sd", "high_2sd", "posterior_over_prior_sd"];
    let row = |run: &RunReport, u: &UnknownReport| {
        let [at, value, low, high, shrinkage] =
            [run.heater_m, u.value, u.low, u.high, u.shrinkage].map(|v| v.to_string());
        vec![at, u.name.clone(), u.unit.clone(), value, low, high, shrinkage]
    };
    let rows = runs.iter().flat_map(|run| run.unknowns.iter().map(move |u| row(run, u)));
    std::iter::once(head.map(str::to_owned).to_vec()).chain(rows).collect()
}

/// The velocity at the heater and the highest speed of sound along the tube, at every power of every run.
#[must_use]
pub fn velocity_table(runs: &[RunReport]) -> Vec<Vec<String>> {
    let head = [
        "heater [m]",
        "power [W]",
        "T_amb [K]",
        "velocity [m/s]",
        "velocity_sd [m/s]",
        "highest_sound_speed [m/s]",
        "highest_sound_speed_sd [m/s]",
    ];
    let row = |run: &RunReport, p: &PowerReport| {
        let hottest = p.profile.iter().max_by(|a, b| a.sound_speed.total_cmp(&b.sound_speed));
        let (c, sd) = hottest.map_or((f64::NAN, f64::NAN), |h| (h.sound_speed, h.sound_speed_sd));
        let numbers = [run.heater_m, p.power_w, p.ambient_k, p.heater_velocity, p.heater_velocity_sd, c, sd];
        numbers.map(|v| v.to_string()).to_vec()
    };
    let rows = runs.iter().flat_map(|run| run.powers.iter().map(move |p| row(run, p)));
    std::iter::once(head.map(str::to_owned).to_vec()).chain(rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::infer::report::PointReport;

    #[test]
    fn exact_the_table_of_velocities_has_the_fastest_sound_of_each_power() {
        let at =
            |x: f64, sound_speed: f64| PointReport { x, temperature: 300.0, sound_speed, sound_speed_sd: x };
        let power = PowerReport {
            point: "a".into(),
            power_w: 30.0,
            ambient_k: 293.0,
            heater_velocity: 0.5,
            heater_velocity_sd: 0.01,
            profile: vec![at(0.1, 343.0), at(0.4, 360.5), at(0.9, 350.0)],
            residuals: Vec::new(),
        };
        let run = RunReport { heater_m: 0.25, powers: vec![power], ..RunReport::empty() };
        let table = velocity_table(&[run.clone(), run]);
        assert_eq!(table.len(), 3);
        assert_eq!(table[2], ["0.25", "30", "293", "0.5", "0.01", "360.5", "0.4"]);
        assert_eq!(table[0].len(), 7);
    }
}
