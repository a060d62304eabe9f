//! Adjoint derivatives with flow, with respect to feedback at every place, lengths, wall losses and ends at
//! once.
//!
//! As in [`crate::Network::sensitivities`] a row Lambda on (p, u, e) goes back through the chain, one for
//! each output. A velocity that is taken elsewhere takes its own weight along: mu = Lambda x_1 k, what it
//! adds at its place, enters Lambda at the reference. For a loop mu is needed before it is known; Lambda is
//! affine in it, and mu = a + b mu follows.

use super::assembly::FlowChain;
use super::ducts::{ActionKind, FlowEnd};
use super::gate::Basis;
use super::mean::state_of;
use super::passage::State;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use crate::respond::answer::Places;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// Derivatives of one output of a chain with flow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlowDerivatives {
    /// By duct, at its upstream end: with respect to k_mu, k_mp, k_eu, k_ep and the k_ep of a side branch
    /// there, whether something acts there already or not; zero for the first duct, where nothing may act.
    pub feedback: Vec<[C64; 5]>,
    /// By duct: with respect to its length, references keeping their distances.
    pub lengths: Vec<C64>,
    /// By duct: with respect to a factor on its wall loss.
    pub walls: Vec<C64>,
    /// With respect to R_u and R_d; zero for choked ends.
    pub ends: [C64; 2],
}

/// First derivatives of an eigenvalue and of relative pressures.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowSensitivities {
    /// Of s.
    pub s: FlowDerivatives,
    /// Of the pressures at [`Places::at`] relative to [`Places::reference`], in that order.
    pub pressures: Vec<FlowDerivatives>,
}

/// In the order of [`FlowDerivatives::feedback`].
pub(super) const EFFECTS: [ActionKind; 5] =
    [ActionKind::Mu, ActionKind::Mp, ActionKind::Eu, ActionKind::Ep, ActionKind::Branch];

pub(super) type Row = [C64; 3];

/// A mode as it passed, and the chain at its s.
pub(super) struct Passed<'a> {
    pub(super) chain: &'a FlowChain,
    /// The chain at this s, all constants.
    pub(super) basis: Basis<ComplexDual>,
    pub(super) s: ComplexDual,
    /// States before and behind every place; the same at the outlet.
    pub(super) before: Vec<State<ComplexDual>>,
    pub(super) behind: Vec<State<ComplexDual>>,
    /// F without the factors of loops, and its derivative in s.
    f: ComplexDual,
}

/// The way back of one output.
pub(super) struct Back {
    /// Lambda at the downstream end of every duct, and behind the place before it.
    pub(super) ends: Vec<Row>,
    pub(super) starts: Vec<Row>,
    /// Weight of the velocity at every reference.
    pub(super) weights: Vec<C64>,
    inlet: Row,
}

/// rho c in duct `i`.
fn impedance(basis: &Basis<ComplexDual>, i: usize) -> f64 {
    let mean = state_of(&basis.after[i]);
    mean.density * mean.sound_speed(basis.gammas[i])
}

/// A constant.
pub(super) fn fixed(x: &State<ComplexDual>) -> State<ComplexDual> {
    x.map(|v| ComplexDual::constant(v.value))
}

pub(super) fn dot(row: &Row, x: &State<ComplexDual>) -> C64 {
    row[0] * x[0].value + row[1] * x[1].value + row[2] * x[2].value
}

/// row M of a linear map M.
pub(super) fn through(row: &Row, map: impl Fn(&State<ComplexDual>) -> State<ComplexDual>) -> Row {
    std::array::from_fn(|k| {
        let mut unit = [ComplexDual::constant(C64::ZERO); 3];
        unit[k] = ComplexDual::constant(C64::ONE);
        dot(row, &map(&unit))
    })
}

fn add_sources(row: &mut Row, place: usize, sources: &[(usize, C64)]) {
    row[0] += sources.iter().filter(|s| s.0 == place).map(|s| s.1).sum::<C64>();
}

impl<'a> Passed<'a> {
    pub(super) fn new(
        chain: &'a FlowChain,
        basis: &Basis<ComplexDual>,
        root: &Root,
    ) -> Result<Self, NetworkError> {
        let s = ComplexDual { value: root.s, slope: C64::ONE };
        let (mut before, mut behind) = (Vec::new(), Vec::new());
        chain.sweep(basis, &s, |_, x, y| {
            before.push(*x);
            behind.push(*y);
        });
        let f = chain.finish(basis, &before[chain.ducts.len()], &s);
        if f.slope.is_finite() && f.slope != C64::ZERO {
            Ok(Self {
                chain,
                basis: basis.at_rest_in_s(),
                s: ComplexDual::constant(root.s),
                before,
                behind,
                f,
            })
        } else {
            Err(NetworkError::NotFinite { s: root.s })
        }
    }

    /// The row of the eigenvalue.
    pub(super) fn eigenvalue(&self) -> Back {
        self.back(-self.f.slope.inv(), &[])
    }

    /// The row of `factor` times F plus sources times the pressure before places.
    fn back(&self, factor: C64, sources: &[(usize, C64)]) -> Back {
        let (chain, n) = (self.chain, self.chain.ducts.len());
        let unit = |x: &State<ComplexDual>| [chain.finish(&self.basis, x, &self.s), self.s, self.s];
        let mut row = through(&[factor, C64::ZERO, C64::ZERO], unit);
        add_sources(&mut row, n, sources);
        let mut back = Back {
            ends: vec![[C64::ZERO; 3]; n],
            starts: vec![[C64::ZERO; 3]; n],
            weights: vec![C64::ZERO; chain.references.len()],
            inlet: row,
        };
        for j in (0..n).rev() {
            back.ends[j] = row;
            for (e, _) in chain.references.iter().enumerate().filter(|(_, e)| e.duct == j && e.is_loop()) {
                back.weights[e] = self.loop_weight(e, row, &back.weights, sources);
            }
            row = self.to_start(j, row, &back.weights);
            back.starts[j] = row;
            if j > 0 {
                for (e, point) in
                    chain.references.iter().enumerate().filter(|(_, e)| e.place == j && !e.is_loop())
                {
                    back.weights[e] = dot(&row, &chain.amplified(&self.basis, point, &self.s));
                }
                row = self.through_place(j, &row);
            }
            add_sources(&mut row, j, sources);
        }
        back.inlet = row;
        back
    }

    /// From the downstream end of duct `j` to its upstream end.
    fn to_start(&self, j: usize, row: Row, weights: &[C64]) -> Row {
        let basis = &self.basis;
        let mut out = through(&row, |x| self.chain.pass(basis, j, x, &self.s));
        for (point, weight) in self.chain.references.iter().zip(weights).filter(|(e, _)| e.duct == j) {
            let unit =
                |x: &State<ComplexDual>| [self.chain.velocity_at(basis, point, x, &self.s), self.s, self.s];
            let added = through(&[*weight, C64::ZERO, C64::ZERO], unit);
            out = std::array::from_fn(|k| out[k] + added[k]);
        }
        out
    }

    fn through_place(&self, j: usize, row: &Row) -> Row {
        through(row, |x| self.chain.cross_alone(&self.basis, j, x, &self.s))
    }

    /// Weight of the velocity at the reference of a loop, from the row at the downstream end of the duct in
    /// which it lies.
    fn loop_weight(&self, index: usize, row: Row, weights: &[C64], sources: &[(usize, C64)]) -> C64 {
        let point = &self.chain.references[index];
        let unit = self.chain.amplified(&self.basis, point, &self.s);
        let at_place = |row: Row, weights: &[C64], sources: &[(usize, C64)]| {
            let mut row = row;
            for j in (point.place..=point.duct).rev() {
                row = self.to_start(j, row, weights);
                if j > point.place {
                    row = self.through_place(j, &row);
                    add_sources(&mut row, j, sources);
                }
            }
            dot(&row, &unit)
        };
        let mut alone = vec![C64::ZERO; weights.len()];
        alone[index] = C64::ONE;
        at_place(row, weights, sources) / (1.0 - at_place([C64::ZERO; 3], &alone, &[]))
    }

    fn derivatives(&self, back: &Back, factor: C64) -> FlowDerivatives {
        let (chain, n) = (self.chain, self.chain.ducts.len());
        let mut basis = self.basis.clone();
        let mut out = FlowDerivatives { feedback: vec![[C64::ZERO; 5]; n], ..FlowDerivatives::default() };
        let behind: Vec<State<ComplexDual>> = self.behind.iter().map(fixed).collect();
        for j in 0..n {
            if j > 0 {
                out.feedback[j] = EFFECTS.map(|effect| {
                    let cause =
                        if effect.of_velocity() { self.before[j][1].value } else { self.before[j][0].value };
                    dot(&back.starts[j], &chain.effect(&basis, j, effect, j - 1)) * cause
                });
            }
            // What a seed in the basis changes: the passage of this duct, and the velocities at references.
            let local = |basis: &Basis<ComplexDual>| {
                let passed = chain.pass(basis, j, &behind[j], &self.s);
                let mut total: C64 = (0..3).map(|k| back.ends[j][k] * passed[k].slope).sum();
                for (point, weight) in chain.references.iter().zip(&back.weights) {
                    total += weight * chain.velocity_at(basis, point, &behind[point.duct], &self.s).slope;
                }
                total
            };
            basis.length[j].slope = C64::ONE;
            out.lengths.push(local(&basis));
            basis.length[j].slope = C64::ZERO;
            basis.wall[j].slope = C64::ONE;
            out.walls.push(local(&basis));
            basis.wall[j].slope = C64::ZERO;
        }
        if matches!(chain.ends[0], FlowEnd::Reflection(_)) {
            let impedance = impedance(&self.basis, 0);
            out.ends[0] = back.inlet[0] + back.inlet[1] / impedance;
        }
        if matches!(chain.ends[1], FlowEnd::Reflection(_)) {
            let impedance = impedance(&self.basis, n - 1);
            let [p, u, _] = &self.before[n];
            out.ends[1] = -0.5 * factor * (p.value + impedance * u.value);
        }
        out
    }
}

impl FlowChain {
    /// First derivatives of s and of relative pressures with respect to every local coefficient, by the
    /// adjoint. What also changes the mean flow (areas, temperature ratios, the inlet), and second
    /// derivatives with their cross terms, in any set of parameters: [`FlowChain::respond`].
    ///
    /// `root` must be an eigenvalue. Cost: a sweep, and some 300 products per duct and output.
    ///
    /// # Errors
    /// As [`FlowChain::respond`].
    pub fn sensitivities(&self, root: &Root, places: &Places) -> Result<FlowSensitivities, NetworkError> {
        let n = self.ducts.len();
        if let Some(&place) = places.at.iter().chain([&places.reference]).find(|&&j| j > n) {
            return Err(NetworkError::NoDuct { index: place, ducts: n });
        }
        let passed = Passed::new(self, &self.basis, root)?;
        let pressure = |j: usize| passed.before[j][0];
        let reference = pressure(places.reference);
        let loudest = places.at.iter().map(|&j| pressure(j).value.norm()).fold(0.0, f64::max);
        if !places.at.is_empty() && reference.value.norm() <= 1e-12 * loudest {
            return Err(NetworkError::SilentReference { place: places.reference });
        }
        let output =
            |factor: C64, sources: &[(usize, C64)]| passed.derivatives(&passed.back(factor, sources), factor);
        let pressures = places.at.iter().map(|&place| {
            let p = pressure(place);
            let (relative, scale) = (p.value / reference.value, reference.value.inv());
            let in_s = (p.slope - relative * reference.slope) * scale;
            output(-in_s / passed.f.slope, &[(place, scale), (places.reference, -relative * scale)])
        });
        Ok(FlowSensitivities { s: output(-passed.f.slope.inv(), &[]), pressures: pressures.collect() })
    }
}
