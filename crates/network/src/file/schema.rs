//! What a network file may hold; its ends stand beside their laws.

use crate::laws::WallLaw;
use serde::Deserialize;
use toml::Spanned;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// For the reader of the file.
    #[serde(default)]
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) gas: Gas,
    #[serde(default)]
    pub(super) search: Search,
    /// Mean flow; without it the gas is at rest.
    pub(super) flow: Option<Flow>,
    pub(super) upstream: Spanned<toml::Table>,
    pub(super) downstream: Spanned<toml::Table>,
    #[serde(default)]
    pub(super) element: Vec<Spanned<toml::Table>>,
}

/// The gas where an element does not say otherwise: dry air at 20 C.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Gas {
    /// K.
    pub(super) temperature: f64,
    /// Pa.
    pub(super) pressure: f64,
    pub(super) gamma: f64,
    /// J/(kg K).
    pub(super) gas_constant: f64,
    /// Pa s at `temperature`; elsewhere by the power 0.7 of temperature.
    pub(super) viscosity: f64,
    pub(super) prandtl: f64,
}

impl Default for Gas {
    fn default() -> Self {
        Self {
            temperature: 293.15,
            pressure: 101_325.0,
            gamma: 1.4,
            gas_constant: 287.05,
            viscosity: 1.813e-5,
            prandtl: 0.71,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Search {
    /// 1/s.
    #[serde(default, deserialize_with = "two")]
    pub(super) growth_rate: Option<[f64; 2]>,
    #[serde(default, deserialize_with = "two")]
    pub(super) frequency_hz: Option<[f64; 2]>,
}

/// Two numbers and no more: an array of fixed length would pass over a third.
fn two<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<[f64; 2]>, D::Error> {
    let list = Vec::<f64>::deserialize(from)?;
    let found = list.len();
    let pair = list.try_into().ok();
    pair.map(Some).ok_or_else(|| {
        serde::de::Error::custom(format!("two numbers are needed, lowest and highest, not {found}"))
    })
}

/// Mean flow, entering at the upstream end.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Flow {
    /// Mach number in the first duct.
    pub(super) mach: Option<f64>,
    /// Velocity in the first duct, m/s.
    pub(super) velocity: Option<f64>,
    /// Whether entropy waves are carried to the next place that they meet.
    #[serde(default = "yes")]
    pub(super) entropy_waves: bool,
}

fn yes() -> bool {
    true
}

/// gain N/D e^{-s delay}, or gain e^{-s delay} times a table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Transfer {
    #[serde(default = "one")]
    pub(super) gain: f64,
    #[serde(default)]
    pub(super) delay: f64,
    pub(super) cutoff_hz: Option<f64>,
    #[serde(default = "unity")]
    pub(super) numerator: Vec<f64>,
    #[serde(default = "unity")]
    pub(super) denominator: Vec<f64>,
    /// Rows of frequency (Hz), gain, phase (rad).
    pub(super) table: Option<Vec<[f64; 3]>>,
    #[serde(default = "fit")]
    pub(super) tolerance: f64,
}

/// A coefficient of feedback: [real, imaginary], or a function of s.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Coefficient {
    Constant([f64; 2]),
    Function(Box<Transfer>),
}

impl Default for Coefficient {
    fn default() -> Self {
        Self::Constant([0.0; 2])
    }
}

impl<'de> Deserialize<'de> for Coefficient {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        // By hand, so that the messages of the alternative that was meant come through.
        let value = toml::Value::deserialize(from)?;
        let outcome = match value {
            toml::Value::Table(_) => <Box<Transfer>>::deserialize(value).map(Self::Function),
            value => <[f64; 2]>::deserialize(value).map(Self::Constant),
        };
        outcome.map_err(|error| serde::de::Error::custom(error.message()))
    }
}

/// On which side of a source its reference lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Direction {
    #[default]
    Upstream,
    Downstream,
}

/// A wall that loses nothing, or one of the laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum WallChoice {
    #[default]
    None,
    Paper,
    Kirchhoff,
    ZwikkerKosten,
}

impl WallChoice {
    pub(super) fn law(self) -> Option<WallLaw> {
        match self {
            Self::None => None,
            Self::Paper => Some(WallLaw::Paper),
            Self::Kirchhoff => Some(WallLaw::Kirchhoff),
            Self::ZwikkerKosten => Some(WallLaw::ZwikkerKosten),
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Scheme {
    /// Loss in the propagation.
    #[default]
    Line,
    /// The paper's jumps between equal pieces.
    Lumped,
}

pub(super) fn one() -> f64 {
    1.0
}

/// Deviation from a table that is allowed, over its largest gain.
pub(super) fn fit() -> f64 {
    1e-6
}

pub(super) fn unity() -> Vec<f64> {
    vec![1.0]
}

/// A straight or conical duct, uniform or with a temperature that varies along it, cut into `pieces`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Duct {
    pub(super) length: f64,
    pub(super) diameter: Option<f64>,
    pub(super) diameter_end: Option<f64>,
    pub(super) area: Option<f64>,
    pub(super) area_end: Option<f64>,
    pub(super) temperature: Option<f64>,
    pub(super) temperature_end: Option<f64>,
    /// Temperatures at equally spaced points from start to end.
    pub(super) temperatures: Option<Vec<f64>>,
    pub(super) sound_speed: Option<f64>,
    pub(super) density: Option<f64>,
    /// Of other gas than that of the file.
    pub(super) gamma: Option<f64>,
    /// J/(kg K).
    pub(super) gas_constant: Option<f64>,
    pub(super) pieces: Option<usize>,
    #[serde(default)]
    pub(super) wall: WallChoice,
    #[serde(default = "one")]
    pub(super) wall_factor: f64,
    #[serde(default)]
    pub(super) scheme: Scheme,
}

/// A compact heat source, k_eu = -gain N/D e^{-s delay}.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Flame {
    pub(super) gain: Option<f64>,
    /// Interaction index, instead of `gain`: Q'/Q = n N/D e^{-s delay} u'/U, so that
    /// gain = n (T2 - T1)/T_ref A_ref/A2.
    pub(super) n: Option<f64>,
    #[serde(default)]
    pub(super) delay: f64,
    pub(super) cutoff_hz: Option<f64>,
    #[serde(default = "unity")]
    pub(super) numerator: Vec<f64>,
    #[serde(default = "unity")]
    pub(super) denominator: Vec<f64>,
    /// Rows of frequency (Hz), gain, phase (rad).
    pub(super) table: Option<Vec<[f64; 3]>>,
    #[serde(default = "fit")]
    pub(super) tolerance: f64,
    /// Distance from the flame of the velocity that it answers to, m.
    #[serde(default)]
    pub(super) reference: f64,
    #[serde(default)]
    pub(super) reference_side: Direction,
    /// Of the heat release, from `at` downstream, m.
    pub(super) length: Option<f64>,
    /// At its downstream end, s.
    pub(super) delay_end: Option<f64>,
    /// Heat per length at equally spaced points from end to end, up to a factor.
    pub(super) density: Option<Vec<f64>>,
    pub(super) pieces: Option<usize>,
}

/// The elements, from upstream to downstream. `name` and `at` are common to all and read before.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Element {
    /// A straight or conical duct.
    Duct(Box<Duct>),
    /// Feedback coefficients.
    Feedback(Feedback),
    /// A plate with a hole.
    Orifice(Orifice),
    /// A gauze across the tube.
    Screen(Screen),
    /// An open hole or chimney in the wall of the tube.
    SideHole(Hole),
    /// A compact heat source.
    Flame(Box<Flame>),
    /// A Helmholtz resonator on the wall.
    Helmholtz(Resonator),
    /// A closed tube on the wall.
    QuarterWave(Branch),
}

/// Feedback coefficients.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Feedback {
    #[serde(default)]
    pub(super) mu: Coefficient,
    #[serde(default)]
    pub(super) mp: Coefficient,
    #[serde(default)]
    pub(super) eu: Coefficient,
    #[serde(default)]
    pub(super) ep: Coefficient,
}

/// A plate with a hole: inertia rho l_eff A/A_hole s, and drag.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Orifice {
    pub(super) diameter: f64,
    pub(super) thickness: f64,
    /// Pa s/m.
    #[serde(default)]
    pub(super) drag: f64,
    /// Of a plate with many holes: the open part of the area of the duct before it.
    pub(super) porosity: Option<f64>,
    /// Of a flow through the holes, averaged over them, m/s.
    pub(super) bias_velocity: Option<f64>,
}

/// A gauze across the tube.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Screen {
    /// Pa s/m, of slow steady flow.
    #[serde(default)]
    pub(super) resistance: f64,
    /// Open part of its area; gives the loss coefficient.
    pub(super) open_area: Option<f64>,
    /// Loss coefficient K of steady flow, pressure drop K rho U^2/2: acts with flow only.
    pub(super) loss: Option<f64>,
    /// Length of the air that it moves, m.
    #[serde(default)]
    pub(super) effective_length: f64,
}

/// An open hole or chimney in the wall of the tube.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hole {
    pub(super) diameter: f64,
    /// Thickness of the wall, or height of the chimney, m.
    pub(super) length: f64,
    #[serde(default)]
    pub(super) outlet: Outlet,
    #[serde(default)]
    pub(super) wall: WallChoice,
}

/// A Helmholtz resonator on the wall.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Resonator {
    pub(super) volume: f64,
    pub(super) neck_area: f64,
    /// Effective length, end corrections included.
    pub(super) neck_length: f64,
    /// Pa s/m, pressure over velocity in the neck.
    #[serde(default)]
    pub(super) resistance: f64,
    /// Of a flow through the neck, averaged over it, m/s.
    pub(super) bias_velocity: Option<f64>,
}

/// A closed tube on the wall.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Branch {
    pub(super) length: f64,
    pub(super) area: f64,
}

/// What a side hole opens to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Outlet {
    /// Flush with a large plane.
    #[default]
    Flanged,
    /// The end of a thin tube.
    Unflanged,
}
