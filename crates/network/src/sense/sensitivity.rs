//! Adjoint derivatives with respect to every local coefficient of the network at once.
//!
//! One backward sweep per output carries the row vector Lambda with which a disturbance of the state at any
//! point changes the output, the change of s included. The derivative with respect to a local coefficient is
//! then Lambda (dM/dtheta) v at its element: a few products each, whatever the number of coefficients.

use crate::chain::coefficients::Coefficients;
use crate::chain::line::Line;
use crate::chain::network::Network;
use crate::chain::sweep::Step;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use crate::respond::answer::Places;
use crate::slot::Slot;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// Derivatives of one output with respect to every local coefficient, in the primitive form of the adjoint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// By place 0 .. N: with respect to k_mu, k_mp, k_eu, k_ep there.
    pub feedback: Vec<[C64; 4]>,
    /// By segment: with respect to the impedance P = l (s rho + kappa_mu) and the admittance Q = l (s/(rho
    /// c^2) + kappa_ep) of the whole segment. [`Sensitivities::with_respect_to`] turns them into derivatives
    /// with respect to length, speed, density and loss.
    pub lines: Vec<[C64; 2]>,
    /// With respect to R_u and R_d.
    pub ends: [C64; 2],
    /// With respect to the characteristic impedances rho c to which R_u and R_d refer.
    pub end_impedances: [C64; 2],
}

/// First derivatives of an eigenvalue and of relative pressures with respect to every local coefficient;
/// reused from call to call.
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
    at: C64,
    first_area: f64,
    /// State upstream of each place, with its derivative in s.
    before: Vec<[ComplexDual; 2]>,
    jumps: Vec<Option<([C64; 4], C64)>>,
    lines: Vec<Passage>,
    /// rho c upstream and downstream, R_u, R_d, p and u at the downstream end.
    end: [C64; 6],
}

/// A segment as the state passed it.
#[derive(Clone, Copy, Debug)]
struct Passage {
    /// C, P S and Q S.
    matrix: [C64; 3],
    /// dM/dP v and dM/dQ v.
    pushed: [[C64; 2]; 2],
    /// P and Q.
    line: [C64; 2],
    /// Length, density, compressibility.
    bare: [C64; 3],
}

impl Sensitivities {
    /// The derivative of one output, [`Sensitivities::s`] or one of [`Sensitivities::pressures`], with
    /// respect to one slot of the network, everything else fixed.
    ///
    /// # Panics
    /// If the network has no such slot.
    #[must_use]
    pub fn with_respect_to(&self, output: &Derivatives, slot: Slot) -> C64 {
        let (record, n) = (&self.record, self.record.lines.len());
        let segment = |i: usize| {
            let Passage { line: [p, q], bare: [l, rho, compressibility], .. } = record.lines[i];
            let [by_p, by_q] = output.lines[i];
            (l, rho, p * by_p, q * by_q, record.at * l * rho * by_p, record.at * l * compressibility * by_q)
        };
        // rho c of an end segment also scales what its reflection coefficient means.
        let by_impedance = |i: usize| {
            let up = if i == 0 { record.end[0] * output.end_impedances[0] } else { C64::ZERO };
            let down = if i + 1 == n { record.end[1] * output.end_impedances[1] } else { C64::ZERO };
            up + down
        };
        match slot {
            Slot::Mu(j) => output.feedback[j][0],
            Slot::Mp(j) => output.feedback[j][1],
            Slot::Eu(j) => output.feedback[j][2],
            Slot::Ep(j) => output.feedback[j][3],
            Slot::Viscous(i) => segment(i).0 * output.lines[i][0],
            Slot::Thermal(i) => segment(i).0 * output.lines[i][1],
            Slot::Length(i) => {
                let (l, _, p, q, ..) = segment(i);
                (p + q) / l
            }
            Slot::Density(i) => {
                let (_, rho, _, _, inertia, compliance) = segment(i);
                (inertia - compliance + by_impedance(i)) / rho
            }
            Slot::SoundSpeed(i) => {
                let [_, rho, compressibility] = record.lines[i].bare;
                (by_impedance(i) - 2.0 * segment(i).5) * (rho * compressibility).sqrt()
            }
            Slot::Area(i) => {
                // The ratio A_{j-1}/A_j acts on u as 1 - k_eu does; the area itself is counted from the first
                // one.
                let ratio = |j: usize| record.jumps[j].as_ref().map_or(C64::ONE, |jump| jump.1);
                let by_log = |j: usize| -output.feedback[j][2] * ratio(j);
                let before = if i > 0 { -by_log(i) } else { C64::ZERO };
                let after = if i + 1 < n { by_log(i + 1) } else { C64::ZERO };
                let area = (1..=i).fold(record.first_area, |area, j| area / ratio(j).re);
                (before + after) / area
            }
            Slot::Upstream => output.ends[0],
            Slot::Downstream => output.ends[1],
        }
    }

    /// Condition of the eigenvalue: sum over all coefficients theta of |theta ds/dtheta| / |s|, that is, how
    /// much relative errors of the coefficients are magnified. Lengths and sound speeds alone give about 2.
    #[must_use]
    pub fn condition(&self, network: &Network, s: C64) -> f64 {
        let mut total = 0.0;
        for (i, segment) in network.segments.iter().enumerate() {
            let values = [
                (Slot::Length(i), segment.length),
                (Slot::Area(i), segment.area),
                (Slot::SoundSpeed(i), segment.sound_speed),
                (Slot::Density(i), segment.density),
            ];
            total += values.iter().map(|&(k, v)| v * self.with_respect_to(&self.s, k).norm()).sum::<f64>();
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
    /// `root` must be an eigenvalue. Cost: one forward sweep, one backward sweep per output. Results go to
    /// `out`, whose memory is reused.
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
            return Err(NetworkError::Slot { slot: Slot::Mu(place), segments: n });
        }
        self.check(coefficients, root.s, &mut work.laws)?;
        let record = &mut out.record;
        record.before.clear();
        record.jumps.clear();
        record.lines.clear();
        record.at = root.s;
        record.first_area = self.segments[0].area;
        let mut state = [C64::ZERO; 2];
        let f = self.sweep(coefficients, root.s, &mut work.laws, |step| match step {
            Step::Joint { p, u, jump, .. } => {
                record.before.push([p, u]);
                state = [p.value, u.value];
                let jump = jump.map(|(k, ratio)| (k.map(|k| k.value), ratio.value));
                if let Some(([mu, mp, eu, ep], ratio)) = &jump {
                    let [p, u] = state;
                    state = [p - mu * u - mp * p, ratio * u - eu * u - ep * p];
                }
                record.jumps.push(jump);
            }
            Step::Segment { line: Line { c, s, s1 }, coefficients: [p, q], bare, .. } => {
                let [pressure, velocity] = state;
                let (p, q) = (p.value, q.value);
                // C' = S/2 and (P S)' by q = PQ.
                let (half, diagonal) = (0.5 * s, s + p * q * s1);
                let by_p =
                    [half * q * pressure - diagonal * velocity, half * q * velocity - q * q * s1 * pressure];
                let by_q =
                    [half * p * pressure - p * p * s1 * velocity, half * p * velocity - diagonal * pressure];
                let passage =
                    Passage { matrix: [*c, p * s, q * s], pushed: [by_p, by_q], line: [p, q], bare };
                record.lines.push(passage);
            }
            Step::End { p, u, impedances: [a, b], reflections: [up, down] } => {
                record.end = [a.value, b.value, up.value, down.value, p.value, u.value];
            }
        });
        if !(f.slope.is_finite() && f.slope != C64::ZERO) {
            return Err(NetworkError::NotFinite { s: root.s });
        }
        let reference = record.before[places.reference][0];
        let loudest = places.at.iter().map(|&j| record.before[j][0].value.norm()).fold(0.0, f64::max);
        if !places.at.is_empty() && reference.value.norm() <= 1e-12 * loudest {
            return Err(NetworkError::SilentReference { place: places.reference });
        }
        out.pressures.resize_with(places.at.len(), Derivatives::default);
        let eigenvalue = Output { factor: -f.slope.inv(), sources: None };
        backward(&out.record, &eigenvalue, &mut out.s);
        for (&place, target) in places.at.iter().zip(&mut out.pressures) {
            let p = out.record.before[place][0];
            let relative = p.value / reference.value;
            let in_s = (p.slope - relative * reference.slope) / reference.value;
            let scale = reference.value.inv();
            let sources = [(place, scale), (places.reference, -relative * scale)];
            let output = Output { factor: -in_s / f.slope, sources: Some(sources) };
            backward(&out.record, &output, target);
        }
        Ok(())
    }
}

/// An output as a function of the state: `factor` times F at the end, plus sources times the pressure at
/// places.
struct Output {
    factor: C64,
    sources: Option<[(usize, C64); 2]>,
}

fn backward(record: &Record, output: &Output, out: &mut Derivatives) {
    let n = record.lines.len();
    out.feedback.resize(n + 1, [C64::ZERO; 4]);
    out.lines.resize(n, [C64::ZERO; 2]);

    let [z_up, z_down, up, down, p, u] = record.end;
    let half = 0.5 * output.factor;
    out.ends[1] = -half * (p + z_down * u);
    out.end_impedances[1] = -half * (1.0 + down) * u;
    let mut row: Row = [half * (1.0 - down), -half * (1.0 + down) * z_down];
    for j in (0..=n).rev() {
        if j < n {
            let Passage { matrix: [c, b, e], pushed: [by_p, by_q], .. } = &record.lines[j];
            out.lines[j] = [row[0] * by_p[0] + row[1] * by_p[1], row[0] * by_q[0] + row[1] * by_q[1]];
            row = [row[0] * c - row[1] * e, row[1] * c - row[0] * b];
        }
        let [p, u] = [record.before[j][0].value, record.before[j][1].value];
        out.feedback[j] = [-row[0] * u, -row[0] * p, -row[1] * u, -row[1] * p];
        if let Some(([mu, mp, eu, ep], ratio)) = &record.jumps[j] {
            row = [row[0] * (1.0 - mp) - row[1] * ep, row[1] * (ratio - eu) - row[0] * mu];
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
    out.end_impedances[0] = -row[1] * (up - 1.0) / (z_up * z_up);
}
