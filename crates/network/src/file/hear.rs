//! Flames that answer to a velocity elsewhere, in a chain at rest.

use super::assembly::{Assembly, Listener};
use super::error::FileError;
use super::item::Item;
use super::problem::ElementProblem;
use crate::chain::network::Network;
use crate::laws::{HeardLaws, NoReference};

impl Listener {
    fn fault(&self, why: NoReference) -> FileError {
        let message = format!("its velocity reference is {} m away, {why}", self.distance);
        self.item.fail(ElementProblem::Keys { message })
    }
}

impl Assembly<'_> {
    /// The segment in which the velocity lies that a device at `place` answers to; none where it is that at
    /// the device.
    pub(super) fn reference(
        &self,
        item: &Item,
        place: usize,
        distance: f64,
        downstream: bool,
    ) -> Result<Option<usize>, FileError> {
        let other_at = |at: usize| self.devices.iter().find(|(j, name)| *j == at && *name != item.place);
        if downstream && let Some((_, other)) = other_at(place) {
            return Err(item.fail(ElementProblem::NotAlone { other: other.clone() }));
        }
        let n = self.segments.len();
        let way: Vec<usize> = if downstream { (place..n).collect() } else { (0..place).rev().collect() };
        let length: f64 = way.iter().map(|&i| self.segments[i].length).sum();
        if distance > length * (1.0 + 1e-9) {
            return Err(item.fail(ElementProblem::ReferenceOutside { distance, length }));
        }
        let (mut reached, mut left) = (None, distance);
        for i in way {
            if left <= 1e-9 * length {
                break;
            }
            let between = if downstream { i } else { i + 1 };
            if reached.is_some()
                && let Some((_, other)) = other_at(between)
            {
                return Err(item.fail(ElementProblem::ReferenceBlocked { other: other.clone() }));
            }
            reached = Some(i);
            left -= self.segments[i].length;
        }
        Ok(reached)
    }

    /// Attaches the flames that answer to a velocity elsewhere, when all else is attached. Lumped wall losses
    /// do not stand in their way: the velocity is as without them.
    pub(super) fn listen(&mut self, network: &mut Network) -> Result<(), FileError> {
        let (spread, compact): (Vec<Listener>, Vec<Listener>) =
            std::mem::take(&mut self.listeners).into_iter().partition(|flame| flame.spread.is_some());
        let places = |all: &[Listener]| -> Vec<usize> { all.iter().map(|flame| flame.place).collect() };
        let first = self.laws.laws.len();
        let HeardLaws { of_compact, of_spread } =
            network.attach_heard(first, &places(&compact), &places(&spread))?;
        for (flame, own) in compact.iter().zip(of_compact) {
            let Listener { place, law, distance, downstream, .. } = *flame;
            let may_act = [&own[..], &self.of_walls].concat();
            let heard = network.remote_source(place, distance, downstream, law, &may_act);
            self.laws.heard.sources.push(heard.map_err(|why| flame.fault(why))?);
        }
        for (flame, own) in spread.iter().zip(of_spread) {
            let Some((end, pieces)) = &flame.spread else { continue };
            let may_act = [&own[..], &self.of_walls].concat();
            let heard = network.remote_spread([flame.place, *end], pieces, flame.distance, &may_act);
            self.laws.heard.spreads.push(heard.map_err(|why| flame.fault(why))?);
        }
        Ok(())
    }
}
