//! Modes whose numbers are those of another label.

use crate::modes::hertz;
use crate::{Campaign, ObservedMode, ObservedModes};
use std::collections::BTreeMap;

/// Points at which labels must be before their order, or their frequencies, are known.
const KNOWN: usize = 4;
/// Of so many points one may be off.
const FEW: usize = 5;
/// By how much of its value, or of the width of the range, a frequency may lie beside the range of a label
/// and still be one of it.
const NEAR: f64 = 0.02;
const BESIDE: f64 = 0.5;
/// Most modes that are named.
const NAMED: usize = 5;

impl ObservedModes {
    /// Modes whose frequencies have the order that two labels have nowhere else, and modes alone at their
    /// point that are far from all others of their label and among those of another, in a sentence. Training
    /// finds a mode by its frequency, so that nothing else shows a label that was exchanged; predictions of
    /// that label start from the wrong mode.
    #[must_use]
    pub fn other_labels(&self, campaign: &Campaign) -> Option<String> {
        let mut found = self.reversed(campaign);
        found.extend(self.elsewhere(campaign));
        let more = found.len().saturating_sub(NAMED);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        let shown = found.iter().take(NAMED).cloned().collect::<Vec<_>>().join("; ");
        (!found.is_empty()).then(|| format!("{shown}{more}: check whether labels or rows were exchanged"))
    }

    /// By label: the angular frequencies at all points.
    fn by_label(&self) -> BTreeMap<&str, Vec<(usize, f64)>> {
        let mut all: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
        for ObservedMode { point, label, angular_frequency, .. } in &self.modes {
            all.entry(label).or_default().extend(angular_frequency.map(|omega| (*point, omega)));
        }
        all
    }

    /// Pairs of modes of one point in an order that is that of few points only.
    fn reversed(&self, campaign: &Campaign) -> Vec<String> {
        let labels = self.by_label();
        let mut found = Vec::new();
        for (k, (a, of_a)) in labels.iter().enumerate() {
            for (b, of_b) in labels.iter().skip(k + 1) {
                let there = |(point, x): &(usize, f64)| {
                    of_b.iter().find(|(other, y)| other == point && x != y).map(|(_, y)| (*point, *x, *y))
                };
                let pairs: Vec<(usize, f64, f64)> = of_a.iter().filter_map(there).collect();
                let (below, above): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|(_, x, y)| x < y);
                let (many, few) = if below.len() < above.len() { (above, below) } else { (below, above) };
                if many.len() < KNOWN || few.len() * FEW > many.len() + few.len() {
                    continue;
                }
                let at = many.len();
                found.extend(few.into_iter().map(|(point, x, y)| {
                    let (side, others) = if x > y { ("above", "below") } else { ("below", "above") };
                    let ([x, y], id) = ([hertz(x), hertz(y)], &campaign.points[point].id);
                    format!(
                        "mode {a} of {id} ({x:.1} Hz) lies {side} mode {b} ({y:.1} Hz), and {others} it at {at} other points"
                    )
                }));
            }
        }
        found
    }

    /// Modes alone at their point whose frequency is one of another label, where labels lie apart.
    fn elsewhere(&self, campaign: &Campaign) -> Vec<String> {
        let labels = self.by_label();
        let heard = |label: &str, beside: usize| {
            let of_it = labels.get(label)?.iter().filter(|(point, _)| *point != beside);
            let mut all: Vec<f64> = of_it.map(|(_, omega)| *omega).collect();
            all.sort_by(f64::total_cmp);
            let off = all.len() / (FEW + 1);
            let (low, high) = (*all.get(off)?, *all.get(all.len().checked_sub(1 + off)?)?);
            let room = (BESIDE * (high - low)).max(NEAR * high);
            (all.len() >= KNOWN).then_some([low - room, high + room])
        };
        let mut found = Vec::new();
        for mode in &self.modes {
            let alone = self.modes.iter().filter(|m| m.point == mode.point).count() == 1;
            let own = heard(&mode.label, mode.point);
            let (true, Some(omega), Some(own)) = (alone, mode.angular_frequency, own) else { continue };
            let fits = |label: &&&str| {
                let theirs = heard(label, mode.point).filter(|r| (r[0]..=r[1]).contains(&omega));
                **label != mode.label && theirs.is_some_and(|r| r[1] < own[0] || own[1] < r[0])
            };
            if let Some(other) = labels.keys().find(fits) {
                let (id, label) = (&campaign.points[mode.point].id, &mode.label);
                let [shown, low, high] = [omega, own[0], own[1]].map(hertz);
                found.push(format!(
                    "mode {label} of {id} ({shown:.1} Hz) is where mode {other} is at other points, and mode {label} is from {low:.1} to {high:.1} Hz"
                ));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use crate::{Campaign, ObservedMode, ObservedModes, source::Source};
    use rijke_numerics::Matrix;
    use std::f64::consts::TAU;

    fn mode(point: usize, label: &str, hz: f64) -> ObservedMode {
        ObservedMode {
            point,
            label: label.into(),
            growth_rate: None,
            angular_frequency: Some(TAU * hz),
            pressures: Vec::new(),
            covariance: Matrix::diagonal(&[1.0]),
            drift_sd: 0.0,
        }
    }

    fn said(modes: Vec<ObservedMode>) -> Option<String> {
        let rows: Vec<String> = (0..8).map(|k| format!("p{k}")).collect();
        let source = Source { file: "campaign.csv".into(), text: format!("point\n{}\n", rows.join("\n")) };
        let campaign = Campaign::parse(&source).unwrap();
        let (kind, source) = (rijke_rig::DataKind::Virtual, String::new());
        ObservedModes { kind, source, modes, ambient: Default::default() }.other_labels(&campaign)
    }

    /// The first mode rises far from point to point, the second little.
    fn changed(change: fn(&mut Vec<ObservedMode>)) -> Option<String> {
        let both = |k: usize| [mode(k, "1", 100.0 + 5.0 * k as f64), mode(k, "2", 300.0 + k as f64)];
        let mut modes: Vec<ObservedMode> = (0..8).flat_map(both).collect();
        change(&mut modes);
        said(modes)
    }

    #[test]
    fn behaviour_labels_that_were_exchanged_are_named_and_others_are_not() {
        assert_eq!(changed(|_| ()), None);
        let text = changed(|modes| {
            (modes[6].label, modes[7].label) = ("2".into(), "1".into());
        });
        let expected = "mode 1 of p3 (303.0 Hz) lies above mode 2 (115.0 Hz), and below it at 7 other points: \
                        check whether labels or rows were exchanged";
        assert_eq!(text.as_deref(), Some(expected));
        let one = changed(|modes| {
            modes.remove(3);
            modes[2].label = "2".into();
        });
        let expected = "mode 2 of p1 (105.0 Hz) is where mode 1 is at other points, and mode 2 is from 29";
        assert!(one.as_ref().is_some_and(|text| text.starts_with(expected)), "{one:?}");
        // A mode that is nobody's is not said to be another.
        assert_eq!(changed(|modes| modes[4].angular_frequency = Some(TAU * 250.0)), None);
    }

    #[test]
    fn behaviour_a_tube_that_is_shortened_exchanges_no_labels() {
        // From 1 m to 0.2 m: the first mode of the last is where the second of others is.
        let length = |k: usize| 1.0 - 0.8 / 7.0 * k as f64;
        let both = |k: usize| [mode(k, "1", 86.0 / length(k)), mode(k, "2", 258.0 / length(k))];
        assert_eq!(said((0..8).flat_map(both).collect()), None);
        assert_eq!(said((0..8).flat_map(both).take(15).collect()), None);
    }
}
