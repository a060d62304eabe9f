//! Forced response of the chain at rest: pressures and velocities of a source, impedances, transfer matrices.
//!
//! The state (p, u) goes from the upstream end with the row of the downstream end kept for later: with a unit
//! vector at either end the boundary conditions and the jump of one source make two linear equations.
//! Everything is a jet in the parameters of the laws and in s, which is i omega here, so that first and
//! second derivatives come along. Poles of what is returned are the modes: all of it is divided by the same
//! F.

use super::response::Context;
use super::values::Values;
use crate::chain::checked::beyond_range;
use crate::chain::coefficients::{At, Coefficients, Laws};
use crate::chain::network::Network;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use rijke_numerics::{C64, Jet, JetSpace, Order};

/// What drives the gas, of unit strength, at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Source {
    /// A velocity that is added to the one behind the place (volume flow per area there), m/s: a loudspeaker
    /// in the wall.
    Velocity(usize),
    /// A pressure that is added to the one behind the place, Pa.
    Pressure(usize),
    /// A wave that enters at the upstream end: its pressure there, Pa.
    Upstream,
    /// A wave that enters at the downstream end.
    Downstream,
}

impl Source {
    /// Its place, what it adds to (p, u) behind it, and the waves that enter upstream and downstream.
    fn parts(self) -> (usize, [f64; 2], [f64; 2]) {
        match self {
            Self::Velocity(j) => (j, [0.0, 1.0], [0.0; 2]),
            Self::Pressure(j) => (j, [1.0, 0.0], [0.0; 2]),
            Self::Upstream => (0, [0.0; 2], [1.0, 0.0]),
            Self::Downstream => (0, [0.0; 2], [0.0, 1.0]),
        }
    }
}

/// Pressure and velocity on both sides of every place, per unit of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct Forced {
    /// p (Pa) and u (m/s) on the upstream side, by place; at place 0 the end.
    pub before: Vec<[Jet; 2]>,
    /// The same behind the place.
    pub behind: Vec<[Jet; 2]>,
}

/// The matrix from (p, u) in front of one place to (p, u) behind another, by rows, and the wave impedances
/// rho c there.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// [[p by p, p by u], [u by p, u by u]].
    pub matrix: [[Jet; 2]; 2],
    /// rho c in front of the first place and behind the second.
    pub impedances: [Jet; 2],
}

impl Transfer {
    /// Scattering matrix: waves that leave, (reflected upstream, transmitted downstream), per waves that
    /// arrive, (from upstream, from downstream), all as pressures: [[r, t'], [t, r']].
    #[must_use]
    pub fn scattering(&self) -> [[Jet; 2]; 2] {
        // p = f + g, z u = f - g on both sides, so that (f2, g2) = M (f1, g1).
        let [[a, b], [c, d]] = &self.matrix;
        let [z1, z2] = &self.impedances;
        let (b, c, d) = (b / z1, c * z2, &(d * z2) / z1);
        let half = |x: Jet| x.scale(C64::new(0.5, 0.0));
        let sum = |p: &Jet, q: &Jet, r: &Jet, s: &Jet| half(&(&(p + q) + r) + s);
        let (m11, m12) = (sum(a, &b, &c, &d), sum(a, &-&b, &c, &-&d));
        let (m21, m22) = (sum(a, &b, &-&c, &-&d), sum(a, &-&b, &-&c, &d));
        let over = m22.recip();
        let r = -&(&m21 * &over);
        let t = &m11 + &(&m12 * &r);
        let back = &m12 * &over;
        [[r, over], [t, back]]
    }
}

impl Network {
    /// The response to one source at s = i omega, with derivatives up to `order` in the parameters of the
    /// laws; the last seed of every jet is s.
    ///
    /// # Errors
    /// [`NetworkError::Slot`] if there is no such place; [`NetworkError::NotFinite`] where the
    /// answer is infinite (close to a mode it is large, and finite), or [`NetworkError::Overflow`] far from
    /// the imaginary axis; [`NetworkError::NoLaw`] and [`NetworkError::Property`] as [`Network::solve`].
    pub fn forced<K: Coefficients + ?Sized>(
        &self,
        laws: &K,
        s: C64,
        source: Source,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Forced, NetworkError> {
        let n = self.segments.len();
        let (place, jump, waves) = source.parts();
        self.check_place(place)?;
        let finished = |before: Vec<[Jet; 2]>, behind: Vec<[Jet; 2]>| {
            let finite = |x: &[Jet; 2]| x.iter().all(|j| j.value().is_finite());
            let all = before.iter().chain(&behind).all(finite);
            if all { Ok(Forced { before, behind }) } else { Err(self.no_value(s)) }
        };
        if order == Order::Value {
            let sides = Values::new(self, laws, s, work)?.forced(place, jump, waves);
            let alone = |x: [C64; 2]| x.map(|v| value_alone(laws, v));
            let [before, behind] = sides.map(|side| side.into_iter().map(alone).collect());
            return finished(before, behind);
        }
        let at = self.filled(laws, s, order, &mut work.laws)?;
        let context = Context::new(self, &work.laws, &at);
        let [up, down] = context.reflections();
        let (z_up, z_down) = (context.impedance(0), context.impedance(n - 1));
        let one = at.space().real(1.0);
        // The state of g = 1 at the upstream end, and that of the source alone: the answer is the second plus
        // x times the first.
        let free = [&up + &one, &(&up - &one) / &z_up];
        let wave = one.scale(C64::new(waves[0], 0.0));
        let own = [wave.clone(), &wave / &z_up];
        let mut states = [free, own];
        let (mut before, mut behind) = (Vec::with_capacity(n + 1), Vec::with_capacity(n + 1));
        for j in 0..=n {
            before.push(states.clone());
            let joint = context.joint_matrix(j);
            states = states.map(|x| apply(&joint, &x));
            if j == place {
                let [p, u] = jump;
                states[1][0] = states[1][0].shift(C64::new(p, 0.0));
                states[1][1] = states[1][1].shift(C64::new(u, 0.0));
            }
            behind.push(states.clone());
            if j < n {
                let line = context.line_matrix(j, &at.s_jet());
                states = states.map(|x| apply(&line, &x));
            }
        }
        // g - R f = what enters downstream.
        let close = |[p, u]: &[Jet; 2]| {
            let wave = &z_down * u;
            (&(p - &wave) - &(&down * &(p + &wave))).scale(C64::new(0.5, 0.0))
        };
        let entering = one.scale(C64::new(waves[1], 0.0));
        let amplitude = &(&entering - &close(&states[1])) / &close(&states[0]);
        let whole = |all: Vec<[[Jet; 2]; 2]>| -> Vec<[Jet; 2]> {
            all.into_iter().map(|[free, own]| [0, 1].map(|k| &own[k] + &(&amplitude * &free[k]))).collect()
        };
        finished(whole(before), whole(behind))
    }

    /// Impedance p/u (Pa s/m) that the chain downstream of a place has, seen from just before it.
    ///
    /// # Errors
    /// As [`Network::forced`].
    pub fn impedance_at<K: Coefficients + ?Sized>(
        &self,
        laws: &K,
        s: C64,
        place: usize,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Jet, NetworkError> {
        if order == Order::Value {
            self.check_place(place)?;
            let [p, u] = Values::new(self, laws, s, work)?.seen_from(place);
            return self.finite(value_alone(laws, p / u), s);
        }
        let [p, u] = self.seen_from(laws, s, place, order, work)?;
        self.finite(&p / &u, s)
    }

    /// Reflection g/f of the chain downstream of a place, seen from just before it, with respect to rho c
    /// there.
    ///
    /// # Errors
    /// As [`Network::forced`].
    pub fn reflection_at<K: Coefficients + ?Sized>(
        &self,
        laws: &K,
        s: C64,
        place: usize,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Jet, NetworkError> {
        if order == Order::Value {
            self.check_place(place)?;
            let values = Values::new(self, laws, s, work)?;
            let [p, u] = values.seen_from(place);
            let wave = values.impedance(place.saturating_sub(1)) * u;
            return self.finite(value_alone(laws, (p - wave) / (p + wave)), s);
        }
        let [p, u] = self.seen_from(laws, s, place, order, work)?;
        let at = At::full(s, laws.parameters(), order);
        let wave = &Context::new(self, &work.laws, &at).impedance(place.saturating_sub(1)) * &u;
        self.finite(&(&p - &wave) / &(&p + &wave), s)
    }

    /// The transfer matrix from just upstream of place `from` to just downstream of place `to`.
    ///
    /// # Errors
    /// As [`Network::forced`].
    pub fn transfer<K: Coefficients + ?Sized>(
        &self,
        laws: &K,
        s: C64,
        [from, to]: [usize; 2],
        order: Order,
        work: &mut Workspace,
    ) -> Result<Transfer, NetworkError> {
        let n = self.segments.len();
        if to > n || from > to {
            return Err(NetworkError::Stretch { from, to, segments: n });
        }
        let finished = |found: Transfer| {
            let all = found.matrix.iter().flatten().chain(&found.impedances);
            let finite = all.into_iter().all(|jet| jet.value().is_finite());
            if finite { Ok(found) } else { Err(self.no_value(s)) }
        };
        if order == Order::Value {
            let values = Values::new(self, laws, s, work)?;
            let alone = |v| value_alone(laws, v);
            let impedances = [from.saturating_sub(1), to.min(n - 1)].map(|i| alone(values.impedance(i)));
            return finished(Transfer {
                matrix: values.matrix([from, to]).map(|row| row.map(alone)),
                impedances,
            });
        }
        let at = self.filled(laws, s, order, &mut work.laws)?;
        let context = Context::new(self, &work.laws, &at);
        let impedances = [context.impedance(from.saturating_sub(1)), context.impedance(to.min(n - 1))];
        let (one, zero) = (at.space().real(1.0), at.space().real(0.0));
        let mut columns = [[one.clone(), zero.clone()], [zero, one]];
        for j in from..=to {
            let joint = context.joint_matrix(j);
            columns = columns.map(|x| apply(&joint, &x));
            if j < to {
                let line = context.line_matrix(j, &at.s_jet());
                columns = columns.map(|x| apply(&line, &x));
            }
        }
        let [[a, c], [b, d]] = columns;
        finished(Transfer { matrix: [[a, b], [c, d]], impedances })
    }

    /// (p, u) before a place, up to a common factor, as the downstream end wants it.
    fn seen_from<K: Coefficients + ?Sized>(
        &self,
        laws: &K,
        s: C64,
        place: usize,
        order: Order,
        work: &mut Workspace,
    ) -> Result<[Jet; 2], NetworkError> {
        let n = self.segments.len();
        let Transfer { matrix: [[a, b], [c, d]], impedances: [_, z] } =
            self.transfer(laws, s, [place, n], order, work)?;
        let at = At::full(s, laws.parameters(), order);
        let [_, down] = Context::new(self, &work.laws, &at).reflections();
        // The row (1 - R, -(1 + R) z) annuls the state at the end: on the state before the place it is (v,
        // w), and p/u = -w/v.
        let (row_p, row_u) = ((-&down).shift(C64::ONE), &(-&down.shift(C64::ONE)) * &z);
        let v = &(&row_p * &a) + &(&row_u * &c);
        let w = &(&row_p * &b) + &(&row_u * &d);
        Ok([-&w, v])
    }

    /// An answer that is a number.
    fn finite(&self, answer: Jet, s: C64) -> Result<Jet, NetworkError> {
        if answer.value().is_finite() { Ok(answer) } else { Err(self.no_value(s)) }
    }

    /// Why there is no answer at `s`.
    fn no_value(&self, s: C64) -> NetworkError {
        beyond_range(NetworkError::NotFinite { s }, s.re, self.travel_time())
    }

    fn check_place(&self, place: usize) -> Result<(), NetworkError> {
        let segments = self.segments.len();
        let wrong = NetworkError::Slot { slot: crate::slot::Slot::Mu(place), segments };
        if place > segments { Err(wrong) } else { Ok(()) }
    }

    fn filled<K: Coefficients + ?Sized>(
        &self,
        k: &K,
        s: C64,
        order: Order,
        laws: &mut Laws,
    ) -> Result<At, NetworkError> {
        self.check_numbers(k)?;
        let at = At::full(s, k.parameters(), order);
        laws.reset(k.laws(), &at);
        k.fill(&at, laws);
        self.check_properties(laws)?;
        Ok(at)
    }
}

/// A number whose derivatives were not asked for.
fn value_alone<K: Coefficients + ?Sized>(laws: &K, value: C64) -> Jet {
    JetSpace::new(laws.parameters() + 1, Order::Value).constant(value)
}

fn apply(m: &[[Jet; 2]; 2], [p, u]: &[Jet; 2]) -> [Jet; 2] {
    [0, 1].map(|k| &(&m[k][0] * p) + &(&m[k][1] * u))
}
