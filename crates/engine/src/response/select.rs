//! Which numbers train a stage.

use super::measured::Measured;
use crate::EngineError;
use rijke_study::Study;
use rijke_study::plan::{Base, SdSpec};
use rijke_study::responses::{ObservedResponse, ResponseKind, ResponseStage, Responses};
use std::collections::BTreeSet;

/// The responses that train a stage, thinned; those of one session stand side by side.
pub(super) struct Selected {
    pub(super) measured: Vec<Measured>,
    /// Operating point of each.
    pub(super) points: Vec<usize>,
    /// What each is.
    pub(super) whats: Vec<ResponseKind>,
    /// Numbers in the file of each.
    pub(super) rows: Vec<usize>,
    /// Response and frequency of every number that is used, by their places in the observations.
    pub(super) used: BTreeSet<(usize, usize)>,
}

impl Selected {
    pub(super) fn new(
        study: &Study,
        observed: &Responses,
        stage: &ResponseStage,
    ) -> Result<Self, EngineError> {
        let campaign = &study.campaign;
        let session = |o: &ObservedResponse| {
            let point = o.point;
            if let ResponseKind::Pressure { excitation, .. } = &o.what {
                let first = o.frequency_hz.first().copied().unwrap_or(f64::NAN);
                return format!("excitation {excitation} from {first} Hz at point {point}");
            }
            let factor = stage.session.as_ref().and_then(|name| campaign.factor(name));
            factor.map_or_else(|| format!("point {point}"), |k| campaign.points[point].factors[k].to_string())
        };
        let heard = |o: &ObservedResponse| match &o.what {
            ResponseKind::Pressure { microphone, .. } if !stage.microphones.is_empty() => {
                stage.microphones.contains(&study.rig.microphones.names[*microphone])
            }
            _ => true,
        };
        let meant = |(_, o): &(usize, &ObservedResponse)| {
            heard(o) && stage.points.holds(campaign, &campaign.points[o.point])
        };
        let mut chosen: Vec<_> = observed.list.iter().enumerate().filter(meant).collect();
        let mut sessions: Vec<String> = Vec::new();
        for (_, o) in &chosen {
            let name = session(o);
            if !sessions.contains(&name) {
                sessions.push(name);
            }
        }
        let number = |o: &ObservedResponse| {
            let own = session(o);
            sessions.iter().position(|s| *s == own).unwrap_or(0)
        };
        chosen.sort_by_cached_key(|(_, o)| (number(o), o.point));
        let mut all = Self {
            measured: Vec::new(),
            points: Vec::new(),
            whats: Vec::new(),
            rows: Vec::new(),
            used: BTreeSet::new(),
        };
        for (place, o) in chosen {
            let keep = thinned(&o.frequency_hz, stage);
            if keep.is_empty() {
                continue;
            }
            // Empty where none are known.
            let at = |all: &[f64]| keep.iter().filter_map(|&k| all.get(k).copied()).collect();
            all.used.extend(keep.iter().map(|&k| (place, k)));
            all.measured.push(Measured {
                label: label(study, o),
                session: number(o),
                sources: match &o.what {
                    ResponseKind::Pressure { sources, .. } => sources.len(),
                    _ => 0,
                },
                frequency_hz: keep.iter().map(|&k| o.frequency_hz[k]).collect(),
                values: keep.iter().map(|&k| o.values[k]).collect(),
                sd: at(&o.sd),
                level: at(&o.level),
                factor: Vec::new(),
            });
            all.points.push(o.point);
            all.whats.push(o.what.clone());
            all.rows.push(o.rows);
        }
        if all.measured.is_empty() && !sessions.is_empty() {
            let problem =
                "no frequency of its responses lies within its `band_hz`, of the instrument and of the stage: correct them".to_owned();
            return Err(EngineError::Refused { stage: stage.id.clone(), problem });
        }
        if all.measured.is_empty() {
            return Err(EngineError::no_point(study, &stage.id, &stage.points));
        }
        Ok(all)
    }

    /// How many complex numbers there are.
    pub(super) fn numbers(&self) -> usize {
        self.measured.iter().map(|m| m.values.len()).sum()
    }
}

/// Refuses a study whose stages count a number twice, or whose gas no model of responses can have.
pub(super) fn check(study: &Study, observed: &Responses) -> Result<(), EngineError> {
    let plan = &study.plan;
    let refuse = |stage: &ResponseStage, problem: String| {
        Err(EngineError::Refused { stage: stage.id.clone(), problem })
    };
    let mut used: Vec<(&str, BTreeSet<(usize, usize)>)> = Vec::new();
    for stage in &plan.responses {
        if !matches!(plan.base, Base::Ambient | Base::Rig) {
            let problem = "responses are those of gas at rest, of one temperature in every duct: write base = \"ambient\", or base = \"rig\" \
                           with a temperature for every duct in rig.toml";
            return refuse(stage, problem.to_owned());
        }
        let data = Selected::new(study, observed, stage)?;
        if stage.misfit.is_some() && data.measured.iter().any(|m| m.sources > 0) {
            let problem = "pressures of unknown sources are trained without a misfit: leave it out; the page says how far the residuals correlate";
            return refuse(stage, problem.to_owned());
        }
        if matches!(stage.noise, SdSpec::Fixed(sd) if sd == 0.0)
            && data.measured.iter().any(|m| m.sd.is_empty())
        {
            let problem = "`noise = 0` leaves numbers without a standard deviation: give their files a column `sd`, or state a noise";
            return refuse(stage, problem.to_owned());
        }
        let mut own = data.used;
        for id in &stage.on {
            let Some((_, before)) = used.iter().find(|(known, _)| known == id) else { continue };
            let twice = own.intersection(before).count();
            if twice > 0 {
                return refuse(
                    stage,
                    format!(
                        "it stands on `{id}`, whose posterior is its prior, and {twice} of its {} numbers trained that stage already: data \
                         count once; choose other `points` or frequencies, or leave `on` out",
                        own.len()
                    ),
                );
            }
        }
        // What an earlier stage knows stems from the data of those on which it stands, too.
        for (_, before) in used.iter().filter(|(known, _)| stage.on.iter().any(|id| id == known)) {
            own.extend(before);
        }
        used.push((&stage.id, own));
    }
    Ok(())
}

/// What a response is called.
fn label(study: &Study, o: &ObservedResponse) -> String {
    let point = &study.campaign.points[o.point].id;
    let ResponseKind::Pressure { microphone, excitation, .. } = &o.what else { return point.clone() };
    let name = &study.rig.microphones.names[*microphone];
    if excitation.is_empty() { format!("{point}, {name}") } else { format!("{point}, {excitation}, {name}") }
}

/// The places of the frequencies that a stage takes: within its band, and at least its step apart.
fn thinned(frequency_hz: &[f64], stage: &ResponseStage) -> Vec<usize> {
    let [low, high] = stage.band_hz.unwrap_or([0.0, f64::INFINITY]);
    let step = stage.step_hz.unwrap_or(0.0);
    let mut next = f64::NEG_INFINITY;
    let mut keep = Vec::new();
    for (k, f) in frequency_hz.iter().enumerate().filter(|(_, f)| (low..=high).contains(*f)) {
        if *f >= next {
            keep.push(k);
            // A grid of its own step must not lose rows to rounding.
            next = f + step * (1.0 - 1e-9);
        }
    }
    keep
}
