//! Whether the readings ask for another closure: Rao's score test.
//!
//! Six free parameters absorb most errors of a model, so chi-squared stays near 1 whatever is wrong. A wrong
//! closure is noticed by the one pattern of readings that it makes and the parameters cannot: with g the
//! change of the whitened readings per handbook sd of the closure, r the residual at the most probable
//! unknowns and J their slopes, the shift g'r/i has the variance 1/i with i = g'g - g'J (J'J + 1)^{-1} J'g,
//! and z = g'r/sqrt(i) is standard normal if the closure is right (Rao 1948).

use super::model::Batch;
use crate::error::FlowError;
use crate::infer::tension::ClosureTension;
use crate::tube::closures::Closures;
use rijke_numerics::{Cholesky, Matrix};

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
    /// The test for every closure that handbooks leave open, at the most probable `scores`, with `slopes` of
    /// the whitened readings there. Responses to closures are differences of rough predictions.
    pub(crate) fn tensions(&self, scores: &[f64], slopes: &Matrix) -> Result<Vec<ClosureTension>, FlowError> {
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
            Ok(ClosureTension { closure: (*name).to_owned(), value, preferred, sd: unit * sd, z: score * sd })
        };
        OPEN.iter()
            .map(one)
            .filter(|t| t.as_ref().map_or(true, |t: &ClosureTension| t.z.is_finite()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::TubeRig;
    use crate::infer::assimilate::batch::model::Batch;
    use crate::infer::assimilate::twin::{Twin, TwinOptions, staircase};
    use crate::tube::closures::Closures;
    use crate::tube::parameters::UNKNOWNS;
    use crate::tube::pipe::Pipe;
    use rijke_numerics::Streams;

    fn worst(truth: &Closures) -> (String, f64, usize) {
        let pipe = |closures: &Closures| Pipe::new(&TubeRig::juniper_yoko_2022(), closures, 0.25, 1).unwrap();
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
    fn lab_a_wrong_jet_length_is_noticed_and_a_right_one_is_not() {
        let (_, z, warnings) = worst(&Closures::default());
        assert!(z.abs() < 3.0 && warnings == 0, "{z}");
        let (closure, z, warnings) = worst(&Closures { jet_length: 0.03, ..Closures::default() });
        assert!(z.abs() > 3.0 && warnings > 0, "{closure} {z}");
    }
}
