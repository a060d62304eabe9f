//! Forced response with mean flow: pressures and velocities of a wave that enters at an end, transfer matrix,
//! impedance.
//!
//! As [`crate::Network::forced`], with the sweep of the modes started from other states: everything is linear
//! in the state at the upstream end, and nothing that enters there carries entropy but what the end itself
//! sheds.

use super::assembly::FlowChain;
use super::number::Number as _;
use super::passage::State;
use crate::error::NetworkError;
use crate::respond::forced::{Forced, Source, Transfer};
use rijke_numerics::{C64, ComplexDual, Jet};

fn jet(value: C64) -> Jet {
    Jet::from_parts(value, Vec::new(), Vec::new())
}

impl FlowChain {
    /// The response to a wave of unit pressure that enters at an end, at s = i omega. The jets are values
    /// alone.
    ///
    /// # Errors
    /// [`NetworkError::SourceInFlow`] for a source that is not at an end; [`NetworkError::NotFinite`] at a
    /// mode.
    pub fn forced(&self, s: C64, source: Source) -> Result<Forced, NetworkError> {
        let at = ComplexDual::constant(s);
        let [zero, one] = [0.0, 1.0].map(|v| at.real(v));
        let (own, entering) = match source {
            Source::Upstream => ([one, self.wave_impedance(0).recip(), zero], zero),
            Source::Downstream => ([zero; 3], one),
            Source::Velocity(place) | Source::Pressure(place) => {
                return Err(NetworkError::SourceInFlow { place });
            }
        };
        let free = self.states_from(&at, self.start(&self.basis, &at));
        let own = self.states_from(&at, own);
        let close = |states: &[[State<ComplexDual>; 2]]| {
            states.last().map_or(at, |[x, _]| self.finish(&self.basis, x, &at))
        };
        let amplitude = (entering - close(&own)).over(&close(&free));
        let side = |k: usize| -> Vec<[Jet; 2]> {
            let both = own.iter().zip(&free);
            both.map(|(own, free)| [0, 1].map(|i| jet((own[k][i] + amplitude * free[k][i]).value))).collect()
        };
        let forced = Forced { before: side(0), behind: side(1) };
        let finite = |x: &[Jet; 2]| x.iter().all(|j| j.value().is_finite());
        if forced.before.iter().chain(&forced.behind).all(finite) {
            Ok(forced)
        } else {
            Err(NetworkError::NotFinite { s })
        }
    }

    /// The matrix from (p, u) at the upstream end to (p, u) at the downstream end, of sound without entropy
    /// upstream. The jets are values alone.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`].
    pub fn transfer(&self, s: C64) -> Result<Transfer, NetworkError> {
        let [[a, c, _], [b, d, _]] = self.columns(&ComplexDual::constant(s)).map(|x| x.map(|v| jet(v.value)));
        let impedances = [0, self.ducts.len() - 1].map(|i| jet(self.wave_impedance(i).value));
        let finite = [&a, &b, &c, &d].iter().all(|j| j.value().is_finite());
        let transfer = Transfer { matrix: [[a, b], [c, d]], impedances };
        if finite { Ok(transfer) } else { Err(NetworkError::NotFinite { s }) }
    }

    /// Impedance p/u (Pa s/m) that the chain has at its upstream end, looking downstream.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`].
    pub fn impedance(&self, s: C64) -> Result<C64, NetworkError> {
        let at = ComplexDual::constant(s);
        // The end's condition is linear in the state upstream: v p + w u = 0.
        let [v, w] = self.columns(&at).map(|x| self.finish(&self.basis, &x, &at));
        let z = (-w.over(&v)).value;
        if z.is_finite() { Ok(z) } else { Err(NetworkError::NotFinite { s }) }
    }

    /// rho c in duct `i`.
    fn wave_impedance(&self, i: usize) -> ComplexDual {
        let mean = &self.basis.after[i];
        mean.density * mean.speed_squared().sqrt()
    }

    /// The states at the downstream end of p = 1 alone and of u = 1 alone upstream.
    fn columns(&self, s: &ComplexDual) -> [State<ComplexDual>; 2] {
        [[1.0, 0.0], [0.0, 1.0]].map(|[p, u]| {
            let mut last = [s.real(f64::NAN); 3];
            let start = [s.real(p), s.real(u), s.real(0.0)];
            let _ = self.sweep_from(&self.basis, s, start, |_, x, _| last = *x);
            last
        })
    }

    /// The states before and behind every place.
    fn states_from(&self, s: &ComplexDual, start: State<ComplexDual>) -> Vec<[State<ComplexDual>; 2]> {
        let mut all = Vec::with_capacity(self.ducts.len() + 1);
        let _ = self.sweep_from(&self.basis, s, start, |_, before, behind| all.push([*before, *behind]));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::workspace::Workspace;
    use crate::file::read;
    use crate::flow_chain::ducts::FlowState;
    use rijke_numerics::Order;
    use std::f64::consts::PI;

    const FLOW: &str = include_str!("../../../../fixtures/networks/combustor-flow.toml");
    const WORK: fn() -> Workspace = Workspace::default;

    #[test]
    fn oracle_slow_flow_tends_to_the_chain_at_rest() {
        let text = |flow: &str| {
            format!(
                "{flow}\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"unflanged\"\n\
                 [[element]]\ntype = \"duct\"\nlength = 0.4\ndiameter = 0.05\nwall = \"kirchhoff\"\n\
                 [[element]]\ntype = \"side-hole\"\ndiameter = 0.008\nlength = 0.01\n\
                 [[element]]\ntype = \"duct\"\nlength = 0.3\ndiameter = 0.05\nwall = \"kirchhoff\"\n"
            )
        };
        let rest = read(&text("")).unwrap();
        for hertz in [90.0, 400.0, 1111.0] {
            let s = C64::new(0.0, 2.0 * PI * hertz);
            let still =
                rest.network.impedance_at(&rest.laws, s, 0, Order::Value, &mut WORK()).unwrap().value();
            let mut errors = Vec::new();
            for mach in [1e-4, 1e-5] {
                let flow = read(&text(&format!("[flow]\nmach = {mach}\nentropy_waves = false")))
                    .unwrap()
                    .flow
                    .unwrap();
                let moving = flow.impedance(s).unwrap();
                errors.push((moving - still).norm() / still.norm());
            }
            // First order in the Mach number.
            assert!(errors[0] < 0.02 && errors[1] < 0.13 * errors[0], "{hertz}: {errors:?}");
        }
    }

    #[test]
    fn exact_waves_in_a_straight_duct_with_flow() {
        // p = f e^{-i k x/(1+M)} + g e^{i k x/(1-M)} between ends of no reflection.
        use crate::flow_chain::ducts::{FlowDuct, FlowEnd};
        use crate::laws::Law;
        let inlet = FlowState { pressure: 101_325.0, density: 1.2, velocity: 40.0 };
        let end = || FlowEnd::Reflection(Law::Constant(C64::ZERO));
        let chain = FlowChain::new(1.4, inlet, vec![FlowDuct::new(0.7, 1e-2)], [end(), end()]).unwrap();
        let (c, mach) = (inlet.sound_speed(1.4), inlet.mach(1.4));
        let s = C64::new(0.0, 2.0 * PI * 700.0);
        let t = chain.transfer(s).unwrap().scattering().map(|r| r.map(|j| j.value()));
        let forward = (-s * 0.7 / (c * (1.0 + mach))).exp();
        let back = (-s * 0.7 / (c * (1.0 - mach))).exp();
        assert!(t[0][0].norm() < 1e-13 && t[1][1].norm() < 1e-13, "{t:?}");
        assert!((t[1][0] - forward).norm() < 1e-12 && (t[0][1] - back).norm() < 1e-12, "{t:?}");
        let sent = chain.forced(s, Source::Upstream).unwrap();
        assert!((sent.before[1][0].value() - forward).norm() < 1e-12);
        let sent = chain.forced(s, Source::Downstream).unwrap();
        assert!((sent.before[0][0].value() - back).norm() < 1e-12);
    }

    #[test]
    fn oracle_the_modes_are_where_the_impedance_meets_the_upstream_end() {
        let built = read(FLOW).unwrap();
        let modes = built.modes(&built.region).unwrap();
        let chain = built.flow.unwrap();
        assert!(!modes.modes.is_empty());
        for mode in &modes.modes {
            // At a mode a wave that enters has an unbounded answer: close to it the answer goes like
            // 1/distance.
            let answer = |d: f64| {
                let at = mode.s + C64::new(d, 0.0);
                chain.forced(at, Source::Upstream).unwrap().before[0][0].value().norm()
            };
            let (near, nearer) = (answer(1e-3), answer(1e-4));
            assert!((nearer / near - 10.0).abs() < 0.05, "{}: {near} {nearer}", mode.s);
        }
    }

    #[test]
    fn message_a_source_inside_is_refused() {
        let built = read(FLOW).unwrap();
        let answer = built.flow.unwrap().forced(C64::new(0.0, 600.0), Source::Velocity(1));
        assert_eq!(answer, Err(NetworkError::SourceInFlow { place: 1 }));
    }
}
