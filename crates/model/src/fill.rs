//! The laws of an operating point at given values of the free parameters, as coefficients of its network.

use crate::PointModel;
use crate::point::LawAt;
use rijke_candidates::{Coefficient, Dual, Effect, Here, Law, Place, Surroundings, Symbol};
use rijke_network::{At, Coefficients, Laws, levine_schwinger};
use rijke_numerics::{C64, Jet, JetSpace, Order};

impl PointModel<'_> {
    /// The same model, faster from the second call on: arithmetic that no parameter enters is done now.
    #[must_use]
    pub fn prepared(mut self) -> Self {
        let candidates = self.assembly.candidates();
        let law =
            |at: &LawAt| candidates[at.candidate].effects[at.effect].law.at(&self.surroundings[at.around]);
        self.prepared = self.laws.iter().map(law).collect();
        self
    }

    /// Law number `k`.
    fn law_number(&self, k: usize) -> &dyn Law {
        let at = &self.laws[k];
        match self.prepared.get(k) {
            Some(Some(law)) => law.as_ref(),
            _ => self.assembly.candidates()[at.candidate].effects[at.effect].law.as_ref(),
        }
    }
}

/// The laws at given values of the free parameters.
pub(crate) struct Filled<'m> {
    model: &'m PointModel<'m>,
    values: &'m [f64],
    /// The parameters of each candidate.
    numbers: Vec<Vec<f64>>,
}

impl<'m> Filled<'m> {
    pub(crate) fn new(model: &'m PointModel<'m>, values: &'m [f64]) -> Self {
        Self { model, values, numbers: model.assembly.numbers(values) }
    }

    fn effect(&self, law: &LawAt) -> &Effect {
        &self.model.assembly.candidates()[law.candidate].effects[law.effect]
    }

    /// Laws with their numbers, the wall first.
    fn in_order(&self) -> impl Iterator<Item = (usize, &LawAt, &Effect)> {
        self.model.order.iter().map(|&k| (k, &self.model.laws[k], self.effect(&self.model.laws[k])))
    }

    /// Values and derivatives in s: for root searches and modes.
    fn fill_in_s(&self, s: C64, laws: &mut Laws) {
        let zero = Dual { value: C64::ZERO, slope: C64::ZERO };
        let s = Dual { value: s, slope: C64::ONE };
        let mut wall = vec![[zero; 2]; self.model.surroundings.len()];
        for (k, law, effect) in self.in_order() {
            let around = &self.model.surroundings[law.around];
            let along_tube = effect.place == Place::Tube;
            let reflection = effect.place.is_end().then(|| {
                let (ka, per_s) = helmholtz_number(around, s.value);
                let [value, slope, _] = levine_schwinger::reflection(ka);
                Dual { value, slope: slope * per_s }
            });
            let [mu, ep] = &wall[law.around];
            let here = Here {
                space: JetSpace::new(1, Order::First),
                surroundings: around,
                s: &s,
                wall: (!along_tube).then_some([mu, ep]),
                levine_schwinger: reflection.as_ref(),
            };
            let found = self.model.law_number(k).evaluate_in_s(&here, &self.numbers[law.candidate]);
            laws.set_analytic(k, [found.value, found.slope, C64::ZERO]);
            if let (true, Some(part)) = (along_tube, part_of_wall(effect.coefficient)) {
                let total = &mut wall[law.around][part];
                *total = Dual { value: total.value + found.value, slope: total.slope + found.slope };
            }
        }
    }

    /// Values with all derivatives. A law depends on the parameters of its own candidate and of the wall: its jet has
    /// these seeds only, and is spread over all seeds at the end.
    fn fill_jets(&self, at: &At, laws: &mut Laws) {
        let (model, order) = (self.model, at.order());
        let seeds = model.assembly.seeds();
        let tube = model.assembly.seeds_of_tube();
        let space = |seeds: &[usize]| JetSpace::new(seeds.len() + 1, order);
        let parameters: Vec<Vec<Jet>> = (0..seeds.len())
            .map(|k| model.assembly.jets(k, &seeds[k], space(&seeds[k]), self.values))
            .collect();
        let mut wall: Vec<Option<[Jet; 2]>> = vec![None; model.surroundings.len()];
        for (k, law, effect) in self.in_order() {
            let (own, around) = (&seeds[law.candidate], &model.surroundings[law.around]);
            let (space_here, along_tube) = (space(own), effect.place == Place::Tube);
            let s = space_here.seed(own.len(), at.s());
            let reflection = effect.place.is_end().then(|| {
                let (ka, per_s) = helmholtz_number(around, at.s());
                let [value, slope, curvature] = levine_schwinger::reflection(ka);
                s.compose(value, slope * per_s, curvature * per_s * per_s)
            });
            let loss = wall[law.around].as_ref().map(|w| [0, 1].map(|i| spread(&w[i], tube, own)));
            let here = Here {
                space: space_here,
                surroundings: around,
                s: &s,
                wall: loss.as_ref().filter(|_| !along_tube).map(|[mu, ep]| [mu, ep]),
                levine_schwinger: reflection.as_ref(),
            };
            let value = self.model.law_number(k).evaluate(&here, &parameters[law.candidate]);
            laws.set_among(k, &value, own);
            if let (true, Some(part)) = (along_tube, part_of_wall(effect.coefficient)) {
                let zero = || space(tube).real(0.0);
                let total = &mut wall[law.around].get_or_insert_with(|| [zero(), zero()])[part];
                *total = &*total + &spread(&value, own, tube);
            }
        }
    }
}

impl Coefficients for Filled<'_> {
    fn parameters(&self) -> usize {
        self.values.len()
    }

    fn laws(&self) -> usize {
        self.model.laws.len()
    }

    fn fill(&self, at: &At, laws: &mut Laws) {
        if at.space() == JetSpace::new(1, Order::First) {
            self.fill_in_s(at.s(), laws);
        } else {
            self.fill_jets(at, laws);
        }
    }
}

fn part_of_wall(coefficient: Coefficient) -> Option<usize> {
    match coefficient {
        Coefficient::Mu => Some(0),
        Coefficient::Ep => Some(1),
        _ => None,
    }
}

/// ka = s a/(i c), and its derivative in s.
fn helmholtz_number(around: &Surroundings, s: C64) -> (C64, C64) {
    let real = |symbol| around.get(symbol).unwrap_or(f64::NAN);
    let per_s = C64::new(0.0, -0.5 * real(Symbol::Diameter) / real(Symbol::SoundSpeed));
    (s * per_s, per_s)
}

/// The same jet with seeds `to` (and s) in place of `from` (and s); every seed of `from` is among `to`.
fn spread(jet: &Jet, from: &[usize], to: &[usize]) -> Jet {
    if from == to {
        return jet.clone();
    }
    let place = |i: usize| from.get(i).map_or(Some(to.len()), |seed| to.iter().position(|t| t == seed));
    let places: Vec<Option<usize>> = (0..=from.len()).map(place).collect();
    let n = to.len() + 1;
    let mut gradient = vec![C64::ZERO; if jet.gradient().is_empty() { 0 } else { n }];
    let mut hessian = vec![C64::ZERO; if jet.hessian_packed().is_empty() { 0 } else { n * (n + 1) / 2 }];
    for (i, slope) in jet.gradient().iter().enumerate() {
        let Some(a) = places[i] else { continue };
        gradient[a] = *slope;
        for j in 0..=i {
            let Some(b) = places[j] else { continue };
            let (row, column) = (a.max(b), a.min(b));
            if let Some(to) = hessian.get_mut(row * (row + 1) / 2 + column) {
                *to = jet.hessian(i, j);
            }
        }
    }
    Jet::from_parts(jet.value(), gradient, hessian)
}
