//! Ends and walls that the file of the rig and a candidate bring together: their laws add up.

use super::model::{LawAt, PointModel};
use crate::assembly::part_of_wall;
use rijke_network::Slot;
use rijke_numerics::C64;
use rijke_study::Coefficient;

/// |R| of two laws together above which each is a whole end, and not one a correction of the other.
const WHOLE: f64 = 1.01;
/// Loss of a candidate over that of the rig's file above which it is a whole wall, and no correction of one.
const WALL: f64 = 0.5;

impl PointModel<'_> {
    /// |R| at s = i omega of the upstream and the downstream end, of those that laws describe; none in rigs
    /// whose lengths are unknown.
    pub(crate) fn end_reflections(&self, values: &[f64], omega: f64) -> [Option<f64>; 2] {
        let laws = self.law_values(values, omega);
        let mut ends: [Option<C64>; 2] = [None; 2];
        for (end, law, weight) in self.at_ends() {
            if let Some(value) = laws.get(law) {
                *ends[end].get_or_insert_default() += value * weight;
            }
        }
        ends.map(|r| r.map(C64::norm))
    }

    /// Which laws act at the upstream (0) and the downstream (1) end, with their weights.
    fn at_ends(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.network.attachments().filter_map(|(slot, law, weight)| match slot {
            Slot::Upstream => Some((0, law, weight)),
            Slot::Downstream => Some((1, law, weight)),
            _ => None,
        })
    }

    /// What the rig's file and a candidate both bring at parameters `values` and s = i omega, in sentences.
    pub(crate) fn doubled(&self, values: &[f64], omega: f64) -> Vec<String> {
        let values = self.law_values(values, omega);
        let mut end_of = vec![None; values.len()];
        for (end, law, _) in self.at_ends() {
            if let Some(known) = end_of.get_mut(law) {
                *known = Some(end);
            }
        }
        let laws = self.laws.iter().zip(end_of);
        let all: Vec<(&LawAt, Option<usize>, C64)> =
            laws.zip(values).map(|((law, end), value)| (law, end, value)).collect();
        let of_rig = |law: &LawAt| self.assembly.candidates()[law.candidate].id == self.assembly.rig.own.id;
        let mut said = Vec::new();
        for (own, end, value) in all.iter().filter(|(law, ..)| of_rig(law)) {
            let effect = self.effect(own);
            let like = |other: &LawAt, end_of_other: &Option<usize>| {
                let effect_of_other = self.effect(other);
                let same_end = end.is_some() && end_of_other == end;
                let same_wall =
                    [effect, effect_of_other].map(part_of_wall) == [Some(0); 2] && other.around == own.around;
                effect_of_other.coefficient == effect.coefficient && (same_end || same_wall)
            };
            let others = || all.iter().filter(|(law, end, _)| !of_rig(law) && like(law, end));
            let Some((first, ..)) = others().next() else { continue };
            let (by, place) = (&self.assembly.candidates()[first.candidate].id, &effect.place_text);
            let sum: C64 = others().map(|(.., value)| value).sum();
            if effect.place.is_end() && effect.coefficient == Coefficient::Reflection {
                let both = (value + sum).norm();
                if both > WHOLE {
                    said.push(format!(
                        "the reflection of `{by}` adds to that which rig.toml has at {place}: |R| is {both:.2} together. Write type = \"free\" there, or \
                         give the candidate the difference alone"
                    ));
                }
            } else if part_of_wall(effect) == Some(0) && sum.norm() > WALL * value.norm() {
                let times = (value + sum).norm() / value.norm();
                said.push(format!(
                    "the loss of `{by}` at the wall adds to that which rig.toml has at {place} (`wall`): {times:.1} times that together. Write wall = \
                     \"none\" there, or give the candidate the difference alone"
                ));
            }
        }
        said.sort();
        said.dedup();
        said
    }
}
