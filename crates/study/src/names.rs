//! The names that laws may use: one scope for a whole study.

use crate::StudyProblem;
use rijke_formula::{Kind, Name, Scope};

/// Meaning of the names that are factors.
pub(crate) const FACTOR: &str = "factor of the campaign";

/// Complex angular frequency.
pub const S: usize = 0;
/// Density, and so on: the gas where a law acts, in the order of the table below.
pub const DENSITY: usize = 1;
/// Speed of sound.
pub const SOUND_SPEED: usize = 2;
/// Temperature.
pub const TEMPERATURE: usize = 3;
/// Mean pressure.
pub const PRESSURE: usize = 4;
/// Dynamic viscosity.
pub const VISCOSITY: usize = 5;
/// Thermal conductivity.
pub const CONDUCTIVITY: usize = 6;
/// Specific heat at constant pressure.
pub const SPECIFIC_HEAT: usize = 7;
/// Ratio of specific heats.
pub const GAMMA: usize = 8;
/// Prandtl number.
pub const PRANDTL: usize = 9;
/// Mean velocity.
pub const VELOCITY: usize = 10;
/// Mach number.
pub const MACH: usize = 11;
/// Mass flux.
pub const MASS_FLUX: usize = 12;
/// Hydraulic diameter.
pub const DIAMETER: usize = 13;
/// Area.
pub const AREA: usize = 14;
/// Perimeter.
pub const PERIMETER: usize = 15;
/// Temperature just downstream.
pub const TEMPERATURE_AFTER: usize = 16;
/// Area just downstream.
pub const AREA_AFTER: usize = 17;
/// Ambient temperature.
pub const AMBIENT: usize = 18;
/// Total length.
pub const LENGTH: usize = 19;
/// Viscous loss of the duct's wall per metre.
pub const WALL_MU: usize = 20;
/// Thermal loss of the duct's wall per metre.
pub const WALL_EP: usize = 21;
/// Levine and Schwinger's reflection coefficient.
pub const LEVINE_SCHWINGER: usize = 22;
/// Reflection coefficient of an end in a baffle.
pub const FLANGED: usize = 23;
/// Density just downstream.
pub const DENSITY_AFTER: usize = 24;

const BUILT_IN: [(&str, &str, &str, Kind); 24] = [
    ("rho", "kg/m^3", "density", Kind::Local),
    ("c", "m/s", "speed of sound", Kind::Local),
    ("T", "K", "gas temperature", Kind::Local),
    ("p_0", "Pa", "mean pressure", Kind::Local),
    ("mu", "Pa s", "dynamic viscosity", Kind::Local),
    ("k_gas", "W/(m K)", "thermal conductivity of the gas", Kind::Local),
    ("c_p", "J/(kg K)", "specific heat at constant pressure", Kind::Local),
    ("gamma", "1", "ratio of specific heats", Kind::Local),
    ("Pr", "1", "Prandtl number", Kind::Local),
    ("U", "m/s", "mean velocity where the law acts", Kind::Local),
    ("M", "1", "Mach number where the law acts", Kind::Local),
    ("G", "kg/(m^2 s)", "mass flux where the law acts", Kind::Local),
    ("D", "m", "hydraulic diameter of the duct, 4 area / perimeter", Kind::Local),
    ("A", "m^2", "cross-section of the duct", Kind::Local),
    ("P", "m", "perimeter of the duct", Kind::Local),
    ("T_2", "K", "gas temperature just downstream of a place", Kind::Local),
    ("A_2", "m^2", "cross-section of the duct just downstream of a place", Kind::Local),
    ("T_amb", "K", "ambient temperature", Kind::Global),
    ("L", "m", "total length of the ducts", Kind::Global),
    (
        "wall_mu",
        "kg/(m^3 s)",
        "viscous loss of the duct's wall per metre, as the wall model gives it",
        Kind::Analytic,
    ),
    (
        "wall_ep",
        "1/(Pa s)",
        "thermal loss of the duct's wall per metre, as the wall model gives it",
        Kind::Analytic,
    ),
    ("R_LS", "1", "reflection coefficient of Levine & Schwinger 1948 at ka = s a/(i c)", Kind::Analytic),
    (
        "R_flanged",
        "1",
        "reflection coefficient of an end in an infinite baffle, by Rayleigh's piston",
        Kind::Analytic,
    ),
    ("rho_2", "kg/m^3", "density just downstream of a place", Kind::Local),
];

/// The factors of the campaign among the names.
pub(crate) fn factors(scope: &Scope) -> impl Iterator<Item = &str> {
    let of_the_campaign = |n: &&Name| n.kind == Kind::Global && n.meaning == FACTOR;
    scope.names().iter().filter(of_the_campaign).map(|n| n.name.as_str())
}

/// The factor of this name.
pub(crate) fn factor_of(scope: &Scope, name: &str) -> Option<usize> {
    scope.find(name).filter(|_| factors(scope).any(|factor| factor == name))
}

/// The scope that every study starts from.
///
/// # Errors
/// None; a test reads the table.
pub(crate) fn built_in() -> Result<Scope, StudyProblem> {
    let mut scope = Scope::new();
    for (name, unit, meaning, kind) in BUILT_IN {
        add(
            &mut scope,
            "symbol",
            Name { name: name.into(), unit: unit.into(), meaning: meaning.into(), kind },
        )?;
    }
    Ok(scope)
}

/// Refuses a name that formulas know; `what` says what kind of thing it is to name.
pub(crate) fn free(scope: &Scope, what: &'static str, name: &str) -> Result<(), StudyProblem> {
    let Some(known) = scope.find(name).and_then(|k| scope.names().get(k)) else { return Ok(()) };
    let meaning = if known.meaning.is_empty() { "something else".to_owned() } else { known.meaning.clone() };
    Err(StudyProblem::Known { what, name: name.to_owned(), meaning })
}

/// Adds a name; `what` says what kind of thing it names.
pub(crate) fn add(scope: &mut Scope, what: &'static str, name: Name) -> Result<usize, StudyProblem> {
    let text = name.name.clone();
    free(scope, what, &text)?;
    let why =
        "use letters, digits and _, start with a letter, and avoid the names of functions and constants";
    scope.add(name).map_err(|_| StudyProblem::Name { what, name: text, why })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_constants_are_the_places_of_the_names() {
        let scope = built_in().unwrap();
        for (name, place) in [
            ("s", S),
            ("rho", DENSITY),
            ("Pr", PRANDTL),
            ("G", MASS_FLUX),
            ("A_2", AREA_AFTER),
            ("L", LENGTH),
            ("R_flanged", FLANGED),
            ("rho_2", DENSITY_AFTER),
        ] {
            assert_eq!(scope.find(name), Some(place), "{name}");
        }
        assert_eq!(scope.len(), BUILT_IN.len() + 1);
    }
}
