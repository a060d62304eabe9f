//! What weak effects that a model does not have would do to a mode, all at once: the derivatives at strength
//! zero.

use super::PointModel;
use super::model::LawAt;
use crate::shape::LawOf;
use crate::{Conditions, EngineError};
use rijke_network::{At, Coefficients, Laws, Slot, Workspace};
use rijke_numerics::{C64, JetSpace, Order};
use rijke_study::names::{DENSITY, DIAMETER, GAMMA, PRANDTL, SOUND_SPEED, VISCOSITY};

/// The derivatives of s and of the relative pressures but the reference's, in the order of a prediction.
pub(crate) struct Probed {
    /// The eigenvalue.
    pub(crate) s: C64,
    /// By place that was asked for, and by k_mu, k_mp, k_eu, k_ep there; none where nothing can act.
    pub(crate) places: Vec<[Option<Vec<C64>>; 4]>,
    /// By end, with respect to R.
    pub(crate) ends: [Option<Vec<C64>>; 2],
    /// With respect to the viscous and the thermal loss per metre of all ducts, in rho c and 1/(rho c).
    pub(crate) walls: [Option<Vec<C64>>; 2],
    /// With respect to a factor of the losses of thin boundary layers along all ducts (G. Kirchhoff, Annalen
    /// der Physik 134 (1868) 177), over sqrt(s).
    pub(crate) layers: Option<Vec<C64>>,
    /// By effect of the model, candidate and number: with respect to e where its law is multiplied by 1 + e.
    pub(crate) laws: Vec<([usize; 2], Vec<C64>)>,
}

/// The laws of a model at one s, and seeds that it does not have.
struct With<'a> {
    laws: &'a dyn Coefficients,
    /// For each law of the model, the seed that multiplies it.
    factors: Vec<usize>,
    /// Seeds that are laws of their own, after those.
    more: usize,
}

impl With<'_> {
    fn scaling(&self) -> usize {
        self.factors.iter().max().map_or(0, |k| k + 1)
    }
}

impl Coefficients for With<'_> {
    fn parameters(&self) -> usize {
        self.scaling() + self.more
    }

    fn laws(&self) -> usize {
        self.laws.laws() + self.more
    }

    fn fill(&self, at: &At, laws: &mut Laws) {
        let search = At::search(at.s());
        let mut own = Laws::default();
        own.reset(self.laws.laws(), &search);
        self.laws.fill(&search, &mut own);
        let alone = JetSpace::new(2, Order::First);
        for k in 0..self.laws.laws() {
            let (value, slope) = (own.value(k), own.gradient(k)[0]);
            let jet = rijke_numerics::Jet::from_parts(value, vec![value, slope], Vec::new());
            match self.factors.get(k) {
                Some(seed) if at.space() != search.space() => laws.set_among(k, &jet, &[*seed]),
                _ => laws.set_analytic(k, [value, slope, C64::ZERO]),
            }
        }
        if at.space() != search.space() {
            for k in 0..self.more {
                laws.set_among(self.laws.laws() + k, &alone.seed(0, C64::ZERO), &[self.scaling() + k]);
            }
        }
    }
}

impl PointModel<'_> {
    /// The effects of the model, candidate and number, that its laws belong to.
    fn owners(&self) -> Vec<[usize; 2]> {
        match &self.shape {
            None => {
                let of = |l: &LawAt| [l.candidate, l.effect];
                // Both coefficients of a source upstream of which the velocity is are in proportion to its
                // law; those of a loop are not.
                let heard = (0..self.heard.laws()).map(|beyond| match self.heard.source_of(beyond) {
                    Some(source) if !source.is_a_loop() => of(&self.laws[source.law]),
                    _ => [usize::MAX; 2],
                });
                self.laws.iter().map(of).chain(heard).collect()
            }
            Some(shape) => {
                let of = |law: &LawOf| match *law {
                    LawOf::Effect { candidate, effect, .. } => [candidate, effect],
                    LawOf::Length(_) | LawOf::Area(_) | LawOf::SoundSpeed(_) | LawOf::Density(_) => {
                        [usize::MAX; 2]
                    }
                };
                shape.laws.iter().map(of).collect()
            }
        }
    }

    /// The derivatives of the mode with respect to effects that the model lacks; the model must have been
    /// made with [`PointModel::with_cuts`].
    ///
    /// # Errors
    /// As [`PointModel::respond`].
    pub(crate) fn probe(
        &self,
        values: &[f64],
        conditions: &Conditions,
        work: &mut Workspace,
    ) -> Result<Probed, EngineError> {
        let (filled, root) = self.solve(values, self.guess, work)?;
        let mut owners = self.owners();
        let of_laws = owners.clone();
        owners.sort_unstable();
        owners.dedup();
        owners.retain(|owner| owner[0] != usize::MAX);
        let factors = of_laws.iter().map(|o| owners.binary_search(o).unwrap_or(owners.len())).collect();
        let mut chain: Box<dyn rijke_network::Chain> = match &self.flowing {
            Some(flowing) => Box::new(flowing.clone()),
            None => Box::new(self.network.clone()),
        };
        let mut with = With { laws: &*filled, factors, more: 0 };
        let mut law = |slots: &[(Slot, f64)]| -> Option<usize> {
            let number = with.laws.laws() + with.more;
            let attached = slots.iter().all(|(slot, weight)| chain.attach(*slot, number, *weight).is_ok());
            with.more += 1;
            attached.then_some(with.more - 1)
        };
        let places: Vec<[Option<usize>; 4]> = self
            .cuts
            .iter()
            .map(|&j| [Slot::Mu(j), Slot::Mp(j), Slot::Eu(j), Slot::Ep(j)].map(|slot| law(&[(slot, 1.0)])))
            .collect();
        let ends = [Slot::Upstream, Slot::Downstream].map(|slot| law(&[(slot, 1.0)]));
        let along = |slot: fn(usize) -> Slot, impedance: fn(f64) -> f64| -> Vec<(Slot, f64)> {
            let segments = self.network.segments().iter().enumerate();
            segments.map(|(i, s)| (slot(i), impedance(s.density * s.sound_speed))).collect()
        };
        let walls = [law(&along(Slot::Viscous, |z| z)), law(&along(Slot::Thermal, f64::recip))];
        let (mut layers, mut end) = (Vec::new(), 0.0);
        for (i, segment) in self.network.segments().iter().enumerate() {
            let around = conditions.around(end + 0.5 * segment.length);
            end += segment.length;
            let viscous = 4.0 / around[DIAMETER] * (around[DENSITY] * around[VISCOSITY]).sqrt();
            let impedance = around[DENSITY] * around[SOUND_SPEED];
            let thermal = viscous * (around[GAMMA] - 1.0) / impedance.powi(2) / around[PRANDTL].sqrt();
            layers.extend([(Slot::Viscous(i), viscous), (Slot::Thermal(i), thermal)]);
        }
        let layers = law(&layers);
        let found = chain.respond(&with, &root, &self.places, Order::First, work);
        let found = found.map_err(|source| self.no_answer(source))?;
        let scaling = with.scaling();
        let slope = |seed: usize| self.numbers(&found).map(|z| z.gradient()[seed]).collect::<Vec<C64>>();
        let of = |seed: Option<usize>| seed.map(|k| slope(scaling + k));
        Ok(Probed {
            s: root.s,
            places: places.into_iter().map(|p| p.map(of)).collect(),
            ends: ends.map(of),
            walls: walls.map(of),
            layers: of(layers),
            laws: owners.iter().enumerate().map(|(k, owner)| (*owner, slope(k))).collect(),
        })
    }
}
