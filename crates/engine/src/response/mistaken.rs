//! Data that a model fits far better once a common mistake is undone: another sign of time, a sign or a ratio
//! turned, or the labels of two microphones exchanged.

use super::head::Rest;
use super::measured::Measured;
use super::residual::left;
use super::select::Selected;
use super::train::ResponseTraining;
use rijke_numerics::C64;
use rijke_study::responses::{ResponseKind, ResponseStage};

/// Nats by which the data must lead without the mistake before it is suspected.
const LEADS: f64 = 10.0;
/// Share of the data that a model may leave of them without the mistake, and how much less than with it: a
/// model that fits neither says nothing.
const LEFT: f64 = 0.3;
const LESS: f64 = 0.5;
/// Most microphones of which every pair is tried.
const MOST: usize = 8;

/// The data without a mistake, ln of the volume that these numbers take for each of the volume of those, and
/// the mistake in a sentence.
pub(super) type Undone = (Vec<Measured>, f64, String);

/// The mistake without which the data have most evidence, if by far more than `here`, and a model then
/// leaves far less of them than the share `poor`, in a sentence. A model that cannot be fitted without one
/// says nothing of it.
pub(super) fn mistaken(
    training: &ResponseTraining<'_>,
    data: &Selected,
    names: &[String],
    at: [f64; 2],
) -> Option<String> {
    let mut all = vec![conjugated(data)];
    let heard = microphones(&data.whats);
    // Of two microphones nobody knows which one is turned, and exchanging them inverts their ratio.
    let two = heard.len() == 2;
    for m in heard.iter().take(if two { 1 } else { usize::MAX }) {
        let of = |what: &ResponseKind| match what {
            ResponseKind::Pressure { microphone, .. } => microphone == m,
            ResponseKind::Transfer { to, from } => (to == m) != (from == m),
            _ => false,
        };
        let which =
            if two { format!("{} or {}", names[heard[0]], names[heard[1]]) } else { names[*m].clone() };
        let said = format!(
            "with the sign of microphone {which} turned these data have GAIN nats more: check its polarity"
        );
        all.push((each(data, of, |z| -z), 0.0, said));
    }
    let reflects = |what: &ResponseKind| matches!(what, ResponseKind::Reflection { .. });
    if data.whats.iter().any(reflects) {
        let said = "with the signs of the reflection coefficients turned these data have GAIN nats more: they are of pressure, and an impedance is p over \
                    rho c u, not its inverse";
        all.push((each(data, reflects, |z| -z), 0.0, said.to_owned()));
    }
    all.extend(inverted(data).filter(|_| !two));
    let pairs = heard.iter().enumerate().flat_map(|(k, a)| heard[k + 1..].iter().map(move |b| [*a, *b]));
    for pair in pairs.filter(|_| heard.len() <= MOST) {
        let [a, b] = pair.map(|m| &names[m]);
        let said = format!(
            "with the labels of the microphones {a} and {b} exchanged these data have GAIN nats more: look which channel is which, and correct \
             their names or their places"
        );
        all.extend(exchanged(data, pair).map(|(exchanged, ln_scale)| (exchanged, ln_scale, said)));
    }
    best_undone(training, all, at)
}

/// The data with the other sign of time.
pub(super) fn conjugated(data: &Selected) -> Undone {
    let said = "the complex conjugates of these data have GAIN nats more: rijke takes numbers that vary as exp(i omega t); if these are for \
                exp(-i omega t), turn the signs of the phases or of the imaginary parts";
    (each(data, |_| true, C64::conj), 0.0, said.to_owned())
}

/// The best of the mistakes, if the data have far more evidence without it.
pub(super) fn best_undone(
    training: &ResponseTraining<'_>,
    all: Vec<Undone>,
    [here, poor]: [f64; 2],
) -> Option<String> {
    let stage = ResponseStage { checked: false, ..training.stage.clone() };
    let kernel = stage.misfit.as_ref().map(|m| m.kernel);
    let gain = |(measured, ln_scale, said): Undone| {
        let other = ResponseTraining { measured: &measured, stage: &stage, starts: &[], ..*training };
        let found = other.found().ok()?;
        let share = left(&measured, found.heard, Rest { noise: &found.fit.noise, kernel }).share;
        let gain = found.evidence.ln_marginal + ln_scale - here;
        (gain > LEADS && share < LEFT && share < LESS * poor).then_some((gain, said))
    };
    let (gain, said) = all.into_iter().filter_map(gain).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(said.replace("GAIN", &format!("{gain:.0}")))
}

/// The data with `change` done to the responses that it is `of`.
fn each(data: &Selected, of: impl Fn(&ResponseKind) -> bool, change: impl Fn(&C64) -> C64) -> Vec<Measured> {
    let one = |(m, what): (&Measured, &ResponseKind)| match of(what) {
        true => Measured { values: m.values.iter().map(&change).collect(), ..m.clone() },
        false => m.clone(),
    };
    data.measured.iter().zip(&data.whats).map(one).collect()
}

/// The data with transfer functions the other way round; none without any.
fn inverted(data: &Selected) -> Option<Undone> {
    let mut ratios = Vec::new();
    let one = |(m, what): (&Measured, &ResponseKind)| {
        if !matches!(what, ResponseKind::Transfer { .. }) {
            return m.clone();
        }
        ratios.extend(m.values.iter().map(|z| z.norm()));
        let sd = m.sd.iter().zip(&m.values).map(|(sd, z)| sd / z.norm_sqr()).collect();
        let factor = m.factor.iter().zip(&m.values).map(|(f, z)| f / z.norm_sqr().powi(2)).collect();
        Measured { values: m.values.iter().map(C64::inv).collect(), sd, factor, ..m.clone() }
    };
    let turned = data.measured.iter().zip(&data.whats).map(one).collect();
    if ratios.is_empty() || ratios.contains(&0.0) {
        return None;
    }
    // Both parts of a number.
    let ln_scale = ratios.iter().map(|size: &f64| -4.0 * size.ln()).sum();
    let said = "the inverses of these transfer functions have GAIN nats more: `to` is the microphone above the fraction line, `from` that below; check whether \
                the two were exchanged";
    Some((turned, ln_scale, said.to_owned()))
}

/// The microphones whose pressures, or ratios of them, are among the responses.
fn microphones(whats: &[ResponseKind]) -> Vec<usize> {
    let of = |what: &ResponseKind| match what {
        ResponseKind::Pressure { microphone, .. } => vec![*microphone],
        ResponseKind::Transfer { to, from } => vec![*to, *from],
        _ => Vec::new(),
    };
    let mut all: Vec<usize> = whats.iter().flat_map(of).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The data if what is labelled as either of two microphones was measured by the other, and ln of the volume
/// that these numbers take for each of the volume of those; none where that changes nothing, or where one of
/// them was not measured beside the other.
fn exchanged(data: &Selected, [a, b]: [usize; 2]) -> Option<(Vec<Measured>, f64)> {
    let other = |m: usize| match m {
        _ if m == a => b,
        _ if m == b => a,
        _ => m,
    };
    let (mut changed, mut ln_scale) = (false, 0.0);
    let one = |(i, m): (usize, &Measured)| -> Option<Measured> {
        let beside = |what: &ResponseKind| {
            let same = |other: &usize| {
                data.points[*other] == data.points[i]
                    && data.whats[*other].is_same(what)
                    && data.measured[*other].frequency_hz == m.frequency_hz
            };
            (0..data.whats.len()).find(same).map(|k| &data.measured[k])
        };
        let values: Vec<C64> = match &data.whats[i] {
            ResponseKind::Pressure { microphone, excitation, sources } => {
                let (excitation, sources) = (excitation.clone(), sources.clone());
                let microphone = other(*microphone);
                let there = beside(&ResponseKind::Pressure { microphone, excitation, sources })?;
                changed |= there.values != m.values;
                return Some(Measured { values: there.values.clone(), sd: there.sd.clone(), ..m.clone() });
            }
            ResponseKind::Transfer { to, from } => {
                // Relative to the microphone below, whose own is one.
                let over = |heard: usize| match heard == *from {
                    true => Some(vec![C64::ONE; m.values.len()]),
                    false => {
                        beside(&ResponseKind::Transfer { to: heard, from: *from }).map(|m| m.values.clone())
                    }
                };
                let (above, below) = (over(other(*to))?, over(other(*from))?);
                above.iter().zip(&below).map(|(z, w)| z / w).collect()
            }
            _ => return Some(m.clone()),
        };
        changed |= values != m.values;
        let sizes: Vec<f64> = values.iter().zip(&m.values).map(|(w, z)| (w / z).norm()).collect();
        // Both parts of a number.
        ln_scale += 2.0 * sizes.iter().map(|size| size.ln()).sum::<f64>();
        let sd = m.sd.iter().zip(&sizes).map(|(sd, size)| sd * size).collect();
        let factor = m.factor.iter().zip(&sizes).map(|(f, size)| f * size * size).collect();
        Some(Measured { values, sd, factor, ..m.clone() })
    };
    let all: Option<Vec<Measured>> = data.measured.iter().enumerate().map(one).collect();
    all.filter(|_| changed).map(|all| (all, ln_scale))
}
