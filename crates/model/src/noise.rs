//! What is assumed of the misfit of a model, and what a training found of it.

use crate::varying::Scatter;
use rijke_inference::{NoiseEstimate, NoiseGroup, NoiseMode};
use rijke_numerics::Matrix;

const NONE: NoiseMode = NoiseMode::Fixed { sd: 0.0 };

/// What is assumed of the difference between model and measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the growth rate, 1/s.
    pub growth_rate: NoiseMode,
    /// Standard deviation of the angular frequency, rad/s.
    pub angular_frequency: NoiseMode,
    /// Standard deviation of each part of a microphone's pressure, relative to the reference microphone's pressure.
    pub pressure: NoiseMode,
    /// Standard deviations of what all hot points at one position of the heater share, in the growth rate (1/s) and the
    /// angular frequency (rad/s): the rig is set once for all powers, and its ends, say, come out a little different each time.
    /// Enters with the errors of the base states only ([`crate::Training::base_errors`]); where every point is a setting of its
    /// own, it cannot be told from the noise of the point.
    pub setting: [NoiseMode; 2],
    /// Standard deviation of the relative error of the law of the heat release, in its real and its imaginary part, which all
    /// points of one power share: a law that is a little wrong is so in the same way wherever the heater stands. Enters with
    /// the errors of the base states only; zero for a law that is taken to be right.
    pub heat_release: f64,
    /// Whether the measured covariance is added to these. Not where they float: noise that is below the measured one
    /// would then have no best value.
    pub measured: bool,
}

impl Noise {
    /// All three are chosen by the data, as in sections 6.2 to 6.5 of the paper: measurement and model error together.
    pub const FLOATED: Self = Self {
        growth_rate: NoiseMode::Floated,
        angular_frequency: NoiseMode::Floated,
        pressure: NoiseMode::Floated,
        setting: [NONE; 2],
        heat_release: 0.0,
        measured: false,
    };

    /// The measured covariance and nothing else: for a model that is exact.
    pub const MEASURED: Self = Self {
        growth_rate: NONE,
        angular_frequency: NONE,
        pressure: NONE,
        setting: [NONE; 2],
        heat_release: 0.0,
        measured: true,
    };
}

impl Noise {
    /// The error of the law, as one of the noises that a training found.
    pub(crate) fn of_the_law(&self) -> Option<NoiseEstimate> {
        let estimate =
            NoiseEstimate { name: LAW.into(), unit: "1".into(), sd: self.heat_release, floats: false };
        (self.heat_release > 0.0).then_some(estimate)
    }
}

/// What a new measurement in a new setting differs by from a model whose parameters and base state are known exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Standard deviations of growth rate (1/s), angular frequency (rad/s) and each part of a relative pressure: noise of the
    /// point and of its setting together.
    pub measured: [f64; 3],
    /// Relative error of the law of the heat release ([`Noise::heat_release`]).
    pub heat_release: f64,
}

impl Misfit {
    /// From the noise that a training found.
    #[must_use]
    pub fn of(noise: &[NoiseEstimate]) -> Self {
        let total = |wanted: &dyn Fn(&str) -> bool| {
            noise.iter().filter(|n| wanted(&n.name)).map(|n| n.sd * n.sd).sum::<f64>().sqrt()
        };
        Self {
            measured: MEASURED.map(|name| total(&|n| n.strip_suffix(BETWEEN).unwrap_or(n) == name)),
            heat_release: total(&|n| n == LAW),
        }
    }
}

/// The groups of noise that act on any block, and where the optional ones stand.
pub(crate) struct Groups {
    pub(crate) list: Vec<NoiseGroup>,
    pub(crate) near_field: Option<usize>,
    pub(crate) setting: Option<[usize; 2]>,
    /// The first of the parameters that vary between settings.
    pub(crate) varying: usize,
}

impl Groups {
    /// Those of the measured numbers.
    pub(crate) fn new(microphones: &[usize], noise: &Noise) -> Self {
        let modes = [noise.growth_rate, noise.angular_frequency, noise.pressure];
        let measured = if microphones.len() > 1 { 3 } else { 2 };
        let group = |k: usize| NoiseGroup { name: MEASURED[k].into(), unit: UNITS[k].into(), mode: modes[k] };
        Self { list: (0..measured).map(group).collect(), near_field: None, setting: None, varying: 0 }
    }

    /// And that of microphones near the heater, where there are any.
    pub(crate) fn near_field(mut self, doubtful: &[Option<Matrix>]) -> Self {
        if doubtful.iter().any(Option::is_some) {
            self.near_field = Some(self.list.len());
            self.list.push(NoiseGroup::fixed("near field of the heater", "1", NEAR_FIELD_SD));
        }
        self
    }

    /// And those of parameters that vary between settings.
    pub(crate) fn varying(mut self, scatter: &[Scatter]) -> Self {
        self.varying = self.list.len();
        self.list.extend(scatter.iter().map(|s| s.group.clone()));
        self
    }

    /// And those that the points of one setting share.
    pub(crate) fn shared(mut self, noise: &Noise) -> Self {
        if noise.setting != [NONE; 2] {
            let first = self.list.len();
            self.list.extend((0..2).map(|k| NoiseGroup {
                name: format!("{}{BETWEEN}", MEASURED[k]),
                unit: UNITS[k].into(),
                mode: noise.setting[k],
            }));
            self.setting = Some([first, first + 1]);
        }
        self
    }
}

/// Standard deviation of a relative pressure in the near field of the heater. Two plates change the pressure there by a few
/// per cent; a judgement, generous on purpose.
const NEAR_FIELD_SD: f64 = 0.1;

const MEASURED: [&str; 3] = ["growth rate", "angular frequency", "relative pressure"];

const UNITS: [&str; 3] = ["1/s", "rad/s", "1"];

pub(crate) const BETWEEN: &str = ", between settings";

const LAW: &str = "law of the heat release, from power to power";
