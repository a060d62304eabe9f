//! Pressures that were written in another form than real and imaginary part over the reference.

use rijke_numerics::C64;
use rijke_numerics::words::rounded;

/// Pressures of another scale than the model's differ at least by this factor: gains are known far better.
const OTHER_SCALE: f64 = 3.0;

/// Phases in degrees that stand in a column of imaginary parts are above this at some microphone; imaginary
/// parts of relative pressures seldom are. Small ones, which a flow makes, are as good as none if they are
/// read as degrees.
const DEGREES: f64 = 1.0;

/// Pressures of one mode at microphones, over that of the reference.
pub(in crate::run) type Pressures = Vec<(usize, C64)>;

/// How they were written.
#[derive(Clone, Copy)]
pub(in crate::run) enum Form {
    /// So many times too large.
    Scaled(f64),
    /// Modulus, and phase in these units of rad.
    Polar(f64, &'static str),
}

impl Form {
    /// The form that lies nearest to the model, and how far it does.
    pub(in crate::run) fn nearest(of_model: &[Pressures], measured: &[&Pressures]) -> Option<(f64, Self)> {
        let (mut product, mut square) = (0.0, 0.0);
        for (model, measured) in of_model.iter().zip(measured) {
            for (own, p) in both(model, measured) {
                product += (own.conj() * p).re;
                square += own.norm_sqr();
            }
        }
        let scale = product / square;
        let scaled = (scale.is_finite() && !(1.0 / OTHER_SCALE..OTHER_SCALE).contains(&scale) && scale > 0.0)
            .then_some(Self::Scaled(scale));
        let are_degrees = measured.iter().flat_map(|all| all.iter()).any(|(_, p)| p.im.abs() > DEGREES);
        let polar = [Self::Polar(1.0_f64.to_radians(), "degrees"), Self::Polar(1.0, "rad")];
        let polar = polar.into_iter().skip(usize::from(!are_degrees));
        let far = |form: Self| {
            let right =
                |_: usize, p: &Pressures| Some(p.iter().map(|(m, p)| (*m, form.put_right(*p))).collect());
            (distance(of_model, measured, right), form)
        };
        scaled.into_iter().chain(polar).map(far).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn put_right(self, p: C64) -> C64 {
        match self {
            Self::Scaled(scale) => p / scale,
            Self::Polar(unit, _) => C64::from_polar(p.re, unit * p.im),
        }
    }

    /// A sentence without its stop.
    pub(in crate::run) fn words(self) -> String {
        match self {
            Self::Scaled(scale) => format!(
                "the relative pressures of all microphones are {} times those of the model: write them over the pressure of the reference, as numbers, not in per cent \
                 or in another unit",
                rounded(scale)
            ),
            Self::Polar(_, unit) => format!(
                "the relative pressures fit if they are read as modulus and phase in {unit}: write their real and imaginary parts"
            ),
        }
    }
}

/// Root mean square of what measured pressures, put right, differ by from those of the model, where it has
/// them.
pub(in crate::run) fn distance(
    of_model: &[Pressures],
    measured: &[&Pressures],
    put_right: impl Fn(usize, &Pressures) -> Option<Pressures>,
) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, (model, measured)) in of_model.iter().zip(measured).enumerate() {
        let right = put_right(k, measured).unwrap_or_else(|| (*measured).clone());
        for (own, p) in both(model, &right) {
            sum += (own - p).norm_sqr();
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// What the model and the measurement have of the same microphones.
fn both<'a>(model: &'a Pressures, measured: &'a Pressures) -> impl Iterator<Item = (C64, C64)> + 'a {
    measured.iter().filter_map(|(m, p)| Some((model.iter().find(|(k, _)| k == m)?.1, *p)))
}

#[cfg(test)]
mod tests {
    use super::{C64, Form, Pressures};

    #[test]
    fn message_pressures_of_another_form_are_told_as_that() {
        let shape = |k: usize| C64::from_polar(1.0 + 0.2 * k as f64, 0.3 * k as f64 - 0.8);
        let model: Vec<Pressures> = (0..3).map(|n| (1..4).map(|m| (m, shape(n + m))).collect()).collect();
        let said = |form: fn(C64) -> C64| {
            let all: Vec<Pressures> =
                model.iter().map(|one| one.iter().map(|(m, p)| (*m, form(*p))).collect()).collect();
            Form::nearest(&model, &all.iter().collect::<Vec<_>>()).map(|(far, form)| (far, form.words()))
        };
        let (far, words) = said(|p| 100.0 * p).unwrap();
        assert!(far < 1e-12 && words.contains("are 100 times those of the model"), "{far} {words}");
        let (far, words) = said(|p| C64::new(p.norm(), p.arg().to_degrees())).unwrap();
        assert!(far < 1e-12 && words.contains("modulus and phase in degrees"), "{far} {words}");
        let (far, words) = said(|p| C64::new(p.norm(), p.arg())).unwrap();
        assert!(far < 1e-12 && words.contains("modulus and phase in rad"), "{far} {words}");
        // What is right is in none of these forms, and phases that a flow makes are none of a column.
        assert!(said(|p| 1.1 * p).is_none_or(|(far, _)| far > 0.3));
        let real: Vec<Pressures> =
            model.iter().map(|o| o.iter().map(|(m, p)| (*m, p.re.into())).collect()).collect();
        let moved: Vec<Pressures> = real
            .iter()
            .map(|o| o.iter().map(|(m, p)| (*m, p * C64::from_polar(1.0, 0.2))).collect())
            .collect();
        let moved: Vec<&Pressures> = moved.iter().collect();
        let (far, _) = Form::nearest(&real, &moved).unwrap();
        assert!(far > 0.9 * super::distance(&real, &moved, |_, p| Some(p.clone())));
    }
}
