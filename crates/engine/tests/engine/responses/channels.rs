//! Delays and gains of channels that hear responses.

use super::bench::{model, normal, observed};
use super::pressures::{AT, NOISE, PRIORS, columns, complex, folder, found, run};
use super::slow::maximum;
use rijke_engine::response::{ResponseRun, ResponseStageRecord};
use rijke_numerics::{C64, Cholesky, Matrix, Stream, Streams};
use rijke_study::responses::{ObservedResponse, ResponseKind};
use rijke_study::{Place, Study};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

const GAIN: f64 = 0.01;
const DELAY: f64 = 2e-6;
/// Errors of which the slow route may neglect the squares.
const SMALL: f64 = 0.3;
const SOURCES: [Place; 2] = [Place::Upstream, Place::Downstream];
const ONE: &str = "compete = [\"waves\"]\namong = [\"waves.flow\"]";

/// As [`folder`], with errors of the channels stated: `size` times [`GAIN`] and [`DELAY`].
fn stated(name: &str, stage: &str, size: f64) -> PathBuf {
    let folder = folder(&format!("channels-{name}"), stage);
    let rig = std::fs::read_to_string(folder.join("rig.toml")).unwrap();
    let keys =
        format!("[microphones]\ngain_sd = {}\ndelay_sd = \"{} us\"\n", GAIN * size, 1e6 * DELAY * size);
    std::fs::write(folder.join("rig.toml"), rig.replace("[microphones]\n", &keys)).unwrap();
    folder
}

/// What a truth makes: unknowns of the duct, delays and gains of all channels.
struct Truth {
    duct: [f64; 3],
    delays: [f64; 8],
    gains: [f64; 8],
}

impl Truth {
    fn drawn(stream: &mut Stream, size: f64) -> Self {
        Self {
            duct: PRIORS.map(|[mean, sd]| mean + sd * normal(stream)),
            delays: [(); 8].map(|()| size * DELAY * normal(stream)),
            gains: [(); 8].map(|()| size * GAIN * normal(stream)),
        }
    }

    /// Pressures by excitation, frequency and microphone, each row over its root mean square.
    fn heard(&self, frequency_hz: &[f64], excitations: usize, stream: &mut Stream) -> Vec<Vec<Vec<C64>>> {
        let mut row = |f: &f64| -> Vec<C64> {
            let [a, b] = [complex(stream), complex(stream)];
            let s = C64::new(0.0, 2.0 * PI * f);
            let waves = columns(*f, self.duct);
            let one = |(m, h): (usize, &[C64; 2])| {
                (h[0] * a + h[1] * b) * (1.0 - s * self.delays[m] + self.gains[m])
            };
            let clean: Vec<C64> = waves.iter().enumerate().map(one).collect();
            let level =
                |row: &[C64]| (row.iter().map(|z| z.norm_sqr()).sum::<f64>() / row.len() as f64).sqrt();
            let size = level(&clean);
            let noisy: Vec<C64> = clean.iter().map(|z| z + NOISE * size * complex(stream)).collect();
            let level = level(&noisy);
            noisy.iter().map(|z| z / level).collect()
        };
        (0..excitations).map(|_| frequency_hz.iter().map(&mut row).collect()).collect()
    }
}

fn trained(folder: &Path, frequency_hz: &[f64], heard: &[Vec<Vec<C64>>]) -> ResponseStageRecord {
    run(folder, frequency_hz, heard, &SOURCES, None).next_stage().unwrap().unwrap()
}

/// The cost of the slow route, nats: one covariance of all pressures, with the fields of the sources and the
/// delays and gains that all rows share, at these very parameters of the duct.
fn cost(frequency_hz: &[f64], heard: &[Vec<Vec<C64>>], x: [f64; 3]) -> f64 {
    let parameters = [0, 1, 2].map(|i| PRIORS[i][0] + PRIORS[i][1] * x[i]);
    let n = AT.len();
    let rows: Vec<(f64, &Vec<C64>)> =
        heard.iter().flat_map(|e| frequency_hz.iter().copied().zip(e.iter())).collect();
    let size = 2 * n * rows.len();
    let mut covariance = Matrix::from_fn(size, size, |i, j| if i == j { NOISE * NOISE } else { 0.0 });
    let mut values = Vec::with_capacity(size);
    // What a gain, and what a delay, of each microphone moves.
    let mut moved = vec![[vec![0.0; size], vec![0.0; size]]; n];
    for (r, (f, row)) in rows.iter().enumerate() {
        let h = columns(*f, parameters);
        let dot = |i: usize, j: usize| h.iter().map(|row| row[i].conj() * row[j]).sum::<C64>();
        let (a, b, d) = (dot(0, 0).re, dot(0, 1), dot(1, 1).re);
        let det = a * d - b.norm_sqr();
        let inverse = [[C64::from(d / det), -b / det], [-b.conj() / det, C64::from(a / det)]];
        let projector = |p: usize, q: usize| {
            let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
            all.iter().map(|(i, j)| h[p][*i] * inverse[*i][*j] * h[q][*j].conj()).sum::<C64>()
        };
        let first = 2 * n * r;
        for p in 0..n {
            for q in 0..n {
                let z = n as f64 * projector(p, q);
                covariance[(first + p, first + q)] += z.re;
                covariance[(first + n + p, first + n + q)] += z.re;
                covariance[(first + p, first + n + q)] -= z.im;
                covariance[(first + n + p, first + q)] += z.im;
            }
            let field: C64 = (0..n).map(|q| projector(p, q) * row[q]).sum();
            for (kind, z) in
                [SMALL * GAIN * field, SMALL * DELAY * C64::new(0.0, 2.0 * PI * f) * field].iter().enumerate()
            {
                (moved[p][kind][first + p], moved[p][kind][first + n + p]) = (z.re, z.im);
            }
        }
        values.extend(row.iter().map(|z| z.re).chain(row.iter().map(|z| z.im)));
    }
    for column in moved.iter().flatten() {
        for i in (0..size).filter(|i| column[*i] != 0.0) {
            for j in 0..size {
                covariance[(i, j)] += column[i] * column[j];
            }
        }
    }
    let factor = Cholesky::new(&covariance).unwrap();
    let square: f64 = factor.whiten(&values).iter().map(|r| r * r).sum();
    let prior = 0.5 * x.iter().map(|x| x * x).sum::<f64>() + 1.5 * (2.0 * PI).ln();
    prior + 0.5 * (square + factor.ln_det() + size as f64 * (2.0 * PI).ln())
}

#[test]
fn oracle_gains_and_delays_are_those_of_the_whole_covariance() {
    let frequency_hz: Vec<f64> = (0..6).map(|k| 300.0 + 190.0 * f64::from(k)).collect();
    let folder = stated("oracle", &format!("{ONE}\nnoise = {NOISE}"), SMALL);
    for seed in 0..3 {
        let mut stream = Streams::new(seed).stream("responses/channels");
        let heard = Truth::drawn(&mut stream, SMALL).heard(&frequency_hz, 2, &mut stream);
        let stage = trained(&folder, &frequency_hz, &heard);
        let near = found(&stage, "waves.flow");
        let (slow, evidence) = maximum(&PRIORS, &near, &|x| cost(&frequency_hz, &heard, x));
        for (i, ([value, sd], [there, width])) in near.iter().zip(slow).enumerate() {
            assert!((value - there).abs() < 0.05 * width, "{seed}, {i}: {value} {there} +- {width}");
            assert!((sd / width).ln().abs() < 0.05, "{seed}, {i}: {sd} {width}");
        }
        let own = model(&stage, "waves.flow").ln_evidence();
        assert!((own - evidence).abs() < 0.1, "{seed}: {own} {evidence}");
    }
}

/// Of 200 drawn truths: the share of parameters within two standard deviations, of the duct and of the
/// channels, and the root mean square of the distances of the first.
fn covered(name: &str, more: &str) -> [f64; 3] {
    let frequency_hz: Vec<f64> = (0..5).map(|k| 350.0 + 210.0 * f64::from(k)).collect();
    let folder = stated(name, &format!("{ONE}\nnoise = \"floated\"\n{more}"), 1.0);
    let (mut within, mut all, mut square) = ([0.0; 2], [0.0; 2], 0.0);
    for set in 0..200 {
        let mut stream = Streams::new(set).stream("responses/channels/coverage");
        let truth = Truth::drawn(&mut stream, 1.0);
        let heard = truth.heard(&frequency_hz, 2, &mut stream);
        let stage = trained(&folder, &frequency_hz, &heard);
        for ([value, sd], truth) in found(&stage, "waves.flow").iter().zip(truth.duct) {
            let z = (value - truth) / sd;
            within[0] += f64::from(u8::from(z.abs() < 2.0));
            (all[0], square) = (all[0] + 1.0, square + z * z);
        }
        let parameters = &model(&stage, "waves.flow").parameters;
        for m in 1..AT.len() {
            for (word, own) in [("gain", &truth.gains), ("delay", &truth.delays)] {
                let name = format!("{word} of p{} over p1", m + 1);
                let Some(p) = parameters.iter().find(|p| p.name == name) else { continue };
                let z = (p.value - (own[m] - own[0])) / p.sd;
                within[1] += f64::from(u8::from(z.abs() < 2.0));
                all[1] += 1.0;
            }
        }
    }
    [within[0] / all[0], within[1] / all[1], (square / all[0]).sqrt()]
}

#[test]
fn coverage_parameters_heard_by_unequal_channels_lie_within_their_errors() {
    let [duct, channels, rms] = covered("coverage", "");
    assert!((0.92..0.98).contains(&duct) && (0.92..0.98).contains(&channels), "{duct} {channels}");
    assert!((0.9..1.1).contains(&rms), "{rms}");
    // Channels that are taken for equal: sure, and wrong.
    let [duct, _, rms] = covered("coverage-equal", "channels = false");
    assert!(duct < 0.9 && rms > 1.2, "{duct} {rms}");
}

#[test]
fn message_channels_that_are_asked_for_are_stated() {
    let folder = folder("channels-unknown", &format!("{ONE}\nnoise = {NOISE}\nchannels = true"));
    let heard = vec![vec![vec![C64::ONE; AT.len()]; 2]];
    let error = run(&folder, &[400.0, 500.0], &heard, &SOURCES, None).next_stage().unwrap_err().to_string();
    for part in ["channels = true", "gain_sd", "channels.toml"] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn message_errors_of_channels_are_one_for_all_or_one_for_each() {
    for (keys, says) in [
        ("gain_sd = [0.01, 0.02]", "2 numbers for 8 microphones"),
        ("gain_sd = 0.0", "above zero"),
        ("delay_sd = \"2 m\"", "delay_sd"),
    ] {
        let folder = folder("channels-stated", ONE);
        let rig = std::fs::read_to_string(folder.join("rig.toml")).unwrap();
        std::fs::write(
            folder.join("rig.toml"),
            rig.replace("[microphones]\n", &format!("[microphones]\n{keys}\n")),
        )
        .unwrap();
        let error = Study::open(&folder).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains("rig.toml"), "{error}");
    }
}

#[test]
fn exact_transfer_functions_tell_the_gains_of_each_session() {
    // An open end at 1.1 m, whatever drives the other; two sessions with gains and delays of their own.
    let frequency_hz: Vec<f64> = (0..12).map(|k| 310.0 + 83.0 * f64::from(k)).collect();
    let (gains, delays) =
        ([[0.0, 0.012, -0.007], [0.0, -0.003, 0.009]], [[0.0, 2e-6, -3e-6], [0.0, 1e-6, 2e-6]]);
    let c = (1.4 * 287.0 * 293.15_f64).sqrt();
    let stage =
        "with = { wall = \"wall.none\" }\nhold = { extra = 0.0 }\nsession = \"session\"\nnoise = 1e-4";
    let folder = stated("transfer", stage, 1.0);
    std::fs::write(folder.join("campaign.csv"), "point,session\na,1\nb,2\n").unwrap();
    let transfer = |point: usize, to: usize, from: usize| {
        let value = |f: &f64| {
            let s = C64::new(0.0, 2.0 * PI * f);
            let at = |m: usize| {
                let wave = (-s * AT[m] / c).exp() - (-s * (2.2 - AT[m]) / c).exp();
                wave * (1.0 - s * delays[point][m] + gains[point][m])
            };
            at(to) / at(from)
        };
        ObservedResponse {
            point,
            what: ResponseKind::Transfer { to, from },
            rows: frequency_hz.len(),
            frequency_hz: frequency_hz.clone(),
            values: frequency_hz.iter().map(value).collect(),
            sd: Vec::new(),
            level: Vec::new(),
        }
    };
    let pairs = [(1, 0), (2, 0), (2, 1)];
    let list = (0..2).flat_map(|point| pairs.map(|(to, from)| transfer(point, to, from))).collect();
    let mut run = ResponseRun::new(Study::open(&folder).unwrap(), observed(list)).unwrap();
    let found = run.next_stage().unwrap().unwrap();
    let parameters = &found.models[0].parameters;
    assert_eq!(parameters.len(), 8);
    for point in 0..2 {
        for m in 1..3 {
            for (word, truth) in [("gain", gains[point][m]), ("delay", delays[point][m])] {
                let name = format!("{word} of p{} over p1 (session = {})", m + 1, point + 1);
                let p = parameters.iter().find(|p| p.name == name).unwrap();
                // Squares of the errors are 1e-4, half a per cent of these.
                let scale = if word == "gain" { 0.01 } else { 2e-6 };
                assert!((p.value - truth).abs() < 0.03 * scale && p.sd < 0.02 * scale, "{p:?} {truth}");
            }
        }
    }
}

/// Two microphones whose labels were exchanged before a transfer function was taken: the row names them, and
/// not the sign of time.
#[test]
fn message_labels_of_two_microphones_are_exchanged() {
    let frequency_hz: Vec<f64> = (0..12).map(|k| 310.0 + 83.0 * f64::from(k)).collect();
    let c = (1.4 * 287.0 * 293.15_f64).sqrt();
    let stage = "with = { wall = \"wall.none\" }\nhold = { extra = 0.0 }\nnoise = 1e-2";
    let remark = |name: &str, labels: [usize; 3]| {
        let folder = stated(name, stage, 1.0);
        let at = |f: f64, m: usize| {
            let s = C64::new(0.0, 2.0 * PI * f);
            (-s * AT[m] / c).exp() - (-s * (2.2 - AT[m]) / c).exp()
        };
        let transfer = |to: usize| ObservedResponse {
            point: 0,
            what: ResponseKind::Transfer { to, from: 0 },
            rows: frequency_hz.len(),
            frequency_hz: frequency_hz.clone(),
            values: frequency_hz.iter().map(|f| at(*f, labels[to]) / at(*f, labels[0])).collect(),
            sd: Vec::new(),
            level: Vec::new(),
        };
        let list = [1, 2].map(transfer).to_vec();
        let mut run = ResponseRun::new(Study::open(&folder).unwrap(), observed(list)).unwrap();
        run.next_stage().unwrap().unwrap().models[0].remark.clone().unwrap_or_default()
    };
    let said = |remark: &str| remark.lines().find(|l| l.contains("nats more")).map(str::to_owned);
    assert_eq!(said(&remark("labels-right", [0, 1, 2])), None);
    for (name, labels, named) in
        [("labels-beside", [0, 2, 1], "p2 and p3"), ("labels-below", [1, 0, 2], "p1 and p2")]
    {
        let remark = remark(name, labels);
        let said = said(&remark).unwrap_or_else(|| panic!("{remark}"));
        assert!(said.contains(&format!("the labels of the microphones {named} exchanged")), "{remark}");
    }
}
