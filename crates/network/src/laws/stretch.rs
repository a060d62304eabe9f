//! What lies between a source and the velocity that it answers to: ducts, and on which side they are.

use crate::chain::line::{curvature, line};
use crate::chain::network::Segment;
use rijke_numerics::{C64, Jet, JetSpace};

/// On which side of a source its reference lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    /// Before it.
    Upstream,
    /// Behind it.
    Downstream {
        /// Area before over area behind the source.
        ratio: f64,
    },
}

impl Side {
    /// k_eu and k_ep of a source u2 - r u1 = T u_ref, from T and the row (beta, alpha) of the velocity at its
    /// reference on (p, u) at the source.
    ///
    /// Upstream of the source u_ref = alpha u1 + beta p1 follows from the state before it, so k_eu = -T alpha
    /// and k_ep = -T beta. Downstream it follows from the state behind it, u_ref = alpha u2 + beta p2 with p2
    /// = p1, so that k_eu = -r T alpha/(1 - T alpha) and k_ep = -T beta/(1 - T alpha): a loop, with poles
    /// where T alpha = 1.
    pub(super) fn coefficients(self, t: &Jet, [beta, alpha]: &[Jet; 2]) -> [Jet; 2] {
        match self {
            Self::Upstream => [-&(t * alpha), -&(t * beta)],
            Self::Downstream { ratio } => {
                let loop_gain = t * alpha;
                let open = (-&loop_gain).shift(C64::ONE);
                [(&loop_gain / &open).scale(C64::new(-ratio, 0.0)), -&(&(t * beta) / &open)]
            }
        }
    }
}

/// A uniform duct on the way, of the length that is passed; the velocity on entering it over that on leaving
/// the one before, which is the inverse ratio of areas, 1 for the first; its viscous and thermal losses per
/// metre at s.
pub(super) type Stretch = (Segment, f64, [Jet; 2]);

/// beta and alpha: the velocity at the reference as a row on (p, u) at the source. The path
/// leads from the source to the reference.
pub(super) fn row(path: &[Stretch], side: Side, s: &Jet, space: JetSpace) -> [Jet; 2] {
    let [mut on_p, mut on_u] = [space.real(0.0), space.real(1.0)];
    let sign = if side == Side::Upstream { 1.0 } else { -1.0 };
    for stretch in path.iter().rev() {
        let [c, psh, qsh] = line_of(stretch, s);
        let turned = |jet: &Jet| jet.scale(C64::new(sign, 0.0));
        let before = &(&on_p * &c) + &(&on_u * &turned(&qsh));
        on_u = (&(&on_p * &turned(&psh)) + &(&on_u * &c)).scale(C64::new(stretch.1, 0.0));
        on_p = before;
    }
    [on_p, on_u]
}

/// Pressure and velocity behind a stretch, as rows on a state far upstream, from those before it.
pub(super) fn carry(stretch: &Stretch, [p, u]: &[[Jet; 2]; 2], s: &Jet) -> [[Jet; 2]; 2] {
    let [c, psh, qsh] = line_of(stretch, s);
    let ratio = C64::new(stretch.1, 0.0);
    let both = |k: usize| {
        let entering = u[k].scale(ratio);
        [&(&c * &p[k]) - &(&psh * &entering), &(&c * &entering) - &(&qsh * &p[k])]
    };
    let [[p0, u0], [p1, u1]] = [both(0), both(1)];
    [[p0, p1], [u0, u1]]
}

/// C, P S and Q S of a stretch: p2 = C p1 - P S u1, u2 = C u1 - Q S p1.
fn line_of((segment, _, [viscous, thermal]): &Stretch, s: &Jet) -> [Jet; 3] {
    let Segment { length, sound_speed, density, .. } = *segment;
    let real = |v: f64| C64::new(v, 0.0);
    let z = &s.scale(real(density)) + viscous;
    let y = &s.scale(real(1.0 / (density * sound_speed * sound_speed))) + thermal;
    let (p, q) = (z.scale(real(length)), y.scale(real(length)));
    let square = &p * &q;
    let at = line(square.value());
    let c = square.compose(at.c, 0.5 * at.s, 0.5 * at.s1);
    let sh = square.compose(at.s, at.s1, curvature(square.value(), &at));
    [c, &p * &sh, &q * &sh]
}
