//! From the text of `study.toml` to a plan that names only what exists.

use super::ids::{known_stage, or_later, short_id};
use super::maps::MapFile;
use super::stands::{counted_once, known_ground};
use super::{Base, Cost, HeatedFlow, NoiseSpec, Plan, Prefer, SdSpec, Selection, Stage};
use crate::error::EARLIER;
use crate::rig::Shape;
use crate::source::{Source, listed};
use crate::{Campaign, Catalogue, Rig, StudyError, StudyProblem};
use rijke_rig::Given;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

impl Plan {
    /// Reads `study.toml`.
    ///
    /// # Errors
    /// File, line and remedy; every name is checked against the rig, the campaign and the candidates.
    pub fn read(
        path: &Path,
        rig: &Rig,
        campaign: &Campaign,
        catalogue: &Catalogue,
    ) -> Result<Self, StudyError> {
        Self::parse(&Source::read(path)?, rig, campaign, catalogue)
    }

    pub(crate) fn parse(
        source: &Source,
        rig: &Rig,
        campaign: &Campaign,
        catalogue: &Catalogue,
    ) -> Result<Self, StudyError> {
        let file: File = source.toml()?;
        let base_at = file.base.as_ref().map_or(0, |base| base.span().start);
        let base = file.base.map(Spanned::into_inner).unwrap_or_default();
        let fail = |(key, problem)| source.fail(source.key_after(base_at, key), problem);
        match &base {
            Base::Ambient | Base::Rig => {}
            Base::States(points) => {
                points.check(campaign).map_err(|problem| source.fail(base_at, problem))?;
            }
            Base::HeatedFlow(heated) => {
                Check { rig, campaign, catalogue }.heated(heated).map_err(fail)?;
            }
            Base::Measured(measured) => measured.check(campaign).map_err(fail)?,
        }
        base.suits(rig).map_err(|problem| source.fail(0, problem))?;
        let (name, question) = (file.name, file.question);
        let erring = |factor: &crate::Factor| {
            let k = campaign.factor(&factor.name);
            k.is_some_and(|k| campaign.points.iter().any(|p| p.factor_sds[k] > 0.0))
        };
        let known = || listed(campaign.factors.iter().filter(|f| erring(f)).map(|f| f.name.as_str()));
        let common = |name: Spanned<String>| {
            let (at, name) = (name.span().start, name.into_inner());
            if campaign.factors.iter().any(|f| f.name == name && erring(f)) {
                return Ok(name);
            }
            let what = "factor with a standard deviation";
            Err(source.fail(at, StudyProblem::Unknown { what, name, known: known() }))
        };
        let common_errors = file.common_errors.into_iter().map(common).collect::<Result<_, _>>()?;
        let cost = file.cost.map(|cost| {
            let at = cost.span().start;
            cost.into_inner().cost().map_err(|problem| source.fail(at, problem))
        });
        let mut plan = Self {
            name,
            question,
            base,
            stages: Vec::new(),
            responses: Vec::new(),
            questions: Vec::new(),
            maps: Vec::new(),
            cost: cost.transpose()?,
            common_errors,
        };
        let of_responses = file.responses.iter().map(|stage| stage.get_ref().id.clone());
        let of_modes = file.stage.iter().map(|stage| stage.get_ref().id.clone());
        let ids: Vec<String> = of_responses.chain(of_modes).collect();
        for stage in file.responses {
            let at = stage.span().start;
            let stage = stage.into_inner();
            short_id(&stage.id).map_err(|problem| source.fail(at, problem))?;
            let checked = stage.check(campaign, catalogue, &plan.responses);
            checked
                .and_then(|()| rig.microphones.have(&stage.microphones))
                .map_err(|problem| source.fail(at, or_later(problem, &ids)))?;
            plan.responses.push(stage);
        }
        for stage in file.stage {
            let at = stage.span().start;
            let check = Check { rig, campaign, catalogue };
            let stage = check.stage(stage.into_inner(), &plan);
            let stage = stage.map_err(|problem| source.fail(at, or_later(problem, &ids)))?;
            let laws = plan.ends_have_laws(&stage, rig, catalogue);
            laws.map_err(|problem| source.fail(at, problem))?;
            plan.stages.push(stage);
        }
        if plan.stages.is_empty() && plan.responses.is_empty() {
            return Err(source.fail(0, StudyProblem::Empty { what: "stage", need: "add a [[stage]]" }));
        }
        if !file.asked.is_empty() {
            plan.ask(source, campaign, catalogue)?;
        }
        for map in file.map {
            let at = map.span().start;
            let map = map.into_inner().question(&plan, campaign);
            plan.maps.push(map.map_err(|problem| source.fail(at, problem))?);
        }
        Ok(plan)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    question: String,
    base: Option<Spanned<Base>>,
    #[serde(default)]
    stage: Vec<Spanned<StageFile>>,
    #[serde(default)]
    responses: Vec<Spanned<crate::responses::ResponseStage>>,
    #[serde(default, rename = "ask")]
    asked: Vec<toml::Table>,
    #[serde(default)]
    map: Vec<Spanned<MapFile>>,
    cost: Option<Spanned<CostFile>>,
    #[serde(default)]
    common_errors: Vec<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CostFile {
    point: Given,
    installation: Option<Given>,
}

impl CostFile {
    fn cost(&self) -> Result<Cost, StudyProblem> {
        let seconds = |key: &str, given: &Given, least: f64| {
            let key = format!("cost.{key}");
            let value = given.of("s").map_err(|source| StudyProblem::Unit { key: key.clone(), source })?;
            if value.is_finite() && value >= least {
                return Ok(value);
            }
            Err(StudyProblem::Value {
                key,
                value: value.to_string(),
                need: "a time, of a point at least 1 s",
            })
        };
        let installation = self.installation.as_ref().map(|given| seconds("installation", given, 0.0));
        Ok(Cost {
            point: seconds("point", &self.point, 1.0)?,
            installation: installation.transpose()?.unwrap_or(0.0),
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StageFile {
    id: String,
    title: Option<String>,
    points: Selection,
    #[serde(default)]
    on: OneOrMore,
    #[serde(default)]
    heard_through: OneOrMore,
    #[serde(default)]
    with: BTreeMap<String, String>,
    #[serde(default)]
    without: Vec<String>,
    #[serde(default)]
    compete: OneOrMore,
    #[serde(default)]
    among: Vec<String>,
    #[serde(default)]
    rows: Vec<Vec<String>>,
    #[serde(default)]
    hold: BTreeMap<String, f64>,
    decides: Option<f64>,
    #[serde(default)]
    prefer: Prefer,
    #[serde(default)]
    noise: NoiseSpec,
    noise_of_predictions: Option<NoiseSpec>,
    #[serde(default)]
    base_errors: bool,
    #[serde(default)]
    channels: bool,
    #[serde(default)]
    microphones: Vec<String>,
}

/// Three nats are odds of twenty to one.
const THREE: f64 = 3.0;

#[derive(Default, Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    #[default]
    None,
    One(String),
    More(Vec<String>),
}

impl OneOrMore {
    fn list(self) -> Vec<String> {
        match self {
            Self::None => Vec::new(),
            Self::One(id) => vec![id],
            Self::More(list) => list,
        }
    }
}

struct Check<'a> {
    rig: &'a Rig,
    campaign: &'a Campaign,
    catalogue: &'a Catalogue,
}

impl Check<'_> {
    /// The key that is wrong, and what is wrong with it.
    fn heated(&self, heated: &HeatedFlow) -> Result<(), (&'static str, StudyProblem)> {
        for (key, name, wanted) in [("power", &heated.power, "W"), ("flow", &heated.flow, "m^3/s")] {
            let factor = self.campaign.known_factor(name).map_err(|problem| (key, problem))?;
            let factor = &self.campaign.factors[factor];
            let full = format!("base.heated-flow.{key} = {name}");
            if !factor.stated {
                let value = "a column without unit".to_owned();
                let need =
                    "a factor whose heading in the campaign states its unit, such as Q [W] or flow [L/min]";
                return Err((key, StudyProblem::Value { key: full, value, need }));
            }
            factor.shown.of(wanted).map_err(|source| (key, StudyProblem::Unit { key: full, source }))?;
        }
        for (key, [mean, sd]) in [("share", heated.share), ("cooling", heated.cooling)] {
            if !(mean > 0.0 && sd > 0.0 && mean.is_finite() && sd.is_finite()) {
                let (full, value) = (format!("base.heated-flow.{key}"), format!("[{mean}, {sd}]"));
                let need = "[mean, standard deviation], both positive";
                return Err((key, StudyProblem::Value { key: full, value, need }));
            }
        }
        if !(0.0..=1.0).contains(&heated.cooling_varies) {
            let (full, value) =
                ("base.heated-flow.cooling_varies".to_owned(), heated.cooling_varies.to_string());
            let need = "a relative number from 0, for one constant, to 1";
            return Err(("cooling_varies", StudyProblem::Value { key: full, value, need }));
        }
        if let Some(sd) = heated.offset_sd.filter(|sd| !(sd.is_finite() && *sd >= 0.0)) {
            let (full, value) = ("base.heated-flow.offset_sd".to_owned(), format!("{sd} K"));
            return Err(("offset_sd", StudyProblem::Value { key: full, value, need: "zero or more, in K" }));
        }
        if !(0.0..1.0).contains(&heated.excess_sd) {
            let (full, value) = ("base.heated-flow.excess_sd".to_owned(), heated.excess_sd.to_string());
            let need = "a relative number from 0 to below 1: 0.02 for 2 %";
            return Err(("excess_sd", StudyProblem::Value { key: full, value, need }));
        }
        let devices = || self.rig.parts.iter().filter(|p| matches!(p.shape, Shape::Device(_)));
        if devices().all(|p| p.name != heated.at) {
            let known = listed(devices().map(|p| p.name.as_str()));
            let what = "part between ducts, at which the heat enters,";
            return Err(("at", StudyProblem::Unknown { what, name: heated.at.clone(), known }));
        }
        Ok(())
    }

    fn stage(&self, file: StageFile, plan: &Plan) -> Result<Stage, StudyProblem> {
        short_id(&file.id)?;
        if plan.stage(&file.id).is_some() || plan.response(&file.id).is_some() {
            return Err(StudyProblem::Duplicate { what: "stage", name: file.id });
        }
        file.points.check(self.campaign)?;
        let on = file.on.list();
        let heard_through = file.heard_through.list();
        on.iter().try_for_each(|id| known_ground(plan, id))?;
        heard_through.iter().try_for_each(|id| known_stage(plan, EARLIER, id))?;
        file.with.iter().try_for_each(|(role, id)| self.catalogue.of_role(role, id).map(|_| ()))?;
        let compete = file.compete.list();
        compete.iter().try_for_each(|role| self.catalogue.known_role(role))?;
        for id in file.among.iter().chain(file.rows.iter().flatten()) {
            if self.catalogue.get(id).is_none() {
                let known = listed(self.catalogue.candidates().iter().map(|c| c.id.as_str()));
                return Err(StudyProblem::Unknown { what: "candidate", name: id.clone(), known });
            }
        }
        self.catalogue.among_all(&compete, &file.among)?;
        for noise in [Some(&file.noise), file.noise_of_predictions.as_ref()].into_iter().flatten() {
            noise.check(plan, self.campaign, self.catalogue)?;
        }
        self.rig.microphones.have(&file.microphones)?;
        // Models that responses leave open are not decided here by less.
        let open = on.iter().filter_map(|id| plan.response(id)).map(|r| r.decides).fold(THREE, f64::max);
        let decides = file.decides.unwrap_or(open);
        if !(decides >= 0.0 && decides.is_finite()) {
            let (key, value) = ("decides".into(), decides.to_string());
            return Err(StudyProblem::Value { key, value, need: "a number of nats, zero or more" });
        }
        let stage = Stage {
            title: file.title.unwrap_or_else(|| file.id.clone()),
            id: file.id,
            points: file.points,
            on,
            heard_through,
            with: file.with,
            without: file.without,
            compete,
            among: file.among,
            rows: file.rows,
            hold: file.hold,
            decides,
            prefer: file.prefer,
            noise: file.noise,
            noise_of_predictions: file.noise_of_predictions,
            base_errors: file.base_errors,
            channels: file.channels,
            microphones: file.microphones,
        };
        counted_once(plan, &stage)?;
        Ok(stage)
    }
}

impl NoiseSpec {
    /// Checks that every stage, factor and role that it names exists.
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`].
    pub fn check(&self, plan: &Plan, campaign: &Campaign, catalogue: &Catalogue) -> Result<(), StudyProblem> {
        for sd in self.all() {
            if let SdSpec::Like { stage, .. } = sd {
                known_stage(plan, "stage", stage)?;
            }
        }
        if let Some(law) = &self.law {
            campaign.known_factor(&law.over)?;
            catalogue.known_role(&law.role)?;
        }
        Ok(())
    }
}
