//! What a small change anywhere along the chain does to an eigenvalue, and the mode itself, as functions of
//! x.
//!
//! With Lambda(x) the row that turns a disturbance of the state (p, u) at x into a change of s (see
//! [`crate::Sensitivities`]), a weak feedback at x changes s by -Lambda_p u per k_mu, -Lambda_p p per k_mp,
//! -Lambda_u u per k_eu and -Lambda_u p per k_ep. A relative change a(x) of the area adds -(da/dx) u to
//! du/dx, so that by parts ds is the integral of (Lambda_u u)' a, with (Lambda_u u)' = Lambda_p Z u -
//! Lambda_u Y p.
//!
//! Between a source and a velocity at a distance to which it answers ([`Coefficients::reference_at`]) its
//! coefficients k_eu, k_ep, which stand for that velocity, change too: see `DistantReference`.

use super::distant_reference::Change;
use super::piece::Piece;
use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::chain::sweep::Step;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// The mode and the sensitivities at one x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// m from the upstream end.
    pub x: f64,
    /// The segment it lies in.
    pub segment: usize,
    /// Pressure and velocity of the mode, of the largest pressure among the stations, which is 1; the
    /// velocity times rho c of the segment.
    pub pressure: C64,
    /// See `pressure`.
    pub velocity: C64,
    /// ds per k_mu (Pa s/m), k_mp, k_eu and k_ep (m/(Pa s)) of a weak feedback put there, 1/s each.
    pub feedback: [C64; 4],
    /// ds per k_ep of a side branch, which takes mass where k_ep takes heat; the same without mean flow.
    pub branch: C64,
    /// rho c there, Pa s/m: k_mu = e rho c and k_ep = e/(rho c) are devices of dimensionless strength e.
    pub impedance: f64,
    /// ds per metre over which the area is larger by a fraction, per that fraction, 1/(s m).
    pub area: C64,
    /// ds per metre over which the temperature is higher by a fraction at the same pressure, per that
    /// fraction, 1/(s m). Laws of wall losses stay as they are.
    pub temperature: C64,
}

/// A weak device that is put into the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// A screen that takes e rho c u from the pressure.
    Drag,
    /// A gauze or flame that adds e u to the velocity, in phase.
    Heat,
    /// A leak or absorber that takes e p/(rho c) from the velocity.
    Leak,
}

impl Station {
    /// Change of s per strength e of a weak device here, 1/s.
    #[must_use]
    pub fn device(&self, device: Device) -> C64 {
        let [mu, _, eu, _] = self.feedback;
        match device {
            Device::Drag => mu * self.impedance,
            Device::Heat => -eu,
            Device::Leak => self.branch / self.impedance,
        }
    }
}

/// Most stations of one answer.
const MOST: usize = 10_000_000;

/// Fails for more stations than anyone can use.
pub(crate) fn bounded(samples: usize, segments: usize) -> Result<(), NetworkError> {
    match samples.checked_mul(segments) {
        Some(all) if all <= MOST => Ok(()),
        _ => Err(NetworkError::Samples { samples, segments, most: MOST }),
    }
}

impl Network {
    /// The mode at `root` and its sensitivities at `samples` points of every segment, ends included (at least
    /// 2).
    ///
    /// Cost: two passes over the chain and some thirty products per station.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`] where dF/ds vanishes or a law has no value; [`NetworkError::Samples`] for
    /// more than ten million stations; [`NetworkError::NoLaw`] and [`NetworkError::Property`] as
    /// [`Network::solve`].
    pub fn along<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        root: &Root,
        samples: usize,
        work: &mut Workspace,
    ) -> Result<Vec<Station>, NetworkError> {
        bounded(samples, self.segments.len())?;
        self.check(coefficients, root.s, &mut work.laws)?;
        let mut pieces: Vec<Piece> = Vec::with_capacity(self.segments.len());
        let mut jumps: Vec<Option<([C64; 4], C64)>> = Vec::new();
        let mut state = [C64::ZERO; 2];
        let mut end = [C64::ZERO; 2];
        let f = self.sweep(coefficients, root.s, &mut work.laws, |step| match step {
            Step::Joint { p, u, jump, .. } => {
                let (p, u) = (p.value, u.value);
                state = jump.map_or([p, u], |(k, ratio)| {
                    let [mu, mp, eu, ep] = k.map(|k: ComplexDual| k.value);
                    [p - mu * u - mp * p, ratio.value * u - eu * u - ep * p]
                });
                jumps.push(jump.map(|(k, ratio)| (k.map(|k| k.value), ratio.value)));
            }
            Step::Segment { coefficients: [p, q], bare: [l, density, compliance], .. } => {
                pieces.push(Piece {
                    start: state,
                    impedance: p.value / l,
                    admittance: q.value / l,
                    length: l.re,
                    rho_c: (density.re / compliance.re).sqrt(),
                    inertia: root.s * density,
                })
            }
            Step::End { impedances, reflections, .. } => {
                let z = impedances[1].value;
                end = [0.5 * (1.0 - reflections[1].value), -0.5 * (1.0 + reflections[1].value) * z];
            }
        });
        let factor = -f.slope.inv();
        let mut row = end.map(|r| r * factor);
        // Lambda at the upstream end of every segment.
        let mut rows = vec![[C64::ZERO; 2]; pieces.len()];
        for (i, piece) in pieces.iter().enumerate().rev() {
            if let Some((k, ratio)) = &jumps[i + 1] {
                let [mu, mp, eu, ep] = k;
                row = [row[0] * (1.0 - mp) - row[1] * ep, row[1] * (ratio - eu) - row[0] * mu];
            }
            row = piece.back(row, piece.length);
            rows[i] = row;
        }
        let mut changes: Vec<Change> = Vec::new();
        for place in 0..=pieces.len() {
            for reference in self.distant_references(coefficients, place, &work.laws) {
                changes.extend(reference.changes(&pieces, &jumps, &rows));
            }
        }
        let last = samples.max(2) - 1;
        let (mut stations, mut x) = (Vec::new(), 0.0);
        for (i, piece) in pieces.iter().enumerate() {
            for k in 0..=last {
                let within = piece.length * (k as f64 / last as f64);
                let mut row = rows[i];
                for change in changes.iter().filter(|c| c.segment == i && c.within.contains(&within)) {
                    row = [row[0] + change.row[0], row[1] + change.row[1]];
                }
                stations.push(piece.station(i, x, within, row));
            }
            x += piece.length;
        }
        of_loudest(stations, root.s)
    }
}

/// The stations with pressures and velocities of the largest pressure among them.
pub(crate) fn of_loudest(mut stations: Vec<Station>, s: C64) -> Result<Vec<Station>, NetworkError> {
    let loudest =
        stations.iter().map(|s| s.pressure).fold(C64::ZERO, |a, b| if b.norm() > a.norm() { b } else { a });
    for station in &mut stations {
        station.pressure /= loudest;
        station.velocity /= loudest;
    }
    if stations.iter().all(|s| s.area.is_finite() && s.pressure.is_finite()) {
        Ok(stations)
    } else {
        Err(NetworkError::NotFinite { s })
    }
}

impl Piece {
    /// `row` is that at the upstream end of the piece, which lies at `x`.
    fn station(&self, segment: usize, x: f64, within: f64, row: [C64; 2]) -> Station {
        let [c, ps, qs] = self.matrix(within);
        let [p0, u0] = self.start;
        let (p, u) = (c * p0 - ps * u0, c * u0 - qs * p0);
        let (on_p, on_u) = (row[0] * c + row[1] * qs, row[0] * ps + row[1] * c);
        Station {
            x: x + within,
            segment,
            pressure: p,
            velocity: u * self.rho_c,
            feedback: [-on_p * u, -on_p * p, -on_u * u, -on_u * p],
            branch: -on_u * p,
            impedance: self.rho_c,
            area: on_p * self.impedance * u - on_u * self.admittance * p,
            temperature: on_p * self.inertia * u,
        }
    }
}
