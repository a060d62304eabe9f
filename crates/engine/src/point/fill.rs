//! The laws of an operating point at given values of the free parameters, as coefficients of its network.

use super::model::{LawAt, PointModel};
use super::poles::{Acting, SAMPLES, poles};
use crate::assembly::{Erring, part_of_wall};
use rijke_formula::{Formula, Here};
use rijke_network::{At, Coefficients, Laws, NetworkError, Pole, Region, laws::Law, levine_schwinger};
use rijke_numerics::{C64, ComplexDual, Jet, JetSpace, Order};
use rijke_study::Effect;
use rijke_study::names::{DIAMETER, FLANGED, LEVINE_SCHWINGER, S, SOUND_SPEED, WALL_EP, WALL_MU};

/// Names that depend on s are the first of the scope.
const NAMES: usize = FLANGED + 1;

/// The laws at given values of the free parameters.
pub(crate) struct Filled<'m> {
    model: &'m PointModel<'m>,
    values: &'m [f64],
    /// The parameters of each candidate.
    numbers: Vec<Vec<f64>>,
}

impl<'m> Filled<'m> {
    pub(super) fn new(model: &'m PointModel<'m>, values: &'m [f64]) -> Self {
        Self { model, values, numbers: model.assembly.numbers(values) }
    }

    /// Laws with their numbers, walls first.
    fn in_order(&self) -> impl Iterator<Item = (usize, &'m LawAt, &'m Effect)> {
        let model: &'m PointModel<'m> = self.model;
        model.order.iter().map(|&k| (k, &model.laws[k], model.effect(&model.laws[k])))
    }

    /// Law number `k`.
    fn law_number(&self, k: usize) -> &Formula {
        let law = &self.model.laws[k];
        self.model.prepared.get(k).unwrap_or_else(|| &self.model.effect(law).law)
    }

    /// All laws but those of sources that answer to a velocity elsewhere.
    fn fill_laws(&self, at: &At, laws: &mut Laws) {
        if at.space() == JetSpace::new(1, Order::First) {
            self.fill_in_s(at.s(), laws);
        } else {
            self.fill_jets(at, laws);
        }
    }

    /// Values and derivatives in s: for root searches and modes.
    fn fill_in_s(&self, s: C64, laws: &mut Laws) {
        let zero = ComplexDual { value: C64::ZERO, slope: C64::ZERO };
        let s_dual = ComplexDual { value: s, slope: C64::ONE };
        let mut wall = vec![[zero; 2]; self.model.surroundings.len()];
        for (k, law, effect) in self.in_order() {
            let around = &self.model.surroundings[law.around];
            let part = part_of_wall(effect);
            let ends = radiation(effect, around, s)
                .map(|end| end.map(|[value, slope, _]| ComplexDual { value, slope }));
            let [mu, ep] = wall[law.around];
            let mut analytic: [Option<&ComplexDual>; NAMES] = [None; NAMES];
            analytic[S] = Some(&s_dual);
            if part.is_none() {
                (analytic[WALL_MU], analytic[WALL_EP]) = (Some(&mu), Some(&ep));
            }
            (analytic[LEVINE_SCHWINGER], analytic[FLANGED]) = (ends[0].as_ref(), ends[1].as_ref());
            let here = Here { space: JetSpace::new(1, Order::First), numbers: around, analytic: &analytic };
            let parameters = &self.numbers[law.candidate];
            let mut found = self.law_number(k).evaluate_in_s(&here, parameters);
            if let Some(how) = self.model.assembly.erring(law.candidate, law.effect)
                && let [.., re, im] = parameters[..]
            {
                let e = C64::new(re, im);
                found = match how {
                    Erring::Relative => {
                        ComplexDual { value: found.value * (e + 1.0), slope: found.slope * (e + 1.0) }
                    }
                    Erring::Added(_) => ComplexDual { value: found.value + e, slope: found.slope },
                };
            }
            laws.set_analytic(k, [found.value, found.slope, C64::ZERO]);
            if let Some(part) = part {
                let total = &mut wall[law.around][part];
                *total = ComplexDual { value: total.value + found.value, slope: total.slope + found.slope };
            }
        }
    }

    /// Values with all derivatives. A law depends on the parameters of its own candidate and of the wall: its
    /// jet has these seeds only, and is spread over all seeds at the end.
    fn fill_jets(&self, at: &At, laws: &mut Laws) {
        let (model, order) = (self.model, at.order());
        let seeds = model.assembly.seeds();
        let of_wall = model.assembly.seeds_of_wall();
        let space = |seeds: &[usize]| JetSpace::new(seeds.len() + 1, order);
        let parameters: Vec<Vec<Jet>> = (0..seeds.len())
            .map(|k| model.assembly.jets(k, &seeds[k], space(&seeds[k]), self.values))
            .collect();
        let mut wall: Vec<Option<[Jet; 2]>> = vec![None; model.surroundings.len()];
        for (k, law, effect) in self.in_order() {
            let (own, around) = (&seeds[law.candidate], &model.surroundings[law.around]);
            let (space_here, part) = (space(own), part_of_wall(effect));
            let s = space_here.seed(own.len(), at.s());
            let ends = radiation(effect, around, at.s())
                .map(|end| end.map(|[value, slope, curvature]| s.compose(value, slope, curvature)));
            let loss = wall[law.around].as_ref().filter(|_| part.is_none());
            let loss = loss.map(|w| [0, 1].map(|i| spread(&w[i], of_wall, own)));
            let mut analytic: [Option<&Jet>; NAMES] = [None; NAMES];
            analytic[S] = Some(&s);
            if let Some([mu, ep]) = &loss {
                (analytic[WALL_MU], analytic[WALL_EP]) = (Some(mu), Some(ep));
            }
            (analytic[LEVINE_SCHWINGER], analytic[FLANGED]) = (ends[0].as_ref(), ends[1].as_ref());
            let here = Here { space: space_here, numbers: around, analytic: &analytic };
            let parameters = &parameters[law.candidate];
            let mut value = self.law_number(k).evaluate(&here, parameters);
            if let Some(how) = model.assembly.erring(law.candidate, law.effect)
                && let [.., re, im] = &parameters[..]
            {
                let e = re + &im.scale(C64::I);
                value = match how {
                    Erring::Relative => &value * &e.shift(C64::ONE),
                    Erring::Added(_) => &value + &e,
                };
            }
            laws.set_among(k, &value, own);
            if let Some(part) = part {
                let zero = || space(of_wall).real(0.0);
                let total = &mut wall[law.around].get_or_insert_with(|| [zero(), zero()])[part];
                *total = &*total + &spread(&value, own, of_wall);
            }
        }
    }
}

impl<'m> Coefficients for Filled<'m> {
    fn parameters(&self) -> usize {
        self.values.len()
    }

    fn laws(&self) -> usize {
        self.model.laws.len() + self.model.heard.laws()
    }

    fn fill(&self, at: &At, laws: &mut Laws) {
        self.fill_laws(at, laws);
        self.model.heard.fill(self.model.laws.len(), at, laws);
    }

    fn reference_at(&self, law: usize) -> Option<f64> {
        self.model.heard.reference_at(law.checked_sub(self.model.laws.len())?)
    }

    fn poles_in(&self, region: &Region) -> Result<Vec<Pole>, NetworkError> {
        let acting = |(k, law, effect): (usize, &LawAt, &'m Effect)| {
            let owner = [law.candidate, law.around];
            // The pieces of a spread flame have the poles of the first.
            let has = !effect.place.is_along() && !self.model.heard.repeats(k);
            let (around, numbers) = (&self.model.surroundings[law.around], &self.numbers[law.candidate]);
            has.then(|| Acting { law: k, owner, formula: effect.law.of_s(around, numbers) })
        };
        let acting: Vec<Acting> = self.in_order().filter_map(acting).collect();
        let mut all = poles(&acting, region, self.model.spacing, |k, part, s| {
            let law = &self.model.laws[k];
            let s = ComplexDual { value: s, slope: C64::ONE };
            let mut analytic: [Option<&ComplexDual>; NAMES] = [None; NAMES];
            analytic[S] = Some(&s);
            let numbers = &self.model.surroundings[law.around];
            let here = Here { space: JetSpace::new(1, Order::First), numbers, analytic: &analytic };
            let found = part.evaluate_in_s(&here, &[]);
            [found.value, found.slope]
        });
        let fill = |at: &At, laws: &mut Laws| self.fill_laws(at, laws);
        let by = (self.model.spacing / SAMPLES, |_: usize| 0.0);
        self.model.heard.poles(self.model.laws.len(), &mut all, region, fill, by)?;
        Ok(all)
    }

    fn name(&self, law: usize) -> String {
        let beyond = law.checked_sub(self.model.laws.len());
        let heard = beyond.and_then(|beyond| self.model.heard.source_of(beyond));
        let number = heard.map_or(law, |source| source.law);
        let Some(law) = self.model.laws.get(number) else { return format!("law {law}") };
        let effect = self.model.effect(law);
        format!(
            "{} of {} at {}",
            effect.coefficient.name(),
            self.model.assembly.candidates()[law.candidate].id,
            effect.place_text
        )
    }
}

/// The reflection coefficients that the law of an end may name, Levine and Schwinger's and a baffle's, with
/// two derivatives in s.
fn radiation(effect: &Effect, around: &[f64], s: C64) -> [Option<[C64; 3]>; 2] {
    if !effect.place.is_end() {
        return [None; 2];
    }
    let (radius, sound_speed) = (0.5 * around[DIAMETER], around[SOUND_SPEED]);
    let unflanged = effect.law.uses(LEVINE_SCHWINGER).then(|| {
        // ka = s a/(i c).
        let per_s = C64::new(0.0, -radius / sound_speed);
        let [value, slope, curvature] = levine_schwinger::reflection(s * per_s);
        [value, slope * per_s, curvature * per_s * per_s]
    });
    let flanged = effect.law.uses(FLANGED).then(|| Law::Flanged { radius, sound_speed }.analytic(s));
    [unflanged, flanged]
}

/// The same jet with seeds `to` (and s) in place of `from` (and s); a seed that is not among `to` is left
/// out.
fn spread(jet: &Jet, from: &[usize], to: &[usize]) -> Jet {
    if from == to {
        return jet.clone();
    }
    let place = |i: usize| from.get(i).map_or(Some(to.len()), |seed| to.iter().position(|t| t == seed));
    JetSpace::new(to.len() + 1, jet.order()).take(jet, place)
}
