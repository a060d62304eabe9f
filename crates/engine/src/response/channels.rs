//! Delays and gains of channels as parameters that all responses of a session share.
//!
//! What a microphone hears, relative to another one of its session, is P (1 - s d + g), as in
//! [`rijke_rig::ChannelErrors`]. An error that all microphones share is that of the sources, or cancels in a
//! transfer function. Being linear in d and g, the model is as Gaussian in them as the noise, so that
//! Laplace's method integrates over them in closed form.

use crate::EngineError;
use rijke_inference::{InferenceError, Parameter, Parameters, Prior};
use rijke_numerics::{C64, Jet, JetSpace, Matrix};
use rijke_rig::ChannelErrors;
use rijke_study::Study;
use rijke_study::responses::{ResponseKind, ResponseStage};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// The delays and gains of a stage.
#[derive(Clone, Debug, Default)]
pub(super) struct ChannelsOfResponses {
    /// Of every session the delays, then the gains, of its microphones but one.
    pub(super) parameters: Vec<Parameter>,
    /// Names and covariance of what is known of them before, session by session.
    known: Vec<(Vec<String>, Matrix)>,
    /// For every load what its numbers change by, over themselves: the parameter, and its slope, times s if
    /// that is said.
    slopes: Vec<Vec<(usize, f64, bool)>>,
}

/// One number for each of two microphones of one session.
struct Pair<'a> {
    study: &'a Study,
    errors: &'a ChannelErrors,
    /// The microphone to which the others are relative.
    base: usize,
}

impl ChannelsOfResponses {
    /// Of a stage whose responses, and their points, these are; none where nothing is stated of the channels,
    /// or the stage takes them for equal.
    ///
    /// # Errors
    /// [`EngineError::Refused`] for a stage that asks for channels of which nothing is stated, and errors of
    /// the file that states them.
    pub(super) fn of(
        study: &Study,
        stage: &ResponseStage,
        whats: &[ResponseKind],
        points: &[usize],
    ) -> Result<Self, EngineError> {
        let mut all = Self { slopes: vec![Vec::new(); whats.len()], ..Self::default() };
        if stage.channels == Some(false) {
            return Ok(all);
        }
        let Some(errors) = study.channels_of_responses()? else {
            if stage.channels == Some(true) {
                let problem = "`channels = true`, but nothing says how well gains and delays are known: state gain_sd and delay_sd in [microphones] \
                               of rig.toml, or write observations/channels.toml";
                return Err(EngineError::Refused { stage: stage.id.clone(), problem: problem.to_owned() });
            }
            return Ok(all);
        };
        let factor = stage.session.as_ref().and_then(|name| study.campaign.factor(name));
        let session = |point: usize| {
            let value = factor.map(|k| study.campaign.points[point].factors[k].to_string());
            stage.session.as_ref().zip(value).map_or_else(String::new, |(name, v)| format!(" ({name} = {v})"))
        };
        let sessions: BTreeSet<String> = points.iter().map(|p| session(*p)).collect();
        for own in sessions {
            let loads: Vec<usize> = (0..whats.len()).filter(|load| session(points[*load]) == own).collect();
            let heard: BTreeSet<usize> = loads.iter().flat_map(|load| heard_by(&whats[*load])).collect();
            let reference = study.rig.microphones.reference;
            let Some(base) = heard.get(&reference).or(heard.first()).copied() else { continue };
            let pair = Pair { study, errors: &errors, base };
            let others: Vec<usize> = heard.into_iter().filter(|m| *m != base).collect();
            let of_kind = [(true, "delay", "d", "s"), (false, "gain", "g", "1")];
            for (is_delay, word, letter, unit) in of_kind {
                let stated = others.iter().all(|m| pair.covariance(is_delay, *m, *m) > 0.0);
                if !stated || others.is_empty() {
                    continue;
                }
                let first = all.parameters.len();
                let mut names = Vec::new();
                for m in &others {
                    let [label, over] = [*m, base].map(|m| &study.rig.microphones.names[m]);
                    let name = format!("{word} of {label} over {over}{own}");
                    let prior = Prior::Normal { mean: 0.0, sd: pair.covariance(is_delay, *m, *m).sqrt() };
                    let symbol = format!("{letter}_{label}");
                    all.parameters.push(Parameter::new(name.clone(), symbol, unit, prior));
                    names.push(name);
                }
                let n = others.len();
                let covariance =
                    Matrix::from_fn(n, n, |i, j| pair.covariance(is_delay, others[i], others[j]));
                all.known.push((names, covariance));
                let slope = |m: usize, sign: f64| {
                    let place = others.iter().position(|other| *other == m)?;
                    Some((first + place, if is_delay { -sign } else { sign }, is_delay))
                };
                for load in &loads {
                    match &whats[*load] {
                        ResponseKind::Pressure { microphone, .. } => {
                            all.slopes[*load].extend(slope(*microphone, 1.0));
                        }
                        ResponseKind::Transfer { to, from } => {
                            all.slopes[*load].extend(slope(*to, 1.0).into_iter().chain(slope(*from, -1.0)));
                        }
                        _ => {}
                    }
                }
            }
        }
        Ok(all)
    }

    /// What is known of them before, unless an earlier stage already knows better.
    ///
    /// # Errors
    /// [`InferenceError`] for a covariance that is none.
    pub(super) fn prior(
        &self,
        mut parameters: Parameters,
        earlier: &BTreeSet<&str>,
    ) -> Result<Parameters, InferenceError> {
        for (names, covariance) in &self.known {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            if !names.iter().any(|name| earlier.contains(name)) {
                parameters = parameters.with_joint(&names, &vec![0.0; names.len()], covariance)?;
            }
        }
        Ok(parameters)
    }

    /// The answer of a load at a frequency (Hz) as its channels give it. `answer` has derivatives in the
    /// `own` parameters of the model and in s. What comes out has those in `own` and in the parameters of the
    /// channels, and zero for the one in s.
    pub(super) fn heard(&self, load: usize, hz: f64, answer: &Jet, own: usize, errors: &[f64]) -> Jet {
        let s = C64::new(0.0, 2.0 * PI * hz);
        let space = JetSpace::new(own + errors.len() + 1, answer.order());
        let mut change = space.real(0.0);
        for (k, a, by_s) in &self.slopes[load] {
            let slope = if *by_s { s * *a } else { C64::from(*a) };
            change.add_scaled(&space.seed(own + k, C64::from(errors[*k])), slope);
        }
        &space.take(answer, |i| (i < own).then_some(i)) * &change.shift(C64::ONE)
    }
}

/// The microphones that a response hears.
fn heard_by(what: &ResponseKind) -> Vec<usize> {
    match what {
        ResponseKind::Pressure { microphone, .. } => vec![*microphone],
        ResponseKind::Transfer { to, from } => vec![*to, *from],
        _ => Vec::new(),
    }
}

impl Pair<'_> {
    /// Covariance of two delays, or gains, over those of the base.
    fn covariance(&self, is_delay: bool, a: usize, b: usize) -> f64 {
        let reference = self.study.rig.microphones.reference;
        let matrix = if is_delay { &self.errors.delays } else { &self.errors.gains };
        let place = |m: usize| m - usize::from(m > reference);
        let of = |a: usize, b: usize| {
            if a == reference || b == reference { 0.0 } else { matrix[(place(a), place(b))] }
        };
        of(a, b) - of(a, self.base) - of(self.base, b) + of(self.base, self.base)
    }
}
