//! Values of forced responses without derivatives: what `forced` computes with jets, of plain numbers.

use super::response::area_laws;
use crate::chain::coefficients::{At, Coefficients, Laws};
use crate::chain::line::line;
use crate::chain::network::{DENSITY, Network, SOUND_SPEED};
use crate::chain::sweep::take;
use crate::chain::workspace::Workspace;
use rijke_numerics::C64;

/// A network and its laws at one s.
pub(super) struct Values<'a> {
    network: &'a Network,
    laws: &'a Laws,
    s: C64,
}

impl<'a> Values<'a> {
    pub(super) fn new<K: Coefficients + ?Sized>(
        network: &'a Network,
        laws: &K,
        s: C64,
        work: &'a mut Workspace,
    ) -> Self {
        let at = At::search(s);
        work.laws.reset(laws.laws(), &at);
        laws.fill(&at, &mut work.laws);
        Self { network, laws: &work.laws, s }
    }

    /// rho c of segment `i`.
    pub(super) fn impedance(&self, i: usize) -> C64 {
        let [density, speed] = [DENSITY, SOUND_SPEED].map(|kind| self.network.property(i, kind, self.laws).v);
        density * speed
    }

    /// The matrix of (p, u) from just before place `from` to just behind place `to`, by rows.
    pub(super) fn matrix(&self, [from, to]: [usize; 2]) -> [[C64; 2]; 2] {
        let Self { network, laws, s } = *self;
        let area_laws = area_laws(network);
        let mut columns = [[C64::ONE, C64::ZERO], [C64::ZERO, C64::ONE]];
        let mut advance = |[[a, b], [c, d]]: [[C64; 2]; 2]| {
            columns = columns.map(|[p, u]| [a * p + b * u, c * p + d * u]);
        };
        let first = network.attachments.partition_point(|a| a.key < 1 + 2 * from);
        let mut rest = &network.attachments[first..];
        for j in from..=to {
            let here = take(&mut rest, 1 + 2 * j);
            if !here.is_empty() || area_laws || network.jumps(j) {
                let [mu, mp, eu, ep] = here.iter().fold(network.feedback[j], |mut k, a| {
                    k[a.kind] += a.weight * laws.value(a.law);
                    k
                });
                advance([[1.0 - mp, -mu], [-ep, network.area_ratio(j, laws) - eu]]);
            }
            if j < to {
                let here = take(&mut rest, 2 + 2 * j);
                let ([p, q], _) = network.line_coefficients(j, s, here, laws);
                let at = line(p.v * q.v);
                advance([[at.c, -(p.v * at.s)], [-(q.v * at.s), at.c]]);
            }
        }
        let [[a, c], [b, d]] = columns;
        [[a, b], [c, d]]
    }

    /// (p, u) before a place, up to a common factor, as the downstream end wants it.
    pub(super) fn seen_from(&self, place: usize) -> [C64; 2] {
        let Self { network, laws, .. } = *self;
        let n = network.segments.len();
        let end = network.attached(2 + 2 * n).iter();
        let r = end.fold(network.ends[1], |r, a| r + a.weight * laws.value(a.law));
        let [[a, b], [c, d]] = self.matrix([place, n]);
        let (row_p, row_u) = (1.0 - r, -(1.0 + r) * self.impedance(n - 1));
        [-(row_p * b + row_u * d), row_p * a + row_u * c]
    }
}
