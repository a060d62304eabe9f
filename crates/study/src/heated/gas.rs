//! The gas at one operating point, and a reading of it.

use crate::cause::Cause;

/// What one operating point brings to the model of the heated gas.
pub(super) struct Heated {
    pub(super) ambient: [f64; 2],
    /// Of the error of the ambient temperature.
    pub(super) cause: Cause,
    /// kg/s.
    pub(super) mass_flow: f64,
    /// Q/(m c_p) with c_p at the ambient temperature, K, and where.
    pub(super) rise: f64,
    pub(super) at: f64,
    /// Perimeter over m c_p, 1/m for h = 1.
    pub(super) cooling: f64,
    /// How c_p grows with temperature above ambient: c_p over its ambient value, less 1, by powers 1 to 3 of
    /// the excess in K.
    pub(super) growth: [f64; 3],
    /// How the heat transfer may differ from one constant.
    pub(super) varies: Varies,
}

/// Numbers of the model of the gas that all points share: eta, h, and four unit normal numbers by which the
/// heat transfer differs from one constant.
pub(super) const VALUES: usize = 6;

/// How the heat transfer to the wall may differ from one constant, at one operating point:
///
/// h(x) = h (1 + v z_1 e^(-x/2D) + v z_2 e^(-x/10D)) exp(v (z_3 f + z_4 r)),
///
/// x from the part on. f and r are the flow and the rise of this point, each as the logarithm to base 2 of
/// its ratio to the geometric mean of the points with readings. Behind a grid heat transfer is larger, for
/// two to three diameters in a turbulent stream (Incropera & DeWitt, Fundamentals of Heat and Mass
/// Transfer, section 8.5) and for tens in a laminar one, like x^(-1/3) (Leveque); with flow it grows by a
/// power of 0 to 0.8, with the rise where buoyancy and radiation take part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Varies {
    /// v.
    pub(super) by: f64,
    /// D, m.
    pub(super) diameter: f64,
    /// f and r.
    pub(super) doublings: [f64; 2],
}

/// Distances over which an excess of heat transfer downstream of the part is lost, in diameters.
pub(super) const REACH: [f64; 2] = [2.0, 10.0];

impl Varies {
    /// The integral of h(x)/h from the part to `x`, m, and its derivatives in z.
    fn integral(&self, x: f64, z: [f64; 4]) -> (f64, [f64; 4]) {
        let of = |reach: f64| {
            let reach = reach * self.diameter;
            -self.by * reach * (-x / reach).exp_m1()
        };
        let near = REACH.map(of);
        let [f, r] = self.doublings.map(|d| self.by * d);
        let factor = z[2].mul_add(f, z[3] * r).exp();
        let along = x + near[0] * z[0] + near[1] * z[1];
        let whole = factor * along;
        (whole, [factor * near[0], factor * near[1], f * whole, r * whole])
    }
}

/// Newton steps at most; a few give all digits.
const STEPS: usize = 20;

impl Heated {
    /// Holds flow and rise against those that are `typical`.
    pub(super) fn compare(&mut self, typical: Option<[f64; 2]>) {
        if let Some([flow, rise]) = typical.filter(|_| self.rise > 0.0) {
            self.varies.doublings = [(self.mass_flow / flow).log2(), (self.rise / rise).log2()];
        }
    }

    /// Temperature at `x` and its derivatives in eta, h and z.
    ///
    /// With the excess y over ambient and r(y) = c_p over its ambient value: int_0^y r = eta Q/(m c_p) at
    /// the part, and dy/dx = -h(x) P y/(m c_p r) behind it, so that q = y/y_0 has
    /// int_1^q r(q y_0) dq/q = -P/(m c_p) int h(x) dx.
    pub(super) fn temperature(&self, x: f64, values: [f64; VALUES]) -> (f64, [f64; VALUES]) {
        if x <= self.at || self.rise == 0.0 {
            return (self.ambient[0], [0.0; VALUES]);
        }
        let [eta, h, z @ ..] = values;
        let first = self.excess(eta * self.rise);
        let (integral, by_z) = self.varies.integral(x - self.at, z);
        let q = self.left(first, h * self.cooling * integral);
        let excess = q * first;
        let r = self.ratio(excess);
        let by_loss = -self.cooling * excess / r;
        let mut slopes = [self.rise * q / r, by_loss * integral, 0.0, 0.0, 0.0, 0.0];
        slopes[2..].iter_mut().zip(by_z).for_each(|(slope, by)| *slope = by_loss * h * by);
        (self.ambient[0] + excess, slopes)
    }

    /// c_p over its ambient value.
    fn ratio(&self, excess: f64) -> f64 {
        let [a, b, c] = self.growth;
        1.0 + excess * (a + excess * (b + excess * c))
    }

    /// The excess whose enthalpy over the ambient c_p is `rise`.
    fn excess(&self, rise: f64) -> f64 {
        let [a, b, c] = self.growth;
        let enthalpy = |y: f64| y * (1.0 + y * (a / 2.0 + y * (b / 3.0 + y * c / 4.0)));
        let mut y = rise;
        for _ in 0..STEPS {
            let step = (enthalpy(y) - rise) / self.ratio(y);
            y -= step;
            if step.abs() <= 1e-12 * rise.abs() {
                break;
            }
        }
        y
    }

    /// The share of an excess that is left where a gas of constant c_p has exp(-`s`) of it.
    fn left(&self, first: f64, s: f64) -> f64 {
        let by = [1, 2, 3].map(|k| self.growth[k - 1] * first.powi(k as i32) / k as f64);
        let mut ln = -s;
        for _ in 0..STEPS {
            let q = ln.exp();
            let off = ln + s + (0..3).map(|k| by[k] * (q.powi(k as i32 + 1) - 1.0)).sum::<f64>();
            let step = off / self.ratio(q * first);
            ln -= step;
            if step.abs() <= 1e-12 {
                break;
            }
        }
        ln.exp()
    }
}

/// The places of readings, m, in order: those of the thermometers.
pub(super) fn places(readings: &[GasReading]) -> Vec<f64> {
    let mut places: Vec<f64> = readings.iter().map(|r| r.at).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}

/// A reading of a thermometer.
#[derive(Clone, Debug, PartialEq)]
pub struct GasReading {
    /// Operating point, by its place in the campaign.
    pub point: usize,
    /// Place, m.
    pub at: f64,
    /// Temperature, K.
    pub temperature: f64,
    /// Its standard deviation, K.
    pub sd: f64,
}
