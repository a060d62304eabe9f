//! Elements of a rig at one place, where it matters which of them comes first.

use crate::Study;
use crate::doubtful::LAID_OUT;
use crate::law::{Coefficient, Effect};
use rijke_numerics::words::few;

/// Most points that are named.
const NAMED: usize = 5;

impl Study {
    /// Two parts at one place of which one answers to what the other changes, one of them an element of the
    /// rig's file: a sentence for each pair. All laws of a place answer to the state in front of it, so that
    /// neither is behind the other. Laws of candidates at parts without a law of their own add on purpose, as
    /// those of a gauze and of what holds it.
    pub(crate) fn side_by_side(&self) -> Vec<String> {
        let parts = 0..self.rig.parts.len();
        let by = |effects: &[&Effect]| -> Vec<Acts> {
            parts.clone().map(|k| Acts::of(effects.iter().filter(|e| e.place.part() == Some(k)))).collect()
        };
        let own: Vec<&Effect> = self.rig.own.effects.iter().collect();
        let of_candidates = self.catalogue.candidates().iter().flat_map(|c| &c.effects);
        let laws = by(&own.iter().copied().chain(of_candidates).collect::<Vec<_>>());
        let is_element: Vec<bool> = by(&own).into_iter().map(|acts| acts != Acts::default()).collect();
        let pairs = parts.clone().flat_map(|b| (0..b).map(move |a| (a, b)));
        let ordered =
            pairs.filter(|(a, b)| (is_element[*a] || is_element[*b]) && laws[*a].differs_by_order(laws[*b]));
        let mut found: Vec<((usize, usize), Vec<&str>)> = ordered.map(|pair| (pair, Vec::new())).collect();
        if found.is_empty() {
            return Vec::new();
        }
        for point in &self.campaign.points {
            let Ok(rig) = self.rig.at(point, point.ambient.map_or(LAID_OUT, |t| t[0])) else { continue };
            for (_, points) in found.iter_mut().filter(|((a, b), _)| rig.are_at_one_place(*a, *b)) {
                points.push(&point.id);
            }
        }
        let said = |((a, b), points): &((usize, usize), Vec<&str>)| {
            let [a, b] = [*a, *b].map(|k| &self.rig.parts[k].name);
            format!(
                "rig.toml: `{a}` and `{b}` are at one place{}: both answer to the pressure and the velocity in front of that place, so that neither stands \
                 behind the other; put a duct of 1e-6 m between them, or their places 1e-6 m apart",
                // A rig by itself has one point, whose name nobody gave.
                if self.campaign.points.len() == 1 {
                    String::new()
                } else {
                    format!(" at {}", few(points, NAMED))
                }
            )
        };
        found.iter().filter(|(_, points)| !points.is_empty()).map(said).collect()
    }
}

/// What laws at a place change, and what in front of it they answer to: pressure, velocity.
#[derive(Clone, Copy, Default, PartialEq)]
struct Acts {
    change: [bool; 2],
    answer_to: [bool; 2],
}

/// Sources of heat: several at one place are one, which answers to the velocity in front.
const FLAME: Acts = Acts { change: [false, true], answer_to: [false, true] };

impl Acts {
    /// What some laws do together.
    fn of<'a>(effects: impl Iterator<Item = &'a &'a Effect>) -> Self {
        effects.map(|effect| Self::of_one(effect)).fold(Self::default(), |a, b| Self {
            change: either(a.change, b.change),
            answer_to: either(a.answer_to, b.answer_to),
        })
    }

    fn of_one(effect: &Effect) -> Self {
        let (change, answer_to) = match effect.coefficient {
            Coefficient::Mu => ([true, false], [false, true]),
            Coefficient::Mp => ([true, false], [true, false]),
            Coefficient::Eu => ([false, true], [false, true]),
            Coefficient::Ep => ([false, true], [true, false]),
            _ => return Self::default(),
        };
        // A source that hears a velocity elsewhere does not answer to what its neighbours make of it.
        Self { change, answer_to: if effect.hears.is_some() { [false; 2] } else { answer_to } }
    }

    /// Whether it matters which of two comes first.
    fn differs_by_order(self, other: Self) -> bool {
        let told = |first: Self, second: Self| (0..2).any(|k| first.change[k] && second.answer_to[k]);
        (told(self, other) || told(other, self)) && !(self == FLAME && other == FLAME)
    }
}

fn either(a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
    [a[0] || b[0], a[1] || b[1]]
}
