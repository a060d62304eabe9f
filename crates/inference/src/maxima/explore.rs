//! The search for all maxima: from given starts, from the images of what was found, from the best of a sample
//! of the prior.

use super::linkage::{distance, ranks, reach};
use super::terrain::{Peak, Terrain};
use crate::density::{Calls, Gaussian, SAME_MODE};
use crate::error::InferenceError;
use crate::fit::Approach;
use rayon::prelude::*;

/// All that was found.
pub(crate) struct Explored {
    /// The maxima, most evidence first; ends that did not converge come last. At least one.
    pub(crate) peaks: Vec<Peak>,
    /// Ends whose likelihood is so low that their evidence cannot matter.
    pub(crate) unpursued: Vec<Approach>,
    pub(crate) starts: usize,
    pub(crate) failed: usize,
    pub(crate) calls: Calls,
    /// Why there may be maxima that were not found, if there may be.
    pub(crate) open: Option<Open>,
}

/// Why a search may have left maxima out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Open {
    /// The last batch of starts that was allowed still found a new one that counts.
    StillFound,
    /// As many were found as starts do not suffice for.
    FewStarts,
    /// An alias leads to more places within the prior than are looked at.
    ManyImages,
}

/// How widely to search.
#[derive(Clone, Copy)]
pub(crate) struct Breadth {
    /// Points of the prior at which J is looked at.
    pub(crate) screened: usize,
    /// Searches from the best of these in one batch; zero: from given starts and known images alone.
    pub(crate) random_starts: usize,
    /// Most searches from places that nothing but a draw or the caller named. Where the best maximum
    /// contradicts its priors or misses the data, there are more.
    pub(crate) most_starts: usize,
}

/// A second maximum counts if it holds more than this fraction of the evidence of the first, as a logarithm:
/// 5 %.
pub(crate) const MODE_LIMIT: f64 = -3.0;

/// Where there are as many places as this, a batch without a new one does not prove that all are known: ...
const MANY: usize = 3;
/// ... there must have been as many searches for each of them.
const PER_PLACE: usize = 3;

/// A prior may be wrong by some of its standard deviations, and another maximum lie there. Half a batch
/// starts from a sample of the prior taken so many times wider, where the likelihood is largest.
const WIDER: f64 = 4.0;

/// Where the best maximum contradicts its priors or misses the data, so many times a further sample of the
/// prior is taken, of so many points, ...
const DEEPER: usize = 4;
const DEEP: usize = 64;
/// ... and so many searches begin where the likelihood is largest. A maximum that fits may be so narrow that
/// few draws lead to it.
const STARTS_OF_DEEP: usize = 8;

/// Finds the maxima of a posterior: from the centre of its prior and the `given` starts, from the images of
/// what was found, from the best of `breadth.screened` points of the prior in batches of
/// `breadth.random_starts`, for as long as a batch finds a new one, and half a batch from outside of the
/// prior. Where the best of them contradicts its priors or misses the data, from where one parameter alone
/// is far away, and from further samples of the prior, too.
///
/// # Errors
/// Those that are not recoverable, and that of the first start if no start leads anywhere.
pub(crate) fn explore(
    ground: &Terrain,
    given: &[Vec<f64>],
    breadth: Breadth,
) -> Result<Explored, InferenceError> {
    let starts: Vec<Option<&[f64]>> =
        std::iter::once(None).chain(given.iter().map(|g| Some(g.as_slice()))).collect();
    let mut search = Search::first(ground, &starts)?;
    let tried = search.found.starts;
    let near: Vec<Approach> = search.screened(&starts[tried..]);
    search.batch(near, Origin::Own);
    let batch = breadth.random_starts.max(1);
    let mut waiting: Vec<Approach> = Vec::new();
    let (mut rounds, mut last_new, mut beyond) = (0, false, false);
    let mut left = breadth.most_starts.saturating_sub(search.found.starts);
    loop {
        search.follow_images(&mut left, breadth.most_starts);
        if breadth.random_starts == 0 {
            break;
        }
        if waiting.is_empty() && left > 0 {
            waiting = search.sampled(&ground.spread(breadth.screened, 1.0, rounds), |a| a.cost);
            rounds += 1;
        }
        if left == 0 || waiting.is_empty() {
            search.close(last_new);
            break;
        }
        let next: Vec<Approach> = waiting.drain(..batch.min(left).min(waiting.len())).collect();
        left -= next.len();
        let (peaks, heavy) = (search.found.peaks.len(), search.heavy());
        let new = search.batch(next, Origin::Own);
        last_new = search.heavy() > heavy || search.best_place() >= peaks;
        if new || search.few_for(search.places()) {
            continue;
        }
        if beyond || left == 0 {
            search.close(last_new);
            break;
        }
        beyond = true;
        let mut far = search.sampled(&ground.spread(breadth.screened, WIDER, 0), misfit);
        far.truncate(batch.div_ceil(2).min(left));
        left -= far.len();
        if !search.batch(far, Origin::Own) {
            break;
        }
    }
    if breadth.random_starts > 0 && search.is_in_doubt() {
        let far = search.beyond(batch);
        if search.batch(far, Origin::Own) {
            search.follow_images(&mut left, breadth.most_starts);
        }
        for round in 0..DEEPER {
            if !search.is_in_doubt() {
                break;
            }
            let mut more = search.sampled(&ground.spread(DEEP, 1.0, rounds + round), misfit);
            more.truncate(STARTS_OF_DEEP);
            if search.batch(more, Origin::Own) {
                search.follow_images(&mut left, breadth.most_starts);
            }
        }
    }
    Ok(search.done())
}

/// What led to a start.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// A draw, the caller, or the centre of the prior.
    Own,
    /// An alias of a maximum that is known.
    Image,
}

pub(super) struct Search<'a> {
    pub(super) ground: &'a Terrain<'a>,
    pub(super) found: Explored,
    /// For each peak, whether its images are known.
    pub(super) imaged: Vec<bool>,
    /// The best peaks whose images were looked at.
    pub(super) bests: Vec<Vec<f64>>,
    /// How many others there were whose images were looked at.
    pub(super) families: usize,
    /// Searches from images, and the new places to which they led.
    pub(super) of_images: [usize; 2],
}

impl<'a> Search<'a> {
    /// The fit from the first start that leads anywhere.
    fn first(ground: &'a Terrain<'a>, starts: &[Option<&[f64]>]) -> Result<Self, InferenceError> {
        let mut first_error = None;
        for (k, start) in starts.iter().enumerate() {
            let peak = ground
                .screen(*start)
                .and_then(|at| ground.approach(at, &[]))
                .and_then(|near| ground.finish(near));
            match peak {
                Ok(peak) => {
                    let (calls, failed) = (peak.calls, k + usize::from(!peak.converged));
                    let found = Explored {
                        peaks: vec![peak],
                        unpursued: Vec::new(),
                        starts: k + 1,
                        failed,
                        calls,
                        open: None,
                    };
                    let (imaged, bests) = (vec![false], Vec::new());
                    return Ok(Self { ground, found, imaged, bests, families: 0, of_images: [0; 2] });
                }
                Err(error) => {
                    first_error.get_or_insert(error);
                }
            }
        }
        Err(first_error.unwrap_or(InferenceError::StartSize { found: 0, expected: 1 }))
    }

    /// Where searches from these starts begin. Starts at which the model fails are counted, and left out.
    pub(super) fn screened(&mut self, starts: &[Option<&[f64]>]) -> Vec<Approach> {
        let all: Vec<_> = starts.par_iter().map(|s| self.ground.screen(*s)).collect();
        self.found.calls.value += all.iter().filter(|a| a.is_err()).count();
        let good: Vec<Approach> = all.into_iter().flatten().collect();
        self.found.starts += starts.len() - good.len();
        self.found.failed += starts.len() - good.len();
        good
    }

    /// The places that searches ended at, without those that images alone led to.
    fn places(&self) -> usize {
        self.found.peaks.len() + self.found.unpursued.len() - self.of_images[1]
    }

    /// Whether there were too few searches, without those from images, to prove that so many places are all.
    fn few_for(&self, places: usize) -> bool {
        places >= MANY && self.found.starts - self.of_images[0] < PER_PLACE * places
    }

    /// How many maxima count beside the best one, and that.
    fn heavy(&self) -> usize {
        let ln = |p: &Peak| p.ln_marginal.unwrap_or(f64::NEG_INFINITY);
        let least = ln(self.best()) + MODE_LIMIT;
        self.found.peaks.iter().filter(|p| ln(p) > least).count()
    }

    /// Says why there may be more maxima that count, where a search ends for want of starts.
    fn close(&mut self, last_new: bool) {
        let heavy = self.heavy();
        if last_new {
            self.found.open = Some(Open::StillFound);
        } else if self.found.open.is_none() && self.few_for(heavy.min(self.places())) {
            self.found.open = Some(Open::FewStarts);
        }
    }

    /// A sample in the order in which it is worth a descent: points that no better one is close to, then the
    /// others, each by its `price` (the rule of single linkage: Rinnooy Kan & Timmer 1987, Math. Program. 39,
    /// 57).
    fn sampled(&mut self, starts: &[Vec<f64>], price: fn(&Approach) -> f64) -> Vec<Approach> {
        let all: Vec<_> = starts.par_iter().map(|s| self.ground.screen(Some(s))).collect();
        // A draw at which the model fails is no failed search.
        self.found.calls.value += all.iter().filter(|a| a.is_err()).count();
        let mut good: Vec<(&Vec<f64>, Approach)> =
            starts.iter().zip(all).filter_map(|(s, a)| Some((s, a.ok()?))).collect();
        good.sort_by(|a, b| price(&a.1).total_cmp(&price(&b.1)));
        let best = self.best();
        let metric = best.gaussian.clone();
        let ranks = ranks(&good.iter().map(|g| g.0.as_slice()).collect::<Vec<_>>());
        let reach = reach(good.len(), ranks.first().map_or(0, Vec::len));
        let lonely = |k: usize| (0..k).all(|j| distance(&ranks[j], &ranks[k]) > reach);
        let first: Vec<bool> = (0..good.len()).map(lonely).collect();
        let known =
            |a: &Approach| metric.as_ref().is_some_and(|g| g.distance(&self.ground.inner(&a.z)) < SAME_MODE);
        let mut ordered: Vec<(bool, Approach)> =
            good.into_iter().zip(first).map(|((_, a), first)| (!first, a)).collect();
        ordered.retain(|(_, a)| !known(a));
        ordered.sort_by_key(|(late, _)| *late);
        // The calls of those that no descent starts from.
        self.found.calls.value += ordered.len();
        ordered.into_iter().map(|(_, a)| a.counted()).collect()
    }

    pub(super) fn best(&self) -> &Peak {
        &self.found.peaks[self.best_place()]
    }

    pub(super) fn best_place(&self) -> usize {
        let peaks = &self.found.peaks;
        // There is one from the start on.
        (0..peaks.len()).min_by(|&a, &b| order(&peaks[a], &peaks[b])).unwrap_or(0)
    }

    /// True if a point belongs to a maximum that is known.
    pub(super) fn known_at(&self, z: &[f64]) -> bool {
        let inner = self.ground.inner(z);
        self.found.peaks.iter().any(|p| p.gaussian.as_ref().is_some_and(|g| g.distance(&inner) < SAME_MODE))
    }

    /// True if two points are one maximum, by the shape of the best one.
    fn same(&self, a: &[f64], b: &[f64]) -> bool {
        self.best().gaussian.as_ref().is_some_and(|g| {
            let offset: Vec<f64> = a.iter().zip(b).zip(&g.mean).map(|((a, b), m)| a - b + m).collect();
            g.distance(&offset) < SAME_MODE
        })
    }

    /// Descends from all of these; true if that led to a place that was not known.
    pub(super) fn batch(&mut self, starts: Vec<Approach>, origin: Origin) -> bool {
        self.found.starts += starts.len();
        let before = self.found.peaks.len() + self.found.unpursued.len();
        if origin == Origin::Image {
            self.of_images[0] += starts.len();
        }
        let known: Vec<Gaussian> = self.found.peaks.iter().filter_map(|p| p.gaussian.clone()).collect();
        let ends: Vec<_> = starts.into_par_iter().map(|s| self.ground.approach(s, &known)).collect();
        self.found.failed += ends.iter().filter(|end| end.is_err()).count();
        let mut ends: Vec<Approach> = ends.into_iter().flatten().collect();
        // Settled ends first, then by cost; the sort is stable, so ties keep the order of the starts.
        ends.sort_by(|a, b| b.settled.cmp(&a.settled).then(a.cost.total_cmp(&b.cost)));
        let limit = self.best().ln_marginal.map_or(f64::NEG_INFINITY, |ln| ln + MODE_LIMIT - 1.0);
        let (mut others, mut new): (Vec<Approach>, bool) = (Vec::new(), false);
        for end in ends {
            let inner = self.ground.inner(&end.z);
            if end.settled && self.known_at(&end.z) {
                self.found.calls = self.found.calls.plus(end.calls);
            } else if end.settled && end.ln_likelihood < limit {
                // An evidence is a mean of the likelihood, and cannot exceed its maximum: this one cannot
                // matter.
                self.found.calls = self.found.calls.plus(end.calls);
                let seen = |u: &Approach| self.same(&self.ground.inner(&u.z), &inner);
                if !self.found.unpursued.iter().any(seen) {
                    new = true;
                    self.found.unpursued.push(end);
                }
            } else if end.settled
                && others.iter().any(|o| o.settled && self.same(&self.ground.inner(&o.z), &inner))
            {
                self.found.calls = self.found.calls.plus(end.calls);
            } else {
                others.push(end);
            }
        }
        let peaks: Vec<_> = others.into_par_iter().map(|near| self.ground.finish(near)).collect();
        for peak in peaks {
            let Ok(peak) = peak else {
                self.found.failed += 1;
                continue;
            };
            self.found.calls = self.found.calls.plus(peak.calls);
            self.found.failed += usize::from(!peak.converged);
            let seen = |p: &Peak| {
                p.gaussian.as_ref().is_some_and(|g| g.distance(&peak.z) < SAME_MODE)
                    || self.same(&p.z, &peak.z)
            };
            if !self.found.peaks.iter().any(seen) {
                new |= peak.converged;
                self.found.peaks.push(peak);
                self.imaged.push(origin == Origin::Image);
            }
        }
        if origin == Origin::Image {
            self.of_images[1] += self.found.peaks.len() + self.found.unpursued.len() - before;
        }
        new
    }

    fn done(self) -> Explored {
        let mut found = self.found;
        found.peaks.sort_by(order);
        let metric = found.peaks[0].gaussian.clone();
        // What was left alone on the way to a better maximum may be that one.
        found
            .unpursued
            .retain(|u| metric.as_ref().is_none_or(|g| g.distance(&self.ground.inner(&u.z)) >= SAME_MODE));
        found.unpursued.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        found
    }
}

/// What a point costs without its prior, where that is known apart.
pub(super) fn misfit(at: &Approach) -> f64 {
    if at.ln_likelihood.is_finite() { -at.ln_likelihood } else { at.cost }
}

/// Converged ends first, then those with more evidence, then by J.
fn order(a: &Peak, b: &Peak) -> std::cmp::Ordering {
    let ln = |p: &Peak| p.ln_marginal.unwrap_or(f64::NEG_INFINITY);
    b.converged.cmp(&a.converged).then(ln(b).total_cmp(&ln(a))).then(a.cost.total_cmp(&b.cost))
}
