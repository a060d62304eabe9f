//! What a folder says that can be so, and most often is a slip.

use crate::law::Effect;
use crate::names::{MACH, MASS_FLUX, VELOCITY};
use crate::plan::Base;
use crate::{Candidate, DuctAt, Factor, Point, RigAtPoint, Shape, Study, StudyProblem};
use rijke_inference::Parameter;
use rijke_numerics::slips::{
    COLD, PRANDTL, PRESSURE, VISCOSITY, is_light, is_too_late, is_too_long, is_too_wide,
};
use rijke_numerics::words::{few, rounded, to_digits};

/// Microphones nearer than this hear the same, m.
const ONE_PLACE: f64 = 0.005;
/// Temperature at which the geometry is looked at, K.
pub(crate) const LAID_OUT: f64 = 293.15;
/// Temperatures of rooms, K. Where degrees Celsius are expected, such a number most often is one.
const ROOM: std::ops::RangeInclusive<f64> = 250.0..=330.0;
/// 0 degrees Celsius, K.
pub(crate) const ZERO: f64 = 273.15;
/// Where the ambient temperature is nearer to 0 degrees Celsius than this, a factor may be so, too, K.
const NEAR_ZERO: f64 = 5.0;
/// Most points that are named.
const NAMED: usize = 5;
/// Mach number from which waves feel the flow: frequencies by 4e-4, phases of a standing wave by 2 %.
const FLOWS: f64 = 0.02;

/// Ends of names of numbers of a part that no duct is narrower than.
const THIN: [&str; 3] = ["diameter", "radius", "thickness"];

impl Study {
    /// Names of factors that are nearly reserved ones, points that no stage takes because they lack a factor,
    /// ambient temperatures in degC whose number is that of a room in K, differences in degC, ducts so cold
    /// that degC were meant, microphones or elements at one place, and sizes that no rig has: each in a
    /// sentence with file and remedy.
    #[must_use]
    pub fn doubtful(&self) -> Vec<String> {
        let mut all = self.campaign.nearly_reserved();
        all.extend(self.without_factor());
        all.extend(self.rooms());
        all.extend(self.differences());
        all.extend(self.cold());
        all.extend(self.no_gas());
        all.extend(self.sizes());
        all.extend(self.at_rest());
        all.extend(self.in_flow());
        all.extend(self.late());
        all.extend(self.side_by_side());
        all
    }

    /// Refuses an operating point at which a length, an area, a temperature or a place is impossible; what a
    /// factor without value leaves open is not judged. `ambient` (K) is where the campaign states none.
    ///
    /// # Errors
    /// [`StudyProblem::AtPoint`].
    pub fn possible(&self, ambient: f64) -> Result<(), StudyProblem> {
        for point in &self.campaign.points {
            match self.rig.at(point, point.ambient.map_or(ambient, |t| t[0])) {
                Err(StudyProblem::Value { value, .. }) if value.contains("NaN") => {}
                Err(problem) => {
                    return Err(StudyProblem::AtPoint { point: point.id.clone(), source: Box::new(problem) });
                }
                Ok(_) => {}
            }
        }
        Ok(())
    }

    /// Candidates that name the flow, or let waves run in it, where all gas is at rest.
    fn at_rest(&self) -> Vec<String> {
        let flows = match &self.plan.base {
            Base::Ambient | Base::Rig => false,
            Base::Measured(gas) => gas.flow.is_some(),
            _ => true,
        };
        if flows {
            return Vec::new();
        }
        let of_flow = |e: &Effect| [VELOCITY, MACH, MASS_FLUX].iter().any(|name| e.law.uses(*name));
        let ids = |has: &dyn Fn(&Candidate) -> bool| {
            let all = self.catalogue.candidates().iter().filter(|c| has(c)).map(|c| c.id.as_str());
            Some(all.collect::<Vec<_>>()).filter(|ids| !ids.is_empty()).map(|ids| few(&ids, NAMED))
        };
        let named = ids(&|c| c.effects.iter().any(of_flow)).map(|ids| {
            format!(
                "{ids} names the flow (U, M or G), which is 0 at every point, because study.toml gives the gas no flow: name a factor of the campaign, or \
                 give `[base]` states that have one"
            )
        });
        let waves = ids(&|c| c.mean_flow.is_some()).map(|ids| {
            format!(
                "`mean_flow` of {ids} changes nothing, because study.toml gives the gas no flow: waves run in gas at rest at every point; name the factor \
                 that is the flow in `[base.measured]` or `[base.heated-flow]`"
            )
        });
        named.into_iter().chain(waves).collect()
    }

    /// A flow that the waves of no model feel.
    fn in_flow(&self) -> Option<String> {
        let factor = match &self.plan.base {
            Base::Measured(gas) => gas.flow.as_ref()?,
            Base::HeatedFlow(heated) => &heated.flow,
            Base::Ambient | Base::Rig | Base::States(_) => return None,
        };
        let (_, unused) = self.plan.unused(&self.catalogue);
        let is_used = |c: &&Candidate| !unused.iter().any(|other| other.id == c.id);
        if self.catalogue.candidates().iter().filter(is_used).any(|c| c.mean_flow.is_some()) {
            return None;
        }
        let k = self.campaign.factor(factor)?;
        let mach = |point: &Point| {
            let temperature = point.ambient.map_or(self.rig.temperature, |t| t[0]);
            let layout = self.rig.at(point, temperature).ok()?;
            let speed = self.rig.gas.at(temperature, self.rig.pressure).sound_speed;
            // Over the length of the ducts: a short narrow one changes little.
            let one = |d: &DuctAt| (d.span[1] - d.span[0]) / (0.5 * (d.area[0] + d.area[1]));
            let mean = layout.ducts.iter().map(one).sum::<f64>() / layout.length;
            Some(point.factors[k] * mean / speed).filter(|m| m.abs() > FLOWS)
        };
        let all = self.campaign.points.iter().filter_map(|p| Some((mach(p)?, &p.id)));
        let (mach, id) = all.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        Some(format!(
            "at point {id} the gas flows with a Mach number of {} on average, by `{factor}`, and no candidate of a stage has `mean_flow`: waves run in gas at rest. For a flow of \
             Mach number M frequencies are then wrong by about M^2, {} %, and phases along a duct by about M of them, {} %; give models a candidate with \
             `mean_flow = \"full\"`",
            to_digits(mach, 2),
            to_digits(100.0 * mach * mach, 1),
            to_digits(100.0 * mach.abs(), 2)
        ))
    }

    /// Priors of delays that are most often meant in milliseconds.
    fn late(&self) -> Vec<String> {
        let parameters =
            self.catalogue.candidates().iter().flat_map(|c| c.parameters.iter().map(move |p| (&c.id, p)));
        let own = self.rig.own.parameters.iter().map(|p| (&self.rig.own.id, p));
        let highest = self.rig.search[1][1];
        let said = |(id, p): (&String, &Parameter)| {
            let seconds = p.unit == "s";
            late(&p.name, p.prior.quantile(0.5), highest)
                .filter(|_| seconds)
                .map(|said| format!("prior of {id}: {said}"))
        };
        parameters.chain(own).filter_map(said).collect()
    }

    /// Points that stages would take if a factor had a value.
    fn without_factor(&self) -> Vec<String> {
        let (campaign, plan) = (&self.campaign, &self.plan);
        let stages = || {
            let modes = plan.stages.iter().map(|s| (&s.id, &s.points));
            modes.chain(plan.responses.iter().map(|s| (&s.id, &s.points)))
        };
        let lost = |point: &Point| {
            if stages().any(|(_, points)| points.holds(campaign, point)) {
                return None;
            }
            campaign.factors.iter().enumerate().find_map(|(k, factor)| {
                let of_it = |(_, points): &(&String, &crate::plan::Selection)| {
                    let mut without = (*points).clone();
                    without.factors.remove(&factor.name).is_some() && without.holds(campaign, point)
                };
                let stage = stages().find(of_it).filter(|_| point.factors[k].is_nan())?.0;
                Some((factor.name.clone(), stage.clone()))
            })
        };
        let mut found: Vec<((String, String), Vec<&str>)> = Vec::new();
        for point in &campaign.points {
            let Some(why) = lost(point) else { continue };
            match found.iter_mut().find(|(known, _)| *known == why) {
                Some((_, points)) => points.push(&point.id),
                None => found.push((why, vec![&point.id])),
            }
        }
        let said = |((factor, stage), points): ((String, String), Vec<&str>)| {
            format!(
                "{}: no stage takes {}, because `{factor}` is empty there and the points of stage `{stage}` are chosen by it: give \
                 its value, as 0 where nothing is set",
                campaign.file,
                few(&points, NAMED)
            )
        };
        found.into_iter().map(said).collect()
    }

    fn rooms(&self) -> Option<String> {
        let celsius = |point: &Point| point.ambient.map(|t| t[0] - ZERO).filter(|t| ROOM.contains(t));
        let hot = self.campaign.points.iter().filter_map(|p| Some((p.id.as_str(), celsius(p)?)));
        let (points, numbers): (Vec<&str>, Vec<f64>) = hot.unzip();
        let number = numbers.first()?;
        Some(format!(
            "{}: T_amb is {number:.1} degC at {}: {number:.1} K is the temperature of a room; if it is meant, write T_amb [K] in the heading",
            self.campaign.file,
            few(&points, NAMED)
        ))
    }

    /// Factors that are 0 degrees Celsius at points where the rig is warm. Most often they are differences of
    /// temperatures.
    fn differences(&self) -> Vec<String> {
        let campaign = &self.campaign;
        let warm = |p: &&Point| p.ambient.is_none_or(|t| (t[0] - ZERO).abs() > NEAR_ZERO);
        let of = |(k, factor): (usize, &Factor)| {
            let is_temperature = (factor.shown.to_si(0.0) - ZERO).abs() < 1e-9;
            let zero = |p: &&Point| (p.factors[k] - ZERO).abs() < 1e-9;
            let points: Vec<&str> =
                campaign.points.iter().filter(warm).filter(zero).map(|p| p.id.as_str()).collect();
            (is_temperature && !points.is_empty()).then(|| {
                format!(
                    "{}: `{}` is 0 degC, which is {ZERO} K, at {}: if it is a difference of temperatures, write its unit as K",
                    campaign.file,
                    factor.name,
                    few(&points, NAMED)
                )
            })
        };
        campaign.factors.iter().enumerate().filter_map(of).collect()
    }

    fn cold(&self) -> Option<String> {
        let mut found: Vec<(&str, usize, f64)> = Vec::new();
        for point in &self.campaign.points {
            let Ok(rig) = self.rig.at(point, point.ambient.map_or(LAID_OUT, |t| t[0])) else { continue };
            let light = |d: &DuctAt| is_light(d.gas.as_ref().unwrap_or(&self.rig.gas).constant());
            let all = rig.ducts.iter().filter(|d| !light(d));
            let all = all.flat_map(|d| d.temperatures.iter().map(|t| (d.part, *t)));
            let coldest = all.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, t)| *t < COLD);
            found.extend(coldest.map(|(part, t)| (point.id.as_str(), part, t)));
        }
        let &(_, part, t) = found.first()?;
        Some(format!(
            "rig.toml: the temperature of `{}` is {t:.1} K at {}: if these are degrees Celsius, say so where the number stands: `T [degC]` in the heading \
             of a factor, \"{t:.1} degC\" in rig.toml",
            self.rig.parts[part].name,
            few(&found.iter().map(|f| f.0).collect::<Vec<_>>(), NAMED)
        ))
    }

    /// A number that the gas of no rig has: walls would lose by another factor than those of the rig.
    fn no_gas(&self) -> Option<String> {
        let gas = self.rig.gas.at(LAID_OUT, self.rig.pressure);
        let numbers = [
            ("pressure", self.rig.pressure, " Pa", PRESSURE),
            ("Prandtl number at 20 degC", gas.prandtl, "", PRANDTL),
            ("viscosity at 20 degC", gas.viscosity, " Pa s", VISCOSITY),
        ];
        let known = if is_light(self.rig.gas.constant()) { 1 } else { numbers.len() };
        let outside = |(_, value, _, [low, high]): &(_, f64, _, [f64; 2])| !(low..=high).contains(&value);
        let (what, value, unit, [low, high]) = numbers.into_iter().take(known).find(outside)?;
        Some(format!(
            "rig.toml: the gas has a {what} of {}{unit}, and in rigs it lies between {low} and {high}{unit}: check the decimal point and the unit",
            rounded(value)
        ))
    }

    fn sizes(&self) -> Vec<String> {
        let Some(Ok(rig)) = self.campaign.points.first().map(|point| self.rig.at(point, LAID_OUT)) else {
            return Vec::new();
        };
        let (mut all, names) = (Vec::new(), &self.rig.microphones.names);
        let at = &rig.microphones;
        let pairs = (0..at.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let near: Vec<(usize, usize)> = pairs.filter(|(a, b)| (at[*a] - at[*b]).abs() < ONE_PLACE).collect();
        // Several pairs at equal places sit around the duct on purpose.
        let around = near.len() > 1 && near.iter().all(|(a, b)| at[*a] == at[*b]);
        for (a, b) in near.into_iter().filter(|_| !around) {
            let (x, y) = (at[a], at[b]);
            all.push(format!(
                "rig.toml: microphones `{}` and `{}` are {:.1} mm apart along the rig, at {x} m and {y} m, so they measure the same pressure: correct `at` \
                 if one of the places is a slip",
                names[a],
                names[b],
                1e3 * (x - y).abs()
            ));
        }
        let widest = rig.widest();
        let sound_speed = self.rig.gas.at(LAID_OUT, self.rig.pressure).sound_speed;
        let wavelength = sound_speed / self.rig.search[1][1];
        if is_too_wide(widest, wavelength) {
            all.push(format!(
                "rig.toml: a duct is {widest:.4} m wide: a number without a unit is in m; write the unit, as in diameter = \"44 mm\""
            ));
        }
        all.extend(self.thick(&rig, widest));
        if is_too_long(rig.length, wavelength) {
            all.push(format!(
                "rig.toml: the rig is {:.4} m long: a number without a unit is in m; write the unit, as in length = \"750 mm\"",
                rig.length
            ));
        }
        all
    }

    /// Wires, holes and plates that do not fit into the widest duct.
    fn thick(&self, rig: &RigAtPoint, widest: f64) -> Vec<String> {
        let devices = self.rig.parts.iter().filter(|p| matches!(p.shape, Shape::Device(_)));
        let numbers = devices.flat_map(|p| p.numbers.iter().map(move |(place, _)| (&p.name, *place)));
        let said = |(part, place): (&String, usize)| {
            let name = self.rig.scope.names().get(place)?.name.rsplit('.').next()?;
            let value = rig.numbers[place];
            (THIN.iter().any(|end| name.ends_with(end)) && value > widest).then(|| {
                format!(
                    "rig.toml: `{name}` of `{part}` is {} m, but the widest duct is {} m: correct the number or its unit, as in {name} = \"0.3 mm\"",
                    rounded(value),
                    rounded(widest)
                )
            })
        };
        numbers.filter_map(said).collect()
    }
}

/// What is doubtful of a delay, s, of so many periods of the frequency `highest`, Hz.
pub(crate) fn late(name: &str, delay: f64, highest: f64) -> Option<String> {
    let periods = delay.abs() * highest;
    is_too_late(delay, highest).then(|| {
        format!(
            "`{name}` is {delay} s, {periods:.0} periods of the highest frequency of the search: if these are ms, write {}",
            1e-3 * delay
        )
    })
}
