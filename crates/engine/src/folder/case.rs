//! What a file or folder describes of which modes are asked: a network file, the rig of a study, a study at
//! an operating point by the model that was ranked, or inputs of OSCILOS_lite.

use super::results::{kept, no_stage};
use super::study::{doubts_of, observations, of_modes, of_the_engine, open_study};
use crate::run::modes_at;
use crate::{SavedModel, Spectrum};
use rijke_network::file::{
    Built, ElementProblem, FileError, OscilosTexts, doubts_of_oscilos, read, read_oscilos, samples_of_each,
};
use rijke_network::flow_chain::FlowChain;
use rijke_network::{
    Chain, Coefficients, Constant, Mode, ModeCurves, Modes, NetworkError, Region, Workspace,
};
use rijke_numerics::words::few;
use rijke_numerics::{C64, Classify, Failed};
use rijke_study::Study;
use rijke_study::plan::Stage;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// What a file or folder describes.
pub struct ModeCase {
    pub(super) path: PathBuf,
    /// Its name, if it has one.
    pub title: Option<String>,
    /// Where modes are sought.
    pub region: Region,
    /// Whether nothing in it feeds energy.
    pub(super) passive: bool,
    pub(super) warnings: Vec<String>,
    /// What the numbers include.
    pub(super) note: Option<String>,
    /// Where devices lie, m.
    pub devices: Vec<f64>,
    pub(super) given: Given,
    remedy: &'static str,
}

/// What is said of open ends of that program.
const OPEN_END: &str = "open ends are laws of s here: type 11 is exact, type 12 a piston in a wall, whose end correction is 3 % too long (frequencies some \
                        0.3 % lower). OSCILOS_lite evaluates polynomials at the frequency alone, so its growth rates of strongly damped modes differ by \
                        some 1/s; they stand below the table";

/// What is asked: chains, or answers.
pub(super) enum Given {
    /// A network file, with its text.
    File(Box<Built>, String),
    /// Inputs of OSCILOS_lite, with the names of what acts at places.
    Oscilos(Box<FlowChain>, Vec<(usize, String)>),
    /// A model of a study at an operating point.
    Point(Box<Spectrum>),
}

impl Given {
    /// The chain to ask and its laws, or the answers that are there already.
    fn chain(&self) -> Result<(&dyn Chain, &dyn Coefficients), &Spectrum> {
        match self {
            Self::File(built, _) => Ok(built.chain()),
            Self::Oscilos(chain, _) => Ok((&**chain, &Constant)),
            Self::Point(spectrum) => Err(spectrum),
        }
    }
}

impl ModeCase {
    fn new(path: &Path, region: Region, given: Given, remedy: &'static str) -> Self {
        let (title, warnings, note, devices) = (None, Vec::new(), None, Vec::new());
        Self { path: path.to_owned(), title, region, passive: false, warnings, note, devices, given, remedy }
    }

    /// A network file, or the `rig.toml` of a study at the medians of its priors; frequencies (Hz) between
    /// `limits` where they are given.
    pub fn file(path: &Path, limits: [Option<f64>; 2]) -> Result<Self, Failed> {
        let text = rijke_numerics::read_text(path).or_bad_input().map_err(|failure| {
            failure.at(path).remedy("Name a network file; docs/network-file.md shows one.")
        })?;
        let mut built = match read(&text) {
            Ok(built) => built,
            Err(
                error @ (FileError::Syntax { .. }
                | FileError::Element { problem: ElementProblem::Keys { .. }, .. }),
            ) => {
                return Self::rig(path, &text, limits, &error.to_string());
            }
            // What both kinds of file have is refused in both.
            Err(error) => return Err(Failed::bad_input(error.to_string()).at(path)),
        };
        let network = &built.network;
        let mut devices: Vec<f64> = built.places.iter().map(|(place, _)| network.position(*place)).collect();
        devices.dedup();
        let warnings = built.warnings.iter().map(ToString::to_string).collect();
        let (title, region, passive) = (built.name.take(), built.region, built.passive);
        let given = Given::File(Box::new(built), text);
        let remedy = "Change the region with [search], --min-hz or --max-hz, or the element named.";
        Ok(Self { title, passive, warnings, devices, ..Self::new(path, region, given, remedy) })
    }

    /// A rig as studies have it, with quantities, formulas and unknowns; `error` says why it is no plain
    /// network file.
    fn rig(path: &Path, text: &str, limits: [Option<f64>; 2], error: &str) -> Result<Self, Failed> {
        const REMEDY: &str = "If the name is a factor of a campaign beside this file, add --point ID; if it is an unknown number, give it a table [unknown.NAME] with a prior.";
        let study = Study::of_rig(path).map_err(|of_the_study| {
            // A file of studies, or one whose numbers have units.
            let text_of_a_number = error.split("the text \"").nth(1).unwrap_or_default();
            let with_unit = text_of_a_number.starts_with(|c: char| c.is_ascii_digit());
            let of_studies = ["[microphones]", "[unknown.", "$"].iter().any(|mark| text.contains(mark));
            if of_studies || with_unit {
                let of_the_study = of_the_study.to_string();
                let needs_a_point = of_the_study.contains("factor");
                let failure = Failed::bad_input(of_the_study);
                if needs_a_point { failure.remedy(REMEDY) } else { failure }
            } else {
                Failed::bad_input(error).at(path)
            }
        })?;
        let (region, spectrum, devices, _) =
            modes_at(&study, None, None, 0, limits).map_err(|e| match text.contains('$') {
                true => of_the_engine(&e, path).remedy(REMEDY),
                false => of_the_engine(&e, path),
            })?;
        let unknowns: Vec<&str> = study.rig.own.parameters.iter().map(|p| p.name.as_str()).collect();
        let at_medians = (!unknowns.is_empty())
            .then(|| format!("unknown numbers are at the medians of their priors: {}", unknowns.join(", ")));
        let doubts = doubts_of(&study)
            .into_iter()
            .map(|said| said.strip_prefix("rig.toml: ").unwrap_or(&said).to_owned());
        let warnings = at_medians.into_iter().chain(doubts).collect();
        let (title, given) = (Some(study.rig.name), Given::Point(Box::new(spectrum)));
        let remedy = "Change the region with [search] of the file.";
        Ok(Self { title, warnings, devices, ..Self::new(path, region, given, remedy) })
    }

    /// Inputs of OSCILOS_lite.
    pub fn oscilos(folder: &Path) -> Result<Self, Failed> {
        let inputs = folder.join("Inputs");
        let path = if inputs.is_dir() { inputs } else { folder.to_path_buf() };
        let text = |name: &str| {
            let file = path.join(name);
            rijke_numerics::read_text(&file).or_bad_input().map_err(|failure| {
                failure.at(&file).remedy("Name the folder that holds the inputs of OSCILOS_lite.")
            })
        };
        let texts = OscilosTexts {
            geometry: text("Geometry.txt")?,
            mean_flow: text("Mean_flow.txt")?,
            flame: if path.join("Flame.txt").exists() { Some(text("Flame.txt")?) } else { None },
            inlet: text("Inlet.txt")?,
            outlet: text("Outlet.txt")?,
            scan_range: text("Scan_range.txt")?,
        };
        let (chain, region) = read_oscilos(&texts).or_bad_input().map_err(|failure| failure.at(&path))?;
        let (mut x, mut names, mut devices) = (0.0, Vec::new(), Vec::new());
        for (place, duct) in chain.ducts().iter().enumerate() {
            if !duct.actions.is_empty() || duct.ratio != 1.0 {
                names.push((place, "flame".to_owned()));
                devices.push(x);
            }
            x += duct.length;
        }
        // Kinds 11 and 12 are open ends, of which that program evaluates a fit.
        let kind = |text: &str| text.lines().nth(1)?.split_whitespace().next()?.parse::<f64>().ok();
        let open = [&texts.inlet, &texts.outlet].into_iter().filter_map(|text| kind(text)).any(|k| k >= 11.0);
        let mut warnings = Vec::from_iter(open.then(|| OPEN_END.to_owned()));
        warnings.extend(doubts_of_oscilos(&texts));
        let given = Given::Oscilos(Box::new(chain), names);
        let remedy = "Change Scan_range.txt, or give --min-hz and --max-hz.";
        Ok(Self { warnings, devices, ..Self::new(&path, region, given, remedy) })
    }

    /// A point of a study, by the model of `stage`; without one, by that of the last ranked stage of which it
    /// is a point, or, where it is none of any, of the last stage of all.
    pub fn point(
        dir: &Path,
        id: &str,
        stage: Option<&str>,
        limits: [Option<f64>; 2],
    ) -> Result<Self, Failed> {
        let study = open_study(dir)?;
        of_modes(&study)?;
        let there = dir.join("observations").is_dir();
        let observed = there.then(|| observations(&study)).transpose()?;
        if let Some(name) = stage.filter(|name| study.plan.stage(name).is_none()) {
            return Err(no_stage(name, &study.plan, dir));
        }
        let Some((k, point)) = study.campaign.point(id) else {
            let all: Vec<&str> = study.campaign.points.iter().map(|p| p.id.as_str()).collect();
            return Err(Failed::bad_input(format!("there is no operating point called `{id}`"))
                .at(&dir.join(&study.campaign.file))
                .remedy(format!("Give one of its names: {}", few(&all, 8))));
        };
        let last = study.plan.stages.last().map(|s| s.id.as_str());
        // The laws of another stage may be those of another rig.
        let of_it = |s: &&Stage| s.points.holds(&study.campaign, point);
        let ranked = |name: &&str| dir.join("results/models").join(format!("{name}.json")).is_file();
        let own = || study.plan.stages.iter().rev().filter(of_it).map(|s| s.id.as_str()).find(ranked);
        let found = || own().or(last.filter(ranked));
        let name = stage.or_else(found);
        let model: Option<SavedModel> = name.map(|name| kept(dir, "models", name)).transpose()?;
        let (region, spectrum, devices, temperature) =
            modes_at(&study, observed.as_ref(), model.as_ref(), k, limits)
                .map_err(|e| of_the_engine(&e, dir))?;
        let by = match &model {
            Some(model) => {
                let all = model.candidates.values().cloned().collect::<Vec<_>>().join(", ");
                match name.filter(|name| Some(*name) != last) {
                    Some(earlier) => format!("{all} (of stage `{earlier}`)"),
                    None => all,
                }
            }
            None => "the first candidates, at the centre of their priors".to_owned(),
        };
        let [stated, counts] = temperature;
        let note = model.is_some().then(|| {
            let shared = if (counts - stated).abs() > 1e-9 {
                format!("{counts:.3} K at x = 0 as corrected by the training ({stated:.3} K as stated)")
            } else {
                format!("{stated:.3} K at x = 0 as stated, errors of factors as inferred by the training")
            };
            format!(
                "most probable parameters, gas of {shared}; `rijke predict` gives the same modes to first order in these errors, \
                 with their uncertainty"
            )
        });
        let title = Some(format!("{} at {id}, by {by}", study.plan.name));
        let (warnings, given) = (doubts_of(&study), Given::Point(Box::new(spectrum)));
        let remedy = "Change the region with [search] of rig.toml, --min-hz or --max-hz.";
        Ok(Self { title, warnings, note, devices, ..Self::new(dir, region, given, remedy) })
    }

    pub(super) fn bad<T>(&self, outcome: Result<T, NetworkError>) -> Result<T, Failed> {
        outcome.or_bad_input().map_err(|failure| failure.at(&self.path).remedy(self.remedy))
    }

    pub(super) fn modes(&self) -> Result<Modes, Failed> {
        self.bad(match self.given.chain() {
            Ok((chain, laws)) => chain.modes(laws, &self.region, &mut Workspace::default()),
            Err(known) => Ok(known.modes.clone()),
        })
    }

    /// Poles of laws within the region: growth rate and frequency.
    pub fn poles(&self) -> Result<Vec<[f64; 2]>, Failed> {
        let poles: Vec<C64> = self.bad(match self.given.chain() {
            Ok((chain, laws)) => {
                chain.poles(laws, &self.region).map(|all| all.into_iter().map(|p| p.0).collect())
            }
            Err(known) => Ok(known.poles.clone()),
        })?;
        let inside = poles.into_iter().filter(|s| self.region.contains(*s));
        Ok(inside.map(|s| [s.re, s.im / (2.0 * PI)]).collect())
    }

    /// Shape of a mode and sensitivities of its growth rate along x.
    pub fn curves(&self, mode: &Mode) -> Result<ModeCurves, Failed> {
        let stations = match self.given.chain() {
            Ok((chain, laws)) => {
                let samples = samples_of_each(chain.count());
                chain.along(laws, &mode.root(), samples, &mut Workspace::default())
            }
            Err(known) => Ok(known.of(mode).map_or_else(Vec::new, |m| m.stations.clone())),
        }
        .or_failed()?;
        Ok(ModeCurves::of(mode.s, &stations))
    }
}
