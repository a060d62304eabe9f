//! The library of elements: what each is made of, and the laws that it brings.

use super::value::Given;
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

/// Compact elements between ducts. `transfer` is N(s)/D(s) e^(-s delay), with a first-order filter, see [`transfer`].
pub(super) const COMPACT: [Kind; 8] = [
    Kind { name: "device", keys: &[], laws: &[] },
    // Heat release in proportion to velocity: k_eu = -gain F(s). With `n`, Q'/Q = n F u'/U and the mean heat is that of the
    // temperature rise, so that gain = n (T_2 - T)/T A/A_2 (Dowling & Stow 2003, with the reference just upstream).
    Kind { name: "flame", keys: &[need("gain", "1")], laws: &[(Eu, "-(gain)*(transfer)")] },
    // A plate with a hole: inertia rho l_eff A/A_hole and drag. End correction of both sides with Fok's function of the ratio of
    // diameters (Fok 1941; Melling 1973, J. Sound Vib. 29, eq. 15).
    Kind {
        name: "orifice",
        keys: &[need("diameter", "m"), need("thickness", "m"), or("drag", "Pa s/m", "0")],
        laws: &[(
            Mu,
            "s*rho*((thickness) + 8/(3*pi)*(diameter)*(1 - 1.4092*((diameter)/D) + 0.33818*((diameter)/D)^3 + 0.06793*((diameter)/D)^5 \
             - 0.02287*((diameter)/D)^6 + 0.03015*((diameter)/D)^7 - 0.01641*((diameter)/D)^8))*A/(pi/4*(diameter)^2) + (drag)",
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
            "s/(A*(s^2*rho*(neck_length)/(neck_area) + s*(resistance)/(neck_area) + rho*c^2/(volume)))",
        )],
    },
    // A closed tube on the wall.
    Kind {
        name: "quarter-wave",
        keys: &[need("length", "m"), need("area", "m^2")],
        laws: &[(Ep, "(area)/(A*rho*c)*tanh(s*(length)/c)")],
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

/// What the laws of a side hole are made of: half the series inertia, the branch, the other half. Inner correction and curved wall:
/// Nederveen, Jansen & van Hassel 1998, Acta Acustica 84, eqs. (40), (37); series length: Dubos et al. 1999, Acta Acustica 85, eq. (73), with coth in
/// the place of tanh where the hole is closed. Holes do not hear each other outside, nor through evanescent waves. `hole_loss` and `hole_outside` are
/// those of [`HOLE_WALLS`] and [`HOLE_OUTLETS`].
pub(super) const SIDE_HOLE: [(&str, &str); 12] = [
    ("hole_radius", "(diameter)/2"),
    ("hole_delta", "(diameter)/D"),
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
    ("hole_inertia", "s*rho + hole_loss"),
    ("hole_spring", "s/(rho*c^2) + hole_loss*(gamma - 1)/(rho*c)^2*Pr^(-1/2)"),
    ("hole_wave", "sqrt(hole_inertia)/sqrt(hole_spring)"),
    ("hole_mouth", "(open)/(rho*c*hole_outside)"),
    (
        "hole_y",
        "pi*hole_radius^2/(A*(s*rho*hole_inner + hole_wave*(1 + hole_wave*hole_mouth*tanh(sqrt(hole_inertia)*sqrt(hole_spring)*hole_line))\
         /(hole_wave*hole_mouth + tanh(sqrt(hole_inertia)*sqrt(hole_spring)*hole_line))))",
    ),
];

/// `hole_loss` by the `wall` of a side hole: none, or Kirchhoff's to first order.
pub(super) const HOLE_WALLS: [(&str, &str); 2] =
    [("none", "0"), ("kirchhoff", "4/(diameter)*sqrt(s*rho*mu)")];

/// Impedance over rho c of the outside by the `outlet` of a side hole, to second order in ka: a piston in a baffle (Pierce 1981, 5-4), or the end of
/// a thin tube (Levine & Schwinger 1948, as in Pierce 7-5).
pub(super) const HOLE_OUTLETS: [(&str, &str); 2] = [
    ("flanged", "(8/(3*pi)*s*(diameter)/2/c - (s*(diameter)/2/c)^2/2)"),
    ("unflanged", "(0.6133*s*(diameter)/2/c - (s*(diameter)/2/c)^2/4)"),
];

/// Ends of the rig.
pub(super) const ENDS: [Kind; 9] = [
    Kind { name: "free", keys: &[], laws: &[] },
    Kind { name: "open", keys: &[], laws: &[(Reflection, "-1")] },
    Kind { name: "closed", keys: &[], laws: &[(Reflection, "1")] },
    Kind { name: "anechoic", keys: &[], laws: &[(Reflection, "0")] },
    Kind {
        name: "constant",
        keys: &[need("modulus", "1"), need("angle", "rad")],
        laws: &[(Reflection, "(modulus)*exp(i*(angle))")],
    },
    Kind {
        name: "delayed",
        keys: &[need("factor", "1"), need("delay", "s")],
        laws: &[(Reflection, "(factor)*exp(-s*(delay))")],
    },
    // Levine & Schwinger 1948, with the end correction of a wall of finite thickness beyond that of a thin one: Dalmont,
    // Nederveen & Joly 2001, J. Sound Vib. 244, eq. (39), with q the inner over the outer radius.
    Kind {
        name: "unflanged",
        keys: &[or("wall_thickness", "m", "0"), or("modulus", "1", "1"), or("angle", "rad", "0")],
        laws: &[(
            Reflection,
            "(modulus)*exp(i*(angle))*R_LS*exp(-s*D/c*(0.8216 - 0.6133 + (0.6133 - 0.8216)*(D/(D + 2*(wall_thickness))) \
             + 0.057*(D/(D + 2*(wall_thickness)))*(1 - (D/(D + 2*(wall_thickness)))^5)))",
        )],
    },
    Kind { name: "flanged", keys: &[], laws: &[(Reflection, "R_flanged")] },
    // Normalised impedance p/(rho c u) into the end.
    Kind {
        name: "impedance",
        keys: &[need("impedance", "1")],
        laws: &[(Reflection, "((impedance) - 1)/((impedance) + 1)")],
    },
];

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

/// Loss coefficient K of a screen of round wires, of its open part of the area: Idelchik 1986, diagram 8-6, for Re above 1000.
pub(super) const SCREEN_LOSS: &str = "1.3*(1 - (open_area)) + (1/(open_area) - 1)^2";

/// N(s)/D(s) e^(-s delay)/(1 + s/(2 pi cutoff)) as a formula; polynomials have ascending coefficients.
pub(super) fn transfer(
    delay: Option<&Given>,
    cutoff: bool,
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
    if cutoff {
        text = format!("{text}/(1 + s/(2*pi*(cutoff_hz)))");
    }
    if delay.is_some() {
        text = format!("{text}*exp(-s*(delay))");
    }
    text
}
