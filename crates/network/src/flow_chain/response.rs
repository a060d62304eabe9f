//! Derivatives of an eigenvalue and mode with flow with respect to what the chain is made of, by jets through
//! the whole chain, mean states included.

use super::assembly::FlowChain;
use super::ducts::ActionKind;
use super::gate::Basis;
use super::number::Seeded;
use crate::chain::coefficients::Laws;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use crate::respond::answer::implicit;
use rijke_numerics::{C64, ComplexDual, Jet, JetSpace, Order};

/// A real quantity of a flow chain to differentiate by. Ducts are numbered from 0; "at" a duct means at its
/// upstream end.
#[derive(Clone, Copy)]
enum FlowParameter {
    /// Velocity of the inlet state, m/s; pressure and density stay.
    Velocity,
    /// Density of the inlet state, kg/m^3; pressure and velocity stay.
    Density,
    /// Length of a duct, m.
    Length(usize),
    /// Area of a duct, m^2; both places beside it follow.
    Area(usize),
    /// Factor (1) on the wall loss of a duct.
    Wall(usize),
    /// Factor (1) on everything that acts at a duct.
    Gain(usize),
    /// A coefficient (0) of weak feedback at a duct, beside what acts there: [`ActionKind`] says which.
    Weak(usize, ActionKind),
    /// ln |R| of the upstream (0) or downstream (1) reflection coefficient.
    LogModulus(usize),
}

/// Ducts that are told apart in a condition, whose cost is that of their number squared.
const MOST_APART: usize = 160;

impl FlowChain {
    /// The chain in jets of first order of the parameters and s, which is the last seed; laws of a caller
    /// depend on s alone.
    fn seeded(&self, s: C64, parameters: &[FlowParameter], laws: &Laws) -> (Basis<Seeded>, Jet) {
        let p = parameters.len();
        let space = JetSpace::new(p + 1, Order::First);
        let one = Seeded::Fixed(C64::ONE);
        let s = space.seed(p, s);
        let law = |k: usize| Seeded::new(s.compose(laws.value(k), laws.slope(k), C64::ZERO));
        let mut basis = self.unsettled_with(&one, &law);
        for (k, &parameter) in parameters.iter().enumerate() {
            use FlowParameter as P;
            let seed = Seeded::Varying(space.seed(k, C64::ZERO));
            let target = match parameter {
                P::Weak(i, effect) => {
                    basis.beside[i].push((effect, seed));
                    continue;
                }
                P::Velocity => &mut basis.inlet.velocity,
                P::Density => &mut basis.inlet.density,
                P::Length(i) => &mut basis.length[i],
                P::Area(i) => &mut basis.area[i],
                P::Wall(i) => &mut basis.wall[i],
                P::Gain(i) => &mut basis.gain[i],
                P::LogModulus(i) => &mut basis.ends[i],
            };
            *target = target.clone() + seed;
        }
        basis.settle(&self.ducts, &self.attached);
        (basis, s)
    }

    /// s as a function of the seeds of `basis`, and the pressure at every place as one of seeds and s, the
    /// last seed.
    pub(super) fn of_seeds(
        &self,
        basis: &Basis<Seeded>,
        s: Jet,
    ) -> Result<(Jet, Vec<Option<Jet>>), NetworkError> {
        let at = s.value();
        let mut pressures = vec![None; self.ducts.len() + 1];
        let f = self.sweep(basis, &Seeded::Varying(s.clone()), |j, x, _| {
            pressures[j] = Some(x[0].clone().jet(&s));
        });
        let s = implicit(&f.jet(&s), at);
        if s.gradient().iter().chain(s.hessian_packed()).all(|z| z.is_finite()) {
            Ok((s, pressures))
        } else {
            Err(NetworkError::NotFinite { s: at })
        }
    }

    /// Condition of the eigenvalue: sum of |theta ds/dtheta|/|s| over lengths, areas, the inlet's density and
    /// velocity, everything that acts, walls and the moduli of the ends, as
    /// [`crate::Sensitivities::condition`]; an end of a small |R| counts as one of |R| near 1. In a
    /// staircase of many pieces every so many-th one stands for those beside it.
    pub(super) fn condition_with(
        &self,
        basis: &Basis<ComplexDual>,
        root: &Root,
        laws: &Laws,
    ) -> Result<f64, NetworkError> {
        use FlowParameter as P;
        let mut parameters = vec![
            (P::Velocity, basis.inlet.velocity.value.re),
            (P::Density, basis.inlet.density.value.re),
            (P::LogModulus(0), 1.0),
        ];
        parameters.push((P::LogModulus(1), 1.0));
        let every = 1 + self.ducts.len() / MOST_APART;
        for (i, duct) in self.ducts.iter().enumerate() {
            let plain = duct.actions.is_empty() && basis.beside[i].is_empty();
            let next_is_smooth = self.ducts.get(i + 1).is_some_and(|next| next.smooth);
            let weight = match duct.smooth && next_is_smooth && plain {
                true if i % every > 0 => continue,
                true => every as f64,
                false => 1.0,
            };
            let [length, area] = [basis.length[i], basis.area[i]].map(|v| weight * v.value.re);
            parameters.extend([(P::Length(i), length), (P::Area(i), area)]);
            if duct.wall.is_some() || basis.loss[i].is_some() {
                parameters.push((P::Wall(i), weight));
            }
            if !duct.actions.is_empty() {
                parameters.push((P::Gain(i), 1.0));
            }
            parameters
                .extend(basis.beside[i].iter().map(|(effect, k)| (P::Weak(i, *effect), k.value.norm())));
        }
        let mut total = 0.0;
        // A few seeds at a time: the cost of a jet grows with their number.
        for some in parameters.chunks(16) {
            let seeds: Vec<P> = some.iter().map(|p| p.0).collect();
            let (basis, s) = self.seeded(root.s, &seeds, laws);
            let s = self.of_seeds(&basis, s)?.0;
            total += some.iter().zip(s.gradient()).map(|((_, v), d)| v * d.norm()).sum::<f64>();
        }
        Ok(total / root.s.norm())
    }
}
