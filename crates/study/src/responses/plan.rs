//! Stages that train on responses: `[[responses]]` of `study.toml`.

use crate::error::EARLIER;
use crate::plan::{SdSpec, Selection};
use crate::source::listed;
use crate::{Campaign, Catalogue, StudyProblem};
use rijke_inference::Kernel;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Some responses train some candidates.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseStage {
    /// Its name.
    pub id: String,
    /// What it is called in tables; its name if empty.
    #[serde(default)]
    pub title: String,
    /// The points whose responses train.
    #[serde(default)]
    pub points: Selection,
    /// Earlier stages of responses whose posterior is the prior here.
    #[serde(default)]
    pub on: Vec<String>,
    /// Role and candidate: what the model consists of, besides what competes.
    #[serde(default)]
    pub with: BTreeMap<String, String>,
    /// The roles whose candidates compete, in all combinations; none for a stage that trains one model.
    #[serde(default)]
    pub compete: Vec<String>,
    /// Which of them; all if empty.
    #[serde(default)]
    pub among: Vec<String>,
    /// Parameters held at a value.
    #[serde(default)]
    pub hold: BTreeMap<String, f64>,
    /// Nats below which a lead does not decide.
    #[serde(default = "five")]
    pub decides: f64,
    /// Frequencies from and to, Hz; all if absent.
    pub band_hz: Option<[f64; 2]>,
    /// Distance of the frequencies that are taken, Hz; all if absent.
    pub step_hz: Option<f64>,
    /// Of pressures only those at these microphones; all if empty.
    #[serde(default)]
    pub microphones: Vec<String>,
    /// The factor whose value the responses share that one instrument measured in one state: its errors are
    /// the same in all of them.
    pub session: Option<String>,
    /// Whether delays and gains of the channels are found together with the model; if absent, where their
    /// errors are stated.
    pub channels: Option<bool>,
    /// Independent noise of the real and of the imaginary part of each number.
    #[serde(default = "floated")]
    pub noise: SdSpec,
    /// Whether noise that floats has a part in proportion to the modulus; as the data ask for it if absent.
    pub noise_in_proportion: Option<bool>,
    /// An error of the model that is correlated along frequency; none if absent.
    pub misfit: Option<MisfitSpec>,
    /// Whether other maxima of the posterior are looked for and the evidence is checked: some hundred calls
    /// of the model.
    #[serde(default)]
    pub checked: bool,
}

/// A model error, independent for every response and for real and imaginary part, that is a smooth random
/// function of frequency.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MisfitSpec {
    /// Its standard deviation.
    pub size: SdSpec,
    /// Its correlation length, Hz.
    pub length_hz: SdSpec,
    /// Its smoothness.
    #[serde(default = "smooth")]
    pub kernel: Kernel,
}

fn five() -> f64 {
    5.0
}

fn floated() -> SdSpec {
    SdSpec::Floated
}

fn smooth() -> Kernel {
    Kernel::Matern52
}

impl ResponseStage {
    /// Checks that everything it names exists.
    pub(crate) fn check(
        &self,
        campaign: &Campaign,
        catalogue: &Catalogue,
        earlier: &[Self],
    ) -> Result<(), StudyProblem> {
        let value =
            |key: &str, value: String, need| Err(StudyProblem::Value { key: key.into(), value, need });
        let known_stages = || listed(earlier.iter().map(|s| s.id.as_str()));
        if earlier.iter().any(|s| s.id == self.id) {
            return Err(StudyProblem::Duplicate { what: "stage", name: self.id.clone() });
        }
        if let Some(id) = self.on.iter().find(|id| !earlier.iter().any(|s| s.id == **id)) {
            return Err(StudyProblem::Unknown { what: EARLIER, name: id.clone(), known: known_stages() });
        }
        self.points.check(campaign)?;
        if let Some(factor) = &self.session {
            campaign.known_factor(factor)?;
        }
        self.compete.iter().try_for_each(|role| catalogue.known_role(role))?;
        self.with.iter().try_for_each(|(role, id)| catalogue.of_role(role, id).map(|_| ()))?;
        for id in &self.among {
            if catalogue.get(id).is_none() {
                let known = listed(catalogue.candidates().iter().map(|c| c.id.as_str()));
                return Err(StudyProblem::Unknown { what: "candidate", name: id.clone(), known });
            }
        }
        catalogue.among_all(&self.compete, &self.among)?;
        if !(self.decides >= 0.0 && self.decides.is_finite()) {
            return value("decides", self.decides.to_string(), "a number of nats, zero or more");
        }
        let of_misfit =
            self.misfit.iter().flat_map(|m| [("misfit.size", &m.size), ("misfit.length_hz", &m.length_hz)]);
        for (key, sd) in [("noise", &self.noise)].into_iter().chain(of_misfit) {
            if matches!(sd, SdSpec::Like { .. }) {
                let need = "\"floated\", a number or { median, ln_sd }: `like` is of stages of modes";
                return value(key, "{ like = ... }".to_owned(), need);
            }
        }
        if let Some([low, high]) = self.band_hz
            && !(low >= 0.0 && low < high)
        {
            return value("band_hz", format!("[{low}, {high}]"), "two ascending frequencies in Hz");
        }
        if let Some(step) = self.step_hz.filter(|step| !(*step > 0.0 && step.is_finite())) {
            return value("step_hz", step.to_string(), "positive, Hz");
        }
        Ok(())
    }
}
