//! A study with what has been trained of it so far.

use super::parameter::TrainedParameter;
use super::record::{CarriedOn, ModelRecord};
use crate::observed::Used;
use crate::response::Ground;
use crate::rows::Choice;
use crate::{Assembly, EngineError, NamedGaussian, Observed, PointModel, Trained};
use rijke_inference::SamplerKind;
use rijke_network::{Response, Workspace};
use rijke_numerics::Order;
use rijke_rig::ChannelErrors;
use rijke_study::plan::Stage;
use rijke_study::{HeatedFit, PointState, Rig, Study};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// How far an evidence is trusted or checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Trusted {
    /// Laplace's method at one maximum.
    #[default]
    Laplace,
    /// Other maxima are looked for; the evidence is summed over them and not checked.
    Searched,
    /// Other starts, importance sampling and doubled priors as well: some hundred calls of the model.
    Checked,
    /// A sampler too, to a statistical error in nats.
    Sampled(SamplerKind, f64),
}

/// Rows within so many nats of the best are checked. Of others a few more maxima are looked for first: a
/// delay whose prior lies at an alias has been seen to cost 316 nats.
pub(super) const CONTENDS: f64 = 150.0;

/// A trained model and its training, kept for the stages that stand on it.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The model.
    pub assembly: Arc<Assembly>,
    /// What training found.
    pub trained: Arc<Trained>,
    /// The observations that trained, as they were heard through the channels that earlier stages found.
    pub observed: Arc<Vec<Observed>>,
    /// What earlier stages knew of it.
    pub(super) known: Arc<Vec<NamedGaussian>>,
    /// The misfit, what was measured included.
    pub(super) misfit: [f64; 3],
    /// Which other maxima of earlier stages its data leave open, in words.
    pub(super) beside: Option<String>,
    /// The other maxima of its posterior that are not improbable.
    pub(super) maxima: Vec<Elsewhere>,
}

/// Another maximum of the posterior of a model.
#[derive(Clone, Debug)]
pub(super) struct Elsewhere {
    /// Its odds against the one that was taken.
    pub(super) odds: f64,
    /// The parameters of the model there.
    pub(super) at: Vec<f64>,
    /// What earlier stages know, by the maximum of theirs on which it stands.
    pub(super) known: Arc<Vec<NamedGaussian>>,
}

impl Chosen {
    /// Its candidates by their roles, without what the rig itself says.
    pub(super) fn choice(&self) -> Choice {
        let own = self.assembly.candidates().iter().filter(|c| c.role != "rig");
        own.map(|c| (c.role.clone(), c.id.clone())).collect()
    }

    /// What the microphones of a stage measured of the modes that trained it.
    pub(super) fn used(&self, rig: &Rig, stage: &Stage) -> Vec<Used> {
        let (reference, microphones) = (rig.microphones.reference, microphones_of(rig, stage));
        self.observed.iter().map(|o| o.used(&microphones, reference)).collect()
    }

    /// An observation as the model itself has it at its most probable parameters, at some microphones:
    /// without the errors of base states and channels that training found beside them.
    pub(super) fn solved(&self, o: &Observed, microphones: &[usize]) -> Result<Response, EngineError> {
        let model = PointModel::new(&self.assembly, &o.conditions, microphones)?.starting_from(o.near);
        let values = self.trained.best();
        model.respond(values, Order::Value, &mut Workspace::default())
    }
}

/// The microphones that a stage uses.
pub(super) fn microphones_of(rig: &Rig, stage: &Stage) -> Vec<usize> {
    let names = &rig.microphones.names;
    (0..names.len()).filter(|m| stage.hears(&names[*m])).collect()
}

/// The parameters that models of later stages found, by stage and model.
pub(super) type Near = BTreeMap<[String; 2], Vec<TrainedParameter>>;

/// A row of a table, and its training if it could be fitted.
pub(super) type Found = (ModelRecord, Option<Chosen>);

/// A row as it was last trained.
pub(super) struct Kept {
    /// How far its evidence is trusted, and that of its course.
    pub(super) trusted: [Trusted; 2],
    /// What the stages before it had chosen. Held, so that no other training can take their place in memory.
    pub(super) on: Vec<Arc<Trained>>,
    pub(super) found: Found,
}

/// Rows as they were last trained, by stage and candidates.
pub(super) type Once = BTreeMap<(String, Choice), Vec<Kept>>;

/// A stage that has run.
#[derive(Clone)]
pub(super) struct Done {
    /// The model that goes on: its candidates, and what training found.
    pub(super) choice: Choice,
    pub(super) chosen: Chosen,
    /// Every row of the table that could be fitted.
    pub(super) rows: Vec<(ModelRecord, Chosen)>,
    /// What its model takes for certain, though the evidence of this stage or of those before it does not
    /// decide it.
    pub(super) assumes: Vec<String>,
    /// The models that it leaves open beside the one that goes on, with their odds against it.
    pub(super) open: Vec<(f64, CarriedOn)>,
    /// The models of later stages that are open if one of these is right.
    pub(super) beside: Vec<Beside>,
}

/// A model of a stage that stands on another model of an earlier stage than the one that went on.
#[derive(Clone)]
pub(super) struct Beside {
    /// That of the earlier stage.
    pub(super) on: String,
    pub(super) stage: String,
    /// Against the best model of the stage that stands on what went on.
    pub(super) odds: f64,
    pub(super) choice: Choice,
    pub(super) parameters: Vec<TrainedParameter>,
    pub(super) chosen: Chosen,
}

/// What a row stands on: the posteriors of earlier stages, and the observations as heard through the channels
/// that they found.
#[derive(Clone)]
pub(super) struct StandsOn {
    /// One list for every maximum that earlier stages leave open, the most probable first, with the ln of its
    /// probability.
    pub(super) maxima: Arc<Vec<(f64, Arc<Vec<NamedGaussian>>)>>,
    pub(super) points: Arc<Vec<Observed>>,
}

impl StandsOn {
    /// One maximum.
    pub(super) fn one(known: Arc<Vec<NamedGaussian>>, points: Arc<Vec<Observed>>) -> Self {
        Self { maxima: Arc::new(vec![(0.0, known)]), points }
    }
}

impl Done {
    /// A model taken by itself.
    pub(super) fn of(choice: Choice, chosen: Chosen) -> Self {
        Self { choice, chosen, rows: Vec::new(), assumes: Vec::new(), open: Vec::new(), beside: Vec::new() }
    }

    /// The best model of the table but the one that goes on.
    pub(super) fn rival(&self) -> Option<&(ModelRecord, Chosen)> {
        let others = self.rows.iter().filter(|(model, _)| model.candidates != self.choice);
        others.max_by(|a, b| a.0.ln_evidence().total_cmp(&b.0.ln_evidence()))
    }
}

/// A study with its observations, and what has been trained of it so far.
pub struct Run {
    /// The study.
    pub study: Study,
    pub(super) rig: Arc<Rig>,
    pub(super) observed: Vec<Observed>,
    pub(super) channels: Option<ChannelErrors>,
    pub(super) trusted: Trusted,
    /// What stages of responses found, on which stages may stand.
    pub(super) grounds: Vec<Ground>,
    pub(super) done: Vec<Done>,
    /// What the readings say of the heat, where a part heats the gas.
    pub heat: Option<HeatedFit>,
    /// Observed points that no stage uses because nothing is known of their gas.
    pub left_out: Vec<String>,
    /// States of the gas that were inferred, by the place of their point, and what is known of the
    /// temperature at each.
    pub(super) states: BTreeMap<usize, PointState>,
    pub(super) ambient: Vec<Option<[f64; 2]>>,
    /// What rows of later stages found after another model of an earlier stage: where their search begins.
    pub(super) near: Near,
    /// Rows of this study, whatever its stages choose.
    pub(super) once: Arc<Mutex<Once>>,
    /// Models trained with what enters predictions but not the comparison, by stage.
    pub(super) predicting: Mutex<BTreeMap<String, Arc<Trained>>>,
    /// Whether stages say what errors of stated lengths would turn their leads; not unless it is set.
    pub lengths: bool,
    /// Set by another thread to end a stage before its next row.
    pub stopped: Arc<AtomicBool>,
}

impl Run {
    /// The same study with these models in the place of what its stages chose.
    pub(super) fn standing_on(&self, done: Vec<Done>) -> Self {
        Self {
            study: self.study.clone(),
            rig: self.rig.clone(),
            observed: self.observed.clone(),
            channels: self.channels.clone(),
            trusted: self.trusted,
            grounds: self.grounds.clone(),
            done,
            heat: self.heat.clone(),
            left_out: self.left_out.clone(),
            states: self.states.clone(),
            ambient: self.ambient.clone(),
            near: Near::new(),
            once: self.once.clone(),
            predicting: Mutex::default(),
            lengths: false,
            stopped: self.stopped.clone(),
        }
    }

    /// Whether to go on.
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(super) fn go_on(&self) -> Result<(), EngineError> {
        if self.stopped.load(Ordering::Relaxed) { Err(EngineError::Stopped) } else { Ok(()) }
    }

    /// What the stage called `id` chose, once it has run.
    #[must_use]
    pub fn chosen(&self, id: &str) -> Option<&Chosen> {
        self.stage_done(id).map(|done| &done.chosen)
    }

    /// What the stage of responses called `id` found.
    pub(super) fn ground(&self, id: &str) -> Option<&Ground> {
        self.grounds.iter().find(|g| g.id == id)
    }

    pub(super) fn stage_done(&self, id: &str) -> Option<&Done> {
        let (k, _) = self.study.plan.stage(id)?;
        self.done.get(k)
    }
}
