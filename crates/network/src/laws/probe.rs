//! Feedback from the velocity at another place: what it is of the pressure and velocity where the source is.

use super::Law;
use crate::chain::line::{curvature, line};
use crate::chain::network::Segment;
use rijke_numerics::{C64, Jet, JetSpace};

/// One of the two coefficients k_eu and k_ep of a source u2 - r u1 = T(s) u_ref whose reference velocity
/// u_ref lies upstream or downstream of it, with nothing but ducts between.
///
/// Upstream of the source u_ref = alpha u1 + beta p1 follows from the state before it, so k_eu = -T alpha and
/// k_ep = -T beta. Downstream it follows from the state behind it, u_ref = alpha u2 + beta p2 with p2 = p1,
/// so that k_eu = -r T alpha/(1 - T alpha) and k_ep = -T beta/(1 - T alpha): a loop, with poles where T
/// alpha = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// T.
    pub transfer: Law,
    /// The ducts from the source to the reference, in that order.
    pub path: Vec<PathDuct>,
    /// The coefficient wanted.
    pub of: SourceCoefficient,
    /// Where the reference lies; downstream with r, the area before over the area behind the source.
    pub side: Side,
}

/// Which coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceCoefficient {
    /// k_eu.
    Velocity,
    /// k_ep.
    Pressure,
}

/// On which side of the source the reference lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Before it.
    Upstream,
    /// Behind it.
    Downstream {
        /// Area before over area behind the source.
        ratio: f64,
    },
}

/// A uniform duct on the way from the source to the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct PathDuct {
    /// The duct, of the length that is passed.
    pub segment: Segment,
    /// Velocity on entering over velocity on leaving the stretch before: the inverse ratio of areas. 1 for
    /// the first.
    pub ratio: f64,
    /// Viscous and thermal loss per metre.
    pub losses: Option<[Law; 2]>,
}

impl Side {
    /// A coefficient from T and the row (beta, alpha) of the reference's velocity on (p, u) at the source.
    pub(super) fn coefficient(self, of: SourceCoefficient, t: &Jet, alpha: &Jet, beta: &Jet) -> Jet {
        match (self, of) {
            (Self::Upstream, SourceCoefficient::Velocity) => -&(t * alpha),
            (Self::Upstream, SourceCoefficient::Pressure) => -&(t * beta),
            (Self::Downstream { ratio }, part) => {
                let loop_gain = t * alpha;
                let open = (-&loop_gain).shift(C64::ONE);
                match part {
                    SourceCoefficient::Velocity => (&loop_gain / &open).scale(C64::new(-ratio, 0.0)),
                    SourceCoefficient::Pressure => -&(&(t * beta) / &open),
                }
            }
        }
    }
}

impl Probe {
    pub(super) fn at(&self, s: &Jet, space: JetSpace) -> Jet {
        let [beta, alpha] = self.row(s, space);
        self.side.coefficient(self.of, &self.transfer.at(s, space), &alpha, &beta)
    }

    /// 1 - T alpha, whose zeros are poles of the coefficients if the reference lies downstream.
    pub(super) fn open_loop(&self, s: &Jet, space: JetSpace) -> Jet {
        let [_, alpha] = self.row(s, space);
        (-&(&self.transfer.at(s, space) * &alpha)).shift(C64::ONE)
    }

    /// How far downstream the reference lies, m; negative upstream.
    pub(super) fn distance(&self) -> f64 {
        let distance = self.path.iter().map(|p| p.segment.length).sum::<f64>();
        if self.side == Side::Upstream { -distance } else { distance }
    }

    /// Time that sound needs to the reference.
    pub(super) fn travel_time(&self) -> f64 {
        self.path.iter().map(|p| p.segment.length / p.segment.sound_speed).sum()
    }

    fn row(&self, s: &Jet, space: JetSpace) -> [Jet; 2] {
        let stretches: Vec<_> = self.path.iter().map(|p| p.at(s, space)).collect();
        row(&stretches, self.side, s, space)
    }
}

/// beta and alpha: the velocity at the reference as a row on (p, u) at the source. The path has segments,
/// ratios and losses as [`PathDuct`].
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

/// A duct on the way, the velocity on entering over that on leaving the one before, its losses at s.
pub(super) type Stretch = (Segment, f64, Option<[Jet; 2]>);

impl PathDuct {
    pub(super) fn at(&self, s: &Jet, space: JetSpace) -> Stretch {
        let losses = self.losses.as_ref().map(|all| all.each_ref().map(|law| law.at(s, space)));
        (self.segment, self.ratio, losses)
    }
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
fn line_of((segment, _, losses): &Stretch, s: &Jet) -> [Jet; 3] {
    let Segment { length, sound_speed, density, .. } = *segment;
    let real = |v: f64| C64::new(v, 0.0);
    let mut z = s.scale(real(density));
    let mut y = s.scale(real(1.0 / (density * sound_speed * sound_speed)));
    if let Some([viscous, thermal]) = losses {
        z = &z + viscous;
        y = &y + thermal;
    }
    let (p, q) = (z.scale(real(length)), y.scale(real(length)));
    let square = &p * &q;
    let at = line(square.value());
    let c = square.compose(at.c, 0.5 * at.s, 0.5 * at.s1);
    let sh = square.compose(at.s, at.s1, curvature(square.value(), &at));
    [c, &p * &sh, &q * &sh]
}
