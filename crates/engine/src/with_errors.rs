//! A training with errors of base states, of factors, of drifts and of laws.
//!
//! A prediction is a straight line in these errors e, y(p, e) = y(p, e0) + S (e - e0), with the slopes S
//! taken at parameters p0 and errors e0. If these are the most probable values by that line, they are those
//! of the model itself, too: Gauss and Newton's method (Bell & Cathey, IEEE Trans. Autom. Control 38 (1993)
//! 294, on the iterated Kalman filter). They are found in turns.

use crate::data::{Blocks, in_one_block};
use crate::errors::{
    Bends, Carried, ChannelsOfModes, Common, LawErrors, Learned, PointErrors, ThroughChannels,
    changes_by_factors_of, of_drift,
};
use crate::fitting::{Fitting, parameters};
use crate::gaussian::Training;
use crate::observed::Observed;
use crate::predictor::Predictor;
use crate::trained::{OfSeveral, Trained};
use crate::{Assembly, Conditions, EngineError};
use rijke_inference::{Data, Forward, ForwardError, Linearised, MapOptions, Prediction, TrustRegion};
use rijke_numerics::Order;
use rijke_study::Cause;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most turns.
const TURNS: usize = 4;
/// They end where what straight lines miss moves no parameter by more than this part of its standard
/// deviation, and the evidence by less than so many nats.
const MISSED: f64 = 0.2;
const NATS: f64 = 0.5;
/// Where they miss less than this many standard deviations, the next turn is the last: each misses about a
/// tenth of what the one before does.
const NEAR: f64 = 3.0;
/// What a search may leave to gain where it only tells where slopes are to be taken, nats.
const LEFT: f64 = 1e-3;
/// States further away than so many standard deviations are not asked for: a model that needs them does not
/// describe its data.
const FARTHEST: f64 = 8.0;

/// A training with errors.
pub(crate) struct WithErrors<'a> {
    pub(crate) assembly: &'a Assembly,
    pub(crate) predictor: &'a Predictor<'a>,
    pub(crate) training: &'a Training,
    pub(crate) blocks: Blocks<'a>,
    pub(crate) law: Option<LawErrors>,
    /// Whether pings that drift have errors of it.
    pub(crate) drifts: bool,
    pub(crate) bends: Bends<'a>,
    pub(crate) channels: Option<&'a ChannelsOfModes>,
}

/// Where slopes are taken.
#[derive(Default)]
struct About {
    /// Parameters of the model, then of the channels.
    parameters: Vec<f64>,
    /// All errors that were found, in their standard deviations. Slopes are taken at those of the base
    /// states, and at no others.
    errors: BTreeMap<Cause, f64>,
    /// What was found of assemblies.
    assemblies: Vec<f64>,
}

/// What a fit with slopes that were taken somewhere is made of.
struct Parts<'a> {
    fitting: Fitting<'a>,
    data: Data,
    order: Vec<usize>,
    options: MapOptions,
    common: &'a Common,
    /// The errors that stay a covariance.
    rest: PointErrors,
    /// The slopes of errors of base states, and of the others.
    of_states: &'a PointErrors,
    others: &'a PointErrors,
    /// The model at the errors where slopes were taken, and what straight lines add there to every number.
    there: &'a Predictor<'a>,
    added: &'a [f64],
}

/// What a turn ends with.
enum Turn {
    /// The fit that counts.
    Last(Box<Trained>),
    /// Where slopes are to be taken next, and whether straight lines from there miss too little to ask again.
    Next { about: About, is_near: bool },
}

/// Where a search ended.
struct Ended<'a> {
    /// Parameters of the model, errors, then parameters of the channels.
    values: &'a [f64],
    /// Model and data to first order there.
    linear: &'a Linearised,
    /// Standard deviations of the model's parameters, in working coordinates.
    sds: Vec<f64>,
}

impl WithErrors<'_> {
    /// The fit that begins at `at`, parameters of the model and then of the channels.
    ///
    /// # Errors
    /// Those of [`train`](crate::train).
    pub(crate) fn fit(&self, at: &[f64]) -> Result<Trained, EngineError> {
        let mut about = About { parameters: at.to_vec(), ..About::default() };
        // Nodes of a bend are models of states without errors.
        let mut turns = if self.bends.is_empty() { TURNS } else { 0 };
        let mut before: Option<About> = None;
        loop {
            let ended = match (self.about(&about, |parts| self.turn(parts, turns == 0)), before.take()) {
                // The mode is lost in that gas: slopes stay where they were.
                (Err(_), Some(before)) => self.about(&before, |parts| self.turn(parts, true))?,
                (ended, _) => ended?,
            };
            match ended {
                Turn::Last(trained) => return Ok(*trained),
                Turn::Next { about: next, is_near } => {
                    before = Some(std::mem::replace(&mut about, next));
                    turns = if is_near { 0 } else { turns - 1 };
                }
            }
        }
    }

    /// One turn: the fit that counts, if it `is_last` or straight lines miss too little for another.
    fn turn(&self, mut parts: Parts<'_>, is_last: bool) -> Result<Turn, EngineError> {
        let own = self.assembly.parameters().len();
        if self.training.checks.is_none() {
            // That fit is a search as well.
            let trained = self.finished(&parts)?;
            let sds = trained.sd();
            let sds = (0..own).map(|j| sds[j] / trained.slope(j).abs()).collect();
            let ended = Ended { values: &trained.values, linear: &trained.linear.0, sds };
            let next = if is_last { None } else { self.nearer(&parts, &ended)? };
            return Ok(next.unwrap_or_else(|| Turn::Last(Box::new(trained))));
        }
        let search = TrustRegion { tolerance: LEFT, ..parts.options.search };
        let quick = MapOptions { search, ..parts.options.clone() };
        // What cannot be searched from here is searched, and refused, by the fit that counts.
        if !is_last
            && let Ok(fit) = parts.fitting.search(&parts.data, parts.order.clone(), &quick)
            && let Ok((laplace, linear)) = parts.fitting.linearised(&parts.data, parts.order.clone(), &fit)
        {
            let sds = (0..own).map(|j| laplace.covariance[(j, j)].sqrt()).collect();
            let ended = Ended { values: &fit.parameters, linear: &linear, sds };
            if let Some(next) = self.nearer(&parts, &ended)? {
                return Ok(next);
            }
            parts.options = parts.options.from(&fit.parameters);
        }
        Ok(Turn::Last(Box::new(self.finished(&parts)?)))
    }

    /// What `then` makes of a fit with slopes taken there.
    fn about<T>(
        &self,
        about: &About,
        then: impl FnOnce(Parts<'_>) -> Result<T, EngineError>,
    ) -> Result<T, EngineError> {
        let (training, channels, bends) = (self.training, self.channels, &self.bends);
        let Blocks { observed, used, scatter, assemblies, .. } = self.blocks;
        let assembly = self.assembly;
        let own = assembly.parameters().len();
        let (values, of_channels) = about.parameters.split_at(own);
        let moved = about.states(observed);
        let displaced = match &moved {
            Cow::Borrowed(_) => None,
            Cow::Owned(moved) => Some(Predictor::new(assembly, moved, used)?),
        };
        let there = displaced.as_ref().unwrap_or(self.predictor);
        let of_states = match training.base_errors {
            true => PointErrors::new(assembly, &moved, used, values)?,
            false => PointErrors::none(observed.len()),
        };
        let others = self.others(&moved, values)?;
        let added = of_states.effect(used, &about.errors);
        let straight = Shifted { inner: there, less: &added };
        let (common, rest) =
            Common::of(of_states.clone().beside(others.clone()), (observed, used, scatter), training, bends)?;
        let alone = !training.base_errors && rest.is_none();
        let (data, order) = if alone { self.blocks.apart() } else { self.blocks.together(&rest) }?;
        let shared = [common.parameters(), assemblies.parameters()].concat();
        let slopes = assemblies.behind(common.slopes());
        let parameters = parameters(assembly, &shared, &common.known(), channels, training)?;
        let bent = bends.placed(used, |cause| common.direction_of(cause));
        let carried = Carried { inner: &straight, own, slopes: &slopes, bends: &bent };
        let through = ThroughChannels::new(&carried, own + shared.len(), channels, observed, used);
        let mut of_assemblies = about.assemblies.clone();
        of_assemblies.resize(assemblies.parameters().len(), 0.0);
        let start = [values, &common.directions(&about.errors), &of_assemblies, of_channels].concat();
        then(Parts {
            fitting: Fitting { assembly, training, model: &through, parameters: &parameters },
            options: training.search.clone().from(&start),
            data,
            order,
            common: &common,
            rest,
            of_states: &of_states,
            others: &others,
            there,
            added: &added,
        })
    }

    /// Where slopes are to be taken instead of there, if straight lines miss too much where a search ended.
    fn nearer(&self, parts: &Parts<'_>, ended: &Ended<'_>) -> Result<Option<Turn>, EngineError> {
        let Parts { order, of_states, others, there, added, .. } = parts;
        let Blocks { observed, used, .. } = self.blocks;
        let (all, linear) = (ended.values, ended.linear);
        let own = self.assembly.parameters().len();
        let values = &all[..own];
        let of_channels = all.len() - self.channels.map_or(0, |c| c.parameters.len());
        let directions = parts.common.slopes().columns();
        let next = About {
            parameters: [values, &all[of_channels..]].concat(),
            assemblies: all[own + directions..of_channels].to_vec(),
            errors: self.found(parts, all, linear.pulls()),
        };
        if !next.is_near(observed) {
            return Ok(None);
        }
        let found = &next.errors;
        let moved = next.states(observed);
        let Ok(next_there) = Predictor::new(self.assembly, &moved, used) else { return Ok(None) };
        let [Ok(exact), Ok(here)] = [&next_there, *there].map(|model| model.predict(values, Order::Value))
        else {
            return Ok(None);
        };
        let Ok(others_there) = self.others(&moved, values) else { return Ok(None) };
        let mut missed = vec![0.0; here.values.len()];
        let add = |to: &mut [f64], sign: f64, of: &[f64]| {
            to.iter_mut().zip(of).for_each(|(t, o)| *t += sign * o);
        };
        add(&mut missed, 1.0, &exact.values);
        add(&mut missed, -1.0, &here.values);
        add(&mut missed, -1.0, &of_states.effect(used, found));
        add(&mut missed, 1.0, added);
        add(&mut missed, 1.0, &others_there.effect(used, found));
        add(&mut missed, -1.0, &others.effect(used, found));
        let change: Vec<f64> = order.iter().map(|&place| missed[place]).collect();
        let change = linear.moved(&change);
        let far = |i: usize| change.step[i].abs() / ended.sds[i];
        let far = (0..own).map(far).fold(change.ln_evidence.abs() * MISSED / NATS, f64::max);
        Ok((far > MISSED).then_some(Turn::Next { about: next, is_near: far < NEAR }))
    }

    /// The most probable errors, in their standard deviations, where a search ended.
    fn found(&self, parts: &Parts<'_>, values: &[f64], pulls: &[f64]) -> BTreeMap<Cause, f64> {
        let Blocks { observed, used, scatter, .. } = self.blocks;
        let own = self.assembly.parameters().len();
        // Where they are in other blocks, pressures have errors of their own.
        let one_block = in_one_block(&parts.rest, observed, used, scatter);
        let most = |p: usize| if one_block[p] { usize::MAX } else { 2 };
        let mut found = parts.rest.told(used, &parts.order, pulls, most);
        found.extend(parts.common.found(&values[own..]));
        found
    }

    /// The fit that counts, and what follows from it.
    fn finished(&self, parts: &Parts<'_>) -> Result<Trained, EngineError> {
        let Parts { fitting, data, order, options, common, rest, .. } = parts;
        let Blocks { observed, assemblies, .. } = self.blocks;
        let trained = fitting.finish(data, order.clone(), options.clone(), observed.len())?;
        let Trained { linear, noise, parameters, values, covariance, .. } = &trained;
        let learned = assemblies.learned(linear, noise, (&**parameters, &**values, covariance));
        let (for_predictions, told) = self.told(common, rest, &trained);
        let mut warnings = common.explained(trained.warnings);
        warnings.extend(self.bends.warning());
        warnings.extend(self.blocks.drawn_anew(rest));
        let trained = Trained { learned, told, warnings, common: Some(for_predictions), ..trained };
        let own = self.assembly.parameters().len();
        let causes = common.learned(&self.training.causes, own, &trained.gaussian());
        Ok(Trained { causes, ..trained })
    }

    /// Errors that are not of base states, with their effect at `values` of the model's parameters.
    fn others(&self, observed: &[Observed], values: &[f64]) -> Result<PointErrors, EngineError> {
        let (assembly, used) = (self.assembly, self.blocks.used);
        let mut errors = PointErrors::none(observed.len());
        if let Some(law) = &self.law {
            errors = errors.and(law.changes(observed, used, values)?);
        }
        let errors = errors.and(changes_by_factors_of(assembly, observed, used, values)?);
        Ok(if self.drifts { errors.and(of_drift(observed, used)) } else { errors })
    }

    /// What the data tell of `errors` that several points share and that stayed a covariance, and `common`
    /// with these.
    fn told(&self, common: &Common, errors: &PointErrors, trained: &Trained) -> (Common, OfSeveral) {
        let Blocks { observed, used, scatter, .. } = self.blocks;
        let (linear, order) = &*trained.linear;
        let one_block = in_one_block(errors, observed, used, scatter);
        let (_, apart) =
            errors.of_several(observed, used, order, |p| if one_block[p] { 0 } else { usize::MAX });
        let (of_several, columns) =
            errors.of_several(observed, used, order, |p| if one_block[p] { usize::MAX } else { 2 });
        let (for_predictions, names) = common.with(of_several);
        let of_parameters = (&*trained.parameters, &*trained.values, &trained.covariance);
        let learned = Learned::of(linear, names, &columns, &vec![1.0; columns.len()], of_parameters);
        (for_predictions, OfSeveral { learned, columns, apart })
    }
}

impl About {
    /// Whether no base state is further away than [`FARTHEST`].
    fn is_near(&self, observed: &[Observed]) -> bool {
        let near = |cause| self.errors.get(cause).is_none_or(|e| e.abs() <= FARTHEST);
        observed.iter().flat_map(|o| &o.conditions.base.errors).all(|e| near(&e.cause))
    }

    /// The observations in base states with these errors.
    fn states<'o>(&self, observed: &'o [Observed]) -> Cow<'o, [Observed]> {
        let has = |o: &Observed| o.conditions.base.errors.iter().any(|e| self.errors.contains_key(&e.cause));
        if !observed.iter().any(has) {
            return Cow::Borrowed(observed);
        }
        let moved = |o: &Observed| {
            let errors = o.conditions.base.errors.iter();
            let sds: Vec<f64> = errors.map(|e| self.errors.get(&e.cause).copied().unwrap_or(0.0)).collect();
            let base = o.conditions.base.displaced(&sds);
            Observed { conditions: Arc::new(Conditions { base, ..(*o.conditions).clone() }), ..o.clone() }
        };
        Cow::Owned(observed.iter().map(moved).collect())
    }
}

/// A model with a constant taken from each number.
struct Shifted<'a> {
    inner: &'a Predictor<'a>,
    less: &'a [f64],
}

impl Forward for Shifted<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let mut found = self.inner.predict(parameters, order)?;
        found.values.iter_mut().zip(self.less).for_each(|(value, less)| *value -= less);
        Ok(found)
    }

    fn highest_order(&self) -> Order {
        self.inner.highest_order()
    }
}
