//! Figs. 6 and 7: the feedback from velocity to heat release, inferred at each hot point by itself.

use crate::catalogue::{catalogue, chosen};
use crate::{Check, Feedback, FeedbackPoint, Hot, StudyError};
use rayon::prelude::*;
use rijke_inference::NoiseMode;
use rijke_model::{Assembly, Knowledge, Noise, Observed, train};

/// Fig. 6: k_eu at each point, with the calibrated model of all other components.
///
/// Every point is an inference of its own: k_eu is free, and the parameters of the cold components have the posterior of the
/// cold stages as their prior, so that their uncertainty is part of the sd. Noise of the growth rate and the frequency is the misfit
/// that the cold model has on row H0; that of the pressures is 1e-3, as neither model has the mean flow, which turns mode
/// shapes by a Mach number; the scatter of the ends between settings and the errors of the base flow come on top.
///
/// # Errors
/// Those of the model.
pub fn feedback(hot: &Hot) -> Result<Feedback, StudyError> {
    let mut candidates = hot.cold.stage.candidates.clone();
    candidates.extend(chosen(&catalogue()?, &["feedback.free"])?);
    let assembly = Assembly::new(hot.rig.clone(), candidates)?;
    let points = inferred(hot, &assembly, [hot.cold.noise[0], hot.cold.noise[1]])?;
    let ids: Vec<&str> = hot.cold.stage.candidates.iter().map(|c| c.id.as_str()).collect();
    Ok(Feedback {
        provenance: hot.provenance.clone(),
        model: format!("calibrated: {}", ids.join(", ")),
        checks: calibrated_checks(&points),
        points,
    })
}

/// Fig. 7: as [`feedback()`], with Levine and Schwinger's ends, Rayleigh's wall with eta = 1, and neither drag nor blockage of
/// prongs and heater. The thermocouples stay, as in the caption.
///
/// # Errors
/// As [`feedback()`].
pub fn feedback_naive(hot: &Hot, calibrated: &Feedback) -> Result<Feedback, StudyError> {
    let ids = ["wall.rayleigh", "ends.levine-schwinger", "thermocouples.paper", "feedback.free"];
    let assembly = Assembly::new(hot.rig.clone(), chosen(&catalogue()?, &ids)?)?.fixed("eta", 1.0)?;
    // Levine and Schwinger's ends do not scatter: what settings add is noise.
    let points = inferred(hot, &assembly, hot.cold.new_setting)?;
    Ok(Feedback {
        provenance: hot.provenance.clone(),
        model: "Levine-Schwinger's ends, eta = 1, no drag or blockage of prongs and heater".into(),
        checks: naive_checks(&points, &calibrated.points),
        points,
    })
}

/// Velocities of 0.1 to 0.6 m/s over the speed of sound, as a judgement. One point cannot tell a small misfit from none.
const MACH: f64 = 1e-3;

fn inferred(hot: &Hot, assembly: &Assembly, sd: [f64; 2]) -> Result<Vec<FeedbackPoint>, StudyError> {
    let fixed = |k: usize| NoiseMode::Fixed { sd: sd[k] };
    let noise = Noise {
        growth_rate: fixed(0),
        angular_frequency: fixed(1),
        pressure: NoiseMode::Fixed { sd: MACH },
        ..Noise::FLOATED
    };
    let training = hot.training(noise, hot.known());
    let one = |o: &Observed| {
        let found = train(assembly, std::slice::from_ref(o), &training)?.knowledge();
        Ok(point(o, &found))
    };
    hot.points.par_iter().map(one).collect()
}

/// k_eu = -(g_r + i g_i) Q_h and its covariance, in the terms of the figure.
fn point(observed: &Observed, found: &Knowledge) -> FeedbackPoint {
    let conditions = &observed.conditions;
    let power = conditions.point.power;
    let index = |name: &str| found.names.iter().position(|n| n == name).unwrap_or(0);
    let at = [index("g_r"), index("g_i")];
    let g = at.map(|k| found.mean[k]);
    let c = |i: usize, j: usize| found.covariance[(at[i], at[j])];
    let modulus = g[0].hypot(g[1]);
    let unit = g.map(|v| v / modulus);
    let along =
        |d: [f64; 2]| (0..2).map(|i| (0..2).map(|j| d[i] * c(i, j) * d[j]).sum::<f64>()).sum::<f64>().sqrt();
    FeedbackPoint {
        id: conditions.point.id.clone(),
        position_m: conditions.point.position.unwrap_or(0.0),
        power_w: power,
        heater_velocity: conditions.base.heater_velocity,
        k_eu: g.map(|v| -v * power),
        covariance: [0, 1].map(|i| [0, 1].map(|j| c(i, j) * power * power)),
        modulus_per_watt: modulus,
        modulus_per_watt_sd: along(unit),
        // g = |g| e^{-i lag}.
        lag: (-g[1]).atan2(g[0]),
        lag_sd: along([-unit[1], unit[0]]) / modulus,
    }
}

/// Powers above which the paper calls k_eu well known, W.
const CLEAR: f64 = 15.0;

fn near(x: f64, y: f64) -> bool {
    (x - y).abs() < 1e-6
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
    sum / f64::from(count.max(1))
}

/// Mean and standard deviation of a number over points.
fn spread(points: &[&FeedbackPoint], number: impl Fn(&FeedbackPoint) -> f64) -> [f64; 2] {
    let centre = mean(points.iter().map(|p| number(p)));
    [centre, mean(points.iter().map(|p| (number(p) - centre).powi(2))).sqrt()]
}

/// The statements of section 6.4 about Fig. 6.
fn calibrated_checks(points: &[FeedbackPoint]) -> Vec<Check> {
    let sd_at = |x: f64| mean(points.iter().filter(|p| near(p.position_m, x)).map(|p| p.modulus_per_watt_sd));
    let mut positions: Vec<f64> = points.iter().map(|p| p.position_m).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|a, b| near(*a, *b));
    let ordered = |from: f64, to: f64| {
        let inside = positions.iter().copied().filter(move |x| *x > from && *x < to);
        let mut by_sd: Vec<f64> = inside.collect();
        by_sd.sort_by(|a, b| sd_at(*a).total_cmp(&sd_at(*b)));
        by_sd
    };
    let best = |from: f64, to: f64| ordered(from, to).first().copied().unwrap_or(f64::NAN);
    let (low, high) = (best(0.0, 0.5), best(0.5, 1.0));
    let worst = ordered(0.0, 1.0).last().copied().unwrap_or(f64::NAN);
    let clear: Vec<&FeedbackPoint> = points
        .iter()
        .filter(|p| p.power_w > CLEAR && (p.position_m - 0.5).abs() > 0.1 && p.position_m < 0.8)
        .collect();
    let [gain, gain_spread] = spread(&clear, |p| p.modulus_per_watt);
    let [lag, lag_spread] = spread(&clear, |p| p.lag);
    vec![
        Check {
            statement: "The standard deviation of k_eu is smallest near X_h = 0.25 and 0.75 and largest near 0.5.".into(),
            holds: (low - 0.25).abs() < 0.076 && (high - 0.75).abs() < 0.076 && (worst - 0.5).abs() < 0.051,
            figure: format!(
                "mean sd of |k_eu|/Q_h smallest at {low:.2} m ({:.2e} 1/W) and {high:.2} m ({:.2e}), largest at {worst:.2} m ({:.2e})",
                sd_at(low),
                sd_at(high),
                sd_at(worst)
            ),
            explanation: None,
        },
        Check {
            statement: "Away from 0.5, below 0.8 and above 15 W, |k_eu|/Q_h is flat: it scatters by less than a fifth.".into(),
            holds: gain_spread < 0.2 * gain,
            figure: format!("{gain:.3e} 1/W, sd over {} points {:.1} %", clear.len(), 100.0 * gain_spread / gain),
            explanation: (gain_spread >= 0.2 * gain).then(|| {
                "The virtual rig's wire cools as King's law says, so that |k_eu| falls as 1/U_h, and U_h grows with power."
                    .to_owned()
            }),
        },
        Check {
            statement: "At the same points the angle of k_eu is flat: it scatters by less than 0.2 rad.".into(),
            holds: lag_spread < 0.2,
            figure: format!("{lag:.3} rad, sd {lag_spread:.3} rad"),
            explanation: (lag_spread >= 0.2)
                .then(|| "The virtual rig's wire lags by a time that falls as 1/U_h, as Lighthill's does.".to_owned()),
        },
    ]
}

/// The statements of section 6.4 about Fig. 7.
fn naive_checks(naive: &[FeedbackPoint], calibrated: &[FeedbackPoint]) -> Vec<Check> {
    let jump = |points: &[FeedbackPoint]| {
        let side = |from: f64, to: f64| {
            mean(
                points
                    .iter()
                    .filter(|p| p.power_w > CLEAR && p.position_m > from && p.position_m < to)
                    .map(|p| p.lag),
            )
        };
        side(0.52, 0.68) - side(0.32, 0.48)
    };
    let of = |points: &[FeedbackPoint]| {
        let clear: Vec<f64> = points
            .iter()
            .filter(|p| p.power_w > CLEAR && (p.position_m - 0.5).abs() > 0.1)
            .map(|p| p.modulus_per_watt)
            .collect();
        let centre = mean(clear.iter().copied());
        mean(clear.iter().map(|v| (v - centre).powi(2))).sqrt() / centre
    };
    vec![
        Check {
            statement: "With the naive model the angle of k_eu jumps near X_h = 0.5; with the calibrated model it does not.".into(),
            holds: jump(naive).abs() > 3.0 * jump(calibrated).abs() && jump(naive).abs() > 0.5,
            figure: format!(
                "mean angle at 0.55 to 0.65 minus that at 0.35 to 0.45, above 15 W: {:.2} rad, calibrated {:.2} rad",
                jump(naive),
                jump(calibrated)
            ),
            explanation: None,
        },
        Check {
            statement: "With the naive model |k_eu|/Q_h varies more with power and position than with the calibrated model.".into(),
            holds: of(naive) > of(calibrated),
            figure: format!(
                "sd over points away from 0.5, above 15 W: {:.0} %, calibrated {:.0} %",
                100.0 * of(naive),
                100.0 * of(calibrated)
            ),
            explanation: None,
        },
    ]
}
