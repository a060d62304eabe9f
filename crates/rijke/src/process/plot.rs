//! Pictures of records: what was recorded, what was fitted, what is left, and the delays of the channels.

use crate::failure::{Classify, Failure};
use crate::figure::both;
use rijke_report::{Look, RecordCurve, RecordFigure, RecordPanel, escape, gallery};
use rijke_rig::RecordSource;
use rijke_signal::{
    ChannelDelays, ClickPicture, LiveRecord, PingFit, PingOptions, Processed, Trace, click_options,
    fit_majority, picture_click,
};
use std::fmt::Write as _;
use std::path::Path;

/// Writes `plots/index.html` and one figure, as SVG and PDF, for the first accepted ping and click of every
/// operating point and for every rejected one.
pub(super) fn write(source: &dyn RecordSource, processed: &Processed, folder: &Path) -> Result<(), Failure> {
    let folder = folder.join("plots");
    let reason = |name: &str| {
        processed.observations.rejections.iter().find(|r| r.record == name).map(|r| r.reason.as_str())
    };
    let set = source.set();
    let mut page = String::from(
        "<p>The first accepted ping and click of every operating point, and every rejected record.</p>\n",
    );
    let mut delays = RecordFigure { title: "Delays of the channels".into(), data: set.kind, panels: vec![] };
    for (what, found) in [("pings", &processed.ping_delays), ("clicks", &processed.click_delays)] {
        delays.panels.extend(found.as_ref().map(|d| delay_panel(what, d)));
    }
    both(&folder, "delays", &delays.svg())?;
    page +=
        "<h2>Delays of the channels</h2>\n<p><img src=\"delays.svg\" alt=\"Delays of the channels\"></p>\n";
    page += "<h2>Records</h2>\n<ul>\n";
    for (k, (records, point)) in set.points.iter().zip(&processed.observations.points).enumerate() {
        let mut entry = |name: &str, svg: &str| -> Result<(), Failure> {
            both(&folder, name, svg)?;
            let reason = reason(name).map_or(String::new(), |r| format!(": rejected, {}", escape(r)));
            let _ = writeln!(page, "<li><a href=\"{name}.svg\">{}</a>{reason}</li>", escape(name));
            Ok(())
        };
        let first = |repeats: &[u32]| repeats.first().map_or(usize::MAX, |n| *n as usize);
        let shown = first(&point.pings.iter().map(|p| p.0).collect::<Vec<_>>());
        for (n, name) in records.pings.iter().enumerate().filter(|(n, r)| *n == shown || reason(r).is_some())
        {
            let panels = of_ping(source, processed, k, n)?;
            let title = title(name, reason(name));
            entry(name, &RecordFigure { title, data: set.kind, panels }.svg())?;
        }
        let shown = first(&point.clicks.iter().map(|c| c.0).collect::<Vec<_>>());
        for (n, name) in records.clicks.iter().enumerate().filter(|(n, r)| *n == shown || reason(r).is_some())
        {
            let panels = of_click(source, processed, k, n)?;
            let title = title(name, reason(name));
            entry(name, &RecordFigure { title, data: set.kind, panels }.svg())?;
        }
    }
    page += "</ul>\n";
    let path = folder.join("index.html");
    std::fs::write(&path, gallery("Records and fits", &page)).or_failed().map_err(|f| f.at(&path))
}

/// A record with its fit, as the text of an SVG file; none of a file that belongs to no operating point.
pub(super) fn of_record(
    source: &dyn RecordSource,
    processed: &Processed,
    name: &str,
) -> Result<Option<String>, Failure> {
    let set = source.set();
    let place = |files: &[String]| files.iter().position(|file| file == name);
    let ping = set.points.iter().enumerate().find_map(|(k, p)| Some((k, place(&p.pings)?)));
    let click = set.points.iter().enumerate().find_map(|(k, p)| Some((k, place(&p.clicks)?)));
    let panels = match (ping, click) {
        (Some((k, n)), _) => of_ping(source, processed, k, n)?,
        (None, Some((k, n))) => of_click(source, processed, k, n)?,
        (None, None) => return Ok(None),
    };
    let reason = processed.observations.rejections.iter().find(|r| r.record == name);
    let title = title(name, reason.map(|r| r.reason.as_str()));
    Ok(Some(RecordFigure { title, data: set.kind, panels }.svg()))
}

fn of_ping(
    source: &dyn RecordSource,
    processed: &Processed,
    k: usize,
    n: usize,
) -> Result<Vec<RecordPanel>, Failure> {
    let record = source.ping(k, n).or_bad_input()?;
    let known = LiveRecord::of(record, source.set().rig.microphones.reference);
    let trace = Trace::from(&known.record);
    let own = PingOptions { reference: known.reference, ..processed.ping.clone() };
    let Ok(found) = fit_majority(&trace, &own) else { return Ok(raw_panels(&trace)) };
    let live: Vec<usize> = found.kept.iter().map(|place| known.live[*place]).collect();
    let channels: Vec<Vec<f64>> = found.kept.iter().map(|place| trace.channels[*place].clone()).collect();
    Ok(ping_panels(&found.fit, &Trace { channels: &channels, ..trace }, &live))
}

fn of_click(
    source: &dyn RecordSource,
    processed: &Processed,
    k: usize,
    n: usize,
) -> Result<Vec<RecordPanel>, Failure> {
    let records = &source.set().points[k];
    let known = click_options(source.set(), records.day, Some(records), &processed.click);
    let record = source.click(k, n).or_bad_input()?;
    let trace = Trace::from(&record);
    Ok(match picture_click(&trace, &known) {
        Ok(picture) => click_panels(&picture),
        Err(_) => raw_panels(&trace),
    })
}

fn title(name: &str, reason: Option<&str>) -> String {
    reason.map_or_else(|| name.to_owned(), |reason| format!("{name}, rejected: {reason}"))
}

fn curve(name: &str, look: Look, points: Vec<[f64; 2]>) -> RecordCurve {
    RecordCurve { name: name.to_owned(), look, points }
}

fn panel(x: &str, y: &str, curves: Vec<RecordCurve>, marks: Vec<f64>) -> RecordPanel {
    RecordPanel { x: x.to_owned(), y: y.to_owned(), curves, marks }
}

/// Start of the decay, what is left, the decay as a whole, and the spectrum before and after.
fn ping_panels(fit: &PingFit, trace: &Trace<'_>, live: &[usize]) -> Vec<RecordPanel> {
    let picture = fit.picture(trace);
    let (start, time) = (fit.window.0, "*t* / s");
    let early = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().take_while(|p| p[0] < start + 0.04).copied().collect()
    };
    let decibels = |points: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
        points.into_iter().map(|[f, d]| [f, 20.0 * d.max(1e-12).log10()]).collect()
    };
    let label = format!("*p* of microphone {} / Pa", live[picture.channel] + 1);
    let (record, fitted) = (early(&picture.record), early(&picture.fit));
    vec![
        panel(
            time,
            &label,
            vec![curve("record", Look::Record, record), curve("fit", Look::Fit, fitted)],
            vec![start],
        ),
        panel(
            time,
            "record less fit / Pa",
            vec![curve("record less fit", Look::Channel(5, 7), picture.residual)],
            vec![],
        ),
        panel(time, &label, vec![curve("record", Look::Record, picture.record)], vec![start]),
        panel(
            "*f* / Hz",
            "density / dB re 1 Pa Hz^{-1/2}",
            vec![
                curve("record", Look::Record, decibels(picture.spectrum)),
                curve("record less fit", Look::Channel(5, 7), decibels(picture.residual_spectrum)),
            ],
            vec![],
        ),
    ]
}

/// The channels in phase with the impulse, and what each leaves.
fn click_panels(picture: &ClickPicture) -> Vec<RecordPanel> {
    let count = picture.channels.len();
    let milliseconds =
        |points: &[[f64; 2]]| -> Vec<[f64; 2]> { points.iter().map(|[t, p]| [1e3 * t, *p]).collect() };
    let channels = picture.channels.iter().enumerate();
    let mut curves: Vec<RecordCurve> = channels
        .map(|(m, points)| {
            curve(&format!("microphone {}", m + 1), Look::Channel(m, count), milliseconds(points))
        })
        .collect();
    curves.push(curve("impulse", Look::Fit, milliseconds(&picture.impulse)));
    let left = picture.left.iter().enumerate();
    let left = left.map(|(m, points)| curve("", Look::Channel(m, count), milliseconds(points)));
    let time = "time from the arrival / ms";
    vec![
        panel(time, "*p* over the gain / Pa", curves, vec![]),
        panel(time, "the same less the fit / Pa", left.collect(), vec![]),
    ]
}

/// All channels as they are, for a record that could not be fitted.
fn raw_panels(trace: &Trace<'_>) -> Vec<RecordPanel> {
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
        curve(&format!("microphone {}", m + 1), Look::Channel(m, count), points.collect())
    };
    vec![panel("*t* / s", "*p* / Pa", trace.channels.iter().enumerate().map(outline).collect(), vec![])]
}

fn delay_panel(what: &str, delays: &ChannelDelays) -> RecordPanel {
    let first = delays.delays.first().copied().unwrap_or(0.0);
    let points: Vec<[f64; 2]> =
        delays.delays.iter().enumerate().map(|(m, d)| [m as f64 + 1.0, 1e6 * (d - first)]).collect();
    let bars = points.iter().enumerate().map(|(m, [x, y])| {
        let (c, (a, b)) = (&delays.covariance, (0, m));
        let sd = 1e6 * (c[(a, a)] + c[(b, b)] - 2.0 * c[(a, b)]).max(0.0).sqrt();
        curve("2 sd", Look::Fit, vec![[*x, y - 2.0 * sd], [*x, y + 2.0 * sd]])
    });
    let name = format!("{what}, {} Hz", delays.rate_hz);
    let curves = [curve(&name, Look::Dots(1), points.clone())].into_iter().chain(bars).collect();
    panel("microphone", &format!("delay of {what} less the first's / us"), curves, vec![])
}
