//! A flame spread along the ducts of a chain at rest, by laws of a caller.

use super::remote::{NoReference, Passed, RemoteSource};
use super::stretch::carry;
use crate::chain::coefficients::{At, Laws};
use crate::chain::network::Network;
use rijke_numerics::{C64, Jet};

/// Heat that is released at many places behind each other and answers to one velocity before the first: its
/// k_eu, k_mu, k_ep and k_mp as one step of pressure and velocity at the first place.
///
/// Volume flow G_k T_k u_ref at x_k, G_k being the part of the heat, is the same, upstream of the first place
/// and downstream of the last, as a step of pressure and velocity at the first: with M_k the transfer matrix
/// of the ducts from there to x_k, M_k^-1 (0, 1) = (-M_12, M_11). Between, the field is that of the
/// equivalent step.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteSpread {
    /// Where the velocity is; its law is that of the first place.
    pub source: RemoteSource,
    places: Vec<Released>,
}

/// A piece of a spread flame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadPiece {
    /// Its place in the network.
    pub place: usize,
    /// Number of the law that is T, of all the heat.
    pub law: usize,
    /// Part of the heat.
    pub weight: f64,
}

/// A place at which heat is released.
#[derive(Clone, Debug, PartialEq)]
struct Released {
    /// The ducts from the place before.
    path: Vec<Passed>,
    /// Number of the law that is T, of all the heat.
    law: usize,
    /// Part of the heat.
    weight: f64,
}

/// The parts of the heat that equal pieces of a spread flame release, for a density at equally spaced points
/// from end to end, linear between them, up to a factor. None where the density is 0 in every middle.
#[must_use]
pub fn spread_weights(density: &[f64], pieces: usize) -> Option<Vec<f64>> {
    let last = density.len().max(2) - 1;
    let points: Vec<f64> = (0..=last).map(|k| k as f64 / last as f64).collect();
    let at = |k: usize| match density {
        [] => 0.0,
        [even] => *even,
        _ => rijke_numerics::interpolate(&points, density, spread_middle(k, pieces)),
    };
    let weights: Vec<f64> = (0..pieces).map(at).collect();
    let sum: f64 = weights.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| weights.iter().map(|weight| weight / sum).collect())
}

/// Where piece `k` of so many releases its heat: in its middle, 0 at the beginning of the flame and 1 at its
/// end.
#[must_use]
pub fn spread_middle(k: usize, pieces: usize) -> f64 {
    (k as f64 + 0.5) / pieces as f64
}

impl Network {
    /// The flame of these `pieces` that begins at `place` and ends at `end`; it answers to the velocity
    /// `distance` (m) upstream of where it begins. `own` are the laws that it has attached for its four
    /// coefficients. Ask when all else is attached.
    ///
    /// # Errors
    /// [`NoReference`].
    pub fn remote_spread(
        &self,
        [place, end]: [usize; 2],
        pieces: &[SpreadPiece],
        distance: f64,
        own: &[usize],
    ) -> Result<RemoteSpread, NoReference> {
        let first = pieces.first().map_or(0, |piece| piece.law);
        let source = self.remote_source(place, distance, false, first, own)?;
        if (place + 1..end).any(|at| self.acts(at, own)) {
            return Err(NoReference::Inside);
        }
        let (mut places, mut from, mut area) = (Vec::with_capacity(pieces.len()), place, None);
        for &SpreadPiece { place: to, law, weight } in pieces {
            let path = (from..to).map(|i| {
                let here = self.segments[i].area;
                let ratio = area.replace(here).map_or(1.0, |before: f64| before / here);
                self.passed(i, ratio)
            });
            places.push(Released { path: path.collect(), law, weight });
            from = to;
        }
        Ok(RemoteSpread { source, places })
    }
}

impl RemoteSpread {
    /// Whether law number `law` is T of one of the places, but not that of the first, which has the poles of
    /// all.
    #[must_use]
    pub fn repeats(&self, law: usize) -> bool {
        law != self.source.law && self.places.iter().any(|place| place.law == law)
    }

    /// k_eu, k_mu, k_ep and k_mp at `at`, where `laws` holds T and the losses of the ducts.
    #[must_use]
    pub fn coefficients(&self, at: &At, laws: &Laws) -> [Jet; 4] {
        let (s, space) = (at.s_jet(), at.space());
        let mut state = [[1.0, 0.0], [0.0, 1.0]].map(|row| row.map(|v| space.real(v)));
        let mut sums = [space.real(0.0), space.real(0.0)];
        for place in &self.places {
            for duct in &place.path {
                state = carry(&duct.at(laws, space), &state, &s);
            }
            let [on_p, on_u] = &state[0];
            let t = laws.jet(place.law).scale(C64::new(self.source.factor * place.weight, 0.0));
            sums = [&sums[0] + &(on_p * &t), &sums[1] - &(on_u * &t)];
        }
        let [beta, alpha] = self.source.row(at, laws);
        let [of_velocity, of_pressure] = [&alpha, &beta].map(|heard| [0, 1].map(|k| -&(&sums[k] * heard)));
        let ([eu, mu], [ep, mp]) = (of_velocity, of_pressure);
        [eu, mu, ep, mp]
    }
}
