//! Candidates of one role, trained on the same points and ranked.

use crate::{CurvePoint, Evidence, MeasuredPoint, ParameterValue, ProngModel, StudyError};
use rayon::prelude::*;
use rijke_candidates::Candidate;
use rijke_inference::{AssessOptions, MapOptions, Parameter, RefereeKind, TrustRegion};
use rijke_model::{
    Assembly, Conditions, Knowledge, Misfit, Noise, Observed, PointModel, Trained, Training, Varying,
    Workspace, train,
};
use rijke_numerics::{Order, Streams};
use rijke_rig::{ChannelErrors, Rig};

/// Number of positions at which the lines of a figure are computed.
const LINE_POINTS: usize = 121;

/// What a stage hands to the next: the candidates in use and what is known of their parameters.
#[derive(Clone, Debug)]
pub struct Stage {
    /// One candidate per role.
    pub candidates: Vec<Candidate>,
    /// Their parameters.
    pub knowledge: Knowledge,
}

/// One row of a table: the model with some candidates of its own.
pub(crate) struct Competitor {
    pub(crate) id: String,
    pub(crate) label: String,
    /// The candidates in question, whose laws the row shows.
    pub(crate) own: Vec<Candidate>,
    /// All others of the model.
    pub(crate) base: Vec<Candidate>,
    /// What earlier stages found.
    pub(crate) known: Vec<Knowledge>,
}

impl Competitor {
    /// One candidate on top of an earlier stage.
    pub(crate) fn new(own: &Candidate, stage: &Stage) -> Self {
        let (id, label) = (own.id.clone(), own.name.clone());
        let (base, known) = (stage.candidates.clone(), vec![stage.knowledge.clone()]);
        Self { id, label, own: vec![own.clone()], base, known }
    }

    /// What the next stage starts from if this row is chosen.
    pub(crate) fn stage(&self, trained: &Trained) -> Stage {
        let candidates = [self.base.as_slice(), &self.own].concat();
        Stage { candidates, knowledge: trained.knowledge() }
    }

    pub(crate) fn assembly(&self, rig: &Rig) -> Result<Assembly, StudyError> {
        Ok(Assembly::new(rig.clone(), [self.base.as_slice(), &self.own].concat())?)
    }
}

/// Which models compete, on which points.
pub(crate) struct Competition<'a> {
    pub(crate) rig: &'a Rig,
    /// The competitors, in the order of the table.
    pub(crate) competing: Vec<Competitor>,
    /// ln BFL, ln OF and ln ML of the published rows, which come first.
    pub(crate) published: &'a [[f64; 3]],
    /// Whether each evidence is checked by other starts, importance sampling and doubled priors, which costs some
    /// hundred calls of the model.
    pub(crate) depth: Depth,
    /// What is assumed of the misfit.
    pub(crate) noise: Noise,
    /// Whether the errors of the base states enter.
    pub(crate) base_errors: bool,
    /// Parameters that vary between settings of the rig.
    pub(crate) varying: Vec<Varying>,
    /// What the pings share of the channels' calibration.
    pub(crate) channels: Option<&'a ChannelErrors>,
    /// Whether predictions are wanted between the shown points, which must then be cold.
    pub(crate) line: bool,
    /// All points of the figure.
    pub(crate) shown: &'a [Observed],
    /// The points that train.
    pub(crate) trained_on: &'a [Observed],
}

/// How far an evidence is checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Depth {
    /// Laplace's method alone.
    #[default]
    Evidence,
    /// Other starts, importance sampling and doubled priors as well: some hundred calls of the model.
    Thorough,
    /// A referee too, to a statistical error in nats.
    Refereed(RefereeKind, f64),
}

impl From<bool> for Depth {
    fn from(thorough: bool) -> Self {
        if thorough { Self::Thorough } else { Self::Evidence }
    }
}

/// On what terms models compete: how far each evidence is checked, and which candidates of the user's own take part.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// How far each evidence is checked.
    pub depth: Depth,
    /// Candidates beside those of the project; those whose role a stage does not rank are left to the other stages.
    pub own: Vec<Candidate>,
}

/// The roles whose candidates compete, one stage each; of all other roles the project has one candidate in use.
pub const COMPETING_ROLES: [&str; 3] = ["prongs", "heater", "heat-release"];

impl From<Depth> for Terms {
    fn from(depth: Depth) -> Self {
        Self { depth, own: Vec::new() }
    }
}

impl From<bool> for Terms {
    fn from(thorough: bool) -> Self {
        Depth::from(thorough).into()
    }
}

impl Terms {
    /// The user's own candidates of one role.
    pub(crate) fn own(&self, role: &str) -> impl Iterator<Item = &Candidate> {
        self.own.iter().filter(move |c| c.role == role)
    }
}

impl Depth {
    fn referee(self) -> Option<(RefereeKind, f64)> {
        if let Self::Refereed(kind, error) = self { Some((kind, error)) } else { None }
    }
}

impl Competition<'_> {
    /// Trains every competitor; rows in the order of the table, each with what was trained, if it was.
    ///
    /// # Errors
    /// A model that cannot be assembled. One that cannot be fitted is a row without evidence.
    pub(crate) fn run(&self) -> Result<Vec<(ProngModel, Option<Trained>)>, StudyError> {
        self.competing.par_iter().enumerate().map(|(k, competitor)| self.row(competitor, k)).collect()
    }

    fn row(
        &self,
        competitor: &Competitor,
        index: usize,
    ) -> Result<(ProngModel, Option<Trained>), StudyError> {
        let assembly = competitor.assembly(self.rig)?;
        let search = gauss_newton();
        let checks = AssessOptions {
            search: search.search,
            // One stream per candidate: a further row must not change the others.
            streams: Streams::new(u64::from_le_bytes(*b"evidence")),
            referee: self.depth.referee(),
            ..AssessOptions::default()
        };
        let training = Training {
            microphones: (0..self.rig.microphones.positions.len()).collect(),
            noise: self.noise,
            known: competitor.known.clone(),
            search,
            base_errors: self.base_errors,
            varying: self.varying.clone(),
            channels: self.channels.cloned(),
            checks: (self.depth != Depth::Evidence).then_some(checks),
        };
        let published = self.published.get(index).copied().map(evidence);
        let effects = competitor.own.iter().flat_map(|c| &c.effects);
        let laws = effects.map(|e| (format!("{:?} at {:?}", e.coefficient, e.place), e.law.text()));
        let mut row = ProngModel {
            id: competitor.id.clone(),
            number: published.and(u32::try_from(index + 1).ok()),
            label: competitor.label.clone(),
            laws: laws.collect(),
            parameters: Vec::new(),
            growth_rate_noise_sd: 0.0,
            angular_frequency_noise_sd: 0.0,
            pressure_noise_sd: 0.0,
            at_points: Vec::new(),
            line: Vec::new(),
            evidence: None,
            remark: None,
            published,
        };
        let trained = match train(&assembly, self.trained_on, &training) {
            Ok(trained) => trained,
            Err(error) => {
                row.remark = Some(error.to_string());
                return Ok((row, None));
            }
        };
        row.evidence = Some(evidence(trained.evidence.per_datapoint()));
        row.parameters = parameter_values(&trained);
        let said = trained.referee.iter().map(ToString::to_string);
        let remarks: Vec<String> = trained.warnings.iter().cloned().chain(said).collect();
        row.remark = Some(remarks.join("; ")).filter(|w| !w.is_empty());
        [row.growth_rate_noise_sd, row.angular_frequency_noise_sd, row.pressure_noise_sd] =
            Misfit::of(&trained.noise).measured;
        (row.at_points, row.line) = self.curves(&assembly, &trained.values[..trained.own])?;
        Ok((row, Some(trained)))
    }

    /// The prediction at every shown point, and along the line between the first and the last.
    fn curves(
        &self,
        assembly: &Assembly,
        values: &[f64],
    ) -> Result<(Vec<CurvePoint>, Vec<CurvePoint>), StudyError> {
        let work = &mut Workspace::default();
        let mut at = |conditions: &Conditions, near: &Observed, x: f64| -> Result<CurvePoint, StudyError> {
            let reference = self.rig.microphones.reference;
            let point = PointModel::new(assembly, conditions, &[reference])?.starting_from(near.ping.s);
            let s = point.respond(values, Order::Value, work)?.s.value();
            Ok(CurvePoint { position_m: x, growth_rate: s.re, angular_frequency: s.im })
        };
        let mut ordered: Vec<&Observed> = self.shown.iter().collect();
        ordered.sort_by(|a, b| position(a).total_cmp(&position(b)));
        let points =
            self.shown.iter().map(|o| at(&o.conditions, o, position(o))).collect::<Result<_, _>>()?;
        let (true, Some(first), Some(last)) = (self.line, ordered.first(), ordered.last()) else {
            return Ok((points, Vec::new()));
        };
        let (from, to) = (position(first), position(last));
        let mut line = Vec::new();
        for k in 0..LINE_POINTS {
            let x = from + (to - from) * k as f64 / (LINE_POINTS - 1) as f64;
            let after = ordered.iter().position(|o| position(o) >= x).unwrap_or(ordered.len() - 1);
            let (left, right) = (ordered[after.saturating_sub(1)], ordered[after]);
            let (x0, x1) = (position(left), position(right));
            let share = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 1.0 };
            let (t0, t1) = (left.conditions.ambient, right.conditions.ambient);
            // As the neighbour above, but here: only the empty tube has no position.
            let mut place = right.conditions.point.clone();
            place.position = Some(x).filter(|x| *x > 0.0);
            let conditions = Conditions::cold(self.rig, place, t0 + (t1 - t0) * share, 0.0)?;
            line.push(at(&conditions, right, x)?);
        }
        Ok((points, line))
    }
}

/// Newton's search, which `rijke_model` does with Gauss and Newton's matrix, to 1e-5 posterior standard deviations.
pub(crate) fn gauss_newton() -> MapOptions {
    let options = MapOptions::default();
    MapOptions { search: TrustRegion { tolerance: 1e-10, ..options.search }, ..options }
}

/// Where the prongs end; 0 for the empty tube.
pub(crate) fn position(observed: &Observed) -> f64 {
    observed.conditions.point.position.unwrap_or(0.0)
}

/// The error of a table in which nothing could be fitted.
pub(crate) fn no_winner(models: &[ProngModel]) -> StudyError {
    StudyError::NoWinner { remark: models.iter().find_map(|m| m.remark.clone()).unwrap_or_default() }
}

pub(crate) fn measured(observed: &Observed) -> MeasuredPoint {
    let Observed { conditions, ping } = observed;
    MeasuredPoint {
        id: conditions.point.id.clone(),
        position_m: position(observed),
        growth_rate: ping.s.re,
        growth_rate_sd: ping.covariance[(0, 0)].sqrt(),
        angular_frequency: ping.s.im,
        angular_frequency_sd: ping.covariance[(1, 1)].sqrt(),
        ambient_temperature: conditions.ambient,
    }
}

pub(crate) fn parameter_values(trained: &Trained) -> Vec<ParameterValue> {
    let numbers = trained.values.iter().zip(trained.sd());
    let value = |(p, (&value, sd)): (&Parameter, (&f64, f64))| ParameterValue {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.clone(),
        value,
        sd,
    };
    trained.parameters[..trained.own].iter().zip(numbers).map(value).collect()
}

fn evidence([ln_best_fit, ln_occam, ln_marginal]: [f64; 3]) -> Evidence {
    Evidence { ln_best_fit, ln_occam, ln_marginal }
}

/// ln ML per datapoint; minus infinity without evidence.
pub(crate) fn marginal(model: &ProngModel) -> f64 {
    model.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal)
}

/// The published model with the highest marginal likelihood, with its place. Candidates beyond the paper are ranked
/// beside the table, and do not change it.
pub(crate) fn winner(models: &[ProngModel]) -> Option<(usize, &ProngModel)> {
    models
        .iter()
        .enumerate()
        .filter(|(_, m)| m.published.is_some())
        .max_by(|a, b| marginal(a.1).total_cmp(&marginal(b.1)))
}

/// Evidence in nats below which a lead does not decide.
pub(crate) const DECIDES: f64 = 3.0;

/// The first row of all, candidates beyond the paper included, that is within [`DECIDES`] of the best on `points` points:
/// where the evidence does not decide, what comes first in the table goes on.
pub(crate) fn first_of_the_best(models: &[ProngModel], points: usize) -> Option<usize> {
    let total = |m: &ProngModel| marginal(m) * points as f64;
    let best = models.iter().map(total).fold(f64::NEG_INFINITY, f64::max);
    models.iter().position(|m| m.evidence.is_some() && total(m) > best - DECIDES)
}

/// Kendall's tau between our order and the published one, over the published models.
pub(crate) fn agreement(models: &[ProngModel]) -> f64 {
    let both: Vec<[f64; 2]> =
        models.iter().filter_map(|m| m.published.map(|p| [marginal(m), p.ln_marginal])).collect();
    let order = |a: f64, b: f64| f64::from(a.total_cmp(&b) as i8);
    let signs: Vec<f64> = (0..both.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| order(both[i][0], both[j][0]) * order(both[i][1], both[j][1]))
        .collect();
    if signs.is_empty() { 1.0 } else { signs.iter().sum::<f64>() / signs.len() as f64 }
}
