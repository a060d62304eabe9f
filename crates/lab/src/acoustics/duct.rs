//! The laboratory's own acoustics: the line dp/dx = -Z U + M p, dU/dx = -Y p + M U is integrated over x from
//! the top end down, with continuous c(x), and closed at the bottom end, where the loudspeaker acts.
//!
//! The integrator is the Magnus series to fourth order (Blanes, Casas, Oteo & Ros, Phys. Rep. 470, 2009):
//! exact where the gas is uniform, error of order h^4 where it is not.

use super::obstacle::Obstacle;
use super::radiation::OpenEnd;
use super::walls::{Line, Section, principal_root};
use rijke_numerics::C64;
use rijke_rig::GasState;

/// A tube as a pile of pieces.
#[derive(Clone, Debug)]
pub struct FineTube {
    /// Every different combination of cross-section and gas that occurs.
    pub media: Vec<(Section, GasState)>,
    /// From the top end down.
    pub pieces: Vec<Piece>,
    /// The top end.
    pub top: TubeEnd,
    /// The bottom end.
    pub bottom: TubeEnd,
}

/// One piece of the tube.
#[derive(Clone, Debug)]
pub enum Piece {
    /// A stretch of line.
    Line {
        /// Length, m.
        length: f64,
        /// Medium at the lower and at the upper Gauss point, (1/2 -+ 1/sqrt(12)) of the length.
        media: [usize; 2],
        /// u/c^2, s/m: to first order in the Mach number a mean flow u multiplies both waves by e^{s u
        /// x/c^2}.
        drift: f64,
    },
    /// The pressure here is what this microphone hears.
    Microphone(usize),
    /// Something across the tube.
    Obstacle(Box<Obstacle>),
}

/// An open end with the gas around it.
#[derive(Clone, Debug)]
pub struct TubeEnd {
    /// Its geometry.
    pub end: OpenEnd,
    /// Area left open by what reaches through it, m^2.
    pub open_area: f64,
    /// The gas there.
    pub gas: GasState,
    /// Pressure lost by what flows in, per velocity, Pa s/m: where a mean flow G enters from rest with loss
    /// K, total pressure is constant and the sound loses (1 + K) G u. Nothing is lost where a jet leaves.
    pub entry_loss: f64,
}

/// One march through the tube, for unit volume velocity out of the top end.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Pressure at the microphones, Pa.
    pub pressures: Vec<C64>,
    /// The source pressure at the bottom end that would drive it, Pa; zero at an eigenvalue.
    pub drive: C64,
}

/// A natural oscillation of the tube.
#[derive(Clone, Debug, PartialEq)]
pub struct FineMode {
    /// Growth rate + i angular frequency.
    pub s: C64,
    /// Residue of the response at the microphones to the source pressure, 1/s: shape and strength in one.
    pub residue: Vec<C64>,
}

impl TubeEnd {
    /// p/U, U out of the tube, at complex frequency `s`.
    #[must_use]
    pub fn impedance(&self, s: C64) -> C64 {
        self.end.impedance(&self.gas, self.open_area, s) + self.entry_loss / self.open_area
    }
}

impl FineTube {
    /// Marches from top to bottom at complex frequency `s`.
    #[must_use]
    pub fn march(&self, s: C64) -> Shot {
        let lines: Vec<Line> = self.media.iter().map(|(section, gas)| section.line(gas, s)).collect();
        let (mut p, mut u) = (self.top.impedance(s), C64::ONE);
        let mut pressures = Vec::new();
        // The mean flow multiplies both waves by the same e^{-s delay}, which no piece changes: it is left to
        // the end.
        let mut delay = 0.0;
        for piece in &self.pieces {
            match piece {
                Piece::Line { length, media: [lower, upper], drift } => {
                    (p, u) = Stretch::new(&lines[*lower], &lines[*upper], *length).descend((p, u));
                    delay += drift * length;
                }
                Piece::Obstacle(obstacle) => (p, u) = obstacle.descend(s, (p, u)),
                Piece::Microphone(m) => {
                    pressures.resize(pressures.len().max(m + 1), C64::ZERO);
                    pressures[*m] = p * (-s * delay).exp();
                }
            }
        }
        // The bottom end's outward velocity is -U.
        Shot { pressures, drive: (p + self.bottom.impedance(s) * u) * (-s * delay).exp() }
    }

    /// Pressure at the microphones per source pressure, at complex frequency `s`.
    #[must_use]
    pub fn response(&self, s: C64) -> Vec<C64> {
        let march = self.march(s);
        march.pressures.iter().map(|p| p / march.drive).collect()
    }

    /// The mode that the secant method finds from `guess`; none if it does not converge in 40 steps.
    #[must_use]
    pub fn mode(&self, guess: C64) -> Option<FineMode> {
        let drive = |s| self.march(s).drive;
        let (mut s, mut before) = (guess, guess * (1.0 + 1e-5));
        let mut last = drive(before);
        for _ in 0..40 {
            let here = drive(s);
            let step = here * (s - before) / (here - last);
            (before, last) = (s, here);
            s -= step;
            if step.norm() < 1e-12 * s.norm() {
                let strength = slope(drive, s).inv();
                let residue = self.march(s).pressures.iter().map(|p| p * strength).collect();
                return Some(FineMode { s, residue });
            }
        }
        None
    }
}

/// Derivative of an analytic function by four points on a circle: error of order h^4, no cancellation to
/// speak of.
fn slope(f: impl Fn(C64) -> C64, s: C64) -> C64 {
    let h = 1e-3 * s.norm();
    let i = C64::I;
    (f(s + h) - f(s - h) - i * (f(s + i * h) - f(s - i * h))) / (4.0 * h)
}

/// A stretch is short if q^2 is below this: what the series of cosh q and sinh q / q leave out is below
/// 1e-17.
const SHORT: f64 = 0.02;

/// The exponential of the Magnus series h/2 (A1 + A2) - h^2 sqrt(3)/12 [A1, A2], A = [[0, -Z], [-Y, 0]], of a
/// stretch: cosh q + sinh q / q [[a, b], [c, -a]].
pub(crate) struct Stretch {
    cosh: C64,
    sinhc: C64,
    a: C64,
    b: C64,
    c: C64,
}

impl Stretch {
    /// A stretch of length `h`, m, from its lines at the lower and the upper Gauss point.
    pub(crate) fn new(lower: &Line, upper: &Line, h: f64) -> Self {
        let (z1, z2, y1, y2) = (lower.impedance, upper.impedance, lower.admittance, upper.admittance);
        let (b, c) = (-0.5 * h * (z1 + z2), -0.5 * h * (y1 + y2));
        let a = -h * h * 3.0_f64.sqrt() / 12.0 * (z1 * y2 - z2 * y1);
        // exp of the traceless matrix [[a, b], [c, -a]] with q^2 = a^2 + bc; even in q, so the branch does
        // not matter.
        let square = a * a + b * c;
        let (cosh, sinhc) = if square.norm_sqr() < SHORT * SHORT {
            let series =
                |orders: [f64; 5]| orders.iter().rev().fold(C64::ONE, |sum, n| 1.0 + sum * square / n);
            (series([2.0, 12.0, 30.0, 56.0, 90.0]), series([6.0, 20.0, 42.0, 72.0, 110.0]))
        } else {
            let q = if square.re > 0.0 { principal_root(square) } else { C64::I * principal_root(-square) };
            let up = q.exp();
            let down = up.inv();
            (0.5 * (up + down), 0.5 * (up - down) / q)
        };
        Self { cosh, sinhc, a, b, c }
    }

    /// From the bottom of the stretch to its top.
    pub(crate) fn ascend(&self, (p, u): (C64, C64)) -> (C64, C64) {
        let Self { cosh, sinhc, a, b, c } = self;
        ((cosh + sinhc * a) * p + sinhc * b * u, (cosh - sinhc * a) * u + sinhc * c * p)
    }

    /// From its top to its bottom: the inverse.
    fn descend(&self, (p, u): (C64, C64)) -> (C64, C64) {
        let Self { cosh, sinhc, a, b, c } = self;
        ((cosh - sinhc * a) * p - sinhc * b * u, (cosh + sinhc * a) * u - sinhc * c * p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rijke_numerics::check;
    use rijke_rig::{Gas, GasState};

    fn gas(t: f64) -> GasState {
        Gas::air().at(t, 101_325.0)
    }

    fn section() -> Section {
        Section { radius: 0.0237, roughness: 1.0, rods: vec![] }
    }

    /// A metre of tube with linear temperature from `cold` to `hot`, in `n` steps, microphones at the bottom.
    fn duct(n: usize, cold: f64, hot: f64) -> FineTube {
        let h = 1.0 / n as f64;
        let (mut media, mut pieces) = (Vec::new(), Vec::new());
        for k in (0..n).rev() {
            let g = 12.0_f64.sqrt().recip();
            for at in [0.5 - g, 0.5 + g] {
                media.push((section(), gas(cold + (hot - cold) * (k as f64 + at) * h)));
            }
            let last = media.len() - 1;
            pieces.push(Piece::Line { length: h, media: [last - 1, last], drift: 0.0 });
        }
        pieces.push(Piece::Microphone(0));
        let end = OpenEnd { inner_radius: 0.0237, outer_radius: 0.0254, absorption: 0.0, extension: 0.0 };
        let mouth = |t| TubeEnd { end, open_area: section().open_area(), gas: gas(t), entry_loss: 0.0 };
        FineTube { media, pieces, top: mouth(hot), bottom: mouth(cold) }
    }

    #[test]
    fn exact_uniform_tube_does_not_depend_on_steps() {
        let guess = C64::new(-10.0, 1040.0);
        let (one, many) =
            (duct(1, 300.0, 300.0).mode(guess).unwrap(), duct(17, 300.0, 300.0).mode(guess).unwrap());
        assert!((one.s - many.s).norm() < 1e-9 * one.s.norm());
        assert!((one.residue[0] - many.residue[0]).norm() < 1e-8 * one.residue[0].norm());
    }

    #[test]
    fn oracle_uniform_tube_against_the_closed_form_of_a_lossy_line() {
        // R^2 e^{-2 gamma L} = 1 with the reflection of the open end seen by the line's own wave impedance.
        let tube = duct(1, 300.0, 300.0);
        let s = tube.mode(C64::new(-10.0, 1040.0)).unwrap().s;
        let line = section().line(&gas(300.0), s);
        let wave = line.impedance.sqrt() / line.admittance.sqrt();
        let load = tube.top.end.impedance(&gas(300.0), section().open_area(), s) / wave;
        let r = (load - 1.0) / (load + 1.0);
        let gamma = line.impedance.sqrt() * line.admittance.sqrt();
        assert!((r * r * (-2.0 * gamma).exp() - 1.0).norm() < 1e-9);
    }

    #[test]
    fn order_four_in_a_temperature_gradient() {
        let s = |n| duct(n, 290.0, 700.0).mode(C64::new(-10.0, 1200.0)).unwrap().s;
        let exact = s(256);
        let errors: Vec<f64> = [2, 4, 8, 16].iter().map(|n| (s(*n) - exact).norm()).collect();
        let slopes: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        check::slopes_near(&slopes, 4.0, 0.2);
    }

    #[test]
    fn oracle_response_near_a_mode_is_its_residue() {
        let tube = duct(1, 300.0, 300.0);
        let mode = tube.mode(C64::new(-10.0, 1040.0)).unwrap();
        let near = C64::new(1e-4, 1e-4);
        let response = tube.response(mode.s + near)[0] * near;
        assert_relative_eq!(response.norm(), mode.residue[0].norm(), max_relative = 1e-5);
    }
}
