//! Sweeps and periodic sounds: closed forms, plain sums, and how often the stated errors hold.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Stream, Streams};
use rijke_signal::{Channel, Fault, Spectra, Swept, SweptOptions};
use std::f64::consts::TAU;

const RATE: f64 = 4096.0;
/// What each microphone hears of the source: amplitudes by delay in samples.
const PATHS: [&[(usize, f64)]; 3] = [&[(1, 1.0), (7, 0.4)], &[(2, 0.9), (5, -0.3)], &[(4, 0.8), (6, 0.75)]];

fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
}

/// The closed form of what a microphone hears over the source, at `f` Hz.
fn truth(m: usize, f: f64) -> C64 {
    PATHS[m].iter().map(|(late, a)| a * C64::from_polar(1.0, -TAU * f * *late as f64 / RATE)).sum()
}

/// A sweep from 60 to 900 Hz with silence before and behind it, 4096 samples.
fn sweep() -> Vec<f64> {
    let (growth, seconds) = ((900.0_f64 / 60.0).ln() / 0.8, 0.8);
    let sample = |n: usize| {
        let t = n as f64 / RATE - 0.1;
        let near = (t.min(seconds - t) / 0.04).clamp(0.0, 1.0);
        (TAU * 60.0 * (growth * t).exp_m1() / growth).sin() * (0.25 * TAU * near).sin().powi(2)
    };
    (0..4096).map(sample).collect()
}

/// What the first `count` microphones hear of a source, with white noise. Before its beginning the source is
/// what it is before its end.
fn record(source: &[f64], count: usize, noise: f64, stream: &mut Stream) -> Vec<Vec<f64>> {
    let n = source.len();
    let channel = |paths: &[(usize, f64)]| -> Vec<f64> {
        let at = |k: usize| paths.iter().map(|(late, a)| a * source[(k + n - late) % n]).sum::<f64>();
        (0..n).map(at).collect()
    };
    let mut all: Vec<Vec<f64>> = PATHS[..count].iter().map(|paths| channel(paths)).collect();
    all.iter_mut().flatten().for_each(|v| *v += noise * normal(stream));
    all
}

/// The spectra of a record at `f` Hz over their length, by plain sums.
fn direction(record: &[Vec<f64>], f: usize) -> Vec<C64> {
    let one = |c: &Vec<f64>| -> C64 {
        let term = |(n, v): (usize, &f64)| v * C64::from_polar(1.0, -TAU * (f * n % 4096) as f64 / RATE);
        c.iter().enumerate().map(term).sum()
    };
    let x: Vec<C64> = record.iter().map(one).collect();
    let length = x.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
    x.into_iter().map(|z| z / length).collect()
}

const OPTIONS: SweptOptions = SweptOptions { band_hz: [80.0, 800.0], resolution_hz: 8.0, period: None };

#[test]
fn oracle_spectra_are_plain_sums_and_fields_their_eigenvectors() {
    let mut stream = Streams::new(1).stream("swept");
    let records: Vec<_> = (0..3).map(|_| record(&sweep(), 3, 0.2, &mut stream)).collect();
    let found = Swept::new(&records, RATE, &OPTIONS).unwrap();
    assert_eq!(found.spectra.frequency_hz.len(), 90);
    assert_eq!(found.spectra.averages, 24.0);
    let transfers = found.spectra.transfer(0, 2);
    for band in [0, 41, 89] {
        let first = 80 + 8 * band;
        assert_eq!(found.spectra.frequency_hz[band], first as f64 + 3.5);
        // By frequency, and the sum of all.
        let sums = |frequencies: std::ops::Range<usize>| {
            let mut sums = [[C64::ZERO; 3]; 3];
            for u in frequencies.flat_map(|f| records.iter().map(move |r| direction(r, f))) {
                (0..9).for_each(|k| sums[k / 3][k % 3] += u[k / 3].conj() * u[k % 3]);
            }
            sums
        };
        let all = sums(first..first + 8);
        let t = transfers[band];
        assert!((t.value - all[0][2] / all[0][0]).norm() < 1e-9);
        assert!((t.coherence - all[0][2].norm_sqr() / (all[0][0] * all[2][2]).re).abs() < 1e-9);
        // The eigenvector turns into itself, and nothing is larger than its eigenvalue: the sum of squares of
        // the others is what the matrix has more.
        let field = &found.fields[band];
        let times = |sums: &[[C64; 3]; 3], p: &[C64]| -> Vec<C64> {
            (0..3).map(|j| (0..3).map(|i| sums[i][j] * p[i]).sum()).collect()
        };
        let turned = times(&all, &field.pressures);
        let value: C64 = turned.iter().zip(&field.pressures).map(|(a, b)| a * b.conj()).sum();
        for (a, b) in turned.iter().zip(&field.pressures) {
            assert!((a - value * b).norm() < 1e-9 * value.norm());
        }
        // Largest eigenvalues of single frequencies, by the matrix to a high power.
        let largest = |sums: [[C64; 3]; 3]| {
            let mut p = vec![C64::ONE, C64::new(0.3, 0.2), C64::new(-0.1, 0.5)];
            let mut length = 1.0;
            for _ in 0..200 {
                p = times(&sums, &p);
                length = p.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
                p.iter_mut().for_each(|z| *z /= length);
            }
            length
        };
        // Three records, three microphones: two squares are free in each of two directions.
        let noise = (first..first + 8).map(|f| (3.0 - largest(sums(f..f + 1))) / 4.0).sum::<f64>() / 8.0;
        let signal = 1.0 - 3.0 * noise;
        let sd = (noise * (signal + noise) / (signal * signal) / 48.0).sqrt();
        assert!((field.sd / sd - 1.0).abs() < 1e-6, "{} {sd}", field.sd);
        assert!((field.coherence - signal * signal).abs() < 1e-6);
    }
}

#[test]
fn oracle_noise_of_one_record_is_what_no_line_over_frequency_tells() {
    let record = record(&sweep(), 3, 0.1, &mut Streams::new(3).stream("one"));
    let found = Swept::new(std::slice::from_ref(&record), RATE, &OPTIONS).unwrap();
    for band in [10, 60] {
        let (first, field) = (80 + 8 * band, &found.fields[band]);
        let p = &field.pressures;
        let beside = |f: usize| -> Vec<C64> {
            let u = direction(&record, f);
            let along: C64 = p.iter().zip(&u).map(|(p, u)| p.conj() * u).sum();
            u.iter().zip(p).map(|(u, p)| u * along.conj() / along.norm() - p * along.norm()).collect()
        };
        let all: Vec<Vec<C64>> = (first..first + 8).map(beside).collect();
        // What two orthogonal columns, one and the place, leave of each microphone.
        let mut left = 0.0;
        for c in 0..3 {
            let dot = |column: &dyn Fn(usize) -> f64| (0..8).map(|k| column(k) * all[k][c]).sum::<C64>();
            let line = |k: usize| (2.0 * k as f64 - 7.0) / 168.0_f64.sqrt();
            let whole: f64 = all.iter().map(|d| d[c].norm_sqr()).sum();
            left += whole - dot(&|_| 8.0_f64.powf(-0.5)).norm_sqr() - dot(&line).norm_sqr();
        }
        let noise = left / 12.0;
        let signal = 1.0 - 3.0 * noise;
        let sd = (noise * (signal + noise) / (signal * signal) / 16.0).sqrt();
        assert!((field.sd / sd - 1.0).abs() < 1e-6, "{} {sd}", field.sd);
    }
}

#[test]
fn exact_two_microphones_give_the_errors_of_bendat_and_piersol() {
    let mut stream = Streams::new(2).stream("two");
    let found = Swept::new(&[record(&sweep(), 2, 0.1, &mut stream)], RATE, &OPTIONS).unwrap();
    for (t, field) in found.spectra.transfer(0, 1).iter().zip(&found.fields) {
        // G00 + G11 = 1, up to a factor; H_v by the root of its quadratic equation.
        let ratio = t.coherence / t.value.norm_sqr();
        let (g0, g1) = (ratio / (1.0 + ratio), 1.0 / (1.0 + ratio));
        let cross = t.value * g0;
        let root = ((g1 - g0).powi(2) + 4.0 * cross.norm_sqr()).sqrt();
        let hv = (g1 - g0 + root) / (2.0 * cross.conj());
        let p = &field.pressures;
        assert!((p[1] / p[0] - hv).norm() < 1e-9 * hv.norm(), "{} {hv}", p[1] / p[0]);
        // Of two microphones of one level the coherence is the ordinary one.
        let relative = field.sd / p[0].norm() / p[1].norm();
        let g = field.coherence;
        let stated = ((1.0 - g) / (2.0 * g * 8.0)).sqrt() * (0.5 / (p[0].norm() * p[1].norm()));
        assert!((relative / stated - 1.0).abs() < 1e-6, "{relative} {stated}");
    }
}

/// Shares of errors of transfer functions over the first microphone that lie within 1.96 stated standard
/// deviations, over 200 seeds.
fn inside(of: impl Fn(&mut Stream) -> Swept) -> f64 {
    let (mut within, mut all) = (0_u32, 0_u32);
    for seed in 0..200 {
        let found = of(&mut Streams::new(seed).stream("coverage"));
        for k in [3, 20, 40, 60, 80] {
            let (f, field) = (found.spectra.frequency_hz[k], &found.fields[k]);
            let p = &field.pressures;
            for c in 1..3 {
                let error = (p[c] / p[0] * truth(0, f) / truth(c, f)).ln();
                let sd = (field.sd / p[c].norm()).hypot(field.sd / p[0].norm());
                assert!(sd < 0.2, "{sd} at {f} Hz");
                for part in [error.re, error.im] {
                    (within, all) = (within + u32::from(part.abs() < 1.96 * sd), all + 1);
                }
            }
        }
    }
    println!("{within} of {all}");
    f64::from(within) / f64::from(all)
}

#[test]
fn coverage_transfer_functions_of_sweeps_lie_within_their_errors() {
    let repeated = |stream: &mut Stream| {
        let records: Vec<_> = (0..4).map(|_| record(&sweep(), 3, 0.1, stream)).collect();
        Swept::new(&records, RATE, &OPTIONS).unwrap()
    };
    let share = inside(repeated);
    assert!((0.92..0.98).contains(&share), "four sweeps: {share}");
    // Of one sweep the field that changes within a band counts as noise, which is little here.
    let single =
        |stream: &mut Stream| Swept::new(&[record(&sweep(), 3, 0.1, stream)], RATE, &OPTIONS).unwrap();
    let share = inside(single);
    assert!((0.92..0.98).contains(&share), "one sweep: {share}");
}

#[test]
fn coverage_bands_without_a_bend_keep_the_noise_between_records() {
    // Two records of two microphones, three frequencies in a band: the ratio of both measures of the noise is
    // F(2, 6), and exceeds the limit of "five standard deviations", 6, in one band of 27 by chance.
    let options = SweptOptions { resolution_hz: 3.0, ..OPTIONS };
    let (mut widened, mut all) = (0_u32, 0_u32);
    for seed in 0..20 {
        let mut stream = Streams::new(seed).stream("bends");
        let records: Vec<_> = (0..2).map(|_| record(&sweep(), 2, 0.1, &mut stream)).collect();
        let found = Swept::new(&records, RATE, &options).unwrap();
        for (band, field) in found.fields.iter().enumerate() {
            let first = 80 + 3 * band;
            let apart = |f: usize| {
                let (a, b) = (direction(&records[0], f), direction(&records[1], f));
                1.0 - a.iter().zip(&b).map(|(a, b)| a.conj() * b).sum::<C64>().norm()
            };
            let noise = (first..first + 3).map(apart).sum::<f64>() / 3.0;
            let signal = 1.0 - 2.0 * noise;
            let sd = (noise * (signal + noise) / (signal * signal) / 12.0).sqrt();
            (widened, all) = (widened + u32::from(field.sd > 1.0001 * sd), all + 1);
        }
    }
    // Stated: one band in 10 000.
    assert!(all == 4800 && widened < 6, "{widened} of {all}");
}

#[test]
fn coverage_transfer_functions_of_periods_lie_within_their_errors() {
    let periods = |stream: &mut Stream| {
        // Tones of random phase; in the first period the rig settles.
        let mut source = vec![0.0; 2048];
        for k in 30..450 {
            let phase = TAU * normal(stream);
            source.iter_mut().enumerate().for_each(|(n, v)| {
                *v += 0.1 * (TAU * (k * n % 2048) as f64 / 2048.0 + phase).cos();
            });
        }
        let long: Vec<f64> = source.iter().cycle().take(6 * 2048).copied().collect();
        let mut heard = record(&long, 3, 0.5, stream);
        heard.iter_mut().for_each(|c| c[..1500].fill(0.0));
        Swept::new(&[heard], RATE, &SweptOptions { period: Some(2048), ..OPTIONS }).unwrap()
    };
    let share = inside(periods);
    assert!((0.92..0.98).contains(&share), "five periods: {share}");
}

#[test]
fn behaviour_what_the_sweep_does_not_excite_has_no_coherence() {
    let mut stream = Streams::new(5).stream("outside");
    let mut records: Vec<_> = (0..4).map(|_| record(&sweep(), 3, 0.02, &mut stream)).collect();
    // A hum that all microphones hear alike, louder than the sweep at its own frequency.
    for (k, channels) in records.iter_mut().enumerate() {
        let hum = |n: usize| (TAU * 500.02 * n as f64 / RATE + k as f64).sin();
        channels.iter_mut().for_each(|c| c.iter_mut().enumerate().for_each(|(n, v)| *v += 0.3 * hum(n)));
    }
    let wide = SweptOptions { band_hz: [10.0, 1600.0], ..OPTIONS };
    let found = Swept::new(&records, RATE, &wide).unwrap();
    let mut hummed = 1.0_f64;
    for (f, field) in found.spectra.frequency_hz.iter().zip(&found.fields) {
        match f {
            495.0..505.0 => hummed = hummed.min(field.coherence),
            80.0..480.0 | 520.0..850.0 => assert!(field.coherence > 0.9, "{f} Hz: {}", field.coherence),
            1000.0.. => assert!(field.coherence < 0.5, "{f} Hz: {}", field.coherence),
            _ => {}
        }
    }
    assert!(hummed < 0.8, "{hummed}");
}

#[test]
fn message_records_that_cannot_be_averaged_are_faults() {
    let mut stream = Streams::new(6).stream("faults");
    let good = record(&sweep(), 3, 0.1, &mut stream);
    let fault = |records: &[Vec<Vec<f64>>], options: SweptOptions| {
        Swept::new(records, RATE, &options).unwrap_err().to_string()
    };
    let shorter: Vec<Vec<f64>> = good.iter().map(|c| c[..4000].to_vec()).collect();
    let one = std::slice::from_ref(&good);
    assert!(fault(&[good.clone(), shorter], OPTIONS).contains("beside the longest"));
    assert!(fault(&[good[..1].to_vec()], OPTIONS).contains("list of microphones"));
    assert!(fault(one, SweptOptions { period: Some(3000), ..OPTIONS }).contains("two periods"));
    assert!(fault(one, SweptOptions { resolution_hz: 0.1, ..OPTIONS }).contains("a single record"));
    assert!(fault(one, SweptOptions { band_hz: [80.0, 81.0], ..OPTIONS }).contains("band"));
    assert!(fault(&[], OPTIONS).contains("microphones"));
    // Each of these was taken once, or looped over the period.
    assert!(fault(one, SweptOptions { period: Some(usize::MAX), ..OPTIONS }).contains("beside its period"));
    for resolution_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            fault(one, SweptOptions { resolution_hz, ..OPTIONS }).contains("the resolution is no number")
        );
    }
    for band_hz in [[800.0, 80.0], [f64::NAN, 80.0], [80.0, f64::NAN], [-1.0, 80.0]] {
        let found = Spectra::welch(&good, RATE, 512, band_hz).unwrap_err().to_string();
        assert!(found.contains("lower one first"), "{found}");
        assert_eq!(fault(one, SweptOptions { band_hz, ..OPTIONS }), found);
    }
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = Spectra::welch(&good, rate, 512, [80.0, 800.0]).unwrap_err().to_string();
        assert!(found.contains("the sampling rate is no number"), "{found}");
    }
    let mut bad = good.clone();
    bad[1][7] = f64::NAN;
    assert_eq!(
        Swept::new(&[bad], RATE, &OPTIONS),
        Err(Fault::NotFinite { channel: Channel::Place(1), sample: 7 })
    );
}
