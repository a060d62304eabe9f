//! Pressures at microphones, of sources of unknown strength.

use super::bench::{model, normal, observed};
use super::slow::maximum;
use rijke_engine::response::{ResponseRun, ResponseStageRecord};
use rijke_numerics::{C64, Cholesky, Matrix, Stream, Streams};
use rijke_study::responses::{ObservedResponse, ResponseKind};
use rijke_study::{Place, Study};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Places of the microphones; the last four are farther than stated by an unknown length.
pub(crate) const AT: [f64; 8] = [0.1, 0.15, 0.18, 0.26, 0.8, 0.85, 0.88, 0.96];
pub(crate) const MOVED: usize = 4;
/// Mean and sd of the priors: length, Mach number, loss.
pub(crate) const PRIORS: [[f64; 2]; 3] = [[0.0, 0.005], [0.08, 0.01], [0.1, 0.05]];
pub(crate) const NOISE: f64 = 5e-3;
/// The same noise at every microphone.
const ALIKE: [f64; 8] = [NOISE; 8];

const CANDIDATES: &str = r#"
[[candidate]]
id = "waves.flow"
role = "waves"
name = "Waves in a flow, with a loss per metre"
cite = ["a test"]
parameters.mach = { unit = "1", prior = { normal = { mean = 0.08, sd = 0.01 } } }
parameters.loss = { unit = "1/m", prior = { normal = { mean = 0.1, sd = 0.05 } } }
[[candidate.effect]]
acts_at = "duct"
forward = "s/(c*(1 + mach)) + loss"
backward = "s/(c*(1 - mach)) + loss"
[[candidate]]
id = "waves.still"
role = "waves"
name = "Waves in gas at rest, without loss"
cite = ["a test"]
[[candidate.effect]]
acts_at = "duct"
forward = "s/c"
backward = "s/c"
[[candidate]]
id = "wall.none"
role = "wall"
name = "No loss"
cite = ["a test"]
[[candidate.effect]]
acts_at = "duct"
mu = "0*s*rho"
"#;

pub(crate) fn folder(name: &str, stage: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-pressures-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("candidates")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    let places: Vec<String> = AT
        .iter()
        .enumerate()
        .map(|(k, x)| if k < MOVED { format!("{x}") } else { format!("\"{x} + $extra\"") })
        .collect();
    let rig = format!(
        "name = \"duct\"\n[gas]\ntemperature = 293.15\ngamma = 1.4\ngas_constant = 287.0\n[upstream]\ntype = \"anechoic\"\n\
         [downstream]\ntype = \"open\"\n[[element]]\nname = \"duct\"\ntype = \"duct\"\nlength = 1.1\ndiameter = 0.05\nwall = \"none\"\n\
         [microphones]\nat = [{}]\n[unknown.extra]\nunit = \"m\"\nprior = {{ normal = {{ mean = 0.0, sd = 0.005 }} }}\n",
        places.join(", ")
    );
    write("rig.toml", &rig);
    write("candidates/all.toml", CANDIDATES);
    write("campaign.csv", "point\na\n");
    write(
        "study.toml",
        &format!("name = \"duct\"\nbase = \"rig\"\n[[responses]]\nid = \"waves\"\n{stage}\n"),
    );
    folder
}

/// What the microphones hear of waves of unit pressure that enter at the ends.
pub(crate) fn columns(f: f64, [extra, mach, loss]: [f64; 3]) -> Vec<[C64; 2]> {
    let (s, c) = (C64::new(0.0, 2.0 * PI * f), (1.4 * 287.0 * 293.15_f64).sqrt());
    let constants = [s / (c * (1.0 + mach)) + loss, s / (c * (1.0 - mach)) + loss];
    let one = |(k, x): (usize, &f64)| {
        let x = if k < MOVED { *x } else { x + extra };
        [(-constants[0] * x).exp(), (constants[1] * (x - 1.1)).exp()]
    };
    AT.iter().enumerate().map(one).collect()
}

pub(crate) fn complex(stream: &mut Stream) -> C64 {
    C64::new(normal(stream), normal(stream))
}

/// Pressures by excitation, frequency and microphone, each row over its root mean square.
fn heard(
    frequency_hz: &[f64],
    excitations: usize,
    truth: [f64; 3],
    noise: [f64; 8],
    stream: &mut Stream,
) -> Vec<Vec<Vec<C64>>> {
    let row = |f: &f64, stream: &mut Stream| -> Vec<C64> {
        let amplitudes = [complex(stream), complex(stream)];
        let clean: Vec<C64> =
            columns(*f, truth).iter().map(|h| h[0] * amplitudes[0] + h[1] * amplitudes[1]).collect();
        let level = |row: &[C64]| (row.iter().map(|z| z.norm_sqr()).sum::<f64>() / row.len() as f64).sqrt();
        let size = level(&clean);
        let noisy: Vec<C64> =
            clean.iter().zip(noise).map(|(z, sd)| z + sd * size * complex(stream)).collect();
        let level = level(&noisy);
        noisy.iter().map(|z| z / level).collect()
    };
    (0..excitations).map(|_| frequency_hz.iter().map(|f| row(f, stream)).collect()).collect()
}

fn trained(folder: &Path, frequency_hz: &[f64], heard: &[Vec<Vec<C64>>]) -> ResponseStageRecord {
    let sources = [Place::Upstream, Place::Downstream];
    run(folder, frequency_hz, heard, &sources, None).next_stage().unwrap().unwrap()
}

pub(crate) fn run(
    folder: &Path,
    frequency_hz: &[f64],
    heard: &[Vec<Vec<C64>>],
    sources: &[Place],
    measured: Option<[f64; 8]>,
) -> ResponseRun {
    let all = responses(frequency_hz, heard, sources, measured);
    ResponseRun::new(Study::open(folder).unwrap(), observed(all)).unwrap()
}

/// The same at the level 1.
fn responses(
    frequency_hz: &[f64],
    heard: &[Vec<Vec<C64>>],
    sources: &[Place],
    measured: Option<[f64; 8]>,
) -> Vec<ObservedResponse> {
    let response = |(e, m): (usize, usize)| ObservedResponse {
        point: 0,
        what: ResponseKind::Pressure { microphone: m, excitation: e.to_string(), sources: sources.to_vec() },
        rows: frequency_hz.len(),
        frequency_hz: frequency_hz.to_vec(),
        values: heard[e].iter().map(|row| row[m]).collect(),
        sd: measured.map_or_else(Vec::new, |sds| vec![sds[m]; frequency_hz.len()]),
        level: vec![1.0; frequency_hz.len()],
    };
    (0..heard.len()).flat_map(|e| (0..AT.len()).map(move |m| (e, m))).map(response).collect()
}

/// The cost of the slow route, nats: the whole covariance of the pressures with the field of the sources at
/// these very parameters.
fn cost(frequency_hz: &[f64], heard: &[Vec<Vec<C64>>], noise: [f64; 8], x: [f64; 3]) -> f64 {
    let parameters = [0, 1, 2].map(|i| PRIORS[i][0] + PRIORS[i][1] * x[i]);
    let n = AT.len();
    let mut sum = 0.5 * x.iter().map(|x| x * x).sum::<f64>() + 1.5 * (2.0 * PI).ln();
    for (k, f) in frequency_hz.iter().enumerate() {
        let h = columns(*f, parameters);
        // H (H* H)^-1 H*, with the inverse of two by two written out.
        let dot = |i: usize, j: usize| h.iter().map(|row| row[i].conj() * row[j]).sum::<C64>();
        let (a, b, d) = (dot(0, 0).re, dot(0, 1), dot(1, 1).re);
        let det = a * d - b.norm_sqr();
        let inverse = [[C64::from(d / det), -b / det], [-b.conj() / det, C64::from(a / det)]];
        let projector = |p: usize, q: usize| {
            let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
            all.iter().map(|(i, j)| h[p][*i] * inverse[*i][*j] * h[q][*j].conj()).sum::<C64>()
        };
        // The field has the mean square of all pressures in every direction: that of a row over its root mean
        // square is n.
        let covariance = Matrix::from_fn(2 * n, 2 * n, |i, j| {
            let z = n as f64 * projector(i % n, j % n);
            let own = if i == j { noise[i % n].powi(2) } else { 0.0 };
            own + match (i / n, j / n) {
                (0, 0) | (1, 1) => z.re,
                (0, _) => -z.im,
                _ => z.im,
            }
        });
        let factor = Cholesky::new(&covariance).unwrap();
        for excitation in heard {
            let row = &excitation[k];
            let values: Vec<f64> = row.iter().map(|z| z.re).chain(row.iter().map(|z| z.im)).collect();
            let square: f64 = factor.whiten(&values).iter().map(|r| r * r).sum();
            sum += 0.5 * (square + factor.ln_det() + 2.0 * n as f64 * (2.0 * PI).ln());
        }
    }
    sum
}

pub(crate) fn found(stage: &ResponseStageRecord, id: &str) -> [[f64; 2]; 3] {
    let found = model(stage, id);
    ["extra", "mach", "loss"].map(|name| {
        let p = found.parameters.iter().find(|p| p.name == name).unwrap();
        [p.value, p.sd]
    })
}

#[test]
fn oracle_unknown_sources_are_those_of_the_whole_covariance() {
    let frequency_hz: Vec<f64> = (0..6).map(|k| 300.0 + 190.0 * f64::from(k)).collect();
    let stage = "compete = [\"waves\"]\namong = [\"waves.flow\"]\n";
    let stated = folder("oracle", &format!("{stage}noise = {NOISE}"));
    let measured = folder("oracle-measured", &format!("{stage}noise = 0"));
    // Noise that is measured, and not the same at all microphones, counts as it was measured.
    let unlike = [0, 1, 2, 3, 4, 5, 6, 7].map(|m| NOISE * [0.6, 1.5, 1.0][m % 3]);
    for (seed, folder, noise, sds) in [
        (0, &stated, ALIKE, None),
        (1, &stated, ALIKE, None),
        (2, &stated, ALIKE, None),
        (3, &measured, unlike, Some(unlike)),
        (4, &measured, unlike, Some(unlike)),
    ] {
        let mut stream = Streams::new(seed).stream("responses/pressures");
        let truth = PRIORS.map(|[mean, sd]| mean + 0.7 * sd * normal(&mut stream));
        let heard = heard(&frequency_hz, 2, truth, noise, &mut stream);
        let sources = [Place::Upstream, Place::Downstream];
        let stage = run(folder, &frequency_hz, &heard, &sources, sds).next_stage().unwrap().unwrap();
        let near = found(&stage, "waves.flow");
        let (slow, evidence) = maximum(&PRIORS, &near, &|x| cost(&frequency_hz, &heard, noise, x));
        for (i, ([value, sd], [there, width])) in near.iter().zip(slow).enumerate() {
            assert!((value - there).abs() < 0.02 * width, "{seed}, {i}: {value} {there} +- {width}");
            assert!((sd / width).ln().abs() < 0.03, "{seed}, {i}: {sd} {width}");
        }
        let own = model(&stage, "waves.flow").ln_evidence();
        assert!((own - evidence).abs() < 0.05, "{seed}: {own} {evidence}");
    }
}

#[test]
fn oracle_waves_by_laws_and_by_the_network_agree() {
    // Whatever the ends reflect, two waves of unknown pressure span the same field.
    let frequency_hz: Vec<f64> = (0..6).map(|k| 300.0 + 190.0 * f64::from(k)).collect();
    let mut stream = Streams::new(5).stream("responses/pressures/network");
    let heard = heard(&frequency_hz, 2, [0.003, 0.0, 0.0], ALIKE, &mut stream);
    let stage = |name: &str, with: &str| {
        let folder = folder(name, &format!("with = {{ {with} }}\nnoise = {NOISE}"));
        trained(&folder, &frequency_hz, &heard)
    };
    let by_law = stage("law", "waves = \"waves.still\"");
    let by_network = stage("network", "wall = \"wall.none\"");
    let [law, network] = [&by_law, &by_network].map(|s| &s.models[0]);
    let difference = law.ln_evidence() - network.ln_evidence();
    assert!(difference.abs() < 1e-6, "{difference}");
    let [p, q] = [law, network].map(|m| &m.parameters[0]);
    assert!((p.value - q.value).abs() < 1e-6 * p.sd && (p.value - 0.003).abs() < 4.0 * p.sd, "{p:?} {q:?}");
}

#[test]
fn exact_one_source_is_heard_with_what_the_other_end_reflects() {
    // An anechoic upstream end and an open one, R = -1, at 1.1 m: one unknown number for every excitation and
    // frequency.
    let frequency_hz: Vec<f64> = (0..6).map(|k| 300.0 + 190.0 * f64::from(k)).collect();
    let (extra, c) = (0.004, (1.4 * 287.0 * 293.15_f64).sqrt());
    let row = |f: &f64, size: f64| -> Vec<C64> {
        let s = C64::new(0.0, 2.0 * PI * f);
        let at = |(k, x): (usize, &f64)| {
            let x = if k < MOVED { *x } else { x + extra };
            let turned = C64::from_polar(size, 7.0 * size);
            turned * ((-s * x / c).exp() - (-s * (2.2 - x) / c).exp())
        };
        let all: Vec<C64> = AT.iter().enumerate().map(at).collect();
        let level = (all.iter().map(|z| z.norm_sqr()).sum::<f64>() / all.len() as f64).sqrt();
        all.iter().map(|z| z / level).collect()
    };
    let heard: Vec<Vec<Vec<C64>>> =
        [1.0, 3.0].iter().map(|size| frequency_hz.iter().map(|f| row(f, *size)).collect()).collect();
    let stage = |name: &str, sources: &[Place]| {
        let folder = folder(name, &format!("with = {{ wall = \"wall.none\" }}\nnoise = {NOISE}"));
        run(&folder, &frequency_hz, &heard, sources, None).next_stage().unwrap().unwrap()
    };
    let one = stage("one-source", &[Place::Upstream]);
    let two = stage("two-sources", &[Place::Upstream, Place::Downstream]);
    let [p, q] = [&one, &two].map(|s| &s.models[0].parameters[0]);
    // The prior pulls by the square of its relative width.
    assert!((p.value - extra).abs() < 0.1 * p.sd && (q.value - extra).abs() < 0.1 * q.sd, "{p:?} {q:?}");
    assert!(p.sd < q.sd, "an end that is known tells more: {p:?} {q:?}");
    assert!(
        one.models[0].residual < 1e-3 && two.models[0].residual < 1e-3,
        "{} {}",
        one.models[0].residual,
        two.models[0].residual
    );
}

#[test]
fn message_a_small_fault_has_a_remedy_that_pressures_can_take() {
    // A loss along the tube that the model does not have, at dense frequencies.
    let frequency_hz: Vec<f64> = (0..100).map(|k| 300.0 + 10.0 * f64::from(k)).collect();
    let c = (1.4 * 287.0 * 293.15_f64).sqrt();
    let row = |f: &f64| -> Vec<C64> {
        let wave = C64::new(0.02, 2.0 * PI * f / c);
        AT.iter().map(|x| (-wave * *x).exp() - (-wave * (2.2 - x)).exp()).collect()
    };
    let heard: Vec<Vec<Vec<C64>>> = vec![frequency_hz.iter().map(row).collect()];
    let folder = folder("fault", "with = { wall = \"wall.none\" }\nnoise = \"floated\"");
    let found = run(&folder, &frequency_hz, &heard, &[Place::Upstream], None).next_stage().unwrap().unwrap();
    let remark = found.models[0].remark.clone().unwrap();
    for part in ["the residuals are not noise", "`step_hz`", "[microphones]"] {
        assert!(remark.contains(part), "{part}: {remark}");
    }
    // Stages of such pressures refuse one.
    assert!(!remark.contains("responses.misfit"), "{remark}");
}

#[test]
fn message_waves_of_laws_are_for_pressures_of_two_sources() {
    let frequency_hz = [400.0, 500.0];
    let folder = folder("refused", "with = { waves = \"waves.still\" }\nnoise = 0.01");
    let heard = vec![vec![vec![C64::ONE; AT.len()]; 2]];
    let error =
        run(&folder, &frequency_hz, &heard, &[Place::Upstream], None).next_stage().unwrap_err().to_string();
    for part in ["waves.still", "forward", "both ends"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let reflection = ObservedResponse {
        point: 0,
        what: ResponseKind::Reflection { at: Place::Upstream, reference_area: None },
        rows: 2,
        frequency_hz: frequency_hz.to_vec(),
        values: vec![C64::ONE; 2],
        sd: Vec::new(),
        level: Vec::new(),
    };
    let mut run = ResponseRun::new(Study::open(&folder).unwrap(), observed(vec![reflection])).unwrap();
    let error = run.next_stage().unwrap_err().to_string();
    assert!(error.contains("only pressures of unknown sources use"), "{error}");
}

#[test]
fn coverage_parameters_of_unknown_sources_lie_within_their_errors() {
    let frequency_hz: Vec<f64> = (0..5).map(|k| 350.0 + 210.0 * f64::from(k)).collect();
    let folder = folder("coverage", "compete = [\"waves\"]\namong = [\"waves.flow\"]\nnoise = \"floated\"");
    let (mut within, mut all, mut square) = (0_u32, 0_u32, 0.0);
    for set in 0..200 {
        let mut stream = Streams::new(set).stream("responses/pressures/coverage");
        let truth = PRIORS.map(|[mean, sd]| mean + sd * normal(&mut stream));
        let heard = heard(&frequency_hz, 2, truth, ALIKE, &mut stream);
        let stage = trained(&folder, &frequency_hz, &heard);
        for ([value, sd], truth) in found(&stage, "waves.flow").iter().zip(truth) {
            let z = (value - truth) / sd;
            (within, all, square) = (within + u32::from(z.abs() < 2.0), all + 1, square + z * z);
        }
    }
    let (share, rms) = (f64::from(within) / f64::from(all), (square / f64::from(all)).sqrt());
    assert!((0.92..0.98).contains(&share), "{within} of {all}");
    assert!((0.9..1.1).contains(&rms), "{rms}");
}

/// Microphones whose noise is 0.2 mPa whatever they hear, of a loudspeaker that makes 2 Pa at low frequencies
/// and 0.02 Pa at high ones, which tell as much: with one noise relative to the level all rows would count
/// alike, and the deviations would be ten times as large.
#[test]
fn coverage_noise_of_one_size_is_found_at_all_levels() {
    let frequency_hz: Vec<f64> = (0..24).map(|k| 350.0 + 40.0 * f64::from(k)).collect();
    let stage = "compete = [\"waves\"]\namong = [\"waves.flow\"]\nnoise = \"floated\"\n";
    let folders = [("one-size", ""), ("relative", "noise_in_proportion = false\n")]
        .map(|(name, key)| folder(name, &format!("{stage}{key}")));
    let (mut squares, mut widths, mut found_so, sets) = ([0.0; 2], [0.0; 2], 0, 40);
    for set in 0..sets {
        let mut stream = Streams::new(set).stream("responses/pressures/one size");
        let truth = PRIORS.map(|[mean, sd]| mean + sd * normal(&mut stream));
        let mut levels = vec![Vec::new(); 2];
        let mut row = |f: &f64, levels: &mut Vec<f64>| -> Vec<C64> {
            let size = 2.0 * 100_f64.powf(-(f - 350.0) / 920.0);
            let amplitudes = [complex(&mut stream) * size, complex(&mut stream) * size];
            let of = |h: &[C64; 2]| h[0] * amplitudes[0] + h[1] * amplitudes[1];
            let all: Vec<C64> =
                columns(*f, truth).iter().map(|h| of(h) + 2e-4 * complex(&mut stream)).collect();
            let level = (all.iter().map(|z| z.norm_sqr()).sum::<f64>() / all.len() as f64).sqrt();
            levels.push(level);
            all.iter().map(|z| z / level).collect()
        };
        let heard: Vec<Vec<Vec<C64>>> =
            levels.iter_mut().map(|levels| frequency_hz.iter().map(|f| row(f, levels)).collect()).collect();
        let mut all = responses(&frequency_hz, &heard, &[Place::Upstream, Place::Downstream], None);
        for (k, response) in all.iter_mut().enumerate() {
            response.level.clone_from(&levels[k / AT.len()]);
        }
        for ((folder, square), width) in folders.iter().zip(&mut squares).zip(&mut widths) {
            let study = Study::open(folder).unwrap();
            let stage =
                ResponseRun::new(study, observed(all.clone())).unwrap().next_stage().unwrap().unwrap();
            let pulls = found(&stage, "waves.flow").into_iter().zip(truth);
            *width += found(&stage, "waves.flow").iter().map(|[_, sd]| sd.ln()).sum::<f64>();
            *square += pulls.map(|([value, sd], truth)| ((value - truth) / sd).powi(2)).sum::<f64>();
            let noise = &model(&stage, "waves.flow").noise;
            if let Some(n) = noise.iter().find(|n| n.name == "noise of one size at all levels") {
                assert!((n.sd / 2e-4 - 1.0).abs() < 0.25, "{noise:?}");
                found_so += 1;
            }
        }
    }
    let [size, relative] = squares.map(|square| (square / (3.0 * sets as f64)).sqrt());
    let narrower = ((widths[1] - widths[0]) / (3.0 * sets as f64)).exp();
    assert_eq!(found_so, sets);
    assert!(
        (0.85..1.15).contains(&size) && (0.85..1.15).contains(&relative) && narrower > 8.0,
        "{size} {relative} {narrower}"
    );
}
