//! Sources that answer to a velocity at a distance, in sensitivities along x.
//!
//! The coefficients k_eu and k_ep of such a source say what the velocity v at its reference is in terms of
//! the state beside the source, for ducts as they are in between. A change in between makes that untrue. With
//! v = beta p + alpha u from the state at any x in between:
//!
//! * upstream, the source adds -k_eu u - k_ep p, which a change in between does not reach: the row that these
//!   coefficients put upstream of the source is taken away again up to the reference;
//! * downstream, u2 = r u1 + T v, so that k_eu = -r T alpha/(1 - T alpha) and k_ep = -T beta/(1 - T alpha): a
//!   change in between changes the reference too, which adds Lambda_u T/(1 - T alpha) times (beta, alpha) to
//!   the row.

use super::piece::Piece;
use crate::chain::coefficients::{Coefficients, Laws};
use crate::chain::network::Network;
use rijke_numerics::C64;
use std::ops::RangeInclusive;

/// k_eu and k_ep of one source, and how far downstream its reference lies, m (upstream if negative).
pub(crate) struct DistantReference {
    place: usize,
    coefficients: [C64; 2],
    distance: f64,
}

/// What is added to the row Lambda, given at the upstream end of a segment, for changes within a stretch of
/// it.
pub(crate) struct Change {
    pub(crate) segment: usize,
    pub(crate) within: RangeInclusive<f64>,
    pub(crate) row: [C64; 2],
}

impl Network {
    /// The sources at `place` whose reference lies at a distance, with the laws as they are in `laws`.
    pub(crate) fn distant_references<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        place: usize,
        laws: &Laws,
    ) -> Vec<DistantReference> {
        let mut all: Vec<DistantReference> = Vec::new();
        for a in self.attached(1 + 2 * place).iter().filter(|a| a.kind >= 2) {
            let Some(distance) = coefficients.reference_at(a.law) else { continue };
            let k = a.weight * laws.value(a.law);
            match all.iter_mut().find(|h| h.distance == distance) {
                Some(known) => known.coefficients[a.kind - 2] += k,
                None => {
                    let mut both = [C64::ZERO; 2];
                    both[a.kind - 2] = k;
                    all.push(DistantReference { place, coefficients: both, distance });
                }
            }
        }
        all
    }
}

impl DistantReference {
    pub(crate) fn changes(
        &self,
        pieces: &[Piece],
        jumps: &[Option<([C64; 4], C64)>],
        rows: &[[C64; 2]],
    ) -> Vec<Change> {
        let ratio = |j: usize| jumps[j].map_or(C64::ONE, |jump| jump.1);
        let [eu, ep] = self.coefficients;
        if self.distance < 0.0 {
            let Some(behind) = rows.get(self.place) else { return Vec::new() };
            let mut row = [behind[1] * ep, behind[1] * eu];
            let mut left = -self.distance;
            let mut out = Vec::new();
            for i in (0..self.place).rev() {
                if left <= 0.0 {
                    break;
                }
                let length = pieces[i].length;
                row = pieces[i].back(row, length);
                out.push(Change { segment: i, within: (length - left).max(0.0)..=length, row });
                row[1] *= ratio(i);
                left -= length;
            }
            return out;
        }
        // From the reference back to the source.
        let mut ends = Vec::new();
        let mut left = self.distance;
        for (i, piece) in pieces.iter().enumerate().skip(self.place) {
            if left <= 0.0 {
                break;
            }
            ends.push((i, left.min(piece.length)));
            left -= piece.length;
        }
        let mut row = [C64::ZERO, C64::ONE];
        let mut out = Vec::new();
        for (i, reach) in ends.into_iter().rev() {
            row = pieces[i].back(row, reach);
            out.push(Change { segment: i, within: 0.0..=reach, row });
            if i > self.place {
                row[1] *= ratio(i);
            }
        }
        let (Some(behind), Some(first)) = (rows.get(self.place), pieces.get(self.place)) else { return out };
        let [beta, alpha] = row;
        // T/(1 - T alpha), from the larger of the two coefficients.
        let gain = if alpha.norm() >= beta.norm() * first.rho_c {
            -eu / (ratio(self.place) * alpha)
        } else {
            -ep / beta
        };
        for change in &mut out {
            change.row = change.row.map(|r| behind[1] * gain * r);
        }
        out
    }
}
