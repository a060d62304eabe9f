//! What can go wrong between a study and its numbers.

use rijke_inference::{ForwardError, InferenceError, Stop};
use rijke_network::NetworkError;
use rijke_numerics::{C64, DenseError};
use rijke_study::plan::Selection;
use rijke_study::{Study, StudyError};

/// Why a model cannot be built, trained or asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// A model that was kept on disk is damaged.
    #[error("the model that stage `{stage}` left is damaged; rank the study again")]
    Damaged {
        /// The stage.
        stage: String,
    },
    /// Readings that no flow can have.
    #[error("the gas at the points, by [base] and readings.csv: {problem}")]
    Readings {
        /// What is wrong.
        problem: Box<rijke_study::StudyProblem>,
    },
    /// The gas at a point is not known.
    #[error(
        "the gas at operating point {point} is not known: base/states.json has no state of it. `rijke flow DIR --out DIR/base` infers it from \
         the clicks at this point; or leave the point out of [base.states] in study.toml if its gas is ambient and at rest"
    )]
    NoState {
        /// The operating point.
        point: String,
    },
    /// The gas of a point is heated, and was not read there.
    #[error(
        "the gas at operating point {point} is not known: [base.measured] takes it from readings.csv, which has no row of this point, although gas \
         is heated where the same factors are above zero; add its readings, or let [base.heated-flow] predict the gas"
    )]
    NoReadings {
        /// The operating point.
        point: String,
    },
    /// Something is asked of factors that the campaign does not have, or without a number.
    #[error("{what}; the factors are {known}")]
    Factors {
        /// What is wrong.
        what: String,
        /// All factors.
        known: String,
    },
    /// The folder cannot be read.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The rig is impossible at an operating point.
    #[error("at operating point {point}: {source}")]
    Rig {
        /// The operating point.
        point: String,
        /// What is wrong there.
        source: Box<rijke_study::StudyProblem>,
    },
    /// The network of an operating point cannot be built or has no mode.
    #[error("at operating point {point}: {source}")]
    Network {
        /// The operating point.
        point: String,
        /// Why.
        source: NetworkError,
    },
    /// The mode that was measured is not one that the rig as described has.
    #[error(
        "at operating point {point}: {measured_hz:.1} Hz was measured, and the nearest mode of this model at the centre of its priors has \
         {described_hz:.1} Hz{}; if no model has a mode there, check ends, lengths, temperatures, and the factors of this point",
        dense(*measured_hz, *described_hz)
    )]
    OtherMode {
        /// The operating point.
        point: String,
        /// Frequency measured, Hz.
        measured_hz: f64,
        /// Nearest mode of the model at the middle of its priors, Hz.
        described_hz: f64,
    },
    /// Two measured modes of a point belong to one mode of the model.
    #[error(
        "at operating point {point}: the modes measured at {first_hz:.1} and {second_hz:.1} Hz are both nearest to that at \
         {described_hz:.1} Hz of the rig as described; check which modes they are"
    )]
    AmbiguousModes {
        /// The operating point.
        point: String,
        /// Frequency of one, Hz.
        first_hz: f64,
        /// Frequency of the other, Hz.
        second_hz: f64,
        /// The mode of the model, Hz.
        described_hz: f64,
    },
    /// Two modes that were followed from measured points are one at a point that was not measured.
    #[error(
        "at operating point {point}: from the points that were measured, the modes `{first}` and `{second}` both lead to the mode at {hertz:.1} Hz: \
         one label may stand for different modes at different points: compare the labels from point to point, or ask for a nearer point"
    )]
    ModesMet {
        /// The operating point.
        point: String,
        /// Label of one mode.
        first: String,
        /// Label of the other.
        second: String,
        /// Frequency at which they met, Hz.
        hertz: f64,
    },
    /// A rig of unknown lengths that is more than straight ducts of one temperature each, in gas at rest.
    #[error("at operating point {point}, as lengths or places of the rig are unknown: {problem}")]
    Shape {
        /// The operating point.
        point: String,
        /// Why, and the remedy.
        problem: &'static str,
    },
    /// A choked end in a mean flow, where it turns entropy waves into sound, which no reflection coefficient
    /// says.
    #[error(
        "at operating point {point}: the rig has a choked end, and a candidate requires waves in the mean flow: write that end as \
         `constant`, with the reflection that you know, or take `mean_flow` out of the candidate"
    )]
    Choked {
        /// The operating point.
        point: String,
    },
    /// A flame that answers to a velocity elsewhere, where that cannot be told.
    #[error("at operating point {point}: `{part}` answers to the velocity elsewhere, {problem}")]
    Reference {
        /// The operating point.
        point: String,
        /// The part.
        part: String,
        /// Why, and the remedy.
        problem: String,
    },
    /// Gas that flows from the downstream end to the upstream end, where a law or the waves need to know.
    #[error(
        "at operating point {point}: the gas flows from downstream to upstream ({velocity:.3} m/s), and {what}: describe the rig from its other end, or leave \
         this point out"
    )]
    Backwards {
        /// The operating point.
        point: String,
        /// Its velocity at the upstream end, m/s.
        velocity: f64,
        /// What cannot be.
        what: String,
    },
    /// A law that has no value.
    #[error(
        "at operating point {point}: {law} has no finite value at s = {s:.1}: the law divides by a number that is 0 there, such as a flow or a power, or a \
         function is outside its range; `--stage` takes the model of an earlier stage, which may lack this law"
    )]
    Undefined {
        /// The operating point.
        point: String,
        /// The law.
        law: String,
        /// Where.
        s: C64,
    },
    /// A length or an area that is not positive.
    #[error(
        "at operating point {point}: a length or an area of the rig is not positive with these parameters"
    )]
    Impossible {
        /// The operating point.
        point: String,
    },
    /// A frequency is needed to know which mode is meant.
    #[error(
        "at operating point {point}: a growth rate without a frequency does not say which mode is meant: the rig has {modes} in the region of the \
         search; give a frequency, here or for the mode of this label at another point, or narrow frequency_hz of [search] to one mode"
    )]
    NoFrequency {
        /// The operating point.
        point: String,
        /// How many modes the rig has there, by the first row at the centre of its priors.
        modes: usize,
    },
    /// An ambient temperature is missing.
    #[error(
        "operating point {point} has no ambient temperature; give the column T_amb in the campaign, the temperature of the records, or temperatures in rig.toml"
    )]
    NoTemperature {
        /// The operating point.
        point: String,
    },
    /// Two candidates model the same role.
    #[error("`{first}` and `{second}` both model {role}; take one")]
    SameRole {
        /// The role.
        role: String,
        /// A candidate.
        first: String,
        /// The other.
        second: String,
    },
    /// Two candidates have a parameter of one name.
    #[error(
        "the parameter `{parameter}` of `{first}` is also one of `{second}`, with which it acts; rename one"
    )]
    SameName {
        /// The parameter.
        parameter: String,
        /// A candidate.
        first: String,
        /// The other.
        second: String,
    },
    /// A parameter that the model does not have.
    #[error("there is no parameter `{name}` in these models; known: {known}; look at `hold` in study.toml")]
    UnknownParameter {
        /// The name.
        name: String,
        /// Names of the parameters that there are.
        known: String,
    },
    /// The wrong number of parameter values.
    #[error("{found} parameter values were given, but the model has {expected}")]
    Count {
        /// How many the model has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// The selection of a stage means no point.
    #[error(
        "study.toml: the `points` of stage `{stage}` select no operating point of the campaign; correct them"
    )]
    NothingSelected {
        /// The stage.
        stage: String,
    },
    /// No point of a stage was observed.
    #[error(
        "stage `{stage}`: none of its points was observed; observe some, correct its `points`, or stop before it with `rijke rank --until`"
    )]
    NoPoint {
        /// The stage.
        stage: String,
    },
    /// A question that no observed point answers.
    #[error("question `{question}`: none of its points was observed")]
    NothingToAnswer {
        /// The question.
        question: String,
    },
    /// No further measurement can be judged.
    #[error("stage `{stage}`: no further measurement can be judged; {reason}")]
    NothingToMeasure {
        /// The stage.
        stage: String,
        /// Why, and the remedy.
        reason: String,
    },
    /// A stage without a model that could be fitted.
    #[error("stage `{stage}`: no model could be fitted\n  {remark}")]
    NoWinner {
        /// The stage.
        stage: String,
        /// Why each of them failed.
        remark: String,
    },
    /// The search for the most probable parameters gave up.
    #[error("{model}: the search for the most probable parameters stopped: {stop}")]
    NotConverged {
        /// The candidates.
        model: String,
        /// Why it stopped.
        stop: Stop,
    },
    /// The most probable parameters are known, and the evidence is not.
    #[error("{model}: {why}")]
    NoEvidence {
        /// The candidates.
        model: String,
        /// Why, and the remedy.
        why: String,
    },
    /// Propagation constants of waves where nothing can use them.
    #[error("`{candidate}` states propagation constants (forward, backward), {problem}")]
    Waves {
        /// The candidate.
        candidate: String,
        /// Why, and the remedy.
        problem: &'static str,
    },
    /// A question about a point at which a model of its stage is undefined.
    #[error(
        "question `{question}` asks for what the model {model} may predict: {source}; take the point out of its `points`, as with where = {{ FACTOR = {{ above = 0 }} }}, or correct the laws"
    )]
    Unanswerable {
        /// The question.
        question: String,
        /// The candidates.
        model: String,
        /// Why.
        source: Box<EngineError>,
    },
    /// A stage that cannot be run as it is asked for.
    #[error("stage `{stage}`: {problem}")]
    Refused {
        /// The stage.
        stage: String,
        /// Why, and the remedy.
        problem: String,
    },
    /// The caller ended a search.
    #[error("the search was stopped")]
    Stopped,
    /// A training without a maximum that can be compared.
    #[error("{what}")]
    Unsettled {
        /// Why.
        what: String,
    },
    /// The inference refuses.
    #[error(transparent)]
    Inference(#[from] InferenceError),
    /// Dense algebra failed.
    #[error(transparent)]
    Dense(#[from] DenseError),
    /// A file cannot be written or read.
    #[error("{file}: {problem}")]
    File {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// Why modes that are near one another do not fit.
fn dense(measured: f64, described: f64) -> &'static str {
    const NEAR: f64 = 0.02;
    let near = (described / measured - 1.0).abs() < NEAR;
    if near {
        ", one of many modes that lie as close to each other: the rig is far too long for it"
    } else {
        ""
    }
}

impl EngineError {
    /// Why a stage has nothing to train on.
    pub(crate) fn no_point(study: &Study, stage: &str, points: &Selection) -> Self {
        let stage = stage.to_owned();
        let none = points.places(&study.campaign).is_empty();
        if none { Self::NothingSelected { stage } } else { Self::NoPoint { stage } }
    }

    /// The operating point at which it arose, where it has one.
    #[must_use]
    pub fn point(&self) -> Option<&str> {
        match self {
            Self::NoState { point }
            | Self::NoReadings { point }
            | Self::Rig { point, .. }
            | Self::Network { point, .. }
            | Self::OtherMode { point, .. }
            | Self::AmbiguousModes { point, .. }
            | Self::ModesMet { point, .. }
            | Self::Shape { point, .. }
            | Self::Reference { point, .. }
            | Self::Backwards { point, .. }
            | Self::Undefined { point, .. }
            | Self::Choked { point }
            | Self::Impossible { point }
            | Self::NoFrequency { point, .. }
            | Self::NoTemperature { point } => Some(point),
            _ => None,
        }
    }

    /// Whether a search may go on at other parameter values.
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        match self {
            Self::Network { source, .. } => source.is_recoverable(),
            Self::Inference(source) => source.is_recoverable(),
            Self::Impossible { .. } => true,
            _ => false,
        }
    }
}

/// A search goes on at other values of the parameters where the fault is one of these values.
impl From<EngineError> for ForwardError {
    fn from(error: EngineError) -> Self {
        if error.is_recoverable() { Self::recoverable(error) } else { Self::fatal(error) }
    }
}
