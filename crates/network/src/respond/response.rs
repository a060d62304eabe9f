//! Derivatives of an eigenvalue and of its mode with respect to the parameters of the caller.
//!
//! The eigenvalue is the implicit function F(a, s(a)) = 0. Tangents of the state in all seeds (a_1 .. a_p,
//! s), to first and second order, are carried downstream through the chain; F and the pressures are then
//! functions of the seeds, and s is eliminated exactly. Because the state has two components only, carrying
//! second-order tangents costs less than one second-order adjoint sweep per microphone as soon as there are
//! two of them.

use super::answer::{Places, Response, implicit};
use crate::chain::coefficients::{At, Coefficients, Laws};
use crate::chain::line::{curvature, line};
use crate::chain::network::{AREA, Attachment, DENSITY, LENGTH, Network, SOUND_SPEED, THERMAL, VISCOUS};
use crate::chain::sweep::take;
use crate::chain::tangents::{Element, Tangents};
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use rijke_numerics::{C64, Jet, JetSpace, Order};

impl Network {
    /// The eigenvalue at `root` and the mode, with derivatives up to `order` with respect to the parameters.
    ///
    /// `root` must be an eigenvalue of this network with these coefficients, as [`Network::solve`] returns
    /// it. Cost: one pass over the chain; per segment about 4 p products to first order and 2 p^2 to second.
    ///
    /// # Errors
    /// [`NetworkError::Slot`] if a place does not exist;
    /// [`NetworkError::SilentReference`] if the reference pressure vanishes; [`NetworkError::NotFinite`];
    /// [`NetworkError::NoLaw`] and [`NetworkError::Property`] as [`Network::solve`].
    pub fn respond<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        root: &Root,
        places: &Places,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, NetworkError> {
        let n = self.segments.len();
        if let Some(&place) = places.at.iter().chain([&places.reference]).find(|&&j| j > n) {
            return Err(NetworkError::Slot { slot: crate::slot::Slot::Mu(place), segments: n });
        }
        self.check_numbers(coefficients)?;
        if order == Order::Value {
            return self.mode_values(coefficients, root, places, work);
        }
        let at = At::full(root.s, coefficients.parameters(), order);
        let Workspace { laws, tangents } = work;
        laws.reset(coefficients.laws(), &at);
        coefficients.fill(&at, laws);
        let laws = &*laws;
        self.check_properties(laws)?;
        let context = Context::new(self, laws, &at);
        let area_laws = context.area_laws;
        let s = at.s_jet();

        let reflection = context.sum(self.ends[0], self.attached(0), 0);
        let start = (&reflection.shift(-C64::ONE), &context.impedance(0));
        tangents.start(&reflection.shift(C64::ONE), &(start.0 / start.1));
        let mut pressures: Vec<Option<Jet>> = vec![None; n + 1];
        let mut rest = self.attachments.as_slice();
        take(&mut rest, 0);
        for j in 0..=n {
            if j == places.reference || places.at.contains(&j) {
                pressures[j] = Some(tangents.jet(0));
            }
            let here = take(&mut rest, 1 + 2 * j);
            if !here.is_empty() || area_laws || self.jumps(j) {
                let element = context.joint(j, here, tangents);
                tangents.advance(&element);
            }
            if j < n {
                let here = take(&mut rest, 2 + 2 * j);
                let element = context.segment(j, &s, here, tangents);
                tangents.advance(&element);
            }
        }
        let reflection = context.sum(self.ends[1], rest, 0);
        let (p, u) = (tangents.jet(0), &tangents.jet(1) * &context.impedance(n - 1));
        let f = &(&reflection.scale(-C64::ONE).shift(C64::ONE) * &p) - &(&reflection.shift(C64::ONE) * &u);

        let s = implicit(&f, root.s);
        if !s.gradient().iter().chain(s.hessian_packed()).all(|z| z.is_finite()) {
            return Err(NetworkError::NotFinite { s: root.s });
        }
        Response::relative(s, &pressures, places, order)
    }
}

/// Whether the area of any segment depends on a law.
pub(super) fn area_laws(network: &Network) -> bool {
    network.attachments.iter().any(|a| a.kind == AREA && a.key % 2 == 0 && a.key > 0)
}

/// Network and laws at one s, for the derivatives of local coefficients.
pub(crate) struct Context<'a> {
    network: &'a Network,
    laws: &'a Laws,
    space: JetSpace,
    /// Whether the area of any segment depends on a law.
    area_laws: bool,
}

impl<'a> Context<'a> {
    /// With laws that were filled at `at`.
    pub(crate) fn new(network: &'a Network, laws: &'a Laws, at: &At) -> Self {
        Self { network, laws, space: at.space(), area_laws: area_laws(network) }
    }

    /// R_u and R_d.
    pub(crate) fn reflections(&self) -> [Jet; 2] {
        let last = 2 + 2 * self.network.segments.len();
        [(0, 0), (1, last)].map(|(end, key)| self.sum(self.network.ends[end], self.network.attached(key), 0))
    }

    /// The matrix of a place as jets.
    pub(crate) fn joint_matrix(&self, j: usize) -> [[Jet; 2]; 2] {
        let (network, here) = (self.network, self.network.attached(1 + 2 * j));
        let minus = |kind: usize| -&self.sum(network.feedback[j][kind], here, kind);
        let [mu, mp, eu, ep] = [0, 1, 2, 3].map(minus);
        let inside = j > 0 && j < network.segments.len();
        let ratio =
            if inside { &self.property(j - 1, AREA) / &self.property(j, AREA) } else { self.space.real(1.0) };
        [[mp.shift(C64::ONE), mu], [ep, &ratio + &eu]]
    }

    /// The matrix of a segment as jets.
    pub(crate) fn line_matrix(&self, i: usize, s: &Jet) -> [[Jet; 2]; 2] {
        let [mu, ep] = self.network.losses[i];
        let here = self.network.attached(2 + 2 * i);
        let (l, c, rho) =
            (self.property(i, LENGTH), self.property(i, SOUND_SPEED), self.property(i, DENSITY));
        let p = &l * &(&(s * &rho) + &self.sum(mu, here, VISCOUS));
        let q = &l * &(&(s / &(&rho * &(&c * &c))) + &self.sum(ep, here, THERMAL));
        let square = &p * &q;
        let at = line(square.value());
        let c = square.compose(at.c, 0.5 * at.s, 0.5 * at.s1);
        let sh = square.compose(at.s, at.s1, curvature(square.value(), &at));
        [[c.clone(), -&(&p * &sh)], [-&(&q * &sh), c]]
    }

    fn sum(&self, base: C64, here: &[Attachment], kind: usize) -> Jet {
        let mut total = self.space.constant(base);
        for a in here.iter().filter(|a| a.kind == kind) {
            let law = Jet::from_parts(
                self.laws.value(a.law),
                self.laws.gradient(a.law).to_vec(),
                self.laws.hessian(a.law).to_vec(),
            );
            total = &total + &law.scale(C64::new(a.weight, 0.0));
        }
        total
    }

    fn property(&self, i: usize, kind: usize) -> Jet {
        let base = C64::new(self.network.constant_property(i, kind), 0.0);
        self.sum(base, self.network.attached(2 + 2 * i), kind)
    }

    pub(crate) fn impedance(&self, i: usize) -> Jet {
        &self.property(i, DENSITY) * &self.property(i, SOUND_SPEED)
    }

    fn joint(&self, j: usize, here: &[Attachment], tangents: &mut Tangents) -> Element<4> {
        let network = self.network;
        let n = network.segments.len();
        let mut k = network.feedback[j];
        tangents.clear(4);
        for a in here {
            k[a.kind] += a.weight * self.laws.value(a.law);
            tangents.add_law(a.kind, a.weight, a.law, self.laws);
        }
        if j > 0 && j < n {
            if self.area_laws {
                let ratio = &self.property(j - 1, AREA) / &self.property(j, AREA);
                k[2] += 1.0 - ratio.value();
                tangents.add_jet(2, &-&ratio);
            } else {
                k[2] += 1.0 - network.segments[j - 1].area / network.segments[j].area;
            }
        }
        let (o, m) = (C64::ZERO, -C64::ONE);
        let first = [[[o, m], [o, o]], [[m, o], [o, o]], [[o, o], [o, m]], [[o, o], [m, o]]];
        let [mu, mp, eu, ep] = k;
        Element { matrix: [[1.0 - mp, -mu], [-ep, 1.0 - eu]], first, second: None }
    }

    fn segment(&self, i: usize, s: &Jet, here: &[Attachment], tangents: &mut Tangents) -> Element<2> {
        let segment = &self.network.segments[i];
        let [mut mu, mut ep] = self.network.losses[i];
        tangents.clear(2);
        let (p, q);
        if here.iter().all(|a| a.kind >= VISCOUS) {
            let l = segment.length;
            let compliance = 1.0 / (segment.density * segment.sound_speed * segment.sound_speed);
            for a in here {
                *(if a.kind == VISCOUS { &mut mu } else { &mut ep }) += a.weight * self.laws.value(a.law);
                tangents.add_law(a.kind - VISCOUS, l * a.weight, a.law, self.laws);
            }
            p = l * (s.value() * segment.density + mu);
            q = l * (s.value() * compliance + ep);
            let seeds = tangents.first.len();
            tangents.gradient[seeds - 1] += l * segment.density;
            tangents.gradient[2 * seeds - 1] += l * compliance;
        } else {
            let (l, c) = (self.property(i, LENGTH), self.property(i, SOUND_SPEED));
            let rho = self.property(i, DENSITY);
            let (mu, ep) = (self.sum(mu, here, VISCOUS), self.sum(ep, here, THERMAL));
            let inertia = &l * &(&(s * &rho) + &mu);
            let compliance = &l * &(&(s / &(&rho * &(&c * &c))) + &ep);
            tangents.add_jet(0, &inertia);
            tangents.add_jet(1, &compliance);
            (p, q) = (inertia.value(), compliance.value());
        }
        let line_at = line(p * q);
        let (c, sh, s1) = (line_at.c, line_at.s, line_at.s1);
        let s2 = curvature(p * q, &line_at);
        // C and S are functions of q = PQ: C' = S/2, C'' = S'/2.
        let (cp, cq) = (0.5 * sh * q, 0.5 * sh * p);
        let (cpp, cqq, cpq) = (0.5 * s1 * q * q, 0.5 * s1 * p * p, 0.5 * (sh + s1 * p * q));
        // (P S)_P = S + PQ S', (P S)_Q = P^2 S', and so on; Q S by symmetry.
        let diagonal = sh + p * q * s1;
        let (ps_pp, ps_pq, ps_qq) =
            (q * (2.0 * s1 + p * q * s2), p * (2.0 * s1 + p * q * s2), p * p * p * s2);
        let (qs_qq, qs_pq, qs_pp) = (ps_pq, ps_pp, q * q * q * s2);
        let first = [[[cp, -diagonal], [-q * q * s1, cp]], [[cq, -p * p * s1], [-diagonal, cq]]];
        let second =
            [[[cpp, -ps_pp], [-qs_pp, cpp]], [[cpq, -ps_pq], [-qs_pq, cpq]], [[cqq, -ps_qq], [-qs_qq, cqq]]];
        Element { matrix: [[c, -p * sh], [-q * sh, c]], first, second: Some(second) }
    }
}
