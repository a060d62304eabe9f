//! What the readings say of the heat, and how they fit the heated gas.

use super::fit::{Found, SCALE};
use super::gas::{GasReading, REACH, VALUES, places};
use crate::doubtful::ZERO;
use rijke_numerics::median;

/// The heat by the readings, beside what was known before, and every thermometer.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatedFit {
    /// Share of the power that the gas gets, and its standard deviation.
    pub share: [f64; 2],
    /// Heat transfer to the wall far downstream of the part, W/(m^2 K), likewise.
    pub cooling: [f64; 2],
    /// Heat transfer one diameter downstream of the part over that far downstream, likewise; none where it is
    /// one constant by `cooling_varies = 0`.
    pub near: Option<[f64; 2]>,
    /// The largest of the numbers by which the heat transfer differs from one constant, in standard
    /// deviations of its prior.
    varies: f64,
    /// Error of the rise of the gas at every point by itself, relative, as a standard deviation: what
    /// readings scatter by beyond their own errors. The root mean square of what it may be, which counts in
    /// the errors of the gas.
    pub scatter: f64,
    /// Quantiles of what it may be: 2.5 and 97.5 %.
    pub scatter_within: [f64; 2],
    /// Mean and standard deviation of both before the readings.
    prior: [[f64; 2]; 2],
    /// Every place of readings: m, how much they read more than the model on average, K, and the standard
    /// deviation of that by what is stated of readings and ambient temperature.
    pub thermometers: Vec<[f64; 3]>,
    /// What all thermometers read too much as the fit has it, K, its standard deviation, and that before the
    /// readings.
    pub common: [f64; 3],
    /// How much all thermometers read more than T_amb where nothing heats, K, and the standard deviation of
    /// that but for what they have in common; none without such readings.
    pub offset: Option<[f64; 2]>,
    /// The one reading that lies far from the model when all others do not, in words.
    alone: Option<String>,
}

/// Readings that are so near to 273 K too large are taken to be in K, K: the heat that is found takes some.
const ABOUT_ZERO: f64 = 40.0;

/// Standard deviations from which readings and heat, or readings and priors, contradict each other.
const CONFLICT: f64 = 4.0;

/// One reading lies far from the model by itself if it lies this many times as far as the others, root mean
/// square, and as its stated error; at a place with so many readings.
const ALONE: f64 = 6.0;
const READ: usize = 5;

impl HeatedFit {
    /// `against` is how much a reading lies above the model, K, and the standard deviation of its ambient
    /// temperature; none where there is no model. Readings of one place are weighted by their stated errors;
    /// those of the ambient temperature are shared. `id` names an operating point.
    pub(super) fn new<'a>(
        found: &Found,
        prior: [[f64; 2]; 2],
        readings: &[GasReading],
        against: impl Fn(&GasReading) -> Option<[f64; 2]>,
        cold: impl Fn(&GasReading) -> bool,
        [offset_sd, varies]: [f64; 2],
        id: impl Fn(usize) -> &'a str,
    ) -> Self {
        let mean = |which: &dyn Fn(&GasReading) -> bool| {
            let (mut weights, mut sum, mut ambient) = (0.0, 0.0, 0.0_f64);
            for r in readings.iter().filter(|r| which(r)) {
                let Some([off, ambient_sd]) = against(r) else { continue };
                let weight = r.sd.powi(-2);
                weights += weight;
                sum += weight * off;
                ambient = ambient.max(ambient_sd);
            }
            (weights > 0.0).then(|| [sum / weights, (1.0 / weights + ambient.powi(2)).sqrt()])
        };
        let offset = mean(&cold);
        let beside = offset.map_or(0.0, |[off, _]| off);
        // Beyond what all have in common, as cold points tell it.
        let known = if offset.is_some() { 1.0 } else { 2.0_f64.sqrt() };
        let at = |at: &f64| {
            let [off, sd] = mean(&|r| r.at == *at)?;
            Some([*at, off - beside, sd.hypot(known * offset_sd)])
        };
        let [share, cooling] = [0, 1].map(|i| [found.values[i], found.covariance[(i, i)].sqrt()]);
        let thermometers = places(readings).iter().filter_map(at).collect();
        let (scatter, scatter_within) = (found.scatter, found.within);
        let common = [found.offset[0], found.offset[1], offset_sd];
        let near = (varies > 0.0).then(|| {
            let slopes = std::array::from_fn::<f64, VALUES, _>(|i| match i {
                2 | 3 => varies * (-1.0 / REACH[i - 2]).exp(),
                _ => 0.0,
            });
            let value =
                1.0 + slopes.iter().zip(found.values).map(|(slope, value)| slope * value).sum::<f64>();
            [value, found.covariance.quadratic(&slopes).sqrt()]
        });
        let varies = found.values[2..].iter().fold(0.0_f64, |most, z| most.max(z.abs()));
        let alone = alone(readings, against).map(|(r, off, times)| {
            let (more, point) = (if off > 0.0 { "more" } else { "less" }, id(r.point));
            format!(
                "the reading at {} m of {point} alone is {:.1} K {more} than the heated gas of this study, beside what that thermometer reads at other \
                 points, {times:.0} times what the others differ by: check it",
                r.at,
                off.abs()
            )
        });
        Self {
            share,
            cooling,
            near,
            varies,
            scatter,
            scatter_within,
            prior,
            thermometers,
            common,
            offset,
            alone,
        }
    }

    /// What does not fit, in words.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        for (what, [value, left], [mean, sd]) in [
            ("the share of the power that the gas gets", self.share, self.prior[0]),
            ("the heat transfer to the wall", self.cooling, self.prior[1]),
        ] {
            // Readings of some error move a value by K (d - mean), with a standard deviation of K^(1/2) sd if
            // the prior is right.
            let gain = (1.0 - (left / sd).powi(2)).max(0.01);
            let off = (value - mean).abs() / (sd * gain.sqrt());
            if off > CONFLICT {
                all.push(format!(
                    "the readings alone require {what} of {:.3} where {mean} +- {sd} was expected; both together give {value:.3} +- {left:.3}, which \
                     goes on; they contradict each other by {off:.1} standard deviations: check power, flow, their units, and places of thermometers, or \
                     widen the prior",
                    mean + (value - mean) / gain
                ));
            }
        }
        if self.varies > CONFLICT {
            all.push(format!(
                "the heat transfer to the wall differs from one constant by {:.1} times what `cooling_varies` admits: the gas does not follow the law of \
                 [base.heated-flow]; check places of thermometers, and whether other parts heat or cool the gas",
                self.varies
            ));
        }
        if self.scatter_within[0] > SCALE {
            all.push(format!(
                "the readings differ from the law of [base.heated-flow] by more than {:.1} % of the rise of the gas, beyond their own errors: check power, \
                 flow and thermometers, or take the gas as it was read with [base.measured]",
                100.0 * self.scatter_within[0]
            ));
        }
        if self.share[0] > 1.0 + CONFLICT * self.share[1] {
            all.push(format!("the gas gets {:.0} % of the power, more than there is", 100.0 * self.share[0]));
        }
        if let Some([off, sd]) = self.offset.filter(|[off, sd]| off.abs() > CONFLICT * sd) {
            let more = if off > 0.0 { "more" } else { "less" };
            all.push(format!(
                "where nothing heats, the thermometers read {:.2} K {more} than T_amb, {:.0} of their combined standard deviations without the shared \
                 offset: this counts as their common error; check their calibration and T_amb",
                off.abs(),
                off.abs() / sd
            ));
        }
        let kelvins = |off: f64, sd: f64| (off - ZERO).abs() < ABOUT_ZERO && off > CONFLICT * sd;
        let of_all = !self.thermometers.is_empty() && self.thermometers.iter().all(|t| kelvins(t[1], t[2]));
        if of_all || self.offset.is_some_and(|[off, sd]| kelvins(off, sd)) {
            all.push(
                "all thermometers read some 273 K too much: write `temperature [K]` over readings that are in K".to_owned(),
            );
        }
        for [at, off, sd] in &self.thermometers {
            if off.abs() > CONFLICT * sd {
                let more = if *off > 0.0 { "more" } else { "less" };
                all.push(format!(
                    "the thermometer at {at} m reads {:.1} K {more} than the heated gas of this study on average, {:.0} of its stated standard deviations",
                    off.abs(),
                    off.abs() / sd
                ));
            }
        }
        all.extend(self.alone.clone());
        all
    }
}

/// The reading that lies far from the model by itself, how far beside the median of its place, K, and how
/// many times as far as the others.
fn alone(
    readings: &[GasReading],
    against: impl Fn(&GasReading) -> Option<[f64; 2]>,
) -> Option<(&GasReading, f64, f64)> {
    let mut all: Vec<(&GasReading, f64, f64)> = Vec::new();
    for at in places(readings) {
        let there = readings.iter().filter(|r| r.at == at);
        let there: Vec<_> = there.filter_map(|r| Some((r, against(r)?))).collect();
        if there.len() < READ {
            continue;
        }
        let usual = median(there.iter().map(|(_, [off, _])| *off).collect());
        all.extend(there.iter().map(|(r, [off, sd])| (*r, off - usual, (off - usual) / r.sd.hypot(*sd))));
    }
    let (farthest, off, sds) = *all.iter().max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    let squares: f64 = all.iter().map(|(_, _, sds)| sds * sds).sum::<f64>() - sds * sds;
    let times = sds.abs() / (squares / (all.len() - 1) as f64).sqrt().max(1.0);
    (times > ALONE).then_some((farthest, off, times))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::Matrix;

    #[test]
    fn behaviour_a_thermometer_that_reads_otherwise_is_named() {
        let at = |at: f64| GasReading { point: 0, at, temperature: 350.0, sd: 0.5 };
        let readings = [at(0.1), at(0.5), at(0.5), at(0.7)];
        let prior = [[0.9, 0.15], [5.0, 3.0]];
        let warnings = |share: [f64; 2], off: f64| {
            let against = |r: &GasReading| Some([if r.at == 0.5 { off } else { 0.3 }, 0.2]);
            let covariance = Matrix::from_fn(6, 6, |i, j| {
                if i == j { [share[1], 1.0, 1.0, 1.0, 1.0, 1.0][i].powi(2) } else { 0.0 }
            });
            let found = Found {
                values: [share[0], 6.0, 0.0, 0.0, 0.0, 0.0],
                covariance,
                scatter: 0.01,
                within: [0.0, 0.02],
                offset: [0.0; 2],
            };
            HeatedFit::new(&found, prior, &readings, against, |_| false, [0.0; 2], |_| "h").warnings()
        };
        assert_eq!(warnings([0.85, 0.02], 0.4), Vec::<String>::new());
        // 8 K of sqrt(0.5^2/2 + 0.2^2) K.
        let said = warnings([0.85, 0.02], 8.0);
        assert!(said.len() == 1 && said[0].contains("the thermometer at 0.5 m reads 8.0 K more"), "{said:?}");
        assert!(said[0].contains("20 of its stated standard deviations"), "{said:?}");
        // Of a prior of 0.9 +- 0.15, and more power than there is.
        let said = warnings([1.7, 0.02], 0.4);
        assert!(said.len() == 2 && said[0].contains("by 5.4 standard deviations"), "{said:?}");
        // 0.4 is only 3.4 deviations of the prior from 0.9, which has drawn it away from 0.3.
        let said = warnings([0.39, 0.08], 0.4);
        assert!(said.len() == 1 && said[0].contains("gets of 0.187 where 0.9 +- 0.15"), "{said:?}");
    }

    #[test]
    fn behaviour_readings_in_kelvins_are_named_by_points_without_heat() {
        let read = |point: usize| GasReading { point, at: 0.5, temperature: 570.0, sd: 0.5 };
        let found = Found {
            values: [0.9, 5.0, 0.0, 0.0, 0.0, 0.0],
            covariance: Matrix::from_fn(6, 6, |i, j| if i == j { 0.01 } else { 0.0 }),
            scatter: 0.01,
            within: [0.0, 0.02],
            offset: [0.0; 2],
        };
        // Where nothing heats, readings in K are just 273.15 K too large; elsewhere heat took some of it.
        let warnings = |cold: f64, hot: f64| {
            let against = move |r: &GasReading| Some([if r.point == 0 { cold } else { hot }, 0.2]);
            let prior = [[0.9, 0.15], [5.0, 3.0]];
            let readings = [read(0), read(1)];
            HeatedFit::new(&found, prior, &readings, against, |r| r.point == 0, [0.5, 0.0], |_| "h")
                .warnings()
        };
        let named = |all: &[String]| all.iter().any(|w| w.contains("write `temperature [K]`"));
        assert!(named(&warnings(273.15, 180.0)), "{:?}", warnings(273.15, 180.0));
        assert!(!named(&warnings(20.0, 20.0)), "{:?}", warnings(20.0, 20.0));
    }

    #[test]
    fn behaviour_one_reading_that_lies_far_off_by_itself_is_found() {
        let readings: Vec<GasReading> = (0..12)
            .map(|k| GasReading { point: k / 2, at: [0.4, 0.7][k % 2], temperature: 350.0, sd: 0.5 })
            .collect();
        // Every thermometer has an offset of its own, and readings differ by some tenths of a kelvin.
        let small = |r: &GasReading| [0.3, -0.2, 0.1, -0.4, 0.2, 0.0][r.point] + 2.0 * r.at;
        let with = |off: f64| {
            let readings = &readings;
            let far = move |r: &GasReading| if r.point == 3 && r.at == 0.7 { off } else { 0.0 };
            alone(readings, move |r| Some([small(r) + far(r), 0.2])).map(|(r, off, _)| (r.point, r.at, off))
        };
        let (point, at, off) = with(15.0).unwrap();
        assert!((point, at) == (3, 0.7) && (off - 14.5).abs() < 0.2, "{off}");
        assert_eq!(with(1.0), None);
        // Where all readings of a point are off, none of them is alone.
        assert!(alone(&readings, |r| Some([if r.point < 3 { 15.0 } else { 0.0 }, 0.2])).is_none());
    }
}
