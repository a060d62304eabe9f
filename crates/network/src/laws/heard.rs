//! All sources of a chain at rest that answer to a velocity elsewhere: their laws, which follow others.

use super::remote::RemoteSource;
use super::remote_spread::RemoteSpread;
use super::zeros_near;
use crate::chain::coefficients::{At, Laws, Pole};
use crate::chain::network::Network;
use crate::error::NetworkError;
use crate::plane::region::Region;
use crate::slot::Slot;
use rijke_numerics::C64;
use std::f64::consts::PI;

/// Sources that answer to a velocity elsewhere. Their laws are numbered after the `first` ones of a caller,
/// among which are their T: two of every compact source, then four of every spread one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heard {
    /// Compact ones, with k_eu and k_ep.
    pub sources: Vec<RemoteSource>,
    /// Those spread along ducts, with k_eu, k_mu, k_ep and k_mp.
    pub spreads: Vec<RemoteSpread>,
}

/// Numbers of the laws of a [`Heard`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeardLaws {
    /// Of every compact source.
    pub of_compact: Vec<[usize; 2]>,
    /// Of every spread one.
    pub of_spread: Vec<[usize; 4]>,
}

impl Network {
    /// Attaches the laws of a [`Heard`] with compact sources at places `compact` and spread ones that begin
    /// at `spread`, after `first` other laws, and gives their numbers.
    ///
    /// # Errors
    /// As [`Network::attach`].
    pub fn attach_heard(
        &mut self,
        first: usize,
        compact: &[usize],
        spread: &[usize],
    ) -> Result<HeardLaws, NetworkError> {
        let beyond = first + 2 * compact.len();
        let of_compact: Vec<[usize; 2]> =
            (0..compact.len()).map(|h| [0, 1].map(|k| first + 2 * h + k)).collect();
        let of_spread: Vec<[usize; 4]> =
            (0..spread.len()).map(|h| [0, 1, 2, 3].map(|k| beyond + 4 * h + k)).collect();
        for (&j, numbers) in compact.iter().zip(&of_compact) {
            for (slot, law) in [Slot::Eu(j), Slot::Ep(j)].into_iter().zip(numbers) {
                self.attach(slot, *law, 1.0)?;
            }
        }
        for (&j, numbers) in spread.iter().zip(&of_spread) {
            for (slot, law) in [Slot::Eu(j), Slot::Mu(j), Slot::Ep(j), Slot::Mp(j)].into_iter().zip(numbers) {
                self.attach(slot, *law, 1.0)?;
            }
        }
        Ok(HeardLaws { of_compact, of_spread })
    }
}

impl Heard {
    /// Number of their laws.
    #[must_use]
    pub fn laws(&self) -> usize {
        2 * self.sources.len() + 4 * self.spreads.len()
    }

    /// The source, or what a spread one hears, whose law has number `beyond` after the `first` ones.
    #[must_use]
    pub fn source_of(&self, beyond: usize) -> Option<&RemoteSource> {
        match beyond.checked_sub(2 * self.sources.len()) {
            None => self.sources.get(beyond / 2),
            Some(k) => self.spreads.get(k / 4).map(|flame| &flame.source),
        }
    }

    /// For a law of a compact source: how far downstream its velocity lies, m, negative upstream.
    #[must_use]
    pub fn reference_at(&self, beyond: usize) -> Option<f64> {
        self.sources.get(beyond / 2).map(|source| source.distance)
    }

    /// Writes their laws, when the `first` others are in `laws`.
    pub fn fill(&self, first: usize, at: &At, laws: &mut Laws) {
        for (h, source) in self.sources.iter().enumerate() {
            for (k, jet) in source.coefficients(at, laws).iter().enumerate() {
                laws.set(first + 2 * h + k, jet);
            }
        }
        let beyond = first + 2 * self.sources.len();
        for (h, flame) in self.spreads.iter().enumerate() {
            for (k, jet) in flame.coefficients(at, laws).iter().enumerate() {
                laws.set(beyond + 4 * h + k, jet);
            }
        }
    }

    /// Whether law number `law` has poles that another of the same spread flame has.
    #[must_use]
    pub fn repeats(&self, law: usize) -> bool {
        self.spreads.iter().any(|flame| flame.repeats(law))
    }

    /// Whether law number `law` is T of a source that hears what is behind it.
    #[must_use]
    pub fn is_in_a_loop(&self, law: usize) -> bool {
        self.sources.iter().any(|source| source.is_a_loop() && source.law == law)
    }

    /// Puts the poles of these sources in the place of those of their T, which `all` has: the same upstream,
    /// and those of the loop downstream. `fill` writes the `first` other laws, `delay` is that of a T (s),
    /// and `longest` the longest interval between samples that the laws themselves allow.
    ///
    /// # Errors
    /// As [`Network::modes`], if the search for those of a loop fails.
    pub fn poles(
        &self,
        first: usize,
        all: &mut Vec<Pole>,
        region: &Region,
        fill: impl Fn(&At, &mut Laws),
        (longest, delay): (f64, impl Fn(usize) -> f64),
    ) -> Result<(), NetworkError> {
        for (h, source) in self.sources.iter().enumerate() {
            let (law, of_t) = (first + 2 * h, |p: &Pole| p.law == source.law);
            if !source.is_a_loop() {
                all.iter_mut().filter(|p| of_t(p)).for_each(|p| p.law = law);
                continue;
            }
            // At a pole of T the coefficients of a loop are finite.
            let poles: Vec<(C64, usize)> = all.iter().filter(|p| of_t(p)).map(|p| (p.at, p.order)).collect();
            all.retain(|p| !of_t(p));
            let open_loop = |s: C64| {
                let (at, mut laws) = (At::search(s), Laws::default());
                laws.reset(first, &at);
                fill(&at, &mut laws);
                let jet = source.open_loop(&at, &laws);
                jet.map_or([C64::ONE, C64::ZERO], |jet| [jet.value(), jet.gradient()[0]])
            };
            let step = (0.25 * PI / (source.travel_time() + delay(source.law))).min(longest);
            let zeros = zeros_near(open_loop, region, step, &poles)?;
            // Both coefficients have the poles, but the network only once: k_eu declares them.
            all.extend(zeros.into_iter().map(|(at, order)| Pole { law, at, order }));
        }
        let beyond = first + 2 * self.sources.len();
        for (h, flame) in self.spreads.iter().enumerate() {
            all.iter_mut().filter(|p| p.law == flame.source.law).for_each(|p| p.law = beyond + 4 * h);
        }
        Ok(())
    }
}
