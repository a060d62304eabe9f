//! Share of the power, heat transfer to the wall, and scatter of the rise by readings.
//!
//! A reading at x of point p is T_amb + a + r(x) (1 + tau z) + b + b_x + e: r is the rise that share and heat
//! transfer give (with what that differs by from one constant), a the error of the ambient temperature of
//! the day, z a unit normal number of the point by itself, b what all thermometers read too much, b_x what
//! the one at x does, and e the stated error of the reading; where thermometers may miss a share g of the
//! excess, tau z + g stands for tau z. a, z, b, b_x and g are integrated over in closed form, share and heat
//! transfer by Laplace's method at every tau, tau by a sum. What is handed on are the moments of that
//! mixture. Points without heat tell b and b_x.
//!
//! Before the readings, tau has half of a Student's t distribution with 4 degrees of freedom and scale
//! [`SCALE`], a weakly informative prior for a standard deviation of which few groups tell (Gelman, Bayesian
//! Analysis 1, 515 (2006), section 2.2); a half-Cauchy has no variance to hand on. It is centred at zero,
//! which it does not exclude.

use super::gas::{GasReading, Heated, VALUES, places};
use crate::StudyProblem;
use crate::cause::Cause;
use rijke_numerics::{Cholesky, Matrix};
use std::collections::BTreeMap;

/// What the readings say.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Share, heat transfer, and how that differs from one constant.
    pub(super) values: [f64; VALUES],
    /// Their covariance.
    pub(super) covariance: Matrix,
    /// Root mean square of tau.
    pub(super) scatter: f64,
    /// Quantiles of tau: 2.5 and 97.5 %.
    pub(super) within: [f64; 2],
    /// What all thermometers read too much, K, and its standard deviation.
    pub(super) offset: [f64; 2],
}

/// Scale of the prior of tau. Meters of power are good to 1 % of the value, controllers of flow to 1 or 2 %,
/// and gas that is not mixed over the cross-section adds some 2 %. Half of the prior is below 2.2 %, one part
/// in twenty above 8 %.
pub(super) const SCALE: f64 = 0.03;

/// Values of tau: enough for the posterior of thousands of points, whose relative width is (2 points)^(-1/2).
const NODES: usize = 128;

/// Gauss-Newton steps at one tau.
const STEPS: usize = 12;

/// A value so many standard deviations from its prior asks for a fit that starts at the priors.
const FAR: f64 = 4.0;

/// A step that makes the fit worse by more than this, nats, is halved, and again, so many times.
const WORSE: f64 = 1.0;
const HALVED: i32 = 12;

/// Readings, by the error of the ambient temperature and by point.
type Days<'a> = BTreeMap<&'a Cause, BTreeMap<usize, (&'a Heated, Vec<&'a GasReading>)>>;

/// All readings, the places of the thermometers, and how much these may read too much.
struct Groups<'a> {
    days: Days<'a>,
    places: Vec<f64>,
    offset_sd: f64,
    excess_sd: f64,
}

/// Share and heat transfer given tau.
struct Given {
    values: [f64; VALUES],
    covariance: Matrix,
    ln_marginal: f64,
    /// Mean and variance of b.
    offset: [f64; 2],
}

/// What `readings` say of points, given means and standard deviations before them, and the standard deviation
/// of what all thermometers read too much and of what each does, K, and of what all do of the excess.
pub(super) fn fit(
    all: &[Option<Heated>],
    readings: &[GasReading],
    prior: [[f64; 2]; VALUES],
    [offset_sd, excess_sd]: [f64; 2],
) -> Result<Found, StudyProblem> {
    let mut days = Days::new();
    for r in readings {
        let heated = all.get(r.point).and_then(Option::as_ref);
        // Upstream of heat the gas may be warmed by radiation and along the wall.
        let Some(h) = heated.filter(|h| h.rise == 0.0 || r.at > h.at) else { continue };
        let of_the_day = days.entry(&h.cause).or_default();
        of_the_day.entry(r.point).or_insert_with(|| (h, Vec::new())).1.push(r);
    }
    let groups = &Groups { days, places: places(readings), offset_sd, excess_sd };
    // tau = SCALE tan(pi u/2), u uniform: half a Cauchy distribution, weighted to that of Student.
    let mut nodes = Vec::with_capacity(NODES);
    let centre = prior.map(|p| p[0]);
    let mut values = centre;
    for k in 0..NODES {
        let t = (std::f64::consts::FRAC_PI_2 * (k as f64 + 0.5) / NODES as f64).tan();
        let from = |values| given(groups, SCALE * t, prior, values);
        // Without scatter, readings that contradict each other drive a fit until numbers overflow: with
        // scatter they have one.
        let Some(mut best) = from(values).or_else(|| from(centre)) else { continue };
        // Without scatter, readings that contradict power or flow have their best fit far from all priors,
        // and with scatter another one.
        if (0..VALUES).any(|i| (best.values[i] - centre[i]).abs() > FAR * prior[i][1]) {
            best = from(centre).filter(|other| other.ln_marginal > best.ln_marginal).unwrap_or(best);
        }
        values = best.values;
        let ln_prior = t.mul_add(t, 1.0).ln() - 2.5 * (t * t / 4.0).ln_1p();
        nodes.push((SCALE * t, best.ln_marginal + ln_prior, best));
    }
    if nodes.is_empty() {
        return Err(StudyProblem::Unexplained);
    }
    let most = nodes.iter().map(|n| n.1).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = nodes.iter().map(|n| (n.1 - most).exp()).sum();
    nodes.iter_mut().for_each(|n| n.1 = (n.1 - most).exp() / total);
    let mean = |of: &dyn Fn(f64, &Given) -> f64| nodes.iter().map(|(t, w, g)| w * of(*t, g)).sum::<f64>();
    let values = std::array::from_fn(|i| mean(&|_, g| g.values[i]));
    // The law of total variance.
    let apart = |g: &Given, i: usize| g.values[i] - values[i];
    let covariance = Matrix::from_fn(VALUES, VALUES, |i, j| {
        mean(&|_, g| g.covariance[(i, j)] + apart(g, i) * apart(g, j))
    });
    let scatter = mean(&|tau, _| tau * tau).sqrt();
    let within = [0.025, 0.975].map(|share| {
        let mut below = 0.0;
        let at = nodes.iter().find(|n| {
            below += n.1;
            below >= share
        });
        at.map_or(f64::NAN, |n| n.0)
    });
    let offset = mean(&|_, g| g.offset[0]);
    let variance = mean(&|_, g| g.offset[1] + (g.offset[0] - offset).powi(2));
    Ok(Found { values, covariance, scatter, within, offset: [offset, variance.sqrt()] })
}

/// Laplace's method at one tau, from `values` on; none where numbers overflow.
fn given(
    groups: &Groups<'_>,
    tau: f64,
    prior: [[f64; 2]; VALUES],
    mut values: [f64; VALUES],
) -> Option<Given> {
    let off = |values: [f64; VALUES]| -> [f64; VALUES] {
        std::array::from_fn(|i| (prior[i][0] - values[i]) / prior[i][1].powi(2))
    };
    let by_prior =
        |values| -> f64 { off(values).iter().zip(prior).map(|(off, [_, sd])| (off * sd).powi(2)).sum() };
    let at = |values| {
        let (gram, ln_det) = moments(groups, tau, values);
        let ln_density = ln_det - 0.5 * (gram[OFF][OFF] + by_prior(values));
        (gram, ln_density)
    };
    let (mut gram, mut ln_density) = at(values);
    for step in 0..=STEPS {
        let off = off(values);
        let precision = Matrix::from_fn(VALUES, VALUES, |i, j| {
            gram[i][j] + if i == j { prior[i][1].powi(-2) } else { 0.0 }
        });
        let factor = Cholesky::new(&precision).ok()?;
        let covariance = factor.inverse();
        let right: Vec<f64> = (0..VALUES).map(|i| gram[i][OFF] + off[i]).collect();
        let change = factor.solve(&right);
        if change.iter().any(|c| !c.is_finite()) {
            return None;
        }
        let small = (0..VALUES).all(|i| change[i].abs() < 1e-6 * covariance[(i, i)].sqrt());
        if small || step == STEPS {
            let ln_marginal = ln_density - 0.5 * factor.ln_det();
            // Of b ~ N(0, s^2) given all values, and their error through its slopes.
            let variance = groups.offset_sd.powi(2);
            let slope: Vec<f64> = (0..VALUES).map(|i| -variance * gram[OFFSET][i]).collect();
            let alone = variance - variance * variance * gram[OFFSET][OFFSET];
            let offset = [variance * gram[OFFSET][OFF], alone.max(0.0) + covariance.quadratic(&slope)];
            return Some(Given { values, covariance, ln_marginal, offset });
        }
        // Readings that contradict power or flow bend so much that a whole step may lead far off.
        for halved in 0..=HALVED {
            let part = 0.5_f64.powi(halved);
            let mut next: [f64; VALUES] = std::array::from_fn(|i| values[i] + part * change[i]);
            next[1] = next[1].max(0.0);
            let (there, ln) = at(next);
            if ln >= ln_density - WORSE || halved == HALVED {
                (values, gram, ln_density) = (next, there, ln);
                break;
            }
        }
    }
    None
}

/// Columns of a Gram matrix: slopes by the values, then what readings miss, the error of the ambient
/// temperature, the rise, what all thermometers read too much, and what each does.
type Gram = Vec<Vec<f64>>;
const OFF: usize = VALUES;
const AMBIENT: usize = OFF + 1;
const RISE: usize = OFF + 2;
const OFFSET: usize = OFF + 3;

/// V'C^{-1}V of the columns V, C being the covariance of the readings, and -1/2 ln det C but for a constant.
fn moments(groups: &Groups<'_>, tau: f64, values: [f64; VALUES]) -> (Gram, f64) {
    let columns = OFFSET + 1 + groups.places.len();
    let none = || vec![vec![0.0; columns]; columns];
    let (mut total, mut ln) = (none(), 0.0);
    for points in groups.days.values() {
        let mut day = none();
        for (h, readings) in points.values() {
            let mut point = none();
            for r in readings {
                let (t, slopes) = h.temperature(r.at, values);
                let mut v = vec![0.0; columns];
                v[..VALUES].copy_from_slice(&slopes);
                v[OFF..OFFSET].copy_from_slice(&[r.temperature - t, h.ambient[1], t - h.ambient[0]]);
                v[OFFSET] = 1.0;
                let place = groups.places.iter().position(|at| *at == r.at);
                place.into_iter().for_each(|k| v[OFFSET + 1 + k] = 1.0);
                add(&mut point, |i, j| v[i] * v[j] / r.sd.powi(2));
            }
            ln -= 0.5 * spread(&mut point, RISE, tau * tau);
            add(&mut day, |i, j| point[i][j]);
        }
        ln -= 0.5 * spread(&mut day, AMBIENT, 1.0);
        add(&mut total, |i, j| day[i][j]);
    }
    // All thermometers of all points miss the same share of the rise.
    ln -= 0.5 * spread(&mut total, RISE, groups.excess_sd.powi(2));
    for k in OFFSET..columns {
        ln -= 0.5 * spread(&mut total, k, groups.offset_sd.powi(2));
    }
    (total, ln)
}

fn add(to: &mut Gram, what: impl Fn(usize, usize) -> f64) {
    for (i, row) in to.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, g)| *g += what(i, j));
    }
}

/// Adds `variance` times column `k` times itself to C, by the formula of Sherman and Morrison. Returns the
/// change of ln det C.
fn spread(gram: &mut Gram, k: usize, variance: f64) -> f64 {
    let (old, grown) = (gram.clone(), 1.0 + variance * gram[k][k]);
    add(gram, |i, j| -variance * old[i][k] * old[k][j] / grown);
    grown.ln()
}
