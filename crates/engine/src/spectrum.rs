//! Every mode of a model at an operating point, with where its energy goes and what small changes would do to
//! it.

use crate::{EngineError, PointModel};
use rijke_network::{Budget, Mode, Modes, NetworkError, Region, Root, Station, Workspace};
use rijke_numerics::C64;
use std::f64::consts::PI;

/// The modes of a model in a region.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// The modes, counted.
    pub modes: Modes,
    /// Poles of laws in the region.
    pub poles: Vec<C64>,
    /// One for each mode, in their order.
    pub details: Vec<ModeDetails>,
}

/// What is known of one mode.
#[derive(Clone, Debug)]
pub struct ModeDetails {
    /// Mean powers over energy, 1/s.
    pub budget: Budget,
    /// The parts of the growth rate that laws have at places: coefficient, candidate and place, and 1/s.
    pub laws: Vec<(String, f64)>,
    /// How much relative errors of the chain's numbers are magnified in s.
    pub condition: f64,
    /// The shape along x, and what a small change there does to s.
    pub stations: Vec<Station>,
}

impl Spectrum {
    /// What is known of one of the modes.
    #[must_use]
    pub fn of(&self, mode: &Mode) -> Option<&ModeDetails> {
        self.modes.modes.iter().position(|m| m.s == mode.s).and_then(|k| self.details.get(k))
    }
}

/// Points along the whole rig, about; at most a twentieth of them in one segment.
const POINTS: usize = 1200;

impl PointModel<'_> {
    /// The eigenvalues in the rig's search region.
    ///
    /// # Errors
    /// As [`PointModel::spectrum`].
    pub(crate) fn modes(&self, values: &[f64]) -> Result<Vec<C64>, EngineError> {
        let filled = self.filled(values)?;
        let [sigma, hertz] = self.assembly.rig.search;
        let region = Region { sigma, omega: hertz.map(|f| 2.0 * PI * f) };
        let modes = self.chain().modes(&*filled, &region, &mut Workspace::default());
        Ok(modes.map_err(|source| self.no_answer(source))?.modes.iter().map(|m| m.s).collect())
    }

    /// The modes in the rig's search region, with frequencies (Hz) between other limits where `limits_hz`
    /// gives them.
    ///
    /// # Errors
    /// [`EngineError::Count`], or [`EngineError::Network`] if the search fails.
    pub fn spectrum(
        &self,
        values: &[f64],
        limits_hz: [Option<f64>; 2],
    ) -> Result<(Region, Spectrum), EngineError> {
        let filled = self.filled(values)?;
        let [sigma, hertz] = self.assembly.rig.search;
        let limit = |k: usize| 2.0 * PI * limits_hz[k].unwrap_or(hertz[k]);
        let region = Region { sigma, omega: [limit(0), limit(1)] };
        let (chain, work) = (self.chain(), &mut Workspace::default());
        let fail = |source| self.no_answer(source);
        let modes = chain.modes(&*filled, &region, work).map_err(|source| match source {
            NetworkError::NotFinite { s } => match self.undefined(values, s) {
                Some(law) => EngineError::Undefined { point: self.id().to_owned(), law, s },
                None => fail(source),
            },
            source => fail(source),
        })?;
        let poles = chain.poles(&*filled, &region).map_err(fail)?.into_iter().map(|(s, _)| s);
        let poles = poles.filter(|s| region.contains(*s)).collect();
        let samples = (POINTS / chain.count().max(1)).clamp(2, POINTS / 20) + 1;
        let mut details = Vec::new();
        for mode in &modes.modes {
            let root = Root { s: mode.s, steps: 0, residual: mode.residual };
            let budget = chain.budget(&*filled, &root, work).map_err(fail)?;
            let mut laws: Vec<(String, f64)> = Vec::new();
            for (law, power) in budget.places.iter().flat_map(|p| &p.laws) {
                let name = rijke_network::Coefficients::name(&*filled, *law);
                match laws.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, sum)) => *sum += 0.5 * power,
                    None => laws.push((name, 0.5 * power)),
                }
            }
            let condition = chain.condition(&*filled, &root, work).map_err(fail)?;
            let stations = chain.along(&*filled, &root, samples, work).map_err(fail)?;
            details.push(ModeDetails { budget, laws, condition, stations });
        }
        Ok((region, Spectrum { modes, poles, details }))
    }
}
