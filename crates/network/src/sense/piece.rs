//! A segment on the way, entered anywhere.

use crate::chain::line::line;
use rijke_numerics::C64;

/// A segment on the way: what it needs to be entered anywhere.
pub(crate) struct Piece {
    pub(super) start: [C64; 2],
    pub(super) impedance: C64,
    pub(super) admittance: C64,
    pub(crate) length: f64,
    pub(crate) rho_c: f64,
    pub(super) inertia: C64,
}

impl Piece {
    /// [[C, P S], [Q S, C]] over `x`: the inverse of its matrix; the matrix itself with the signs of P S and
    /// Q S turned.
    pub(super) fn matrix(&self, x: f64) -> [C64; 3] {
        let (p, q) = (self.impedance * x, self.admittance * x);
        let at = line(p * q);
        [at.c, p * at.s, q * at.s]
    }

    /// A row on the state, `x` upstream of where it is given.
    pub(crate) fn back(&self, row: [C64; 2], x: f64) -> [C64; 2] {
        let [c, ps, qs] = self.matrix(x);
        [row[0] * c - row[1] * qs, row[1] * c - row[0] * ps]
    }
}
