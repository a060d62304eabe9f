//! The library of elements: what each is made of, and the laws that it brings.

use crate::law::Coefficient::{self, Ep, Eu, Mp, Mu, Reflection};

/// A kind of element or end.
pub(super) struct Kind {
    /// Its `type` in files.
    pub(super) name: &'static str,
    /// Numbers that it has.
    pub(super) keys: &'static [Key],
    /// Laws that act at it, as formulas of its numbers.
    pub(super) laws: &'static [(Coefficient, &'static str)],
}

/// A number of an element.
pub(super) struct Key {
    pub(super) name: &'static str,
    /// SI.
    pub(super) unit: &'static str,
    /// What it is if it is not given; it must be given if there is none.
    pub(super) default: Option<&'static str>,
}

const fn need(name: &'static str, unit: &'static str) -> Key {
    Key { name, unit, default: None }
}

const fn or(name: &'static str, unit: &'static str, default: &'static str) -> Key {
    Key { name, unit, default: Some(default) }
}

/// Compact elements between ducts. `transfer` is N(s)/D(s) e^(-s delay), with a first-order filter, see
/// [`transfer`].
pub(super) const COMPACT: [Kind; 8] = [
    Kind { name: "device", keys: &[], laws: &[] },
    // Heat release in proportion to velocity: k_eu = -gain F(s). With `n`, Q'/Q = n F u'/U and the mean heat
    // is that of the rise of p/rho, so that gain = n (rho/rho_2 - 1) A/A_2 (Dowling & Stow 2003, with the
    // reference just upstream).
    Kind { name: "flame", keys: &[need("gain", "1")], laws: &[(Eu, "-(gain)*(transfer)")] },
    // A plate with a hole, or with many: inertia rho l_eff A/A_hole and drag; what it is made of is
    // [`PLATE`].
    Kind {
        name: "orifice",
        keys: &[need("diameter", "m"), need("thickness", "m"), or("drag", "Pa s/m", "0")],
        laws: &[(
            Mu,
            "s*rho*((thickness) + 4/(3*pi)*(diameter)*(fok_before + fok_after) + shed)/plate_open + (drag)",
        )],
    },
    // A gauze: resistance, air that it moves, and the slope of the steady loss K rho U^2/2.
    Kind {
        name: "screen",
        keys: &[or("resistance", "Pa s/m", "0"), or("effective_length", "m", "0"), or("loss", "1", "0")],
        laws: &[(Mu, "(resistance) + s*rho*(effective_length) + (loss)*rho*U")],
    },
    // A Helmholtz resonator on the wall.
    Kind {
        name: "helmholtz",
        keys: &[
            need("volume", "m^3"),
            need("neck_area", "m^2"),
            need("neck_length", "m"),
            or("resistance", "Pa s/m", "0"),
        ],
        laws: &[(
            Ep,
            "s/(A_2*(s^2*rho*((neck_length) + shed)/(neck_area) + s*(resistance)/(neck_area) + rho*c^2/(volume)))",
        )],
    },
    // A closed tube on the wall.
    Kind {
        name: "quarter-wave",
        keys: &[need("length", "m"), need("area", "m^2")],
        laws: &[(Ep, "(area)/(A_2*rho*c)*tanh(s*(length)/c)")],
    },
    // A hole or chimney of a tube as a symmetric T, open (1) or closed (0), see [`SIDE_HOLE`].
    Kind {
        name: "side-hole",
        keys: &[need("diameter", "m"), need("length", "m"), or("open", "1", "1")],
        laws: &[
            (Mu, "hole_z*(1 + hole_y*hole_z/4)"),
            (Mp, "-hole_y*hole_z/2"),
            (Eu, "-hole_y*hole_z/2"),
            (Ep, "hole_y"),
        ],
    },
    Kind {
        name: "feedback",
        keys: &[
            or("mu", "kg/(m^2 s)", "0"),
            or("mp", "1", "0"),
            or("eu", "1", "0"),
            or("ep", "m/(Pa s)", "0"),
        ],
        laws: &[(Mu, "(coupling_mu)"), (Mp, "(coupling_mp)"), (Eu, "(coupling_eu)"), (Ep, "(coupling_ep)")],
    },
];

/// What the laws of a side hole are made of: half the series inertia, the branch, the other half. Inner
/// correction and curved wall: Nederveen, Jansen & van Hassel 1998, Acta Acustica 84, eqs. (40), (37); series
/// length: Dubos et al. 1999, Acta Acustica 85, eq. (73), with coth in the place of tanh where the hole is
/// closed. Holes do not hear each other outside, nor through evanescent waves. `hole_viscous` and
/// `hole_thermal` are those of [`WALLS`], `hole_outside` of [`HOLE_OUTLETS`].
pub(super) const SIDE_HOLE: [(&str, &str); 12] = [
    ("hole_radius", "(diameter)/2"),
    ("hole_delta", "(diameter)*sqrt(pi/A_2)/2"),
    (
        "hole_inner",
        "hole_radius*(0.82 - 0.193*hole_delta - 1.09*hole_delta^2 + 1.27*hole_delta^3 - 0.71*hole_delta^4)",
    ),
    ("hole_line", "(length) + hole_radius*hole_delta/8*(1 + 0.207*hole_delta^3)"),
    ("hole_side", "0.940 + 0.540*hole_delta + 0.285*hole_delta^2"),
    ("hole_tanh", "tanh(1.84*(length)/hole_radius)"),
    (
        "hole_z",
        "-s*rho*hole_radius*hole_delta^2*((open)/(1.78*hole_tanh + hole_side) + (1 - (open))/(1.78/hole_tanh + hole_side))",
    ),
    ("hole_inertia", "s*rho + hole_viscous"),
    ("hole_spring", "s/(rho*c^2) + hole_thermal"),
    ("hole_wave", "sqrt(hole_inertia)/sqrt(hole_spring)"),
    ("hole_mouth", "(open)/(rho*c*hole_outside)"),
    (
        "hole_y",
        "pi*hole_radius^2/(A_2*(s*rho*hole_inner + hole_wave*(1 + hole_wave*hole_mouth*tanh(sqrt(hole_inertia)*sqrt(hole_spring)*hole_line))\
         /(hole_wave*hole_mouth + tanh(sqrt(hole_inertia)*sqrt(hole_spring)*hole_line))))",
    ),
];

/// Impedance over rho c of the outside by the `outlet` of a side hole, to second order in ka: a piston in a
/// baffle (Pierce 1981, 5-4), or the end of a thin tube (Levine & Schwinger 1948, as in Pierce 7-5).
pub(super) const HOLE_OUTLETS: [(&str, &str); 2] = [
    ("flanged", "(8/(3*pi)*s*(diameter)/2/c - (s*(diameter)/2/c)^2/2)"),
    ("unflanged", "(0.6133*s*(diameter)/2/c - (s*(diameter)/2/c)^2/4)"),
];

/// What the law of an orifice is made of: for the duct before it and the one behind, Fok's function of the
/// diameter over that of the duct (Fok 1941; Melling 1973, J. Sound Vib. 29, eq. 15), with a last term that
/// makes it 0 at 1, as in network files.
pub(super) const PLATE: [(&str, &str); 6] = [
    ("plate_open", "pi/4*(diameter)^2/A"),
    ("plate_before", "(diameter)/D"),
    ("plate_after", "(diameter)*sqrt(pi/A_2)/2"),
    // What walls leave of the steady loss of a jet, Idelchik 1986, chapter 4.
    ("plate_steady", "((0.707*sqrt(1 - plate_before^2) + 1 - plate_after^2)/1.707)^2"),
    (
        "fok_before",
        "1 - 1.4092*plate_before + 0.33818*plate_before^3 + 0.06793*plate_before^5 - 0.02287*plate_before^6 \
         + 0.03015*plate_before^7 - 0.01641*plate_before^8 + 0.01222*plate_before^9",
    ),
    (
        "fok_after",
        "1 - 1.4092*plate_after + 0.33818*plate_after^3 + 0.06793*plate_after^5 - 0.02287*plate_after^6 \
         + 0.03015*plate_after^7 - 0.01641*plate_after^8 + 0.01222*plate_after^9",
    ),
];

/// What a bias flow adds to the length of air that a hole moves, by kind: pi R/2 (2R/K_R - 1) with Howe's
/// conductivity (1979, Proc. R. Soc. Lond. A 366), for a plate less what the ducts leave of it.
pub(super) const SHED: [(&str, &str); 2] = [
    (
        "orifice",
        "pi/8*(diameter)*(fok_before + fok_after)*(1/howe(s*(diameter)/4*(fok_before + \
         fok_after)/plate_steady/(bias_velocity)) - 1)",
    ),
    ("helmholtz", "sqrt(pi*(neck_area))/2*(1/howe(s*sqrt((neck_area)/pi)/(bias_velocity)) - 1)"),
];

/// The first three of [`PLATE`] for a plate of many holes, of which each has its share of the duct.
pub(super) const PLATE_OF_HOLES: [(&str, &str); 3] = [
    ("plate_open", "(porosity)"),
    ("plate_before", "sqrt(plate_open)"),
    ("plate_after", "sqrt(plate_open*A/A_2)"),
];

/// Ends of the rig. Laws call a number of an end by `end_` and its key.
pub(super) const ENDS: [Kind; 12] = [
    Kind { name: "free", keys: &[], laws: &[] },
    Kind { name: "open", keys: &[], laws: &[(Reflection, "-1")] },
    Kind { name: "closed", keys: &[], laws: &[(Reflection, "1")] },
    Kind { name: "anechoic", keys: &[], laws: &[(Reflection, "0")] },
    Kind {
        name: "constant",
        keys: &[need("modulus", "1"), need("angle", "rad")],
        laws: &[(Reflection, "(end_modulus)*exp(i*(end_angle))")],
    },
    Kind {
        name: "delayed",
        keys: &[need("factor", "1"), need("delay", "s")],
        laws: &[(Reflection, "(end_factor)*exp(-s*(end_delay))")],
    },
    // Levine & Schwinger 1948, with the end correction of a wall of finite thickness beyond that of a thin
    // one: Dalmont, Nederveen & Joly 2001, J. Sound Vib. 244, eq. (39), with q the inner over the outer
    // radius.
    Kind {
        name: "unflanged",
        keys: &[or("wall_thickness", "m", "0"), or("modulus", "1", "1"), or("angle", "rad", "0")],
        laws: &[(
            Reflection,
            "(end_modulus)*exp(i*(end_angle))*R_LS*exp(-s*D/c*(0.8216 - 0.6133 + (0.6133 - 0.8216)*(D/(D + 2*(end_wall_thickness))) \
             + 0.057*(D/(D + 2*(end_wall_thickness)))*(1 - (D/(D + 2*(end_wall_thickness)))^5)))",
        )],
    },
    Kind { name: "flanged", keys: &[], laws: &[(Reflection, "R_flanged")] },
    // A compact nozzle, see [`CHOKED`]; without `mach` that of the mean flow of the base state.
    Kind { name: "choked", keys: &[or("mach", "1", "M")], laws: &[(Reflection, "(1 - end_m)/(1 + end_m)")] },
    // Normalised impedance p/(rho c u) into the end: a number or formula, or a function of s as of
    // [`FUNCTION`].
    Kind {
        name: "impedance",
        keys: &[need("impedance", "1")],
        laws: &[(Reflection, "((end_impedance) - 1)/((end_impedance) + 1)")],
    },
    Kind { name: "rational", keys: &[], laws: &[(Reflection, "end_transfer")] },
    Kind { name: "table", keys: &[], laws: &[(Reflection, "end_transfer")] },
];

/// `end_m` of a choked end upstream, which keeps mass flow and stagnation enthalpy (Stow, Dowling & Hynes
/// 2002), and downstream (Marble & Candel 1977).
pub(super) const CHOKED: [&str; 2] =
    ["gamma*(end_mach)/(1 + (gamma - 1)*(end_mach)^2)", "(gamma - 1)/2*(end_mach)"];

/// Kinds that have a function of s: its keys. Those of `feedback` stand in a table of their own for every
/// coupling.
pub(super) const FUNCTION: [(&str, &[&str]); 5] = [
    ("flame", &["delay", "cutoff_hz", "numerator", "denominator", "table", "tolerance"]),
    ("feedback", &["gain", "delay", "cutoff_hz", "numerator", "denominator", "table", "tolerance"]),
    ("impedance", &["delay", "numerator", "denominator", "table", "tolerance"]),
    ("rational", &["delay", "numerator", "denominator"]),
    ("table", &["gain", "delay", "table", "tolerance"]),
];

/// Keys of network files that rigs do not have: element, key, and what must stand there in its place.
pub(super) const REFUSED: [(&str, &str, &str); 3] = [
    ("duct", "sound_speed", OF_ITS_GAS),
    ("duct", "density", OF_ITS_GAS),
    (
        "duct",
        "scheme",
        "left out: in a rig walls lose along the duct; a candidate may let a law act at places instead",
    ),
];

const OF_ITS_GAS: &str =
    "left out: in a rig it follows from `temperature`, `gamma` and `gas_constant` of the duct: give these";

/// No number of a rig is larger in SI units.
const LARGEST: f64 = 1e30;

/// What a number of an element must be, where it is one number.
pub(super) fn fault_of(key: &str, value: f64) -> Option<&'static str> {
    if value.abs() > LARGEST {
        return Some("below 1e30 in size: no number of a rig is larger");
    }
    let positive = [
        "bias_velocity",
        "diameter",
        "diameter_end",
        "length",
        "volume",
        "neck_area",
        "neck_length",
        "area",
        "cutoff_hz",
        "gas_constant",
    ];
    let least_zero = [
        "delay",
        "delay_end",
        "thickness",
        "drag",
        "resistance",
        "effective_length",
        "loss",
        "wall_thickness",
        "modulus",
    ];
    let fault = |wrong: bool, need| wrong.then_some(need);
    match key {
        _ if positive.contains(&key) => fault(value <= 0.0, "positive"),
        _ if least_zero.contains(&key) => fault(value < 0.0, "zero or more"),
        "porosity" | "open_area" => {
            fault(!(value > 0.0 && value <= 1.0), "above 0 and at most 1: a part of an area")
        }
        "gamma" => fault(value <= 1.0, "above 1"),
        "mach" => fault(!(value > 0.0 && value < 0.3), "above 0 and below 0.3"),
        "angle" => fault(value.abs() > 2.0 * std::f64::consts::PI, "at most a turn: angles are in rad"),
        _ => None,
    }
}

/// Losses at the walls of a duct: viscous and thermal, per metre, as formulas of `wall_factor`.
pub(super) const WALLS: [(&str, [&str; 2]); 3] = [
    (
        "paper",
        [
            "(wall_factor)*4/D*sqrt(s*rho*mu)",
            "(wall_factor)*4/D*sqrt(s*rho*mu)*(gamma - 1)/(rho*c)^2*Pr^(-2/3)",
        ],
    ),
    (
        "kirchhoff",
        [
            "(wall_factor)*4/D*sqrt(s*rho*mu)",
            "(wall_factor)*4/D*sqrt(s*rho*mu)*(gamma - 1)/(rho*c)^2*Pr^(-1/2)",
        ],
    ),
    (
        "zwikker-kosten",
        [
            "(wall_factor)*s*rho/(D/4*sqrt(s*rho/mu)/bessel_ratio(D/2*sqrt(s*rho/mu)) - 1)",
            "(wall_factor)*s*(gamma - 1)/(rho*c^2)*bessel_ratio(D/2*sqrt(s*rho/mu*Pr))/(D/4*sqrt(s*rho/mu*Pr))",
        ],
    ),
];

/// Loss coefficient K of a screen of round wires, of its open part of the area: Idelchik 1986, diagram 8-6,
/// for Re above 1000.
pub(super) const SCREEN_LOSS: &str = "1.3*(1 - (open_area)) + (1/(open_area) - 1)^2";

/// N(s)/D(s) e^(-s delay)/(1 + s/(2 pi cutoff)) as a formula of these names; polynomials have ascending
/// coefficients.
pub(super) fn transfer(
    delay: Option<&str>,
    cutoff: Option<&str>,
    numerator: &[String],
    denominator: &[String],
) -> String {
    let horner = |k: &[String]| {
        let mut text = k.last().map_or_else(|| "1".to_owned(), |k| format!("({k})"));
        for k in k.iter().rev().skip(1) {
            text = format!("(({k}) + s*{text})");
        }
        text
    };
    let mut text = String::from("1");
    if !numerator.is_empty() {
        text = horner(numerator);
    }
    if !denominator.is_empty() {
        text = format!("{text}/{}", horner(denominator));
    }
    if let Some(cutoff) = cutoff {
        text = format!("{text}/(1 + s/(2*pi*({cutoff})))");
    }
    if let Some(delay) = delay {
        text = format!("{text}*exp(-s*({delay}))");
    }
    text
}
