//! Base states from profiles that were measured: temperatures or sound speeds along the tube, and the
//! velocity at the heater, for those who have no clicks.

use super::state::{BaseState, ErrorComponent};
use super::states::BaseStates;
use super::table::{at, readings, rows};
use crate::apparatus::geometry::TubeRig;
use crate::apparatus::observed::TubeObservations;
use crate::apparatus::point::TubePoint;
use crate::error::FlowError;
use rijke_rig::Gas;
use std::collections::BTreeMap;
use std::path::Path;

/// The file of profiles in a folder of observations: `point, at [m], temperature [K], sd [K]`, or with
/// `sound_speed [m/s], sd [m/s]` in their place. One row per place.
pub const PROFILES: &str = "profiles.csv";

/// The file of velocities at the heater, which may be missing: `point, velocity [m/s], sd [m/s]`.
pub const VELOCITIES: &str = "velocities.csv";

/// Base states of all points that the files of `folder` speak of.
///
/// Between the places of a profile the temperature is linear, beyond them constant. The errors of the places
/// are independent of each other. The mass flux is the velocity at the heater times the density of the place
/// next below; without a velocity both are 0, and laws that need them have no value.
///
/// # Errors
/// [`FlowError::File`] with file, line and remedy.
pub fn read_profiles(folder: &Path, observations: &TubeObservations) -> Result<BaseStates, FlowError> {
    let rig = &observations.rig;
    let points: BTreeMap<&str, &TubePoint> =
        observations.points.iter().map(|p| (p.point.id.as_str(), &p.point)).collect();
    let path = folder.join(PROFILES);
    let (by_sound, rows) = readings(&path)?;
    let mut nodes: BTreeMap<String, Vec<[f64; 3]>> = BTreeMap::new();
    for (line, id, numbers) in rows {
        let wrong = |problem: String| at(&path, line, &problem);
        known(&points, &id).map_err(&wrong)?;
        let (x, value, sd) = (numbers[0], numbers[1], numbers[2]);
        if !(0.0..=rig.tube.length).contains(&x) {
            return Err(wrong(format!("x = {x} m is outside the tube (0 to {} m)", rig.tube.length)));
        }
        let [kelvin, kelvin_sd] =
            if by_sound { warmth(&rig.gas, rig.pressure, value, sd) } else { [value, sd] };
        if !((150.0..3000.0).contains(&kelvin) && sd > 0.0 && kelvin_sd < 3000.0) {
            return Err(wrong(format!(
                "{value} +- {sd} is no {}; give kelvin or m/s, and a positive sd",
                if by_sound { "sound speed" } else { "temperature" }
            )));
        }
        let profile = nodes.entry(id).or_default();
        if profile.last().is_some_and(|last| last[0] >= x) {
            return Err(wrong(format!("x = {x} m does not follow the row before; list each profile upward")));
        }
        profile.push([x, kelvin, kelvin_sd]);
    }
    let velocities = velocities(&folder.join(VELOCITIES), &points)?;
    let mut states = BTreeMap::new();
    for (id, nodes) in nodes {
        let velocity = velocities.get(&id).copied().unwrap_or([0.0; 2]);
        let state = state(rig, points[id.as_str()], &nodes, velocity)
            .checked()
            .map_err(|error| at(&path, 1, &format!("operating point {id}: {error}")))?;
        states.insert(id, state);
    }
    Ok(BaseStates { kind: observations.kind, source: observations.source.clone(), points: states })
}

fn state(
    rig: &TubeRig,
    point: &TubePoint,
    nodes: &[[f64; 3]],
    [velocity, velocity_sd]: [f64; 2],
) -> BaseState {
    let heater = point.position.unwrap_or(0.0);
    let below = nodes.iter().rev().find(|n| n[0] <= heater).or(nodes.first()).map_or(f64::NAN, |n| n[1]);
    let density = rig.gas.at(below, rig.pressure).density;
    // The ends of the tube are the first and the last place.
    let mut all: Vec<(f64, usize)> = nodes.iter().enumerate().map(|(k, n)| (n[0], k)).collect();
    if all.first().is_some_and(|first| first.0 > 0.0) {
        all.insert(0, (0.0, 0));
    }
    if all.last().is_some_and(|last| last.0 < rig.tube.length) {
        all.push((rig.tube.length, nodes.len() - 1));
    }
    let component = |k: usize| ErrorComponent {
        cause: format!("{}: profile at {} m", point.id, nodes[k][0]),
        mass_flux: 0.0,
        heater_velocity: 0.0,
        temperature: all.iter().map(|(_, node)| if *node == k { nodes[k][2] } else { 0.0 }).collect(),
    };
    let mut errors: Vec<ErrorComponent> = (0..nodes.len()).map(component).collect();
    if velocity_sd > 0.0 {
        errors.push(ErrorComponent {
            cause: format!("{}: velocity at the heater", point.id),
            mass_flux: velocity_sd * density,
            heater_velocity: velocity_sd,
            temperature: vec![0.0; all.len()],
        });
    }
    BaseState {
        gas: rig.gas.clone(),
        pressure: rig.pressure,
        mass_flux: velocity * density,
        heater_velocity: velocity,
        places: all.iter().map(|(x, _)| *x).collect(),
        temperature: all.iter().map(|(_, node)| nodes[*node][1]).collect(),
        errors,
    }
}

/// The temperature of a sound speed, and its standard deviation to first order; by bisection, because c grows
/// with T.
fn warmth(gas: &Gas, pressure: f64, sound_speed: f64, sd: f64) -> [f64; 2] {
    let speed = |kelvin: f64| gas.at(kelvin, pressure).sound_speed;
    let (mut low, mut high) = (100.0, 4000.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if speed(middle) < sound_speed { low = middle } else { high = middle }
    }
    let slope = (speed(low + 0.5) - speed(low - 0.5)).abs();
    [low, sd / slope]
}

fn velocities(
    path: &Path,
    points: &BTreeMap<&str, &TubePoint>,
) -> Result<BTreeMap<String, [f64; 2]>, FlowError> {
    if !path.exists() {
        return Ok(BTreeMap::new());
    }
    let mut all = BTreeMap::new();
    for (line, id, numbers) in rows(path, &[("velocity", "m/s"), ("sd", "m/s")])? {
        known(points, &id).map_err(|problem| at(path, line, &problem))?;
        if !numbers[..2].iter().all(|v| (0.0..1e3).contains(v)) {
            return Err(at(path, line, "velocity and sd must lie from 0 to 1000 m/s"));
        }
        all.insert(id, [numbers[0], numbers[1]]);
    }
    Ok(all)
}

fn known(points: &BTreeMap<&str, &TubePoint>, id: &str) -> Result<(), String> {
    let names = || points.keys().copied().collect::<Vec<_>>().join(", ");
    if points.contains_key(id) {
        Ok(())
    } else {
        Err(format!("the operating point `{id}` is not known; known: {}", names()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ObservedTube, TubeCampaign};
    use rijke_rig::{DataKind, Day};

    fn observations() -> TubeObservations {
        let points = TubeCampaign::juniper_yoko_2022().points.into_iter().filter(|p| p.id == "H30-25");
        let day = Day { id: "d".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 };
        let of = |point| ObservedTube { point, ambient: day.clone(), click: None, is_planned: true };
        TubeObservations {
            rig: TubeRig::juniper_yoko_2022(),
            kind: DataKind::Virtual,
            source: "a test".into(),
            points: points.map(of).collect(),
            ramps: Vec::new(),
        }
    }

    #[test]
    fn exact_temperatures_and_their_sound_speeds_give_the_same_state() {
        let folder = std::env::temp_dir().join(format!("rijke-profiles-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (observations, gas) = (observations(), Gas::air());
        let rows = [(0.2, 294.0), (0.3, 340.0), (0.9, 330.0)];
        let write = |head: &str, value: &dyn Fn(f64) -> [f64; 2]| {
            let row = |(x, kelvin): (f64, f64)| {
                format!("H30-25,{x},{:?},{:?}\n", value(kelvin)[0], value(kelvin)[1])
            };
            std::fs::write(folder.join(PROFILES), format!("point,at [m],{head}\n{}", rows.map(row).concat()))
                .unwrap();
            read_profiles(&folder, &observations)
        };
        let warm = write("temperature [K],sd [K]", &|kelvin| [kelvin, 0.5]).unwrap().points["H30-25"].clone();
        let slope = |t: f64| gas.at(t + 0.5, 101_325.0).sound_speed - gas.at(t - 0.5, 101_325.0).sound_speed;
        let sound = write("sound_speed [m/s],sd [m/s]", &|kelvin| {
            [gas.at(kelvin, 101_325.0).sound_speed, 0.5 * slope(kelvin)]
        });
        let sound = sound.unwrap().points["H30-25"].clone();
        assert_eq!(warm.places, [0.0, 0.2, 0.3, 0.9, 1.0]);
        for x in [0.0, 0.25, 0.6, 1.0] {
            assert!((warm.temperature(x) - sound.temperature(x)).abs() < 1e-9);
        }
        assert_eq!((warm.temperature(0.25), warm.temperature(1.0), warm.mass_flux), (317.0, 330.0, 0.0));
        let sd = |state: &BaseState| state.sound_speed_covariance(&[0.3])[(0, 0)].sqrt();
        assert!((sd(&warm) / sd(&sound) - 1.0).abs() < 1e-6 && (sd(&warm) - 0.5 * slope(340.0)).abs() < 1e-6);

        std::fs::write(folder.join(VELOCITIES), "point,velocity [mm/s],sd [mm/s]\nH30-25,400,20\n").unwrap();
        let moving = read_profiles(&folder, &observations).unwrap().points["H30-25"].clone();
        assert_eq!((moving.heater_velocity, moving.heater_velocity_sd()), (0.4, 0.02));
        assert!((moving.mass_flux - 0.4 * gas.at(294.0, 101_325.0).density).abs() < 1e-12);

        let refused = |text: &str, says: &str| {
            std::fs::write(folder.join(PROFILES), text).unwrap();
            let said = read_profiles(&folder, &observations).unwrap_err().to_string();
            assert!(said.contains(says) && said.contains(PROFILES), "{said}");
        };
        let head = "point,at [m],temperature [K],sd [K]\n";
        refused(&format!("{head}H30-25,0.2,21,0.5\n"), "line 2: 21 +- 0.5 is no temperature; give kelvin");
        refused(
            &format!("{head}H30-25,0.2,294,0.5\nH30-25,0.1,294,0.5\n"),
            "line 3: x = 0.1 m does not follow",
        );
        refused(
            &format!("{head}H99-25,0.2,294,0.5\n"),
            "line 2: the operating point `H99-25` is not known; known: H30-25",
        );
        refused(
            "point,x [m],T [K]\nH30-25,0.2,294\n",
            "`x [m]` is not known; known: point, at, temperature, sd",
        );
        refused("point,at [m],temperature [K],sd [m]\nH30-25,0.2,294,1\n", "column `sd`");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
