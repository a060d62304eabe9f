//! What the calibration clicks of a record set say of its channels, and what is done without them.

use super::copies::leave_out_copied_clicks;
use super::fitted::rejection;
use super::live::of_rig;
use super::options::{ProcessError, ProcessOptions};
use super::path::click_options;
use crate::click::{ClickFit, ClickOptions, Extent, fit_click};
use crate::delays::{CalibrationError, ChannelDelays, KnownClick, exchanged};
use crate::{Fault, Trace};
use rayon::prelude::*;
use rijke_numerics::InOrder;
use rijke_rig::{Calibration, RecordSet, RecordSource, Rejection, RigError};

/// What is known of the channels.
#[derive(Clone, Debug)]
pub(super) struct Calibrated {
    /// At the pings' sampling rate; none if shapes are left out.
    pub(super) pings: Option<ChannelDelays>,
    /// Whether that is so at any rate, because delays and gains were stated.
    pub(super) at_any_rate: bool,
    /// At the clicks'; none if clicks are left out.
    pub(super) clicks: Option<ChannelDelays>,
    /// How the clicks of the operating points are to be fitted.
    pub(super) click: ClickOptions,
    pub(super) rejections: Vec<Rejection>,
    pub(super) notes: Vec<String>,
    /// Records read.
    pub(super) records: usize,
}

/// Records from which the extent of the clicks is read.
const LOOKED_AT: usize = 5;
/// A delay that is only known to be one within a sample has this standard deviation in samples: 1/sqrt(12).
const WITHIN_A_SAMPLE: f64 = 0.289;

pub(super) fn calibrate(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    has_pings: bool,
    has_clicks: bool,
    advance: &(dyn Fn() + Sync),
) -> Result<Calibrated, ProcessError> {
    let set = source.set();
    let (mut rejections, mut notes, mut records) = (Vec::new(), Vec::new(), 0);
    let mut learn = |needed: bool, rate_hz: f64| -> Result<(Option<Found>, Option<String>), ProcessError> {
        if !needed {
            return Ok((None, None));
        }
        let before = rejections.len();
        let cause =
            match at_rate(source, options, rate_hz, advance, (&mut rejections, &mut notes), &mut records)? {
                Ok(found) => return Ok((Some(found), None)),
                Err(CalibrationError::TooFew { have: 0 }) if rejections.len() == before => {
                    format!("there are no calibration clicks at {rate_hz} Hz")
                }
                Err(CalibrationError::TooFew { have }) => {
                    let first = rejections.get(before).map_or(String::new(), |r| {
                        format!("; the first rejected, {}: {}", r.record, r.reason)
                    });
                    format!("of the calibration clicks at {rate_hz} Hz {have} can be used{first}")
                }
                Err(cause) => {
                    let first = rejections.get(before).map(|r| format!("{}: {}", r.record, r.reason));
                    let cause = Box::new(cause.called(&of_rig(&set.acquisition, &set.rig.microphones)));
                    let records = files(set, rate_hz);
                    return Err(ProcessError::Calibration {
                        rate_hz,
                        records,
                        cause,
                        first_rejection: first,
                    });
                }
            };
        Ok((None, Some(cause)))
    };
    let (pings, no_pings) = learn(has_pings, set.ping.rate_hz)?;
    let (clicks, no_clicks) = learn(has_clicks, set.click.rate_hz)?;
    if let Some(cause) = no_clicks {
        notes.push(format!("{cause}: clicks are left out, because arrival times need the calibration"));
    }
    let click = clicks.as_ref().map_or_else(|| options.click.clone(), |f| f.options.clone());
    if click != options.click {
        notes.push(format!(
            "the clicks are fitted from {:.2} ms before to {:.2} ms after their peak, from {:.0} to {:.0} Hz, as the calibration clicks need",
            1e3 * click.window.0, 1e3 * click.window.1, click.band_hz.0, click.band_hz.1
        ));
    }
    let at_any_rate = pings.is_none() && (options.stated.is_some() || set.acquisition.stated.is_some());
    let (clicks, channels) = (clicks.map(|f| f.delays), set.rig.microphones.positions.len());
    let pings = match (pings, no_pings) {
        (Some(found), _) => Some(found.delays),
        (None, None) => None,
        (None, Some(cause)) => {
            let need = "growth rate and frequency need none";
            let (delays, words) = match (&options.stated, &set.acquisition.stated, &clicks) {
                (None, Some(stated), _) => {
                    let largest = |sds: &[f64]| sds.iter().copied().fold(0.0, f64::max);
                    let words = format!(
                        "mode shapes take gains and delays from [microphones] of the manifest, known to {:.1} % and {:.0} us or better",
                        100.0 * largest(&stated.gain_sds),
                        1e6 * largest(&stated.delay_sds)
                    );
                    (Some(ChannelDelays::stated_of_each(set.ping.rate_hz, stated)), words)
                }
                (Some(stated), _, _) => {
                    let words = format!(
                        "mode shapes take all gains as equal to {:.1} % and all delays to {:.0} us, as stated",
                        100.0 * stated.gain_sd,
                        1e6 * stated.delay_sd
                    );
                    (Some(ChannelDelays::stated(channels, set.ping.rate_hz, *stated)), words)
                }
                (None, None, Some(found)) => {
                    let delay = WITHIN_A_SAMPLE / set.ping.rate_hz;
                    let words = format!(
                        "mode shapes take the gains found at {} Hz, and all delays as equal to within one sample ({:.0} us, standard deviation)",
                        set.click.rate_hz,
                        1e6 * delay
                    );
                    (Some(found.at_another_rate(set.ping.rate_hz, delay)), words)
                }
                (None, None, None) => {
                    let words = "mode shapes are left out, and the observations hold the reference microphone alone; for shapes \
                                 record a few clicks in the empty tube at that rate and list them as a [[calibration]] in the \
                                 manifest, or state how equal the channels are: gain_sd (or sensitivity_sd) and delay_sd in its [microphones], or --channels";
                    (None, words.to_owned())
                }
            };
            notes.push(format!("{cause}; {need}; {words}"));
            delays
        }
    };
    Ok(Calibrated { pings, at_any_rate, clicks, click, rejections, notes, records })
}

/// The calibrations of one sampling rate, and their numbers.
fn of_rate(set: &RecordSet, rate_hz: f64) -> impl Iterator<Item = (usize, &Calibration)> {
    let same = move |c: &Calibration| (c.stretch.rate_hz - rate_hz).abs() < 1e-6 * rate_hz;
    set.calibrations.iter().enumerate().filter(move |(_, c)| same(c))
}

/// The first of the files of one sampling rate, and how many more there are.
fn files(set: &RecordSet, rate_hz: f64) -> String {
    let names: Vec<&String> = of_rate(set, rate_hz).flat_map(|(_, c)| &c.clicks).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => (*one).clone(),
        [first, others @ ..] => format!("{first} and {} more", others.len()),
    }
}

struct Found {
    delays: ChannelDelays,
    options: ClickOptions,
}

/// The calibration clicks of one sampling rate.
fn at_rate(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    rate_hz: f64,
    advance: &(dyn Fn() + Sync),
    (rejections, notes): (&mut Vec<Rejection>, &mut Vec<String>),
    records: &mut usize,
) -> Result<Result<Found, CalibrationError>, ProcessError> {
    let set = source.set();
    let called = of_rig(&set.acquisition, &set.rig.microphones);
    let jobs: Vec<(usize, usize)> =
        of_rate(set, rate_hz).flat_map(|(k, c)| (0..c.clicks.len()).map(move |n| (k, n))).collect();
    *records += jobs.len();
    let known =
        |which: usize, click: &ClickOptions| click_options(set, set.calibrations[which].day, None, click);
    let mut extents = Vec::new();
    for &(which, repeat) in jobs.iter().take(LOOKED_AT) {
        let record = source.calibration(which, repeat)?;
        // A click that has no extent is refused below, with the reason.
        extents.extend(Extent::of(&Trace::from(&record), &known(which, &options.click)).ok());
    }
    let click = Extent::median(&extents).map_or_else(|| options.click.clone(), |e| options.click.holding(&e));
    let fits: Vec<Result<ClickFit, Fault>> = jobs
        .par_iter()
        .map(|&(which, repeat)| -> Result<_, RigError> {
            let record = source.calibration(which, repeat)?;
            let trace = Trace::from(&record);
            let known = known(which, &click);
            let fit = Extent::of(&trace, &known).and_then(|_| fit_click(&trace, &known));
            advance();
            Ok(fit)
        })
        .in_order::<Result<_, _>>()?;
    let (mut clicks, mut names) = (Vec::new(), Vec::new());
    for (&(which, repeat), fit) in jobs.iter().zip(fits) {
        let calibration = &set.calibrations[which];
        let day = &set.days[calibration.day];
        match fit {
            Ok(fit) => {
                let speed = set.rig.gas.at(day.ambient_temperature, set.rig.pressure).sound_speed;
                names.push(calibration.clicks[repeat].as_str());
                clicks.push(KnownClick {
                    fit,
                    expected: set.rig.microphones.positions.iter().map(|x| x / speed).collect(),
                    group: calibration.day,
                    // c goes as the square root of the temperature.
                    speed_sd: 0.5 * day.ambient_temperature_sd / day.ambient_temperature,
                });
            }
            Err(fault) => rejections.push(rejection(&calibration.clicks[repeat], &fault.called(&called))),
        }
    }
    let copies = leave_out_copied_clicks(&mut names, &mut clicks, rejections);
    notes.extend(copies.filter(|said| !notes.contains(said)));
    if clicks.len() < 2 {
        // An impulse of another channel does not fit the place at which it is sought: that is no fault of it.
        let mut heard = Vec::new();
        for &(which, repeat) in &jobs {
            heard.push(onsets(&Trace::from(&source.calibration(which, repeat)?)));
        }
        let day = jobs.first().map(|(which, _)| &set.days[set.calibrations[*which].day]);
        let speed = day.map(|day| set.rig.gas.at(day.ambient_temperature, set.rig.pressure).sound_speed);
        let expected = speed.map(|c| set.rig.microphones.positions.iter().map(|x| x / c).collect());
        let files: Vec<&str> = jobs.iter().map(|(k, n)| set.calibrations[*k].clicks[*n].as_str()).collect();
        if let Err(cause) =
            expected.map_or(Ok(()), |expected: Vec<f64>| exchanged(&heard, &expected, rate_hz))
        {
            return Ok(Err(cause.with_names(&files)));
        }
    }
    let spread = options.gain_spread.unwrap_or(crate::delays::GAIN_SPREAD);
    let delays = ChannelDelays::calibrate_within(&clicks, rate_hz, spread);
    let delays = delays.map_err(|cause| cause.with_names(&names));
    Ok(delays.map(|delays| Found { delays, options: click }))
}

/// When each channel first hears half of its largest sound after the trigger, s.
fn onsets(trace: &Trace<'_>) -> Vec<f64> {
    let of = |y: &Vec<f64>| {
        let after = &y[trace.quiet.min(y.len())..];
        let largest = after.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        after.iter().position(|v| v.abs() >= 0.5 * largest).unwrap_or(0) as f64 / trace.rate_hz
    };
    trace.channels.iter().map(of).collect()
}
