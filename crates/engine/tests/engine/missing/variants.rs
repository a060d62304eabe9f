//! Examples with other stages, and with terms of the library as candidates.

use rijke_engine::run::{Asked, Run, StageRecord, Trusted};
use rijke_study::Study;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// An example, and the stages of the model that its ranking chose, without the last one's choice of
/// candidates.
pub(crate) struct Example {
    pub(crate) name: &'static str,
    pub(crate) stages: &'static str,
    /// What comes to its rig and its candidates.
    pub(crate) more: [&'static str; 2],
}

pub(crate) const QUARTER_WAVE: Example = Example {
    name: "quarter-wave",
    stages: r#"
[[stage]]
id = "tube"
title = "tube"
points = { where = { gauze = false } }
with = { wall = "wall.kirchhoff", inlet = "inlet.blown", mouth = "mouth.thick" }
base_errors = true
[[stage]]
id = "gauze"
title = "gauze"
points = { where = { gauze = true, Q = 0 } }
on = "tube"
with = { gauze = "gauze.wires" }
base_errors = true
[[stage]]
id = "heat"
title = "heat"
points = { where = { Q = { above = 0 } } }
on = "gauze"
base_errors = true
"#,
    more: ["", ""],
};

pub(crate) const DUCTED_FLAME: Example = Example {
    name: "ducted-flame-stages",
    stages: r#"
[[stage]]
id = "tube"
title = "tube"
points = { where = { burner = false } }
with = { wall = "wall.kirchhoff", inlet = "inlet.blown", outlet = "outlet.thick", mouth = "mouth.jet", junction = "junction.mass" }
base_errors = true
[[stage]]
id = "burner"
title = "burner"
points = { where = { burner = true, Q = 0 } }
on = "tube"
with = { swirler = "swirler.loss" }
base_errors = true
[[stage]]
id = "flame"
title = "flame"
points = { where = { Q = { above = 0 } } }
on = "burner"
base_errors = true
"#,
    // The term that the data of the example ask for: the added mass of the other end of the burner tube.
    more: [
        "\n[[element]]\nname = \"junction\"\ntype = \"device\"\nat = \"249 mm\"\n",
        "[[candidate]]\nid = \"junction.mass\"\nrole = \"junction\"\nname = \"added mass\"\ncite = [\"own judgement\"]\n\
         parameters.mass = { symbol = \"l_j\", unit = \"m\", prior = { normal = { mean = 0.0, sd = 0.1 } } }\n\
         [[candidate.effect]]\nacts_at = \"junction\"\nmu = \"mass*s*rho\"\n",
    ],
};

pub(crate) const COMBUSTOR: Example = Example {
    name: "helmholtz-combustor",
    stages: r#"
[[stage]]
id = "bare"
title = "bare"
points = { where = { damper = false } }
with = { wall = "wall.kirchhoff", junctions = "junctions.karal", outlet = "outlet.oscilos", flame = "flame.filter" }
base_errors = true
[[stage]]
id = "damper"
title = "damper"
points = { where = { damper = true } }
on = "bare"
base_errors = true
"#,
    more: ["", ""],
};

/// A copy of an example that goes with the test.
pub(crate) struct Variant {
    folder: PathBuf,
    head: String,
    stages: &'static str,
}

impl Variant {
    pub(crate) fn new(name: &str, example: &Example) -> Self {
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(example.name);
        let folder = std::env::temp_dir().join(format!("rijke-missing-{name}-{}", std::process::id()));
        copy(&from, &folder);
        let [rig, candidates] = example.more;
        if !rig.is_empty() {
            let path = folder.join("rig.toml");
            let text = std::fs::read_to_string(&path).unwrap();
            std::fs::write(path, text.replacen("\n[microphones]", &format!("{rig}\n[microphones]"), 1))
                .unwrap();
            std::fs::write(folder.join("candidates/more.toml"), candidates).unwrap();
        }
        let plan = std::fs::read_to_string(from.join("study.toml")).unwrap();
        let head = plan.split("[[stage]]").next().unwrap().to_owned();
        Self { folder, head, stages: example.stages }
    }

    /// With a last stage of this choice.
    pub(crate) fn stage(self, last: &str) -> Self {
        std::fs::write(self.folder.join("study.toml"), format!("{}{}{last}", self.head, self.stages))
            .unwrap();
        self
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    pub(crate) fn study(&self) -> Study {
        Study::open(&self.folder).unwrap()
    }

    pub(crate) fn run(&self) -> Vec<StageRecord> {
        self.try_run().unwrap()
    }

    pub(crate) fn try_run(&self) -> Result<Vec<StageRecord>, rijke_engine::EngineError> {
        let study = self.study();
        let observations = study.observations()?;
        let mut run = Run::new(study, &observations, Trusted::Laplace)?;
        let mut stages = Vec::new();
        while let Some(stage) = run.next_stage()? {
            stages.push(stage);
        }
        Ok(stages)
    }

    /// What the evidence gains by every term, trained as a candidate whose strength has the prior that the
    /// library takes.
    pub(crate) fn refits(self, last: &str, terms: &[&Asked]) -> Vec<f64> {
        let mut candidates = String::new();
        let mut rig = std::fs::read_to_string(self.folder.join("rig.toml")).unwrap();
        let cut = rig.find("\n[microphones]").unwrap();
        let mut probes = String::new();
        for (k, term) in terms.iter().enumerate() {
            let (place, law, largest, per) = formula(term).unwrap();
            let place = place.unwrap_or_else(|| {
                let x = term.x.unwrap();
                let _ = write!(
                    probes,
                    "\n[[element]]\nname = \"probe-{k}\"\ntype = \"device\"\nat = \"{x} m\"\n"
                );
                format!("probe-{k}")
            });
            let _ = write!(
                candidates,
                "[[candidate]]\nid = \"term.{k}\"\nrole = \"term\"\nname = \"term\"\ncite = [\"own judgement\"]\n\
                 parameters.theta = {{ symbol = \"t\", unit = \"{}\", prior = {{ normal = {{ mean = 0.0, sd = {:e} }} }} }}\n\
                 [[candidate.effect]]\nacts_at = \"{place}\"\n{law}\n",
                match format!("{} {per}", if term.unit == "1" { "" } else { &term.unit }).trim() {
                    "" => "1",
                    unit => unit,
                },
                term.prior_sd / largest
            );
        }
        candidates += "[[candidate]]\nid = \"term.none\"\nrole = \"term\"\nname = \"none\"\ncite = [\"own judgement\"]\n\
                       [[candidate.effect]]\nacts_at = \"ducts\"\nmu = \"0*rho*s\"\n";
        rig.insert_str(cut, &probes);
        std::fs::write(self.folder.join("rig.toml"), rig).unwrap();
        std::fs::write(self.folder.join("candidates/terms.toml"), candidates).unwrap();
        let stages = self.stage(&format!("{last}compete = \"term\"\n")).run();
        let models = &stages.last().unwrap().models;
        let evidence = |id: &str| {
            models.iter().find(|m| m.id == id).unwrap().evidence.map_or(f64::NAN, |e| e.ln_marginal)
        };
        let without = evidence("term.none");
        (0..terms.len()).map(|k| evidence(&format!("term.{k}")) - without).collect()
    }
}

impl Drop for Variant {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Whether a term of the library can be written as a candidate here.
pub(crate) fn has_formula(term: &Asked) -> bool {
    formula(term).is_some()
}

/// A place if it is not a cut of its own, the law, the largest value of its factor, and one over the unit of
/// that.
fn formula(term: &Asked) -> Option<(Option<String>, String, f64, String)> {
    let (factor, largest, per) = match term.times.split_once("/(") {
        None => (String::new(), 1.0, String::new()),
        Some(("frequency" | "velocity", _)) => return None,
        Some((name, rest)) => {
            let (number, unit) = rest.trim_end_matches(')').split_once(' ').unwrap_or((rest, ""));
            let largest = number.trim_end_matches(')').parse().ok()?;
            let inverse = |unit: &str| match unit.split_once('^') {
                Some((unit, power)) => format!("{unit}^{}", -power.parse::<i32>().unwrap()),
                None => format!("{unit}^-1"),
            };
            let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
            let powers = above.split(' ').filter(|u| !["", "1"].contains(u)).map(inverse);
            (format!("*{name}"), largest, powers.chain([below.to_owned()]).collect::<Vec<_>>().join(" "))
        }
    };
    let device = Some(term.place.clone()).filter(|p| !p.starts_with("x = "));
    let end = || Some(term.place.split(' ').next().unwrap().to_owned());
    let (place, coefficient, law) = match (term.effect.as_str(), term.place.as_str()) {
        (_, place) if place.contains(',') => return None,
        // Beyond the end of the shortest rig.
        _ if term.x.is_some_and(|x| x > 0.75) && device.is_none() => return None,
        ("resistance", _) => (device, "mu", "*rho*c"),
        ("inertia", _) => (device, "mu", "*s*rho"),
        ("force in phase with pressure", _) => (device, "mp", ""),
        ("force out of phase with pressure", _) => (device, "mp", "*s"),
        ("heat release in phase with velocity", _) => (device, "eu", "*(-1)"),
        ("heat release out of phase with velocity", _) => (device, "eu", "*s"),
        ("leak", _) => (device, "ep", "/(rho*c)"),
        ("compliance", _) => (device, "ep", "*s/(rho*c^2)"),
        ("reflection, real part", _) => (end(), "reflection", ""),
        ("reflection, in proportion to s", _) => (end(), "reflection", "*s"),
        ("friction of walls", _) => (Some("ducts".into()), "mu", "*rho*c"),
        ("heat to walls", _) => (Some("ducts".into()), "ep", "/(rho*c)"),
        _ => return None,
    };
    Some((place, format!("{coefficient} = \"theta{law}{factor}\""), largest, per))
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().flatten() {
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}
