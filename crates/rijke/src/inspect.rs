//! `rijke inspect`: what is in a file of records.

use crate::ui::Ui;
use rijke_numerics::{Classify, Failed};
use rijke_rig::{FileContents, inspect};
use serde_json::json;
use std::path::PathBuf;

/// List the channels of a record with their levels, to find out which channel is which microphone.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke inspect C3-35/ping-00.wav\n  rijke inspect run-7.mat\n\n\
    Reads WAV, text with one column per channel, MATLAB 5 to 7.3, and HDF5.")]
pub(crate) struct Args {
    /// The file.
    file: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let FileContents { format, rate_hz, channels, others } = inspect(&args.file).or_bad_input()?;
    // The list `channels` of a manifest counts without the column of time.
    let mut numbers = 0..;
    let numbers: Vec<Option<usize>> =
        channels.iter().map(|c| if c.is_time { None } else { numbers.next() }).collect();
    let described = channels.iter().zip(&numbers).map(|(c, number)| {
        json!({
            "channel": number, "name": c.name, "samples": c.samples, "mean": c.mean, "rms": c.rms, "smallest": c.smallest, "largest": c.largest,
            "at_full_scale": c.at_full_scale, "not_finite": c.not_finite,
        })
    });
    let described: Vec<_> = described.collect();
    let answer = json!({ "format": format, "rate_hz": rate_hz, "channels": described, "others": others });
    let frames = channels.first().map_or(0, |c| c.samples);
    let even = channels.iter().all(|c| c.samples == frames);
    let frames_shown = if even { frames.to_string() } else { "different numbers of".to_owned() };
    let duration =
        rate_hz.map_or_else(String::new, |rate| format!(" at {rate} Hz: {:.4} s", frames as f64 / rate));
    ui.say(format!(
        "{format}, {} channels of {frames_shown} samples{duration}",
        numbers.iter().flatten().count()
    ));
    let head = "channel,name,mean,root mean square,smallest,largest,at full scale,not a number".split(',');
    let rows = channels.iter().zip(&numbers).map(|(c, number)| {
        let numbers = [c.mean, c.rms, c.smallest, c.largest].map(|v| format!("{v:.6}"));
        let number = number.map_or_else(|| "time".to_owned(), |k| k.to_string());
        let row = [number, c.name.clone().unwrap_or_default()].into_iter().chain(numbers);
        row.chain([c.at_full_scale.to_string(), c.not_finite.to_string()])
    });
    ui.table(head, rows);
    for other in others {
        ui.say(other);
    }
    ui.result(&answer)
}
