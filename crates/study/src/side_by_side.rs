//! Elements of a rig at one place, where it matters which of them comes first.

use crate::law::{Coefficient, Effect};
use crate::{PartAt, Study};
use rijke_numerics::words::few;

/// Places closer than this part of the length are the same.
const SAME: f64 = 1e-9;
/// Most points that are named.
const NAMED: usize = 5;

impl Study {
    /// Two parts at one place of which one answers to what the other changes, one of them an element of the
    /// rig's file: a sentence for each pair. All laws of a place answer to the state in front of it, so that
    /// neither is behind the other. Laws of candidates at parts without a law of their own add on purpose, as
    /// those of a heater and of what holds it.
    pub(crate) fn side_by_side(&self) -> Vec<String> {
        let own: Vec<&Effect> = self.rig.own.effects.iter().collect();
        let of_candidates = self.catalogue.candidates().iter().flat_map(|c| &c.effects);
        let all: Vec<&Effect> = own.iter().copied().chain(of_candidates).collect();
        let acting = |list: &[&Effect], part: usize| {
            list.iter()
                .filter(|e| e.place.part() == Some(part))
                .map(|e| acts(e))
                .fold([[false; 2]; 2], either)
        };
        let parts = 0..self.rig.parts.len();
        let element: Vec<bool> = parts.clone().map(|k| acting(&own, k) != [[false; 2]; 2]).collect();
        let laws: Vec<_> = parts.clone().map(|k| acting(&all, k)).collect();
        let ordered = |a: usize, b: usize| {
            let answers = |first: [[bool; 2]; 2], second: [[bool; 2]; 2]| {
                (0..2).any(|of| first[CHANGES][of] && second[ANSWERS][of])
            };
            let one_flame = laws[a] == FLAME && laws[b] == FLAME;
            (element[a] || element[b])
                && !one_flame
                && (answers(laws[a], laws[b]) || answers(laws[b], laws[a]))
        };
        let pairs = parts.clone().flat_map(|b| (0..b).map(move |a| (a, b)));
        let pairs: Vec<(usize, usize)> = pairs.filter(|(a, b)| ordered(*a, *b)).collect();
        if pairs.is_empty() {
            return Vec::new();
        }
        let mut found: Vec<Vec<&str>> = vec![Vec::new(); pairs.len()];
        for point in &self.campaign.points {
            let Ok(rig) = self.rig.at(point, point.ambient.map_or(crate::doubtful::LAID_OUT, |t| t[0]))
            else {
                continue;
            };
            let places = |k: usize| match &rig.parts[k] {
                PartAt::Places(places) => places.as_slice(),
                _ => &[],
            };
            let same = |(a, b): &(usize, usize)| {
                places(*a).iter().any(|x| places(*b).iter().any(|y| (x - y).abs() <= SAME * rig.length))
            };
            for (points, _) in found.iter_mut().zip(&pairs).filter(|(_, pair)| same(pair)) {
                points.push(&point.id);
            }
        }
        let said = |((a, b), points): (&(usize, usize), &Vec<&str>)| {
            let [a, b] = [*a, *b].map(|k| &self.rig.parts[k].name);
            format!(
                "rig.toml: `{a}` and `{b}` are at one place at {}: both answer to the pressure and the velocity in front of that place, so that neither stands \
                 behind the other; put a duct of 1e-6 m between them, or their places 1e-6 m apart",
                few(points, NAMED)
            )
        };
        pairs.iter().zip(&found).filter(|(_, points)| !points.is_empty()).map(said).collect()
    }
}

/// Whether a law changes pressure and velocity, and whether it answers to them.
const CHANGES: usize = 0;
const ANSWERS: usize = 1;
/// What a source of heat does: several at one place are one, which answers to the velocity in front.
const FLAME: [[bool; 2]; 2] = [[false, true], [false, true]];

fn acts(effect: &Effect) -> [[bool; 2]; 2] {
    let (changes, answers) = match effect.coefficient {
        Coefficient::Mu => ([true, false], [false, true]),
        Coefficient::Mp => ([true, false], [true, false]),
        Coefficient::Eu => ([false, true], [false, true]),
        Coefficient::Ep => ([false, true], [true, false]),
        _ => return [[false; 2]; 2],
    };
    // A source that hears a velocity elsewhere does not answer to what its neighbours make of it.
    [changes, if effect.hears.is_some() { [false; 2] } else { answers }]
}

fn either(a: [[bool; 2]; 2], b: [[bool; 2]; 2]) -> [[bool; 2]; 2] {
    [0, 1].map(|k| [0, 1].map(|of| a[k][of] || b[k][of]))
}
