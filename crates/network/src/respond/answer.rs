//! Where pressures are wanted, and the answer: s and relative pressures, from which s as a seed is
//! eliminated.

use crate::error::NetworkError;
use rijke_numerics::{C64, Jet, Order};

/// Where pressures are wanted: places of the network (see [`crate::Network::place_at`]), and the place they
/// are relative to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Places whose pressure is returned, upstream side, in any order.
    pub at: Vec<usize>,
    /// Place whose pressure is 1.
    pub reference: usize,
}

/// An eigenvalue and mode with their derivatives with respect to the real parameters a_1 .. a_p.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// s = sigma + i omega. The gradient of sigma is the real part of the gradient, and so on.
    pub s: Jet,
    /// Pressures at [`Places::at`], in that order, divided by the one at [`Places::reference`].
    pub pressures: Vec<Jet>,
}

impl Response {
    /// The response of `s`, the eigenvalue as a function of the parameters, from the pressures by place,
    /// whose last seed is still s.
    pub(crate) fn relative(
        s: Jet,
        pressures: &[Option<Jet>],
        places: &Places,
        order: Order,
    ) -> Result<Self, NetworkError> {
        let value = |jet: Jet| Jet::from_parts(jet.value(), Vec::new(), Vec::new());
        let keep = |jet: Jet| if order == Order::Value { value(jet) } else { jet };
        if places.at.is_empty() {
            return Ok(Self { s: keep(s), pressures: Vec::new() });
        }
        let loudest = pressures.iter().flatten().map(|p| p.value().norm()).fold(0.0, f64::max);
        let reference = pressures[places.reference]
            .as_ref()
            .filter(|p| p.value().norm() > 1e-12 * loudest)
            .ok_or(NetworkError::SilentReference { place: places.reference })?
            .recip();
        let one = |&j: &usize| {
            let relative = pressures[j].as_ref().map(|p| p * &reference);
            relative.map(|p| eliminate(&p, &s)).ok_or(NetworkError::NotFinite { s: s.value() })
        };
        let pressures = places.at.iter().map(one).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { s: keep(s), pressures: pressures.into_iter().map(keep).collect() })
    }
}

/// s(a) from F(a, s) = 0, whose last seed is s: s_a = -F_a/F_s,
/// s_ab = -(F_ab + F_as s_b + F_bs s_a + F_ss s_a s_b)/F_s.
pub(crate) fn implicit(f: &Jet, s: C64) -> Jet {
    let p = f.gradient().len() - 1;
    let slope = -f.gradient()[p].inv();
    let gradient: Vec<C64> = f.gradient()[..p].iter().map(|g| slope * g).collect();
    let mut hessian = Vec::new();
    if !f.hessian_packed().is_empty() {
        for a in 0..p {
            for b in 0..=a {
                let (sa, sb) = (gradient[a], gradient[b]);
                let along = f.hessian(a, b) + f.hessian(p, a) * sb + f.hessian(p, b) * sa;
                hessian.push(slope * (along + f.hessian(p, p) * sa * sb));
            }
        }
    }
    Jet::from_parts(s, gradient, hessian)
}

/// y(a, s(a)) from y(a, s), whose last seed is s.
pub(crate) fn eliminate(y: &Jet, s: &Jet) -> Jet {
    let p = s.gradient().len();
    let ys = y.gradient()[p];
    let ds = s.gradient();
    let gradient = (0..p).map(|a| y.gradient()[a] + ys * ds[a]).collect();
    let mut hessian = Vec::new();
    if !y.hessian_packed().is_empty() {
        for a in 0..p {
            for b in 0..=a {
                let along = y.hessian(a, b) + y.hessian(p, a) * ds[b] + y.hessian(p, b) * ds[a];
                hessian.push(along + y.hessian(p, p) * ds[a] * ds[b] + ys * s.hessian(a, b));
            }
        }
    }
    Jet::from_parts(y.value(), gradient, hessian)
}
