//! A source of a chain at rest that answers to the velocity elsewhere, by laws of a caller.

use super::stretch::{Side, Stretch, row};
use crate::chain::coefficients::{At, Laws};
use crate::chain::network::{Network, Segment};
use crate::slot::Slot;
use rijke_numerics::{C64, Jet, JetSpace};

/// A source u2 - r u1 = T u_ref, where T is a law times a factor and only ducts lie between the source and
/// u_ref: its k_eu and k_ep.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteSource {
    /// Number of the law that is T.
    pub law: usize,
    /// What it is multiplied by.
    pub factor: f64,
    /// How far downstream u_ref is, m; negative upstream.
    pub distance: f64,
    side: Side,
    path: Vec<Passed>,
}

/// A duct on the way to the reference.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Passed {
    index: usize,
    segment: Segment,
    ratio: f64,
    /// Viscous and thermal losses per metre: laws and their weights.
    losses: [Vec<(usize, f64)>; 2],
}

/// Why a source cannot have its reference where it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoReference {
    /// The reference lies outside.
    #[error("which lies outside of the ducts: give a smaller distance")]
    Outside,
    /// Something acts between.
    #[error("but something acts between: only ducts may")]
    Blocked,
    /// Something acts where the source is, whose reference lies downstream.
    #[error("downstream, but something else acts where it is: it must stand alone")]
    NotAlone,
    /// Something acts within the flame.
    #[error("but something acts inside the flame: only ducts may lie there")]
    Inside,
}

impl Passed {
    /// The duct with its losses at `laws`.
    pub(super) fn at(&self, laws: &Laws, space: JetSpace) -> Stretch {
        let lost = |part: &[(usize, f64)]| {
            part.iter()
                .fold(space.real(0.0), |sum, (k, weight)| &sum + &laws.jet(*k).scale(C64::new(*weight, 0.0)))
        };
        (self.segment, self.ratio, [lost(&self.losses[0]), lost(&self.losses[1])])
    }
}

impl Network {
    /// The source at `place` whose velocity lies `distance` (m) downstream of it, or upstream; `own` are
    /// the laws that may act there: those that it has attached for k_eu and k_ep. Ask when all else is
    /// attached.
    ///
    /// # Errors
    /// [`NoReference`].
    pub fn remote_source(
        &self,
        place: usize,
        distance: f64,
        downstream: bool,
        law: usize,
        own: &[usize],
    ) -> Result<RemoteSource, NoReference> {
        let n = self.segments.len();
        if downstream && self.acts(place, own) {
            return Err(NoReference::NotAlone);
        }
        let way: Vec<usize> = if downstream { (place..n).collect() } else { (0..place).rev().collect() };
        let total: f64 = self.segments.iter().map(|s| s.length).sum();
        let (mut path, mut left): (Vec<Passed>, f64) = (Vec::new(), distance);
        for i in way {
            if left <= 1e-9 * total {
                break;
            }
            let between = if downstream { i } else { i + 1 };
            if !path.is_empty() && self.acts(between, own) {
                return Err(NoReference::Blocked);
            }
            let ratio = path.last().map_or(1.0, |p| p.segment.area / self.segments[i].area);
            let mut passed = self.passed(i, ratio);
            passed.segment.length = passed.segment.length.min(left);
            left -= passed.segment.length;
            path.push(passed);
        }
        if left > 1e-9 * total {
            return Err(NoReference::Outside);
        }
        let inside = place > 0 && place < n;
        let ratio = if inside { self.segments[place - 1].area / self.segments[place].area } else { 1.0 };
        let (side, distance) =
            if downstream { (Side::Downstream { ratio }, distance) } else { (Side::Upstream, -distance) };
        Ok(RemoteSource { law, factor: 1.0, distance, side, path })
    }
}

impl Network {
    /// Whether anything but the laws `own` acts at a place.
    pub(super) fn acts(&self, at: usize, own: &[usize]) -> bool {
        self.attachments().any(|(slot, law, _)| {
            let here = matches!(slot, Slot::Mu(j) | Slot::Mp(j) | Slot::Eu(j) | Slot::Ep(j) if j == at);
            here && !own.contains(&law)
        })
    }

    /// The whole of segment `i` on a way, with the losses that are attached to it.
    pub(super) fn passed(&self, i: usize, ratio: f64) -> Passed {
        let losses = [0, 1].map(|part| {
            let of = |(slot, law, weight): (Slot, usize, f64)| match slot {
                Slot::Viscous(k) if k == i && part == 0 => Some((law, weight)),
                Slot::Thermal(k) if k == i && part == 1 => Some((law, weight)),
                _ => None,
            };
            self.attachments().filter_map(of).collect()
        });
        Passed { index: i, segment: self.segments[i], ratio, losses }
    }
}

impl RemoteSource {
    /// The segment in which the reference lies; none where it is that at the source.
    #[must_use]
    pub fn segment(&self) -> Option<usize> {
        self.path.last().map(|p| p.index)
    }

    /// Time that sound needs to the reference, s.
    #[must_use]
    pub fn travel_time(&self) -> f64 {
        self.path.iter().map(|p| p.segment.length / p.segment.sound_speed).sum()
    }

    /// Whether the reference lies behind the source, so that it hears itself.
    #[must_use]
    pub fn is_a_loop(&self) -> bool {
        self.side != Side::Upstream
    }

    /// k_eu and k_ep at `at`, where `laws` holds T and the losses of the ducts.
    #[must_use]
    pub fn coefficients(&self, at: &At, laws: &Laws) -> [Jet; 2] {
        self.side.coefficients(&self.transfer(laws), &self.row(at, laws))
    }

    /// 1 - T alpha, whose zeros are poles of the coefficients if the reference lies downstream; none
    /// upstream.
    #[must_use]
    pub fn open_loop(&self, at: &At, laws: &Laws) -> Option<Jet> {
        let [_, alpha] = self.row(at, laws);
        self.is_a_loop().then(|| (-&(&self.transfer(laws) * &alpha)).shift(C64::ONE))
    }

    /// beta and alpha: the velocity at the reference as a row on (p, u) at the source.
    pub(super) fn row(&self, at: &At, laws: &Laws) -> [Jet; 2] {
        let stretches: Vec<_> = self.path.iter().map(|p| p.at(laws, at.space())).collect();
        row(&stretches, self.side, &at.s_jet(), at.space())
    }

    /// T with its factor.
    fn transfer(&self, laws: &Laws) -> Jet {
        laws.jet(self.law).scale(C64::new(self.factor, 0.0))
    }
}
