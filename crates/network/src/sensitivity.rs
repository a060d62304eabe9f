//! Adjoint derivatives with respect to every local coefficient of the network at once.
//!
//! One backward sweep per output carries the row vector Lambda with which a disturbance of the state at any point
//! changes the output, the change of s included. The derivative with respect to a local coefficient is then
//! Lambda (dM/dtheta) v at its element: a few products each, whatever the number of coefficients.

use crate::chain::Network;
use crate::coefficients::Coefficients;
use crate::error::NetworkError;
use crate::newton::{Root, Workspace};
use crate::response::Places;
use crate::sweep::{Dual, Step};
use crate::transfer::Line;
use rijke_numerics::C64;

/// Derivatives of one output with respect to every local coefficient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// By place 0 .. N: with respect to k_mu, k_mp, k_eu, k_ep there.
    pub feedback: Vec<[C64; 4]>,
    /// By segment: with respect to viscous and thermal loss per metre.
    pub losses: Vec<[C64; 2]>,
    /// By segment: with respect to length, area (m^2, taken at the constant of the network where laws act on it),
    /// sound speed and density, each varied alone.
    pub properties: Vec<[C64; 4]>,
    /// With respect to R_u and R_d.
    pub ends: [C64; 2],
}

/// First derivatives of an eigenvalue and of relative pressures with respect to every local coefficient; reused from
/// call to call.
#[derive(Clone, Debug, Default)]
pub struct Sensitivities {
    /// Of s.
    pub s: Derivatives,
    /// Of the pressures at [`Places::at`] relative to [`Places::reference`], in that order.
    pub pressures: Vec<Derivatives>,
    record: Record,
}

type Row = [C64; 2];

/// The forward sweep, kept.
#[derive(Clone, Debug, Default)]
struct Record {
    /// State upstream of each place, with its derivative in s.
    before: Vec<[Dual; 2]>,
    jumps: Vec<Option<([C64; 4], C64)>>,
    /// Line functions, P, Q, and length, density, compressibility.
    lines: Vec<(Line, C64, C64, [C64; 3])>,
    end: [C64; 6],
}

impl Sensitivities {
    /// Condition of the eigenvalue: sum over all coefficients theta of |theta ds/dtheta| / |s|, that is, how much
    /// relative errors of the coefficients are magnified. Lengths and sound speeds alone give about 2.
    #[must_use]
    pub fn condition(&self, network: &Network, s: C64) -> f64 {
        let mut total = 0.0;
        for (segment, d) in network.segments.iter().zip(&self.s.properties) {
            let values = [segment.length, segment.area, segment.sound_speed, segment.density];
            total += values.iter().zip(d).map(|(v, d)| v * d.norm()).sum::<f64>();
        }
        for (jump, d) in self.record.jumps.iter().zip(&self.s.feedback) {
            if let Some((k, _)) = jump {
                total += k.iter().zip(d).map(|(k, d)| (k * d).norm()).sum::<f64>();
            }
        }
        let [_, _, upstream, downstream, ..] = self.record.end;
        total += (upstream * self.s.ends[0]).norm() + (downstream * self.s.ends[1]).norm();
        total / s.norm()
    }
}

impl Network {
    /// First derivatives of s and of the pressures with respect to every local coefficient, by the adjoint.
    ///
    /// `root` must be an eigenvalue. Cost: one forward sweep, one backward sweep per output. Results go to `out`, whose
    /// memory is reused.
    ///
    /// # Errors
    /// As [`Network::respond`].
    pub fn sensitivities<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        root: &Root,
        places: &Places,
        out: &mut Sensitivities,
        work: &mut Workspace,
    ) -> Result<(), NetworkError> {
        let n = self.segments.len();
        if let Some(&place) = places.at.iter().chain([&places.reference]).find(|&&j| j > n) {
            return Err(NetworkError::Slot { slot: crate::Slot::Mu(place), segments: n });
        }
        let record = &mut out.record;
        record.before.clear();
        record.jumps.clear();
        record.lines.clear();
        let f = self.sweep(coefficients, root.s, &mut work.laws, |step| match step {
            Step::Joint { p, u, jump, .. } => {
                record.before.push([p, u]);
                record.jumps.push(jump.map(|(k, ratio)| (k.map(|k| k.v), ratio.v)));
            }
            Step::Segment { line, coefficients: [p, q], bare, .. } => {
                record.lines.push((*line, p.v, q.v, bare));
            }
            Step::End { p, u, impedances: [a, b], reflections: [up, down] } => {
                record.end = [a.v, b.v, up.v, down.v, p.v, u.v];
            }
        });
        if !(f.d.is_finite() && f.d != C64::ZERO) {
            return Err(NetworkError::NotFinite { s: root.s });
        }
        let reference = record.before[places.reference][0];
        let loudest = places.at.iter().map(|&j| record.before[j][0].v.norm()).fold(0.0, f64::max);
        if reference.v.norm() <= 1e-12 * loudest {
            return Err(NetworkError::SilentReference { place: places.reference });
        }
        out.pressures.resize_with(places.at.len(), Derivatives::default);
        let eigenvalue = Output { factor: -f.d.inv(), sources: None };
        backward(self, root.s, &out.record, &eigenvalue, &mut out.s);
        for (&place, target) in places.at.iter().zip(&mut out.pressures) {
            let p = out.record.before[place][0];
            let relative = p.v / reference.v;
            let in_s = (p.d - relative * reference.d) / reference.v;
            let scale = reference.v.inv();
            let sources = [(place, scale), (places.reference, -relative * scale)];
            let output = Output { factor: -in_s / f.d, sources: Some(sources) };
            backward(self, root.s, &out.record, &output, target);
        }
        Ok(())
    }
}

/// An output as a function of the state: `factor` times F at the end, plus sources times the pressure at places.
struct Output {
    factor: C64,
    sources: Option<[(usize, C64); 2]>,
}

fn backward(network: &Network, s: C64, record: &Record, output: &Output, out: &mut Derivatives) {
    let n = network.segments.len();
    out.feedback.clear();
    out.feedback.resize(n + 1, [C64::ZERO; 4]);
    out.losses.clear();
    out.losses.resize(n, [C64::ZERO; 2]);
    out.properties.clear();
    out.properties.resize(n, [C64::ZERO; 4]);

    let [z_up, z_down, up, down, p, u] = record.end;
    let half = 0.5 * output.factor;
    out.ends[1] = -half * (p + z_down * u);
    let by_impedance = -half * (1.0 + down) * u;
    out.properties[n - 1][2] += by_impedance * record.lines[n - 1].3[1];
    out.properties[n - 1][3] += by_impedance * z_down / record.lines[n - 1].3[1];
    let mut row: Row = [half * (1.0 - down), -half * (1.0 + down) * z_down];
    for j in (0..=n).rev() {
        if j < n {
            row = through_segment(s, record, j, row, out);
        }
        let [p, u] = record.before[j].map(|d| d.v);
        out.feedback[j] = [-row[0] * u, -row[0] * p, -row[1] * u, -row[1] * p];
        let by_ratio = row[1] * u;
        let mut ratio = C64::ONE;
        if let Some(([mu, mp, eu, ep], areas)) = &record.jumps[j] {
            ratio = *areas;
            row = [row[0] * (1.0 - mp) - row[1] * ep, row[1] * (ratio - eu) - row[0] * mu];
        }
        if j > 0 && j < n {
            // ratio = A_{j-1}/A_j.
            out.properties[j - 1][1] += by_ratio * ratio / network.segments[j - 1].area;
            out.properties[j][1] -= by_ratio * ratio / network.segments[j].area;
        }
        if let Some(sources) = &output.sources {
            for &(place, weight) in sources {
                if place == j {
                    row[0] += weight;
                }
            }
        }
    }
    out.ends[0] = row[0] + row[1] / z_up;
    let by_impedance = -row[1] * (up - 1.0) / (z_up * z_up);
    out.properties[0][2] += by_impedance * record.lines[0].3[1];
    out.properties[0][3] += by_impedance * z_up / record.lines[0].3[1];
}

/// Derivatives of segment `i`, and the row vector upstream of it.
fn through_segment(s: C64, record: &Record, i: usize, row: Row, out: &mut Derivatives) -> Row {
    let (Line { c, s: sh, s1 }, p, q, [l, rho, compressibility]) = record.lines[i];
    let [mut pressure, mut velocity] = record.before[i].map(|d| d.v);
    if let Some(([mu, mp, eu, ep], ratio)) = &record.jumps[i] {
        (pressure, velocity) =
            (pressure - mu * velocity - mp * pressure, ratio * velocity - eu * velocity - ep * pressure);
    }
    // M = [[C, -P S], [-Q S, C]]; C' = S/2 by q = PQ.
    let pq = p * q;
    let diagonal = row[0] * pressure + row[1] * velocity;
    let (upper, lower) = (row[0] * velocity, row[1] * pressure);
    let by_p = 0.5 * sh * q * diagonal - (sh + pq * s1) * upper - q * q * s1 * lower;
    let by_q = 0.5 * sh * p * diagonal - p * p * s1 * upper - (sh + pq * s1) * lower;
    out.losses[i] = [l * by_p, l * by_q];
    let inertia = l * s * by_p;
    let compliance = s * l * compressibility * by_q;
    let speed = (rho * compressibility).sqrt().inv();
    let properties = &mut out.properties[i];
    properties[0] += (p * by_p + q * by_q) / l;
    properties[2] -= 2.0 / speed * compliance;
    properties[3] += inertia - compliance / rho;
    [row[0] * c - row[1] * q * sh, row[1] * c - row[0] * p * sh]
}
