//! Records larger than what is held of them.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_rig::{Arrays, Event, Layout, Reading, Record, Samples24, inspect, read_event, read_record};
use std::path::PathBuf;

const RATE: f64 = 1e4;
/// End of forcing of the long ping, and time of the long click, s.
const STOP: f64 = 60.0;
const CLICK: f64 = 30.02;

/// A folder that is removed when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rijke-long-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn layout(quiet: usize) -> Layout<'static> {
    static ARRAYS: std::sync::LazyLock<Arrays> = std::sync::LazyLock::new(Arrays::default);
    static READING: std::sync::LazyLock<Reading> = std::sync::LazyLock::new(Reading::default);
    Layout {
        channels: &[Some(1), None, Some(0)],
        full_scale: 8.388_608,
        rate_hz: RATE,
        quiet,
        arrays: &ARRAYS,
        reading: &READING,
    }
}

/// 85 s of three channels: noise in steps of a micropascal, and what `event` says.
fn samples(event: impl Fn(f64) -> f64) -> Samples24 {
    let mut state = 1_u32;
    let mut interleaved = Vec::new();
    for n in 0..850_000 {
        for c in 0..3 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 20) - 2048.0;
            interleaved.push((noise + (1.0 + f64::from(c)) * 1e6 * event(f64::from(n) / RATE)) as i32);
        }
    }
    Samples24 { rate_hz: RATE as u32, interleaved }
}

fn ping() -> Samples24 {
    samples(|t| match t {
        t if t < 0.2 => 0.0,
        t if t < STOP => (1080.0 * t).sin(),
        t => (-9.0 * (t - STOP)).exp() * (1080.0 * t).sin(),
    })
}

/// Checks that `part` is the quiet part and one stretch of the `whole`, and returns the stretch in s.
fn stretch(part: &Record, whole: &Record) -> [f64; 2] {
    let from = (0..whole.len() - 50)
        .find(|&n| (0..50).all(|k| part.channels[0][part.quiet + k] == whole.channels[0][n + k]))
        .unwrap();
    let count = part.len() - part.quiet;
    for (part, whole) in part.channels.iter().zip(&whole.channels) {
        assert!(part.iter().skip(part.len() - count).eq(&whole[from..from + count]));
    }
    [from as f64 / RATE, (from + count) as f64 / RATE]
}

#[test]
fn exact_of_a_long_ping_only_the_decay_is_held() {
    let scratch = Scratch::new("ping");
    let path = scratch.0.join("long.wav");
    ping().write(3, &path).unwrap();
    let layout = layout(2000);
    let (part, whole) =
        (read_event(&path, layout, Event::Ping).unwrap(), read_record(&path, layout).unwrap());
    assert!(whole.len() > 30 * part.len(), "{} of {}", part.len(), whole.len());
    assert_eq!((part.quiet, part.full_scale), (2000, whole.full_scale));
    assert_eq!(part.channels[1][..2000], whole.channels[1][..2000]);
    let [from, to] = stretch(&part, &whole);
    // The amplitude of 1e6 steps is lost in noise of 1200 after 0.75 s.
    assert!(
        (STOP - 0.5..STOP - 0.3).contains(&from) && (STOP + 1.0..STOP + 2.0).contains(&to),
        "{from} {to}"
    );
    // The same as text, whose size is not that of its frames.
    let text = scratch.0.join("long.csv");
    let lines = (0..whole.len()).map(|n| format!("{},0,{}\n", whole.channels[1][n], whole.channels[0][n]));
    std::fs::write(&text, lines.collect::<String>()).unwrap();
    assert_eq!(read_event(&text, layout, Event::Ping).unwrap().channels, part.channels);
    let (a, b) = (inspect(&path).unwrap(), inspect(&text).unwrap());
    let microphones = [1, 0].map(|m| &whole.channels[m]);
    for ((a, b), p) in a.channels.iter().zip(&b.channels).step_by(2).zip(microphones) {
        let mean = p.iter().sum::<f64>() / p.len() as f64;
        let rms = (p.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / p.len() as f64).sqrt();
        assert_eq!((a.samples, b.samples), (p.len(), p.len()));
        assert!((b.rms / rms - 1.0).abs() < 1e-9 && (a.rms * 8.388_608 / rms - 1.0).abs() < 1e-9);
        assert!((b.mean - mean).abs() < 1e-9 * rms);
    }
}

#[test]
fn exact_of_a_long_click_the_time_since_the_trigger_is_kept() {
    let scratch = Scratch::new("click");
    let path = scratch.0.join("long.wav");
    samples(|t| (-((t - CLICK) / 3e-4).powi(2)).exp()).write(3, &path).unwrap();
    let layout = layout(300_000);
    let (part, whole) =
        (read_event(&path, layout, Event::Click).unwrap(), read_record(&path, layout).unwrap());
    assert!(whole.len() > 30 * part.len(), "{} of {}", part.len(), whole.len());
    let peak = (0..part.len()).max_by(|&a, &b| part.channels[0][a].total_cmp(&part.channels[0][b])).unwrap();
    assert_eq!((peak - part.quiet) as f64 / RATE + 30.0, CLICK);
    assert_eq!(stretch(&part, &whole)[0], 30.0);
    assert!(part.channels[0][..part.quiet] == whole.channels[0][300_000 - part.quiet..300_000]);
}

#[test]
fn exact_a_long_record_that_is_damaged_is_refused_with_the_place() {
    let scratch = Scratch::new("damaged");
    let path = scratch.0.join("long.wav");
    ping().write(3, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 9000]).unwrap();
    let message = read_event(&path, layout(2000), Event::Ping).unwrap_err().to_string();
    assert!(message.contains("ends after sample 849000 of 850000"), "{message}");
    let text = scratch.0.join("long.csv");
    let lines = (0..400_000).map(|n| if n == 390_001 { "1,2,x\n" } else { "1,2,3\n" });
    std::fs::write(&text, lines.collect::<String>()).unwrap();
    let message = read_event(&text, layout(2000), Event::Ping).unwrap_err().to_string();
    assert!(message.contains("line 390002, column 3: `x` is not a number"), "{message}");
}
