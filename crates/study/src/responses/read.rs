//! From `observations.toml` and the files that it names to responses.

use super::{ObservedResponse, ResponseKind, Responses, columns, doubts, pressures};
use crate::law::Place;
use crate::source::Source;
use crate::{Coefficient, Study, StudyError, StudyProblem};
use rijke_formula::{Context, Formula, Kind};
use rijke_numerics::C64;
use rijke_rig::{DataKind, Elsewhere, Quantity as Number};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    kind: KindOf,
    /// A place; for a transfer the microphone above; of pressures none.
    at: Option<String>,
    /// For pressures: the ends at which waves of unknown pressure enter.
    sources: Option<Vec<String>>,
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
    Pressures,
    Transfer,
    FlameTransferFunction,
}

impl Study {
    /// The responses that `observations/observations.toml` declares.
    ///
    /// # Errors
    /// File, line and remedy; [`StudyProblem::Elsewhere`] if the data are other people's and not here.
    pub fn responses(&self) -> Result<Responses, StudyError> {
        let folder = self.folder.join("observations");
        let source = Source::read(&folder.join("observations.toml"))?;
        let file: File = source.toml()?;
        let data = match &file.measured {
            None => folder.clone(),
            Some(elsewhere) => elsewhere.find().ok_or_else(|| {
                let Elsewhere { variable, folder, obtain } = elsewhere.clone();
                source.fail(0, StudyProblem::Elsewhere { variable, folder, obtain })
            })?,
        };
        let mut all = Responses {
            kind: file.kind,
            source: file.source,
            list: Vec::new(),
            ambient: self.ambient_of_records(&folder)?,
            warnings: Vec::new(),
        };
        for entry in file.response {
            let at = entry.span().start;
            let entry = entry.into_inner();
            let fail = |problem| source.fail(at, problem);
            if entry.kind == KindOf::Pressures {
                for (point, path) in self.places(&entry, &data).map_err(fail)? {
                    self.pressures(&entry, point, &path, &fail, &mut all)?;
                }
                continue;
            }
            let what = self.quantity(&entry).map_err(fail)?;
            let columns = columns::declared(&entry.columns).map_err(fail)?;
            for (point, path) in self.places(&entry, &data).map_err(fail)? {
                let mut rows = columns::read(&path, &columns)?;
                let mut doubt = |said: Option<String>| {
                    all.warnings.extend(said.map(|said| format!("{}: {said}", path.display())));
                };
                doubt(doubts::without_repeats(&mut rows));
                doubt(doubts::phase(&rows));
                doubt(
                    doubts::far(&rows.frequency_hz, self.rig.search[1])
                        .filter(|_| self.rig.search_is_stated[1]),
                );
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
                if entry.kind == KindOf::FlameTransferFunction && entry.coefficient.is_none() {
                    doubt(doubts::gains(&rows));
                }
                if entry.kind != KindOf::Transfer {
                    doubt(doubts::early(&rows));
                }
                let [low, high] = entry.band_hz.unwrap_or([0.0, f64::INFINITY]);
                let keep: Vec<usize> = (0..rows.values.len())
                    .filter(|&k| (low..=high).contains(&rows.frequency_hz[k]))
                    .collect();
                if keep.is_empty() {
                    return Err(fail(OUTSIDE));
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
                    level: Vec::new(),
                };
                self.add(observed, &path, &mut all).map_err(fail)?;
            }
        }
        if all.list.is_empty() {
            return Err(source.fail(0, StudyProblem::Empty { what: "response", need: "add a [[response]]" }));
        }
        let above = self.above_cut_on(&all.list);
        all.warnings
            .extend(above.map(|said| format!("{}: {said}", folder.join("observations.toml").display())));
        Ok(all)
    }

    /// Operating points and files of an entry.
    fn places(&self, entry: &Entry, data: &Path) -> Result<Vec<(usize, PathBuf)>, StudyProblem> {
        let place = |(point, name): (&String, &String)| {
            self.campaign.known_point(point).map(|point| (point, data.join(name)))
        };
        entry.files.iter().map(place).collect()
    }

    /// Adds a response that is not there yet.
    fn add(&self, observed: ObservedResponse, path: &Path, all: &mut Responses) -> Result<(), StudyProblem> {
        if let Some(frequency_hz) = all.list.iter().find_map(|before| doubts::twice(before, &observed)) {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let point = self.campaign.points[observed.point].id.clone();
            return Err(StudyProblem::Twice { file, point, frequency_hz });
        }
        all.list.push(observed);
        Ok(())
    }

    /// Adds the pressures of a file, a response for every excitation and microphone.
    fn pressures(
        &self,
        entry: &Entry,
        point: usize,
        path: &Path,
        fail: &dyn Fn(StudyProblem) -> StudyError,
        all: &mut Responses,
    ) -> Result<(), StudyError> {
        let sources = match &entry.sources {
            None => vec![Place::Upstream, Place::Downstream],
            Some(names) => names.iter().map(|name| source(name)).collect::<Result<_, _>>().map_err(fail)?,
        };
        if sources.is_empty() || sources.len() > 2 || sources.first() == sources.get(1) {
            let (key, value) =
                ("sources".to_owned(), format!("{:?}", entry.sources.clone().unwrap_or_default()));
            return Err(fail(StudyProblem::Value {
                key,
                value,
                need: "one or both of upstream, downstream",
            }));
        }
        let names = &self.rig.microphones.names;
        let table = pressures::declared(&entry.columns, names, sources.len()).map_err(fail)?;
        let band = entry.band_hz.unwrap_or([0.0, f64::INFINITY]);
        let search = self.rig.search_is_stated[1].then_some(self.rig.search[1]);
        let (list, doubts) = pressures::read(path, &table, band, search)?;
        all.warnings.extend(doubts.iter().map(|said| format!("{}: {said}", path.display())));
        if list.is_empty() {
            return Err(fail(OUTSIDE));
        }
        for heard in list {
            for (microphone, values, sd) in heard.pressures {
                let (excitation, sources) = (heard.excitation.clone(), sources.clone());
                let observed = ObservedResponse {
                    point,
                    what: ResponseKind::Pressure { microphone, excitation, sources },
                    rows: heard.of,
                    frequency_hz: heard.frequency_hz.clone(),
                    values,
                    sd,
                    level: heard.level.clone(),
                };
                self.add(observed, path, all).map_err(fail)?;
            }
        }
        Ok(())
    }

    fn quantity(&self, entry: &Entry) -> Result<ResponseKind, StudyProblem> {
        let value =
            |key: &str, value: &str, need| StudyProblem::Value { key: key.into(), value: value.into(), need };
        let need = "name the place, or the microphone, of the response";
        let named = entry.at.as_ref().ok_or_else(|| StudyProblem::Missing { key: "at".into(), need })?;
        match entry.kind {
            KindOf::Impedance | KindOf::Reflection => {
                let at = Place::parse(named, &self.rig.parts)?;
                if at != Place::Upstream {
                    return Err(value("at", named, "upstream: the port is where the rig begins"));
                }
                let diameter = entry.reference_diameter.as_deref().map(|text| {
                    let fail = |source| StudyProblem::Unit { key: "reference_diameter".into(), source };
                    Number::parse(text).and_then(|number| number.of("m")).map_err(fail)
                });
                let diameter = diameter.transpose()?;
                if let Some(d) = diameter.filter(|d| !(1e-5..=100.0).contains(d)) {
                    return Err(value(
                        "reference_diameter",
                        &format!("{d} m"),
                        "a diameter from 0.01 mm to 100 m",
                    ));
                }
                let area = diameter.map(|d| 0.25 * PI * d * d);
                Ok(ResponseKind::Reflection { at, reference_area: area })
            }
            KindOf::Pressures | KindOf::Transfer => {
                let microphone = |name: &str| {
                    let names = &self.rig.microphones.names;
                    self.rig.microphones.have(&[name.to_owned()])?;
                    Ok::<_, StudyProblem>(names.iter().position(|n| n == name).unwrap_or(0))
                };
                let over = entry.over.as_deref().ok_or_else(|| StudyProblem::Missing {
                    key: "over".into(),
                    need: "name the microphone by which is divided",
                })?;
                let (to, from) = (microphone(named)?, microphone(over)?);
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
                let at = Place::parse(named, &self.rig.parts)?;
                let name = entry.coefficient.as_deref().unwrap_or("eu");
                let coefficient = Coefficient::ALL.iter().find(|(known, _)| *known == name).map(|(_, c)| *c);
                let coefficient = coefficient.ok_or_else(|| StudyProblem::Unknown {
                    what: "coefficient",
                    name: name.to_owned(),
                    known: Coefficient::ALL.map(|c| c.0).join(", "),
                })?;
                let here = |name: usize| self.rig.scope.names()[name].kind == Kind::Global;
                let text = entry.factor.as_deref().unwrap_or("-1");
                let own = crate::law::named_in(text, &self.rig.own_numbers(&at));
                let context =
                    Context { scope: &self.rig.scope, here: &here, parameters: &[], definitions: &own };
                let factor = Formula::parse(text, &context)
                    .map_err(|source| StudyProblem::Formula { key: "factor".into(), source })?;
                Ok(ResponseKind::Law { at, coefficient, factor })
            }
        }
    }
}

/// What is said of a band without a frequency of the file.
const OUTSIDE: StudyProblem = StudyProblem::Empty {
    what: "frequency of the file in the band",
    need: "choose `band_hz` so that it holds some frequencies",
};

/// An end at which a wave of unknown pressure enters.
fn source(name: &str) -> Result<Place, StudyProblem> {
    match name {
        "upstream" => Ok(Place::Upstream),
        "downstream" => Ok(Place::Downstream),
        other => Err(StudyProblem::Unknown {
            what: "source",
            name: other.to_owned(),
            known: "upstream, downstream".to_owned(),
        }),
    }
}
