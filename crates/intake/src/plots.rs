//! Pictures of records as numbers: what was recorded, what was fitted, what is left, and the delays of the
//! channels.

use crate::Intake;
use rijke_numerics::{Classify, Failed};
use rijke_rig::{Look, Plot, PlotCurve, PlotPanel, RecordSource};
use rijke_signal::{
    ChannelDelays, ClickPicture, LiveRecord, PingFit, PingOptions, Processed, Trace, click_options,
    fit_majority, picture_click,
};

/// Of a record its name, why it was rejected, and its picture.
pub type Shown<'a> = (&'a str, Option<&'a str>, Plot);

impl Intake {
    /// Pictures of the first accepted ping and click of every operating point and of every rejected one; each
    /// is handed to `show`, so that not all are held at once.
    ///
    /// # Errors
    /// Records that cannot be read, and what `show` returns.
    pub fn plots(
        &self,
        processed: &Processed,
        show: &mut dyn FnMut(Shown<'_>) -> Result<(), Failed>,
    ) -> Result<(), Failed> {
        let set = self.source().set();
        for (k, (records, point)) in set.points.iter().zip(&processed.observations.points).enumerate() {
            let pings: Vec<u32> = point.pings.iter().map(|p| p.0).collect();
            let clicks: Vec<u32> = point.clicks.iter().map(|c| c.0).collect();
            for (names, accepted, of) in [
                (&records.pings, pings, of_ping as OfRecord),
                (&records.clicks, clicks, of_click as OfRecord),
            ] {
                let first = accepted.first().map_or(usize::MAX, |n| *n as usize);
                for (n, name) in names.iter().enumerate() {
                    let reason = reason(processed, name);
                    if n == first || reason.is_some() {
                        let panels = of(self.source(), processed, k, n)?;
                        let plot = Plot { title: title(name, reason), data: set.kind, panels };
                        show((name, reason, plot))?;
                    }
                }
            }
        }
        Ok(())
    }

    /// A record with its fit; none of a file that belongs to no operating point.
    ///
    /// # Errors
    /// The record cannot be read.
    pub fn plot_of(&self, processed: &Processed, name: &str) -> Result<Option<Plot>, Failed> {
        let set = self.source().set();
        let place = |files: &[String]| files.iter().position(|file| file == name);
        let ping = set.points.iter().enumerate().find_map(|(k, p)| Some((k, place(&p.pings)?)));
        let click = set.points.iter().enumerate().find_map(|(k, p)| Some((k, place(&p.clicks)?)));
        let panels = match (ping, click) {
            (Some((k, n)), _) => of_ping(self.source(), processed, k, n)?,
            (None, Some((k, n))) => of_click(self.source(), processed, k, n)?,
            (None, None) => return Ok(None),
        };
        Ok(Some(Plot { title: title(name, reason(processed, name)), data: set.kind, panels }))
    }

    /// The delays of the channels.
    pub fn plot_of_delays(&self, processed: &Processed) -> Plot {
        let names = self.source().set().rig.microphones.called();
        let found = [("pings", &processed.ping_delays), ("clicks", &processed.click_delays)];
        let panel = |(k, (what, d)): (usize, (_, &Option<ChannelDelays>))| {
            Some(delay_panel(what, k, d.as_ref()?, &names))
        };
        let panels = found.into_iter().enumerate().filter_map(panel).collect();
        Plot { title: "Delays of the channels".into(), data: self.source().set().kind, panels }
    }
}

/// The panels of a record, by the numbers of its point and of its repeat.
type OfRecord = fn(&dyn RecordSource, &Processed, usize, usize) -> Result<Vec<PlotPanel>, Failed>;

fn reason<'a>(processed: &'a Processed, name: &str) -> Option<&'a str> {
    processed.observations.rejections.iter().find(|r| r.record == name).map(|r| r.reason.as_str())
}

fn title(name: &str, reason: Option<&str>) -> String {
    reason.map_or_else(|| name.to_owned(), |reason| format!("{name}, rejected: {reason}"))
}

fn of_ping(
    source: &dyn RecordSource,
    processed: &Processed,
    k: usize,
    n: usize,
) -> Result<Vec<PlotPanel>, Failed> {
    let record = source.ping(k, n).or_bad_input()?;
    let known = LiveRecord::of(record, source.set().rig.microphones.reference);
    let trace = Trace::from(&known.record);
    let own = PingOptions { reference: known.reference, ..processed.ping.clone() };
    let names = source.set().rig.microphones.called();
    let heard: Vec<&str> = known.live.iter().map(|m| names[*m].as_str()).collect();
    let Ok(found) = fit_majority(&trace, &own) else { return Ok(raw_panels(&trace, &heard)) };
    let live: Vec<&str> = found.kept.iter().map(|place| heard[*place]).collect();
    let channels: Vec<Vec<f64>> = found.kept.iter().map(|place| trace.channels[*place].clone()).collect();
    Ok(ping_panels(&found.fit, &Trace { channels: &channels, ..trace }, &live))
}

fn of_click(
    source: &dyn RecordSource,
    processed: &Processed,
    k: usize,
    n: usize,
) -> Result<Vec<PlotPanel>, Failed> {
    let records = &source.set().points[k];
    let known = click_options(source.set(), records.day, Some(records), &processed.click);
    let record = source.click(k, n).or_bad_input()?;
    let trace = Trace::from(&record);
    let names = source.set().rig.microphones.called();
    Ok(match picture_click(&trace, &known) {
        Ok(picture) => click_panels(&picture, &names),
        Err(_) => raw_panels(&trace, &names),
    })
}

/// Of the microphones with these names: start of the decay, what is left, the decay as a whole, and the
/// spectrum before and after.
fn ping_panels(fit: &PingFit, trace: &Trace<'_>, live: &[&str]) -> Vec<PlotPanel> {
    let picture = fit.picture(trace);
    let (start, time) = (fit.window.0, "*t* / s");
    let early = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().take_while(|p| p[0] < start + 0.04).copied().collect()
    };
    let decibels = |points: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
        points.into_iter().map(|[f, d]| [f, 20.0 * d.max(1e-12).log10()]).collect()
    };
    let label = format!("Pressure at {} / Pa", live[picture.channel]);
    let (record, fitted) = (early(&picture.record), early(&picture.fit));
    vec![
        PlotPanel {
            marks: vec![start],
            ..PlotPanel::new(
                time,
                &label,
                vec![
                    PlotCurve::new("record", Look::Record, record),
                    PlotCurve::new("fit", Look::Fit, fitted),
                ],
            )
        },
        PlotPanel::new(
            time,
            "Residual / Pa",
            vec![PlotCurve::new("residual: record less fit", Look::Channel(5, 7), picture.residual)],
        ),
        PlotPanel {
            marks: vec![start],
            ..PlotPanel::new(time, &label, vec![PlotCurve::new("record", Look::Record, picture.record)])
        },
        PlotPanel::new(
            "*f* / Hz",
            "Density / dB re 1 Pa Hz^{-1/2}",
            vec![
                PlotCurve::new("record", Look::Record, decibels(picture.spectrum)),
                PlotCurve::new(
                    "residual: record less fit",
                    Look::Channel(5, 7),
                    decibels(picture.residual_spectrum),
                ),
            ],
        ),
    ]
}

/// The channels in phase with the impulse, each divided by its gain, and what each leaves.
fn click_panels(picture: &ClickPicture, names: &[String]) -> Vec<PlotPanel> {
    let count = picture.channels.len();
    let milliseconds =
        |points: &[[f64; 2]]| -> Vec<[f64; 2]> { points.iter().map(|[t, p]| [1e3 * t, *p]).collect() };
    let channels = picture.channels.iter().enumerate();
    let mut curves: Vec<PlotCurve> = channels
        .map(|(m, points)| PlotCurve::new(&names[m], Look::Channel(m, count), milliseconds(points)))
        .collect();
    curves.push(PlotCurve::new("impulse", Look::Fit, milliseconds(&picture.impulse)));
    let left = picture.left.iter().enumerate();
    let left = left.map(|(m, points)| PlotCurve::new("", Look::Channel(m, count), milliseconds(points)));
    let time = "Time from the arrival / ms";
    vec![PlotPanel::new(time, "Pressure / Pa", curves), PlotPanel::new(time, "Residual / Pa", left.collect())]
}

/// All channels as they are, which are microphones of these names, for a record that could not be fitted.
fn raw_panels(trace: &Trace<'_>, names: &[impl AsRef<str>]) -> Vec<PlotPanel> {
    let count = trace.channels.len();
    // Largest and smallest of every few samples: the outline, at the resolution of the picture.
    let few = trace.len().div_ceil(500).max(1);
    let outline = |(m, y): (usize, &Vec<f64>)| {
        let points = y.chunks(few).enumerate().flat_map(|(k, y)| {
            let t = (k * few) as f64 / trace.rate_hz;
            let high = y.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
            let low = y.iter().fold(f64::INFINITY, |a, b| a.min(*b));
            [[t, high], [t, low]]
        });
        PlotCurve::new(names[m].as_ref(), Look::Channel(m, count), points.collect())
    };
    vec![PlotPanel::new("*t* / s", "Pressure / Pa", trace.channels.iter().enumerate().map(outline).collect())]
}

/// Delays of the microphones with these names, in the colour with number `colour`.
fn delay_panel(what: &str, colour: usize, delays: &ChannelDelays, names: &[String]) -> PlotPanel {
    let first = delays.delays.first().copied().unwrap_or(0.0);
    let points: Vec<[f64; 2]> =
        delays.delays.iter().enumerate().map(|(m, d)| [m as f64, 1e6 * (d - first)]).collect();
    let bars = points.iter().enumerate().map(|(m, [x, y])| {
        let (c, (a, b)) = (&delays.covariance, (0, m));
        let sd = 1e6 * (c[(a, a)] + c[(b, b)] - 2.0 * c[(a, b)]).max(0.0).sqrt();
        PlotCurve::new("two standard deviations", Look::Fit, vec![[*x, y - 2.0 * sd], [*x, y + 2.0 * sd]])
    });
    let name = format!("{what}, {} Hz", delays.rate_hz);
    let curves =
        [PlotCurve::new(&name, Look::Dots(colour), points.clone())].into_iter().chain(bars).collect();
    let relative = names.first().map_or(String::new(), |name| format!(" relative to {name}"));
    PlotPanel {
        places: names.to_vec(),
        ..PlotPanel::new("Microphone", &format!("Delay{relative} / \u{b5}s"), curves)
    }
}
