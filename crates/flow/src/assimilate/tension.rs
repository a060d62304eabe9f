//! Whether the readings ask for another closure: Rao's score test.
//!
//! Six free parameters absorb most errors of a model, so chi-squared stays near 1 whatever is wrong. A wrong closure is noticed by
//! the one pattern of readings that it makes and the parameters cannot: with g the change of the whitened readings per handbook sd
//! of the closure, r the residual at the most probable unknowns and J their slopes, the shift g'r/i has the variance 1/i with
//! i = g'g - g'J (J'J + 1)^{-1} J'g, and z = g'r/sqrt(i) is standard normal if the closure is right (Rao 1948).

use super::Batch;
use crate::{Closures, FlowError};
use rijke_numerics::{Cholesky, Matrix};
use serde::{Deserialize, Serialize};

/// What the readings say of one closure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tension {
    /// Name of the closure.
    pub closure: String,
    /// Its value in the fit.
    pub value: f64,
    /// The value that the readings prefer, to first order.
    pub preferred: f64,
    /// Sd of that.
    pub sd: f64,
    /// Standard normal if the closure is right.
    pub z: f64,
}

impl Tension {
    /// More than three sd away: with eight closures, one right model in fifty is called wrong.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        self.z.abs() > 3.0
    }

    /// What several runs with the same closures say together: means weighted by 1/sd^2, closure by closure. An error too small to be
    /// seen at one place of the heater is seen at fifteen.
    #[must_use]
    pub fn together(runs: &[&[Tension]]) -> Vec<Tension> {
        let Some(first) = runs.first() else { return Vec::new() };
        let one = |t: &Tension| {
            let same = runs.iter().flat_map(|run| run.iter().filter(|o| o.closure == t.closure));
            let (weight, shift) = same.fold((0.0, 0.0), |(weight, shift), o| {
                let w = o.sd.powi(-2);
                (weight + w, shift + w * (o.preferred - o.value))
            });
            let sd = f64::sqrt(weight).recip();
            let (preferred, z) = (t.value + shift / weight, shift / weight / sd);
            Tension { closure: t.closure.clone(), value: t.value, preferred, sd, z }
        };
        first.iter().map(one).collect()
    }
}

/// A closure, and how far handbooks leave it open ([`crate::settled::unknowns`] has the reasons).
type Open = (&'static str, fn(&mut Closures) -> &mut f64, fn(f64) -> f64);

const OPEN: [Open; 8] = [
    ("emissivity", |c| &mut c.emissivity, |v| 0.25 * v),
    ("wire_share", |c| &mut c.wire_share, |v| 0.35 * v),
    ("wire_length", |c| &mut c.wire_length, |v| 0.25 * v),
    ("entrance_loss", |c| &mut c.entrance_loss, |_| 0.15),
    ("development_loss", |c| &mut c.development_loss, |v| 0.15 * v),
    ("jet_length", |c| &mut c.jet_length, |v| 0.35 * v),
    ("profile_factor", |c| &mut c.profile_factor, |_| 0.1),
    ("radiated_share", |c| &mut c.radiated_share, |_| 0.035),
];

impl Batch<'_> {
    /// The test for every closure that handbooks leave open, at the most probable `scores`, with `slopes` of the whitened readings
    /// there. Responses to closures are differences of rough predictions.
    pub(crate) fn tensions(&self, scores: &[f64], slopes: &Matrix) -> Result<Vec<Tension>, FlowError> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let fitted = self.whitened(scores)?;
        let data = self.whitening.apply(self.means.clone());
        let residual: Vec<f64> = data.iter().zip(&fitted).map(|(d, f)| d - f).collect();
        let across = slopes.transpose();
        let precision = across.product(slopes).plus(1.0, &Matrix::identity(scores.len()));
        let precision = Cholesky::new(&precision)?;
        // The slopes of the cost, which nearly vanish at the maximum.
        let pull: Vec<f64> = across.times(&residual).iter().zip(scores).map(|(p, z)| p - z).collect();
        let left = precision.whiten(&pull);
        let rough = self.rough();
        let plain = rough.whitened(scores)?;
        let one = |(name, field, open): &Open| {
            let mut closures = self.pipe.closures.clone();
            let value = *field(&mut closures);
            let unit = open(value);
            *field(&mut closures) += unit;
            let altered = self.pipe.altered(0.0, &closures)?;
            let moved = Batch { pipe: &altered, ..rough.clone() }.whitened(scores)?;
            let change: Vec<f64> = moved.iter().zip(&plain).map(|(m, p)| m - p).collect();
            let absorbed = precision.whiten(&across.times(&change));
            let information = dot(&change, &change) - dot(&absorbed, &absorbed);
            let score = dot(&change, &residual) - dot(&absorbed, &left);
            let sd = information.sqrt().recip();
            let preferred = value + unit * score * sd * sd;
            Ok(Tension { closure: (*name).to_owned(), value, preferred, sd: unit * sd, z: score * sd })
        };
        OPEN.iter().map(one).filter(|t| t.as_ref().map_or(true, |t: &Tension| t.z.is_finite())).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::assimilate::{Batch, Twin, TwinOptions, staircase};
    use crate::{Closures, Pipe, UNKNOWNS};
    use rijke_numerics::Streams;
    use rijke_rig::Rig;

    fn worst(truth: &Closures) -> (String, f64, usize) {
        let pipe = |closures: &Closures| Pipe::new(&Rig::juniper_yoko_2022(), closures, 0.25, 1).unwrap();
        let options = TwinOptions { powers: staircase(&[0.0, 30.0, 180.0], 100), ..TwinOptions::default() };
        let scores = vec![0.0; UNKNOWNS + 8];
        let twin = Twin::new(&pipe(truth), &options, &Streams::new(3), Some(&scores)).unwrap();
        let model = pipe(&Closures::default());
        let record = twin.record.checked(&model).unwrap();
        let health = Batch::new(&model, &record, 10).unwrap().fit().unwrap().health.unwrap();
        let worst = health.tensions.iter().max_by(|a, b| a.z.abs().total_cmp(&b.z.abs())).unwrap();
        (worst.closure.clone(), worst.z, health.warnings().len())
    }

    #[test]
    fn exact_runs_add_up_by_weight() {
        let run = |preferred: f64, sd: f64| {
            let (closure, value) = ("emissivity".to_owned(), 0.3);
            vec![crate::assimilate::Tension { closure, value, preferred, sd, z: (preferred - value) / sd }]
        };
        let runs = [run(0.4, 0.05), run(0.5, 0.1)];
        let all = crate::assimilate::Tension::together(&[&runs[0], &runs[1]]);
        // Weights 400 and 100: shift 0.12 with sd 1/sqrt(500).
        assert!((all[0].preferred - 0.42).abs() < 1e-12 && (all[0].z - 0.12 * 500_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn lab_a_wrong_jet_length_is_noticed_and_a_right_one_is_not() {
        let (_, z, warnings) = worst(&Closures::default());
        assert!(z.abs() < 3.0 && warnings == 0, "{z}");
        let (closure, z, warnings) = worst(&Closures { jet_length: 0.03, ..Closures::default() });
        assert!(z.abs() > 3.0 && warnings > 0, "{closure} {z}");
    }
}
