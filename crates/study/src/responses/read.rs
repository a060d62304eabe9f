//! From `observations.toml` and the files that it names to responses.

use super::{ObservedResponse, ResponseKind, Responses, columns, doubts};
use crate::rig::Place;
use crate::source::{Source, listed};
use crate::{Coefficient, Problem, Study, StudyError};
use rijke_formula::{Context, Formula, Kind};
use rijke_numerics::C64;
use rijke_rig::{DataKind, Quantity as Number};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::PathBuf;
use toml::{Spanned, Value as Toml};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    kind: DataKind,
    source: String,
    measured: Option<Elsewhere>,
    #[serde(default)]
    response: Vec<Spanned<Entry>>,
}

/// Data that are not part of the study.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Elsewhere {
    /// The environment variable that names the folder of all such data.
    variable: String,
    /// The folder within.
    folder: String,
    /// How to get them.
    obtain: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    kind: KindOf,
    /// A place; for a transfer the microphone above.
    at: String,
    /// For a transfer: the microphone below.
    over: Option<String>,
    /// For a law.
    coefficient: Option<String>,
    factor: Option<String>,
    /// Operating point and file.
    files: BTreeMap<String, String>,
    columns: Toml,
    reference_diameter: Option<String>,
    /// Frequencies that the instrument is made for, Hz.
    band_hz: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum KindOf {
    Impedance,
    Reflection,
    Transfer,
    FlameTransferFunction,
}

impl Study {
    /// The responses that `observations/observations.toml` declares.
    ///
    /// # Errors
    /// File, line and remedy; [`Problem::Elsewhere`] if the data are other people's and not here.
    pub fn responses(&self) -> Result<Responses, StudyError> {
        let folder = self.folder.join("observations");
        let source = Source::read(&folder.join("observations.toml"))?;
        let file: File = source.toml()?;
        let data = match &file.measured {
            None => folder,
            Some(elsewhere) => elsewhere.folder(&source)?,
        };
        let mut all =
            Responses { kind: file.kind, source: file.source, list: Vec::new(), warnings: Vec::new() };
        for entry in file.response {
            let at = entry.span().start;
            let entry = entry.into_inner();
            let fail = |problem| source.fail(at, problem);
            let what = self.quantity(&entry).map_err(fail)?;
            let columns = columns::declared(&entry.columns).map_err(fail)?;
            for (point, name) in &entry.files {
                let Some((point, _)) = self.campaign.point(point) else {
                    let known = listed(self.campaign.points.iter().take(8).map(|p| p.id.as_str()));
                    return Err(fail(Problem::Unknown {
                        what: "operating point",
                        name: point.clone(),
                        known,
                    }));
                };
                let path = data.join(name);
                let mut rows = columns::read(&path, &columns)?;
                let mut doubt = |said: Option<String>| {
                    all.warnings.extend(said.map(|said| format!("{}: {said}", path.display())));
                };
                doubt(doubts::without_repeats(&mut rows));
                doubt(doubts::phase(&rows));
                let reflects = |z: &C64| (z - 1.0) / (z + 1.0);
                if entry.kind == KindOf::Impedance {
                    // dR/dz = 2/(z + 1)^2.
                    let spread =
                        rows.sd.iter().zip(&rows.values).map(|(sd, z)| 2.0 * sd / (z + 1.0).norm_sqr());
                    rows.sd = spread.collect();
                    rows.values = rows.values.iter().map(reflects).collect();
                }
                if matches!(entry.kind, KindOf::Impedance | KindOf::Reflection) {
                    doubt(doubts::passive(&rows, &rows.values));
                }
                let [low, high] = entry.band_hz.unwrap_or([0.0, f64::INFINITY]);
                let keep: Vec<usize> = (0..rows.values.len())
                    .filter(|&k| (low..=high).contains(&rows.frequency_hz[k]))
                    .collect();
                if keep.is_empty() {
                    let need = "choose `band_hz` so that it holds some frequencies";
                    return Err(fail(Problem::Empty { what: "frequency of the file in the band", need }));
                }
                doubt(doubts::band(&rows, keep.len(), [low, high]));
                let observed = ObservedResponse {
                    point,
                    what: what.clone(),
                    rows: rows.values.len(),
                    frequency_hz: keep.iter().map(|&k| rows.frequency_hz[k]).collect(),
                    values: keep.iter().map(|&k| rows.values[k]).collect(),
                    sd: if rows.sd.is_empty() {
                        Vec::new()
                    } else {
                        keep.iter().map(|&k| rows.sd[k]).collect()
                    },
                };
                if let Some(f) = all.list.iter().find_map(|before| doubts::twice(before, &observed)) {
                    return Err(fail(Problem::Twice {
                        file: name.clone(),
                        point: self.campaign.points[point].id.clone(),
                        frequency_hz: f,
                    }));
                }
                all.list.push(observed);
            }
        }
        if all.list.is_empty() {
            return Err(source.fail(0, Problem::Empty { what: "response", need: "add a [[response]]" }));
        }
        Ok(all)
    }

    fn quantity(&self, entry: &Entry) -> Result<ResponseKind, Problem> {
        let value =
            |key: &str, value: &str, need| Problem::Value { key: key.into(), value: value.into(), need };
        match entry.kind {
            KindOf::Impedance | KindOf::Reflection => {
                let at = Place::parse(&entry.at, &self.rig.parts)?;
                if at != Place::Upstream {
                    return Err(value("at", &entry.at, "upstream: the port is where the rig begins"));
                }
                let diameter = entry.reference_diameter.as_deref().map(|text| {
                    let fail = |source| Problem::Unit { key: "reference_diameter".into(), source };
                    Number::parse(text).and_then(|number| number.of("m")).map_err(fail)
                });
                let area = diameter.transpose()?.map(|d| 0.25 * PI * d * d);
                Ok(ResponseKind::Reflection { at, reference_area: area })
            }
            KindOf::Transfer => {
                let microphone = |name: &str| {
                    let names = &self.rig.microphones.names;
                    names.iter().position(|n| n == name).ok_or_else(|| Problem::Unknown {
                        what: "microphone",
                        name: name.to_owned(),
                        known: listed(names.iter().map(String::as_str)),
                    })
                };
                let over = entry.over.as_deref().ok_or_else(|| Problem::Missing {
                    key: "over".into(),
                    need: "name the microphone by which is divided",
                })?;
                let (to, from) = (microphone(&entry.at)?, microphone(over)?);
                if to == from {
                    return Err(value(
                        "over",
                        over,
                        "another microphone than `at`: a pressure over itself is 1",
                    ));
                }
                Ok(ResponseKind::Transfer { to, from })
            }
            KindOf::FlameTransferFunction => {
                let at = Place::parse(&entry.at, &self.rig.parts)?;
                let name = entry.coefficient.as_deref().unwrap_or("eu");
                let coefficient = Coefficient::ALL.iter().find(|(known, _)| *known == name).map(|(_, c)| *c);
                let coefficient = coefficient.ok_or_else(|| Problem::Unknown {
                    what: "coefficient",
                    name: name.to_owned(),
                    known: Coefficient::ALL.map(|c| c.0).join(", "),
                })?;
                let here = |name: usize| self.rig.scope.names()[name].kind == Kind::Global;
                let own = self.rig.own_numbers(&at);
                let context =
                    Context { scope: &self.rig.scope, here: &here, parameters: &[], definitions: &own };
                let factor = Formula::parse(entry.factor.as_deref().unwrap_or("-1"), &context)
                    .map_err(|source| Problem::Formula { key: "factor".into(), source })?;
                Ok(ResponseKind::Law { at, coefficient, factor })
            }
        }
    }
}

impl Elsewhere {
    fn folder(&self, source: &Source) -> Result<PathBuf, StudyError> {
        let set = std::env::var_os(&self.variable).filter(|value| !value.is_empty());
        let folder = set.map(|value| PathBuf::from(value).join(&self.folder)).filter(|path| path.is_dir());
        folder.ok_or_else(|| {
            let (variable, folder, obtain) =
                (self.variable.clone(), self.folder.clone(), self.obtain.clone());
            source.fail(0, Problem::Elsewhere { variable, folder, obtain })
        })
    }
}
