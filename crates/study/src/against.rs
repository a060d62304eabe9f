//! What the files of a study say against its observations.

use crate::made_of::has_temperatures_of_campaign;
use crate::plan::Base;
use crate::rig::PartAt;
use crate::{GasReading, ObservedModes, Point, Study, StudyError, read_readings};
use rijke_numerics::words::{counted, few};
use rijke_rig::Observations;

/// The temperature of a day is no nearer to that of a plan than this, K: beyond, one of the two is a slip.
const UNLIKE: f64 = 15.0;

/// A temperature that was written and read again differs by no more than this, K.
const ROUNDING: f64 = 1e-6;

/// Two readings of one point on both sides of a part differ by more than this share of their mean, and are
/// farther apart than this share of the length: the laws of the part see a temperature that is nowhere.
const STEEP: f64 = 0.05;
const APART: f64 = 2e-3;

/// Most points without an observation that are named.
const NAMED: usize = 5;

impl Study {
    /// Errors of channels that are stated and that no stage of modes counts, a sentence each.
    ///
    /// # Errors
    /// As [`Study::channels`].
    pub fn idle_channels(&self) -> Result<Vec<String>, StudyError> {
        let mut all = Vec::new();
        let stated = self.channels()?.is_some();
        if stated && !self.plan.stages.iter().any(|s| s.channels) {
            all.push(
                "observations/channels.toml states errors of gains and delays that all points share, but no stage of modes has `channels = true`: \
                 without it they count as errors of each point alone, and parameters come out too certain"
                    .to_owned(),
            );
        }
        if let Some(stage) = self.plan.stages.iter().find(|s| s.channels && !stated) {
            all.push(format!(
                "`channels = true` of stage `{}` does nothing: observations/channels.toml, which states the errors of gains and delays, is absent",
                stage.id
            ));
        }
        if self.rig.microphones.channel_errors().is_some() && !stated {
            all.push(
                "gain_sd and delay_sd of rig.toml count in stages of responses alone: for stages of modes state the errors of the channels in \
                 observations/channels.toml"
                    .to_owned(),
            );
        }
        Ok(all)
    }

    /// Points that stages mean and nothing was observed at, in a sentence; none where nothing was observed at
    /// all.
    #[must_use]
    pub fn unobserved(&self, observations: &ObservedModes) -> Option<String> {
        let nothing = |k: usize| observations.modes.iter().all(|m| m.point != k);
        let meant = |point: &Point| {
            self.plan.stages.iter().any(|s| s.points.first.is_none() && s.points.holds(&self.campaign, point))
        };
        let points = self.campaign.points.iter().enumerate();
        let missing: Vec<&str> =
            points.filter(|(k, p)| nothing(*k) && meant(p)).map(|(_, p)| p.id.as_str()).collect();
        if missing.is_empty() || observations.modes.is_empty() {
            return None;
        }
        Some(format!(
            "{} of stages without an observation: {}; nothing is trained there",
            counted(missing.len(), "point"),
            few(&missing, NAMED)
        ))
    }

    /// Points whose ambient temperature differs between the campaign and what was read with the records, in a
    /// sentence.
    #[must_use]
    pub fn other_temperatures(&self, observations: &ObservedModes) -> Option<String> {
        // What the campaign gave when the records were processed it has still, unless it was corrected since.
        let given = has_temperatures_of_campaign(&self.folder.join("observations"));
        let differs = |(k, point): (usize, &Point)| {
            let ([stated, sd], [read, read_sd]) = (point.ambient?, *observations.ambient.get(&k)?);
            let corrected = (stated - read).abs() > ROUNDING || (sd - read_sd).abs() > ROUNDING;
            let unlike = if given { corrected } else { (stated - read).abs() > UNLIKE };
            unlike.then(|| {
                format!("{} ({stated} +- {sd} K there, {read} +- {read_sd} K with the records)", point.id)
            })
        };
        let points: Vec<String> = self.campaign.points.iter().enumerate().filter_map(differs).collect();
        points.first().map(|first| {
            format!(
                "at {}, first {first}, the campaign and the records state different ambient temperatures; those of the records count \
                 (observations/points.csv); {}",
                counted(points.len(), "point"),
                if given {
                    "the campaign was changed since they were processed: process them again, with --force"
                } else {
                    "correct T_amb, or process the records again"
                }
            )
        })
    }

    /// Readings of thermometers that stand in the table again with the same number, in a sentence: copies of
    /// a row count as measurements of their own.
    ///
    /// # Errors
    /// Those of the readings.
    pub fn copied_readings(&self) -> Result<Option<String>, StudyError> {
        let Some(path) = self.readings(false)? else { return Ok(None) };
        let readings = read_readings(&path, &self.campaign, &self.rig)?;
        let same = |a: &GasReading, b: &GasReading| {
            (a.point, a.at, a.temperature, a.sd) == (b.point, b.at, b.temperature, b.sd)
        };
        let copies: Vec<&GasReading> = (1..readings.len())
            .filter(|k| readings[..*k].iter().any(|r| same(r, &readings[*k])))
            .map(|k| &readings[k])
            .collect();
        Ok(copies.first().map(|first| {
            format!(
                "{}: {} of {} rows have the point, place and temperature of an earlier one, the first at {}, {:.3} m: if rows were copied, take the copies \
                 out, because each counts as a reading of its own",
                path.display(),
                copies.len(),
                readings.len(),
                self.campaign.points[first.point].id,
                first.at
            )
        }))
    }

    /// Parts that stand between two thermometers of `[base.measured]` where the gas is much hotter on one
    /// side, a sentence each.
    ///
    /// # Errors
    /// Those of the readings.
    pub fn between_thermometers(&self) -> Result<Vec<String>, StudyError> {
        let Base::Measured(_) = &self.plan.base else { return Ok(Vec::new()) };
        let Some(path) = self.readings(false)? else { return Ok(Vec::new()) };
        let readings = read_readings(&path, &self.campaign, &self.rig)?;
        let mut steepest: Vec<Option<(f64, String)>> = vec![None; self.rig.parts.len()];
        for (k, point) in self.campaign.points.iter().enumerate() {
            let mut of_it: Vec<_> = readings.iter().filter(|r| r.point == k).collect();
            of_it.sort_by(|a, b| a.at.total_cmp(&b.at));
            let Some(Ok(layout)) = of_it.first().map(|r| self.rig.at(point, r.temperature)) else { continue };
            for ((part, at), most) in self.rig.parts.iter().zip(&layout.parts).zip(&mut steepest) {
                let PartAt::Places(places) = at else { continue };
                for pair in of_it.windows(2) {
                    let [a, b] = [pair[0], pair[1]];
                    let share = 2.0 * (b.temperature - a.temperature).abs() / (a.temperature + b.temperature);
                    let between = places.iter().any(|x| a.at < *x && *x < b.at);
                    let far = b.at - a.at > APART * layout.length;
                    if between && far && share > STEEP.max(most.as_ref().map_or(0.0, |(s, _)| *s)) {
                        *most = Some((
                            share,
                            format!(
                                "at {} the gas has {:.0} K at {:.3} m and {:.0} K at {:.3} m, and the temperature at {} is interpolated \
                             between the two, so laws there have the wrong velocity: measure close to both faces, or use [base.heated-flow]",
                                point.id, a.temperature, a.at, b.temperature, b.at, part.name
                            ),
                        ));
                    }
                }
            }
        }
        Ok(steepest.into_iter().flatten().map(|(_, said)| said).collect())
    }

    /// Gives every point of observations the ambient temperature that the campaign states for it, in place of
    /// that of its day; a sentence on how many these are.
    pub fn give_temperatures(&self, observations: &mut Observations) -> Option<String> {
        let (mut count, mut apart, all) = (0, 0.0_f64, observations.points.len());
        for point in &mut observations.points {
            let known = self.campaign.point(&point.point.id).and_then(|(_, p)| p.ambient);
            if let Some([temperature, sd]) = known {
                apart = apart.max((temperature - point.ambient.ambient_temperature).abs());
                (point.ambient.ambient_temperature, point.ambient.ambient_temperature_sd) = (temperature, sd);
                count += 1;
            }
        }
        let of_days = if count == all {
            String::new()
        } else {
            format!(", and those of the days for the other {}", all - count)
        };
        (count > 0).then(|| {
            format!(
                "{count} of {all} points have the ambient temperature of the campaign (T_amb), up to {apart:.2} K from that of their day{of_days}"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{MadeOf, OneTable};

    #[test]
    fn exact_points_that_lack_observations_and_other_temperatures_are_said() {
        let folder = std::env::temp_dir().join(format!("rijke-against-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [rig, table] = ["rig.toml", "modes.csv"].map(|file| folder.join(file));
        let tube = "name = \"tube\"\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
                    [[element]]\ntype = \"duct\"\nlength = \"L0\"\ndiameter = 0.05\n";
        let modes = "L0,T_amb [K],growth_rate,growth_rate_sd,frequency,frequency_sd\n0.8,293,-3,1,107,1\n0.9,294,-4,1,95,1\n";
        std::fs::write(&rig, tube).unwrap();
        std::fs::write(&table, modes).unwrap();
        let (study, mut observations) = OneTable::read(&rig, &table).unwrap().study().unwrap();
        assert_eq!((study.unobserved(&observations), study.other_temperatures(&observations)), (None, None));
        observations.ambient.insert(1, [320.0, 0.1]);
        let other = study.other_temperatures(&observations).unwrap();
        assert!(
            other.starts_with("at 1 point, first line-3 (294 +- 0 K there, 320 +- 0.1 K with the records)"),
            "{other}"
        );
        // Less than a plan may be off; but the campaign gave it when the records were processed.
        observations.ambient.insert(1, [299.0, 0.0]);
        assert_eq!(study.other_temperatures(&observations), None);
        let observed = study.folder.join("observations");
        std::fs::create_dir_all(&observed).unwrap();
        MadeOf::records(&observed).unwrap().with_temperatures_of_campaign().write(&observed).unwrap();
        let corrected = study.other_temperatures(&observations);
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(corrected.unwrap().ends_with("process them again, with --force"));
        observations.modes.pop();
        let lacking = study.unobserved(&observations).unwrap();
        assert!(
            lacking.starts_with("1 point of stages without an observation: line-3; nothing"),
            "{lacking}"
        );
    }
}
