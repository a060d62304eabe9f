//! From the manifest's names to what they stand for, and back.

use super::keys::{CalibrationEntry, ExceptionEntry, Listed, Manifest, PointEntry, unit};
use super::microphones::Channels;
use crate::apparatus::geometry::Apparatus;
use crate::apparatus::point::OperatingPoint;
use crate::files::in_range;
use crate::problem::Problem;
use crate::records::acquisition::{Acquisition, Exception};
use crate::records::reading::Reading;
use crate::records::set::{Calibration, PointRecords, RecordSet, RecordTiming, check_map};
use crate::units::{Given, Quantity, Unit};
use std::collections::BTreeMap;

type Wrong = (String, Problem);

impl Manifest {
    /// Replaces names by what they stand for. Microphones that are dead in all records are taken out of the
    /// rig.
    pub(super) fn resolve(
        self,
        mut rig: Apparatus,
        campaign: &[OperatingPoint],
        channels: Channels,
    ) -> Result<RecordSet, Wrong> {
        let (numbers, removed) = remove_dead(&mut rig, &self.dead)?;
        let (full_scale, full_scale_in_volts) = full_scale(self.full_scale_pa, self.full_scale.as_ref())?;
        let (ping, click) = self.stretches()?;
        let channels = channels.without(&self.dead);
        let (places, names) = columns(&self.channels, &numbers);
        let reading = Reading {
            names,
            microphones: Vec::new(),
            time: self.time,
            text: self.text,
            unit: unit("unit", self.unit.as_deref())?,
            full_scale_in_volts,
            sensitivities: channels.sensitivities,
            volts_stay: false,
            dead: Vec::new(),
        };
        let days: BTreeMap<&str, usize> =
            self.day.iter().enumerate().map(|(k, day)| (day.id.as_str(), k)).collect();
        let day_index = |place: String, name: &str| {
            let known = || self.day.iter().map(|day| day.id.clone()).collect();
            days.get(name).copied().ok_or_else(|| unknown(place, name, known()))
        };
        let known: BTreeMap<&str, usize> =
            campaign.iter().enumerate().map(|(k, p)| (p.id.as_str(), k)).collect();
        let mut points = Vec::with_capacity(self.point.len());
        for (k, entry) in self.point.into_iter().enumerate() {
            let names = || campaign.iter().map(|p| p.id.clone()).collect();
            let found = known.get(entry.id.as_str()).map(|k| campaign[*k].clone());
            let point = found.ok_or_else(|| unknown(format!("point[{k}].id"), &entry.id, names()))?;
            let day = day_index(format!("point[{k}] `{}`: day", entry.id), &entry.day)?;
            points.push(PointRecords {
                point,
                day,
                pings: entry.pings,
                clicks: entry.clicks,
                way: entry.way,
            });
        }
        let mut calibrations = Vec::with_capacity(self.calibration.len());
        for (k, entry) in self.calibration.into_iter().enumerate() {
            let day = day_index(format!("calibration[{k}].day"), &entry.day)?;
            in_range(&format!("calibration[{k}].rate_hz"), entry.rate_hz, 1.0, 1e9, "Hz")?;
            let stretch = RecordTiming { rate_hz: entry.rate_hz, quiet: entry.quiet_samples };
            calibrations.push(Calibration { day, stretch, clicks: entry.clicks });
        }
        let mut exceptions = Vec::with_capacity(self.exception.len());
        for (k, entry) in self.exception.into_iter().enumerate() {
            let of_day = |name: &String| day_index(format!("exception[{k}].days"), name);
            let of_days = entry.days.iter().map(of_day).collect::<Result<_, _>>()?;
            exceptions.push(entry.resolve(k, of_days, &places, &reading, &numbers)?);
        }
        Ok(RecordSet {
            rig,
            kind: self.kind,
            source: self.source,
            channels: places,
            arrays: self.arrays,
            full_scale,
            ping,
            click,
            days: self.day,
            points,
            calibrations,
            acquisition: Acquisition {
                reading,
                exceptions,
                stated: channels.stated,
                removed,
                band_hz: self.band_hz,
                mains_hz: self.mains_hz,
                may_be_silent: self.may_be_silent,
            },
        })
    }

    /// How pings and clicks are taken. A kind of which there is no record needs no entry.
    fn stretches(&self) -> Result<(RecordTiming, RecordTiming), Wrong> {
        let (mut pings, mut clicks) = (false, false);
        for point in &self.point {
            (pings, clicks) = (pings || !point.pings.is_empty(), clicks || !point.clicks.is_empty());
        }
        let missing = |key: &str| {
            let what = "is missing; say how the listed records were taken: { rate_hz = 10000.0, quiet_samples = 1000 }";
            (key.to_owned(), Problem::Keys { what })
        };
        for (key, stretch) in [("ping", self.ping), ("click", self.click)] {
            let rate = stretch.map_or(1.0, |s| s.rate_hz);
            in_range(&format!("{key}.rate_hz"), rate, 1.0, 1e9, "Hz")?;
        }
        match (self.ping, self.click) {
            (None, _) if pings => Err(missing("ping")),
            (_, None) if clicks => Err(missing("click")),
            (Some(ping), Some(click)) => Ok((ping, click)),
            (Some(one), None) | (None, Some(one)) => Ok((one, one)),
            (None, None) => Err(missing("ping")),
        }
    }

    /// The manifest of a set.
    pub(super) fn of(set: &RecordSet) -> Self {
        let day = |index: usize| set.days[index].id.clone();
        let Acquisition { reading, exceptions, stated, removed: _, band_hz, mains_hz, may_be_silent } =
            &set.acquisition;
        let stated_scale = set.full_scale.is_finite();
        let volts =
            || Unit::parse("V").ok().map(|unit| Given::Stated(Quantity { value: set.full_scale, unit }));
        Self {
            rig: Some("rig.toml".into()),
            campaign: Some("campaign.csv".into()),
            kind: set.kind,
            source: set.source.clone(),
            arrays: set.arrays.clone(),
            full_scale_pa: Some(set.full_scale).filter(|_| stated_scale && !reading.full_scale_in_volts),
            full_scale: volts().filter(|_| stated_scale && reading.full_scale_in_volts),
            unit: reading.unit.as_ref().map(ToString::to_string),
            dead: reading.dead.clone(),
            band_hz: *band_hz,
            mains_hz: *mains_hz,
            may_be_silent: *may_be_silent,
            time: reading.time.clone(),
            text: reading.text.clone(),
            channels: listed(&set.channels, reading),
            ping: Some(set.ping),
            click: Some(set.click),
            microphones: Channels::keys(&reading.sensitivities, stated.as_ref()),
            day: set.days.clone(),
            exception: exceptions
                .iter()
                .map(|e| ExceptionEntry {
                    days: e.days.iter().map(|k| day(*k)).collect(),
                    files: e.files.clone(),
                    unit: e.reading.unit.as_ref().map(ToString::to_string),
                    dead: e.reading.dead.clone(),
                    time: e.reading.time.clone(),
                    channels: Some(listed(&e.channels, &e.reading)),
                    text: Some(e.reading.text.clone()),
                    rate_hz: e.rate_hz,
                    quiet_samples: e.quiet,
                })
                .collect(),
            calibration: set
                .calibrations
                .iter()
                .map(|c| CalibrationEntry {
                    day: day(c.day),
                    rate_hz: c.stretch.rate_hz,
                    quiet_samples: c.stretch.quiet,
                    clicks: c.clicks.clone(),
                })
                .collect(),
            point: set
                .points
                .iter()
                .map(|p| PointEntry {
                    id: p.point.id.clone(),
                    day: day(p.day),
                    pings: p.pings.clone(),
                    clicks: p.clicks.clone(),
                    way: p.way.clone(),
                })
                .collect(),
        }
    }
}

impl ExceptionEntry {
    fn resolve(
        self,
        k: usize,
        days: Vec<usize>,
        places: &[Option<usize>],
        usual: &Reading,
        numbers: &[Option<usize>],
    ) -> Result<Exception, Wrong> {
        if days.is_empty() && self.files.is_empty() {
            let need = "one of `days` and `files` that it speaks of";
            return Err((format!("exception[{k}]"), Problem::Empty { need }));
        }
        let (channels, names) = match &self.channels {
            Some(listed) => columns(listed, numbers),
            None => (places.to_vec(), usual.names.clone()),
        };
        let mut dead = Vec::new();
        for &microphone in &self.dead {
            let problem = Problem::NoSuchIndex { index: microphone, count: numbers.len() };
            let number = numbers.get(microphone).ok_or((format!("exception[{k}].dead"), problem))?;
            dead.extend(*number);
        }
        let unit =
            unit(&format!("exception[{k}].unit"), self.unit.as_deref())?.or_else(|| usual.unit.clone());
        let (time, text) =
            (self.time.or_else(|| usual.time.clone()), self.text.unwrap_or_else(|| usual.text.clone()));
        let reading = Reading { names, time, text, unit, dead, ..usual.clone() };
        if let Some(rate_hz) = self.rate_hz {
            in_range(&format!("exception[{k}].rate_hz"), rate_hz, 1.0, 1e9, "Hz")?;
        }
        let (rate_hz, quiet) = (self.rate_hz, self.quiet_samples);
        Ok(Exception { days, files: self.files, channels, reading, rate_hz, quiet })
    }
}

/// Largest integer in Pa or V, and whether it is V; infinite if not stated.
pub(crate) fn full_scale(in_pa: Option<f64>, given: Option<&Given>) -> Result<(f64, bool), Wrong> {
    let key = || "full_scale".to_owned();
    match (in_pa, given) {
        (Some(_), Some(_)) => {
            let what = "stands beside `full_scale_pa`; keep one of the two";
            Err((key(), Problem::Keys { what }))
        }
        (Some(pascal), None) => Ok((pascal, false)),
        (None, Some(given @ Given::Stated(_))) => match given.of("V") {
            Ok(volts) => Ok((volts, true)),
            Err(_) => given.of("Pa").map(|pascal| (pascal, false)).map_err(|e| (key(), Problem::Unit(e))),
        },
        (None, Some(Given::Si(_))) => {
            let what = "is a number without a unit; write it as in \"10 V\" or \"20 Pa\"";
            Err((key(), Problem::Keys { what }))
        }
        (None, None) => Ok((f64::INFINITY, false)),
    }
}

/// For each microphone its number in the rig without the dead ones; numbers and places of those.
type Removed = (Vec<Option<usize>>, Vec<(usize, f64)>);

/// Takes microphones out of the rig.
fn remove_dead(rig: &mut Apparatus, dead: &[usize]) -> Result<Removed, Wrong> {
    let count = rig.microphones.positions.len();
    let place = || "dead".to_owned();
    for &index in dead {
        if index >= count {
            return Err((place(), Problem::NoSuchIndex { index, count }));
        }
        if index == rig.microphones.reference {
            return Err((place(), Problem::DeadReference { microphone: index }));
        }
    }
    let mut left = 0..;
    let numbers: Vec<Option<usize>> =
        (0..count).map(|m| if dead.contains(&m) { None } else { left.next() }).collect();
    let places = rig.microphones.positions.iter().copied().enumerate();
    let removed = places.filter(|(m, _)| dead.contains(m)).collect();
    let mut m = 0..;
    rig.microphones.positions.retain(|_| m.next().is_none_or(|m| !dead.contains(&m)));
    rig.microphones.reference = numbers.get(rig.microphones.reference).copied().flatten().unwrap_or(0);
    Ok((numbers, removed))
}

impl Listed {
    /// Channels by their place and by their name, of `count` microphones; as many as are listed if none. The
    /// `dead` need no channel.
    ///
    /// # Errors
    /// A microphone that there is not, or one without a channel, or with two.
    pub(crate) fn channels(&self, count: Option<usize>, dead: &[usize]) -> Result<Named, Wrong> {
        let listed: Vec<i64> = match self {
            Self::ByPlace(all) => all.clone(),
            Self::ByName(all) => all.values().copied().collect(),
        };
        let most = listed.into_iter().max().and_then(|m| usize::try_from(m).ok()).map_or(0, |m| m + 1);
        let count = count.unwrap_or(most);
        let numbers: Vec<Option<usize>> = (0..count).map(Some).collect();
        let (places, names) = columns(self, &numbers);
        let reading = Reading { names, dead: dead.to_vec(), ..Reading::default() };
        check_map(&places, &reading, count, "channels")?;
        Ok((places, reading.names))
    }
}

/// Channels by their place, or by their name.
type Named = (Vec<Option<usize>>, BTreeMap<String, Option<usize>>);

/// Channels by their place and by their name, with the numbers that the microphones have after the dead ones
/// are taken out. A number that the rig does not have stays, so that it is found.
fn columns(listed: &Listed, numbers: &[Option<usize>]) -> Named {
    let shift = numbers.iter().filter(|n| n.is_none()).count();
    let number = |m: i64| {
        let m = usize::try_from(m).ok()?;
        numbers.get(m).copied().unwrap_or(Some(m - shift.min(m)))
    };
    match listed {
        Listed::ByPlace(all) => (all.iter().map(|m| number(*m)).collect(), BTreeMap::new()),
        Listed::ByName(all) => (Vec::new(), all.iter().map(|(name, m)| (name.clone(), number(*m))).collect()),
    }
}

fn listed(places: &[Option<usize>], reading: &Reading) -> Listed {
    let number = |m: &Option<usize>| m.map_or(-1, |m| m as i64);
    match reading.names.is_empty() {
        true => Listed::ByPlace(places.iter().map(number).collect()),
        false => Listed::ByName(reading.names.iter().map(|(name, m)| (name.clone(), number(m))).collect()),
    }
}

fn unknown(place: String, name: &str, known: Vec<String>) -> (String, Problem) {
    (place, Problem::UnknownName { name: name.to_owned(), known })
}
