//! Errors of factors and temperatures that the campaign states, against models in which what is in error is
//! an unknown with that prior: a porous sample at the end of a tube without losses.

use super::bench::{GAMMA, GAS_CONSTANT, law_itself, observed};
use super::pressures::complex;
use rijke_engine::response::{ResponseModelRecord, ResponseRun};
use rijke_engine::run::{Run, Trusted};
use rijke_numerics::{C64, Streams};
use rijke_study::responses::{ObservedResponse, ResponseKind};
use rijke_study::{Place, Study};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

const AT: [f64; 3] = [0.05, 0.12, 0.2];
const LENGTH: f64 = 0.3;
const THICKNESS: f64 = 0.025;
pub(super) const TEMPERATURE: f64 = 293.15;
const SIGMA: f64 = 12000.0;
const NOISE: f64 = 0.01;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum What {
    /// Reflection coefficients.
    Reflection,
    /// Transfer functions between microphones with gains and delays.
    Transfer,
    /// Pressures, of a wave of unknown strength.
    Pressure,
}

const MIKI: &str = r#"
[[candidate]]
id = "miki"
role = "sample"
name = "Miki 1990"
cite = ["Y. Miki, J. Acoust. Soc. Jpn (E) 11 (1990) 19"]
parameters.sig = { unit = "Pa s/m^2", prior = { log_normal = { median = 15000.0, ln_sd = 0.8 } } }
MORE
[candidate.where]
X = "s/(2*pi)*rho/sig"
z = "1 + 0.12786*X^(-0.632)"
k = "s/c*(1 + 0.1936*X^(-0.618))"
e = "exp(-2*k*(DEPTH))"
zz = "z*(1 + e)/(1 - e)"
[[candidate.effect]]
acts_at = "downstream"
reflection = "(zz - 1)/(zz + 1)"
[[candidate]]
id = "head"
role = "head"
name = "A head"
cite = ["a test"]
head = true
error = ERRORS
"#;

/// What differs between two studies of the same data.
pub(super) struct Written<'a> {
    /// Standard deviations of the sample's depth and of its face, mm, and of the temperature, K.
    pub(super) sds: [f64; 3],
    /// The depth in laws, and what defines it.
    pub(super) depth: [&'a str; 2],
    /// The length of the tube in the file of the rig, a line of the tube, and what defines their unknowns.
    pub(super) rig: [&'a str; 3],
    pub(super) base: &'a str,
    /// Errors of the head.
    pub(super) errors: &'a str,
    pub(super) stages: &'a str,
}

const ONE: &str =
    "[[responses]]\nid = \"all\"\nwith = { head = \"head\" }\ncompete = [\"sample\"]\nnoise = 0.01\n";

impl Default for Written<'_> {
    fn default() -> Self {
        let rig = ["0.3 - face", "", ""];
        Self { sds: [0.0; 3], depth: ["depth", ""], rig, base: "ambient", errors: "[]", stages: ONE }
    }
}

impl Written<'_> {
    fn folder(&self, name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rijke-stated-{name}-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("candidates")).unwrap();
        let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
        let [length, line, unknown] = self.rig;
        let rig = format!(
            "name = \"Tube\"\n[gas]\ntemperature = {TEMPERATURE}\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
             [upstream]\ntype = \"anechoic\"\n[downstream]\ntype = \"free\"\n\
             [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = \"{length}\"\ndiameter = 0.04\nwall = \"none\"\n{line}\n\
             [microphones]\nat = {AT:?}\ngain_sd = 0.005\ndelay_sd = \"2 us\"\n{unknown}"
        );
        write("rig.toml", &rig);
        let [depth, more] = self.depth;
        let laws = MIKI.replace("ERRORS", self.errors).replace("DEPTH", depth).replace("MORE", more);
        write("candidates/all.toml", &laws);
        let [depth, face, temperature] = self.sds;
        let mm = 1e3 * THICKNESS;
        let row = |p: &str| format!("{p},{p},i,1,{mm},{depth},{mm},{face},{TEMPERATURE},{temperature}\n");
        let head = "point,row,installation,day,depth [mm],depth_sd [mm],face [mm],face_sd [mm],T_amb [K],T_amb_sd [K]\n";
        write("campaign.csv", &(head.to_owned() + &row("a") + &row("b")));
        write("study.toml", &format!("name = \"tube\"\nbase = \"{}\"\n{}", self.base, self.stages));
        folder
    }

    fn run(&self, name: &str, what: What, truth: [f64; 3]) -> ResponseRun {
        let study = Study::open(&self.folder(name)).unwrap();
        ResponseRun::new(study, observed(measured(what, truth))).unwrap()
    }

    /// The model that wins, and what becomes of the width of sigma by [`ResponseRun::foresight`].
    pub(super) fn found(&self, name: &str, what: What, truth: [f64; 3]) -> (ResponseModelRecord, f64) {
        let mut run = self.run(name, what, truth);
        let foresight = run.foresight().unwrap();
        let widths = &foresight[0].models[0].widths;
        let width = widths.iter().find(|(name, _)| name == "sig").unwrap().1;
        (run.next_stage().unwrap().unwrap().models[0].clone(), width)
    }
}

/// Two points of one sample, which is `by[0]` m deeper than stated, with its face `by[1]` m nearer, and of
/// one day, `by[2]` K hotter.
fn measured(what: What, by: [f64; 3]) -> Vec<ObservedResponse> {
    let (depth, face, t) = (THICKNESS + by[0], THICKNESS + by[1], TEMPERATURE + by[2]);
    let (c, rho) = ((GAMMA * GAS_CONSTANT * t).sqrt(), 101_325.0 / (GAS_CONSTANT * t));
    let frequency_hz: Vec<f64> = (0..40).map(|k| 200.0 + 45.0 * f64::from(k)).collect();
    let end = |s: C64| {
        let x = s / (2.0 * PI) * rho / SIGMA;
        let (z, k) = (1.0 + 0.12786 * x.powf(-0.632), s / c * (1.0 + 0.1936 * x.powf(-0.618)));
        let e = (-2.0 * k * depth).exp();
        let z = z * (1.0 + e) / (1.0 - e);
        (z - 1.0) / (z + 1.0) * (-2.0 * s * (LENGTH - face) / c).exp()
    };
    let pressure = |s: C64, m: usize| (-s * AT[m] / c).exp() + end(s) * (s * AT[m] / c).exp();
    let (up, sources) = (Place::Upstream, vec![Place::Upstream]);
    let kinds = match what {
        What::Reflection => vec![ResponseKind::Reflection { at: up, reference_area: None }],
        What::Transfer => [1, 2].map(|to| ResponseKind::Transfer { to, from: 0 }).to_vec(),
        What::Pressure => (0..3)
            .map(|microphone| ResponseKind::Pressure {
                microphone,
                excitation: String::new(),
                sources: sources.clone(),
            })
            .collect(),
    };
    let mut stream = Streams::new(11).stream("responses/stated");
    let mut all = Vec::new();
    for point in 0..2 {
        for what in &kinds {
            let answer = |f: &f64| {
                let s = C64::new(0.0, 2.0 * PI * f);
                NOISE * complex(&mut stream)
                    + match what {
                        ResponseKind::Transfer { to, from } => pressure(s, *to) / pressure(s, *from),
                        ResponseKind::Pressure { microphone, .. } => pressure(s, *microphone),
                        _ => end(s),
                    }
            };
            all.push(ObservedResponse {
                point,
                what: what.clone(),
                rows: frequency_hz.len(),
                values: frequency_hz.iter().map(answer).collect(),
                frequency_hz: frequency_hz.clone(),
                sd: Vec::new(),
                level: Vec::new(),
            });
        }
    }
    all
}

pub(super) fn number(model: &ResponseModelRecord, name: &str) -> [f64; 2] {
    let found = model.parameters.iter().find(|p| p.name == name);
    let p = found.unwrap_or_else(|| panic!("{name} of {:?}", model.parameters));
    [p.value, p.sd]
}

/// A model with an error that is stated, and one in which it is an unknown of standard deviation `sd` about
/// `mean`.
fn same(
    a: &(ResponseModelRecord, f64),
    b: &(ResponseModelRecord, f64),
    [error, unknown]: [&str; 2],
    [mean, sd]: [f64; 2],
) {
    let [one, other] = [a, b].map(|m| number(&m.0, "sig"));
    assert!(
        (one[0] - other[0]).abs() < 1e-2 * other[1] && (one[1] / other[1] - 1.0).abs() < 1e-2,
        "{one:?} {other:?}"
    );
    let [e, u] = [number(&a.0, error), number(&b.0, unknown)];
    assert!(
        (mean + sd * e[0] - u[0]).abs() < 2e-2 * u[1] && (sd * e[1] / u[1] - 1.0).abs() < 2e-2,
        "{e:?} {u:?}"
    );
    let apart = a.0.ln_evidence() - b.0.ln_evidence();
    assert!(apart.abs() < 0.05, "{apart} nats");
    assert!((a.1 / b.1 - 1.0).abs() < 1e-2, "widths {} {}", a.1, b.1);
    assert_eq!((a.0.errors, b.0.errors), (1, 0));
}

#[test]
fn oracle_an_error_of_a_factor_is_an_unknown_of_the_rig() {
    let prior = "{ normal = { mean = 0.0, sd = 0.3e-3 } }";
    let parameter = format!("parameters.off = {{ unit = \"m\", prior = {prior} }}");
    let unknown = format!("[unknown.off]\nunit = \"m\"\nprior = {prior}\n");
    let head = "[{ power = 1, functions = 3, sd = 0.02 }]";
    for (what, errors, in_law) in [
        (What::Reflection, "[]", true),
        (What::Reflection, "[]", false),
        (What::Reflection, head, true),
        (What::Transfer, "[]", true),
        (What::Transfer, "[]", false),
        (What::Pressure, "[]", true),
    ] {
        let [truth, sds] = [0.36e-3, 0.3].map(|v| if in_law { [v, 0.0, 0.0] } else { [0.0, v, 0.0] });
        let plain = || Written { errors, ..Written::default() };
        let stated = Written { sds, ..plain() }.found("factor", what, truth);
        let own = match in_law {
            true => Written { depth: ["depth + off", &parameter], ..plain() },
            false => Written { rig: ["0.3 - face - $off", "", &unknown], ..plain() },
        };
        let error = if in_law { "error of depth 0.025 (i)" } else { "error of face 0.025 (i)" };
        same(&stated, &own.found("off", what, truth), [error, "off"], [0.0, 0.3e-3]);
        let counted = number(&stated.0, "sig");
        assert!((counted[0] - SIGMA).abs() < 3.0 * counted[1], "{what:?} {counted:?}");
        // Without it the answer is far off and sure.
        let ignored = number(&plain().found("sure", what, truth).0, "sig");
        assert!(
            !in_law || errors == head || (ignored[0] - SIGMA).abs() > 3.0 * ignored[1],
            "{what:?} {counted:?} {ignored:?}"
        );
    }
}

#[test]
fn oracle_an_error_of_the_ambient_temperature_is_an_unknown_temperature() {
    let truth = [0.0, 0.0, -1.2];
    let unknown = "[unknown.hot]\nunit = \"K\"\nprior = { normal = { mean = 293.15, sd = 1.5 } }\n";
    for what in [What::Reflection, What::Transfer, What::Pressure] {
        let stated = Written { sds: [0.0, 0.0, 1.5], ..Written::default() }.found("warm", what, truth);
        let rig = ["0.3 - face", "temperature = \"$hot\"", unknown];
        let own = Written { rig, base: "rig", ..Written::default() };
        same(&stated, &own.found("hot", what, truth), ["error of T_amb (day 1)", "hot"], [TEMPERATURE, 1.5]);
        let counted = number(&stated.0, "sig");
        assert!((counted[0] - SIGMA).abs() < 3.0 * counted[1], "{what:?} {counted:?}");
    }
}

#[test]
fn oracle_predictions_beside_a_stated_error_are_those_beside_an_unknown() {
    let parameter = "parameters.off = { unit = \"m\", prior = { normal = { mean = 0.0, sd = 0.3e-3 } } }";
    let unknown = Written { depth: ["depth + off", parameter], ..Written::default() };
    let stated = Written { sds: [0.3, 0.0, 0.0], ..Written::default() };
    for (what, count) in [(What::Reflection, 2), (What::Transfer, 3), (What::Pressure, 1)] {
        let found = |written: &Written<'_>, name: &str| {
            let mut run = written.run(name, what, [0.36e-3, 0.0, 0.0]);
            run.next_stage().unwrap().unwrap();
            let data = observed(measured(what, [0.36e-3, 0.0, 0.0]));
            run.grounds()[0]
                .forecast(&Study::open(&written.folder(name)).unwrap(), &data, &[0, 1], &[333.0, 2500.0])
                .unwrap()
        };
        let [a, b] = [found(&stated, "told-a"), found(&unknown, "told-b")];
        assert_eq!((a.len(), b.len()), (4 * count, 4 * count));
        for (a, b) in a.iter().zip(&b) {
            let off = |k: usize| (a.value[k] - b.value[k]).abs() + (a.sd()[k] - b.sd()[k]).abs();
            assert!(a.what == b.what && (0..2).all(|k| off(k) < 0.02 * b.sd()[k]), "{a:?} {b:?}");
        }
    }
}

#[test]
fn oracle_what_a_stage_learns_of_an_error_goes_on_to_the_next() {
    let stage = |id: &str, on: &str| {
        format!(
            "[[responses]]\nid = \"{id}\"\npoints = {{ rows = [\"{id}\"] }}\n{on}compete = [\"sample\"]\nwith = {{ head = \"head\" }}\nnoise = 0.01\n"
        )
    };
    let stages = stage("a", "") + &stage("b", "on = [\"a\"]\n");
    let truth = [0.36e-3, 0.0, 0.8];
    let sds = [0.3, 0.0, 1.5];
    let mut chain =
        Written { sds, stages: &stages, ..Written::default() }.run("chain", What::Reflection, truth);
    let [first, last] = [0, 1].map(|_| chain.next_stage().unwrap().unwrap().models[0].clone());
    let all = Written { sds, ..Written::default() }.found("whole", What::Reflection, truth).0;
    let apart = first.ln_evidence() + last.ln_evidence() - all.ln_evidence();
    assert!(apart.abs() < 0.05, "{apart} nats");
    for name in ["sig", "error of depth 0.025 (i)", "error of T_amb (day 1)"] {
        let [chained, at_once] = [&last, &all].map(|m| number(m, name));
        assert!((chained[0] - at_once[0]).abs() < 0.05 * at_once[1], "{name} {chained:?} {at_once:?}");
        assert!((chained[1] / at_once[1] - 1.0).abs() < 0.02, "{name} {chained:?} {at_once:?}");
        assert!(number(&first, name)[1] > 1.02 * at_once[1], "{name} {:?} {at_once:?}", number(&first, name));
    }
}

/// A law alone that goes with (T/293.15 K)^4 tells the temperature of the day; the frequency of a tube, f =
/// c/(4 (L + a)), then tells a.
#[test]
fn oracle_a_stage_of_modes_knows_the_temperature_that_responses_told() {
    let folder = std::env::temp_dir().join(format!("rijke-stated-modes-{}", std::process::id()));
    for part in ["candidates", "observations"] {
        std::fs::create_dir_all(folder.join(part)).unwrap();
    }
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
    let rig = format!(
        "name = \"Tube\"\n[gas]\ntemperature = 293.15\npressure = 101325\ngamma = {GAMMA}\ngas_constant = {GAS_CONSTANT}\n\
         [search]\nfrequency_hz = [50, 150]\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
         [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"none\"\n\
         [[element]]\nname = \"part\"\ntype = \"device\"\nat = 0.4\npresent = \"alone\"\n"
    );
    write("rig.toml", &rig);
    write(
        "candidates/all.toml",
        "[[candidate]]\nid = \"one\"\nrole = \"part\"\nname = \"one\"\ncite = [\"a test\"]\n\
         parameters.a = { unit = \"m\", prior = { normal = { mean = 0.01, sd = 0.01 } } }\n\
         parameters.cold = { unit = \"K\", prior = { normal = { mean = 293.15, sd = 1e-4 } } }\n\
         [[candidate.effect]]\nacts_at = \"part\"\neu = \"(T/cold)^4\"\n\
         [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"-exp(-0.1 - 2*s*a/c)\"\n",
    );
    let (hotter, a, tells, hertz) = (0.5_f64, 0.012_f64, 1e-3_f64, 0.01_f64);
    let found = |day: &str| {
        write(
            "campaign.csv",
            &format!(
                "point,row,day,alone,T_amb [K],T_amb_sd [K]\nalone,part,1,1,293.15,1\nm,tube,{day},0,293.15,1\n"
            ),
        );
        write(
            "study.toml",
            &format!(
                "name = \"t\"\nbase = \"ambient\"\n[[responses]]\nid = \"alone\"\npoints = {{ rows = [\"part\"] }}\ncompete = [\"part\"]\nnoise = {tells}\n\
                 [[stage]]\nid = \"tube\"\npoints = {{ rows = [\"tube\"] }}\non = \"alone\"\nbase_errors = true\n[stage.noise]\ngrowth_rate = 0.0\n\
                 angular_frequency = 0.0\n"
            ),
        );
        let f = (GAMMA * GAS_CONSTANT * (293.15 + hotter)).sqrt() / (4.0 * (0.8 + a));
        write(
            "observations/modes.csv",
            &format!(
                "point,growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]\nm,-20,100,{f},{hertz}\n"
            ),
        );
        write("observations/observations.toml", "kind = \"virtual\"\nsource = \"a closed form\"\n");
        modes(&folder, (1.0_f64 + hotter / 293.15).powi(4), f)
    };
    let (told, f) = found("1");
    let slope = 0.812 / (2.0 * 293.15);
    // Four frequencies, of which the real part says something.
    let kelvin = tells / 2.0 / (4.0 / 293.15);
    let sd = f64::hypot(slope * kelvin, hertz * 0.812 / f);
    assert!((told[0] - a).abs() < 0.1 * sd && (told[1] / sd - 1.0).abs() < 0.03, "{told:?} {sd}");
    // On another day nothing is told.
    let untold = found("2").0;
    assert!((untold[0] - a + slope * hotter).abs() < 0.1 * slope && untold[1] > 0.9 * slope, "{untold:?}");
}

/// The parameter a of a stage of modes on a law of this value, and the frequency that it was given.
fn modes(folder: &Path, law: f64, f: f64) -> ([f64; 2], f64) {
    let study = Study::open(folder).unwrap();
    let response = ObservedResponse {
        point: 0,
        what: law_itself(&study),
        rows: 4,
        frequency_hz: vec![50.0, 100.0, 150.0, 200.0],
        values: vec![C64::new(law, 0.0); 4],
        sd: Vec::new(),
        level: Vec::new(),
    };
    let mut responses = ResponseRun::new(study.clone(), observed(vec![response])).unwrap();
    responses.next_stage().unwrap().unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::on_responses(study, &observations, Trusted::Laplace, responses.grounds()).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let p = stage.models[0].parameters.iter().find(|p| p.name == "a").unwrap();
    ([p.value, p.sd], f)
}
