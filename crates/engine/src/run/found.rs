//! What is found of a trained model beside its evidence, as numbers that are written and drawn.

use rijke_numerics::words::quantity;
use serde::{Deserialize, Serialize};

/// What the data still ask for after a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// How many terms were tried.
    pub tried: usize,
    /// The gain that the best of all terms reaches by chance in one of twenty data sets of the model itself,
    /// nats.
    pub by_chance: f64,
    /// Families of terms, in the order in which each gains most beyond those before it.
    pub families: Vec<Family>,
    /// Of each kind of effect at each place the term of the largest gain, the most gain first.
    pub best: Vec<Asked>,
    /// Gains and delays of laws that these data put far from one and from nothing, although earlier stages
    /// found what makes them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laws: Vec<Asked>,
}

/// Terms that these data cannot tell apart.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Family {
    /// The most probable term at the most probable place.
    pub first: Asked,
    /// Its gain beyond the families before it, nats, noise as fitted; and the probability that the best of
    /// all terms does by chance as well as the best of this family.
    pub beyond: (f64, f64),
    /// Other terms of the same effect at the same place, its other phase or in proportion to something else,
    /// that gain beside it, in words.
    #[serde(default)]
    pub also: Vec<String>,
    /// Others like it, in words, the most gain alone first.
    pub like: Vec<String>,
    /// Where along the rig terms of the same effect are like it, m; none for what acts along it.
    pub between: Option<[f64; 2]>,
}

/// A term with what the data say of it. It describes what is missing, and is no cause.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// What it does.
    pub effect: String,
    /// Where.
    pub place: String,
    /// Where along the rig, m, in the mean over the observations.
    pub x: Option<f64>,
    /// What it is in proportion to; empty if it is the same at all points.
    pub times: String,
    /// Its strength and the standard deviation of that, the parameters of the model being free to follow.
    pub strength: [f64; 2],
    /// Unit of the strength.
    pub unit: String,
    /// Standard deviation of the prior of the strength.
    pub prior_sd: f64,
    /// Expected gain in ln evidence, nats: noise chosen again.
    pub gain: f64,
    /// Probability that the best term of the library does as well by chance.
    pub probability: f64,
    /// Root mean square change of growth rates (1/s) and of angular frequencies (rad/s) at that strength,
    /// before parameters follow.
    pub moves: [f64; 2],
}

impl Missing {
    /// Probability by chance above which a term is not told.
    pub const CHANCE: f64 = 0.05;

    /// What the data say of laws that earlier stages found otherwise, a sentence each without its stop;
    /// nothing of what is told as missing.
    pub fn disagreeing(&self) -> impl Iterator<Item = String> {
        let told: Vec<String> = self.required().take(2).map(|f| f.first.words()).collect();
        let others = self.laws.iter().filter(move |law| !told.contains(&law.words()));
        others.map(|law| {
            let [value, sd] = law.strength;
            format!(
                "these modes alone give {} = {}, {:.0} standard deviations from zero, which contradicts the result of an earlier stage for this law; check the \
                 normalisation (`factor`), the unit and the conditions of the data that trained it before you look for a further term",
                law.words(),
                quantity(value, sd, &law.unit),
                (value / sd).abs()
            )
        })
    }

    /// The families that the data require beyond those before them, the most gain first.
    pub fn required(&self) -> impl Iterator<Item = &Family> {
        self.families.iter().take_while(|f| f.is_required())
    }
}

impl Family {
    /// Whether it gains more beyond the families before it than chance would.
    #[must_use]
    pub fn is_required(&self) -> bool {
        self.beyond.1 <= Missing::CHANCE
    }
}

impl Asked {
    /// The term in words.
    #[must_use]
    pub fn words(&self) -> String {
        words(&self.effect, &self.place, &self.times)
    }
}

/// The model that goes on from a stage, point by point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checks {
    /// The best other model, if one could be fitted.
    pub rival: Option<String>,
    /// Every operating point given all others.
    pub points: Vec<PointCheck>,
    /// For every observation: growth rate and angular frequency less what the other points foresee, in
    /// standard deviations.
    pub residuals: Vec<[Option<f64>; 2]>,
    /// Residuals of one kind together.
    pub sums: Vec<SumCheck>,
}

/// An operating point given all others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointCheck {
    /// Its name.
    pub point: String,
    /// ln of the density of its data given those of all other points, nats; none if it alone decides a
    /// parameter.
    pub ln_left_out: Option<f64>,
    /// How many nats of it the model has more than its rival.
    pub ahead: Option<f64>,
    /// How far the parameters move without it, in posterior standard deviations; the density is linearised,
    /// and is not to be trusted to 0.05 nats where this is large.
    pub shift: f64,
    /// Whether it is that large.
    pub doubtful: bool,
}

/// Standard deviations that are stated so many times too large are said.
const TOO_LARGE: f64 = 1.5;

impl Checks {
    /// The largest probability that counts as never: that of at most one of a thousand draws.
    const NEVER: f64 = 2.5e-3;

    /// The kinds of residuals that are larger, or much smaller, than noise and stated errors allow, each in a
    /// sentence without its stop.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let one = |s: &SumCheck| {
            let SumCheck { what, count, chi_squared, .. } = s;
            if let Some(p) = s.probability.filter(|p| *p < Self::NEVER) {
                return Some(format!(
                    "chi-squared of the {what} is too large: {chi_squared:.1} for {count} numbers (p < {:.3}). Stated noise or errors are too small, \
                     or points are wrong, so the evidence and all standard deviations of this stage are not reliable: let a stated noise float, \
                     and check the points that the page marks and the errors stated for T_amb and factors",
                    p + 5e-4
                ));
            }
            match &s.law {
                Some(role) => {
                    let times = (*count as f64 / chi_squared).sqrt();
                    let is_small = s.probability.is_some_and(|p| p > 1.0 - Self::NEVER);
                    (is_small && times > TOO_LARGE).then(|| format!(
                        "the noise of the {what} is about {times:.1} times too large: chi-squared is {chi_squared:.1} for {count} numbers. The misfit of the law \
                         of `{role}`, which an earlier stage found, is a part of it: look there first; the standard deviations of parameters are too large, and \
                         differences of evidence too small"
                    ))
                }
                None => {
                    let NoiseCheck { chi_squared, expected, probability } = s.of_noise.as_ref()?;
                    let times = (expected / chi_squared).sqrt();
                    (*probability < Self::NEVER && times > TOO_LARGE).then(|| format!(
                        "the stated noise of the {what} is about {times:.1} times too large: chi-squared of the noise alone is {chi_squared:.1}, and \
                         {expected:.1} is expected; the standard deviations of parameters are therefore too large, and differences of evidence too small"
                    ))
                }
            }
        };
        self.sums.iter().filter_map(one).collect()
    }

    /// How little of what residuals have beyond their noise the missing terms explain, in a sentence without
    /// its stop; none where they explain half or more. All of it is half of what chi-squared has above its
    /// mean, in nats.
    #[must_use]
    pub(super) fn unexplained(&self, missing: &Missing) -> Option<String> {
        let too_large = self.sums.iter().filter(|s| s.probability.is_some_and(|p| p < Self::NEVER));
        let beyond: f64 = too_large.map(|s| 0.5 * (s.chi_squared - s.count as f64)).sum();
        let gain: f64 = missing.required().map(|f| f.beyond.0).sum();
        (gain > 0.0 && gain < 0.5 * beyond).then(|| {
            format!(
                "the residuals exceed their noise by {beyond:.0} nats, of which the missing terms explain {gain:.0}: bad points, errors of days, or a \
                 stated noise that is too small are as likely as a missing effect"
            )
        })
    }
}

/// Residuals of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SumCheck {
    /// What of.
    pub what: String,
    /// How many there are.
    pub count: usize,
    /// Their sum of squares in standard deviations of the noise.
    pub chi_squared: f64,
    /// Probability that data of the model itself have a larger one; none where the data chose more than half
    /// of the noise, which makes the sum what it is.
    pub probability: Option<f64>,
    /// The role of a law whose misfit, found by an earlier stage, is a part of the noise; none where all of
    /// it is stated or was chosen here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// The noise alone; none where the data chose more than half of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_noise: Option<NoiseCheck>,
}

/// The noise of one kind of residuals alone, without errors that several of them share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseCheck {
    /// Sum of squares of what it most probably was, in its standard deviations.
    pub chi_squared: f64,
    /// The mean of that sum over data of the model itself.
    pub expected: f64,
    /// Probability that such data have a smaller one.
    pub probability: f64,
}

/// A term in words.
pub(super) fn words(effect: &str, place: &str, times: &str) -> String {
    let by = if times.is_empty() { String::new() } else { format!(", times {times}") };
    format!("{effect} at {place}{by}")
}

/// Errors of stated lengths that would reverse the lead of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExactLengths {
    /// The model that leads, and the next.
    pub models: [String; 2],
    /// The lead, nats.
    pub lead: f64,
    /// The lengths whose smallest errors reverse it, the smallest first; empty where none below a twentieth
    /// of the rig does.
    pub smallest: Vec<LengthError>,
    /// The lengths whose smallest errors move a parameter of the model that leads by one of its standard
    /// deviations, the smallest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moving: Vec<MovingLength>,
}

/// The error of a length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LengthError {
    /// Which length.
    pub what: String,
    /// By how much it would have to be longer than stated, m.
    pub by: f64,
}

/// The error of a length that moves a parameter by one of its standard deviations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingLength {
    /// Which length.
    pub what: String,
    /// By how much it would have to be longer than stated, m.
    pub by: f64,
    /// Which parameter becomes larger.
    pub parameter: String,
}

impl ExactLengths {
    /// A sentence without its stop.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { models: [leader, next], lead, smallest, moving } = self;
        // Found by slopes: further digits would promise what training again does not keep.
        let error = |e: &LengthError| {
            let mm = 1e3 * e.by;
            let digits = usize::from(mm.abs() < 1.0);
            format!("about {mm:+.digits$} mm on the {}", e.what)
        };
        let by = match &smallest[..] {
            [] => "no error of one of them below a twentieth of the rig".to_owned(),
            some => some.iter().map(error).collect::<Vec<_>>().join(", or "),
        };
        let said = format!(
            "lengths are taken as exact: {by} would reverse the lead of {leader} over {next}, {lead:.1} nats, by slopes at the fit: train again with that length to be sure"
        );
        let moves = |m: &MovingLength| {
            // A hundredth of a millimetre is the finest that anybody measures a duct by.
            let mm = 1e3 * m.by;
            let digits = if mm.abs() < 1.0 { 2 } else { 0 };
            format!("{mm:+.digits$} mm on the {} raises {} by one standard deviation", m.what, m.parameter)
        };
        match &moving[..] {
            [] => said,
            some => format!("{said}; in {leader}, {}", some.iter().map(moves).collect::<Vec<_>>().join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Asked, Checks, Family, Missing, NoiseCheck, SumCheck};

    /// Who stated 1 1/s, and was right, must not read that it is 162 times too large.
    #[test]
    fn message_noise_of_an_earlier_law_is_not_called_stated() {
        let said = |law: Option<&str>| {
            let (what, law) = ("growth rates".to_owned(), law.map(str::to_owned));
            let of_noise = Some(NoiseCheck { chi_squared: 2.3e-4, expected: 6.0, probability: 1e-3 });
            let sum =
                SumCheck { what, count: 6, chi_squared: 2.3e-4, probability: Some(0.999), law, of_noise };
            Checks { sums: vec![sum], ..Checks::default() }.doubts().join("")
        };
        assert!(
            said(None).starts_with("the stated noise of the growth rates is about 161.5 times too large")
        );
        let of_a_law = said(Some("flame"));
        assert!(!of_a_law.contains("stated") && of_a_law.contains("the law of `flame`"), "{of_a_law}");
    }

    #[test]
    fn exact_terms_that_explain_a_small_part_are_said_to() {
        let checks = |chi_squared: f64| Checks {
            sums: vec![SumCheck {
                what: "a".into(),
                count: 96,
                chi_squared,
                probability: Some(0.0),
                law: None,
                of_noise: None,
            }],
            ..Checks::default()
        };
        let missing = |gain: f64| {
            let first = Asked { gain, ..Asked::default() };
            let family = Family { first, beyond: (gain, 0.001), ..Family::default() };
            Missing { families: vec![family], ..Missing::default() }
        };
        // Half of 1011 - 96.
        let said = checks(1011.0).unexplained(&missing(12.3)).unwrap();
        assert!(said.contains("by 458 nats, of which the missing terms explain 12"), "{said}");
        assert_eq!(checks(1011.0).unexplained(&missing(300.0)), None);
        assert_eq!(checks(110.0).unexplained(&missing(12.3)), None);
    }
}
