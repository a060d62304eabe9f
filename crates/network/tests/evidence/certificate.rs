//! All modes of a region, counted.

use crate::common_laws::{Given, c, given, rig_segment};
use rijke_network::{
    At, Coefficients, Constant, Laws, Network, NetworkError, Newton, Pole, Region, Segment, Slot, Workspace,
    follow,
};
use rijke_numerics::C64;
use std::f64::consts::PI;

fn closed_by(r: f64) -> Network {
    let mut net = Network::cut_tube(rig_segment(), &[0.3]).unwrap();
    net.set(Slot::Upstream, c(r, 0.0)).unwrap();
    net.set(Slot::Downstream, c(r, 0.0)).unwrap();
    net
}

#[test]
fn exact_all_modes_of_a_uniform_tube() {
    let speed = rig_segment().sound_speed;
    let region = Region { sigma: [-100.0, 100.0], omega: [10.0, 2.0 * PI * 2000.0] };
    let found = closed_by(-0.95).modes(&Constant, &region, &mut Workspace::default()).unwrap();
    assert_eq!((found.counted, found.modes.len(), found.poles), (11, 11, 0));
    for (k, mode) in found.modes.iter().enumerate() {
        let exact = c(speed * 0.95_f64.ln(), PI * speed * (k + 1) as f64);
        assert!((mode.s - exact).norm() < 1e-12 * exact.norm(), "{mode:?}");
        assert!(mode.residual < 1e-12 && mode.multiplicity == 1);
    }
    assert!(found.evaluations < 100 * 11, "{} sweeps", found.evaluations);
    let empty = Region { sigma: [-10.0, 100.0], ..region };
    let none = closed_by(-0.95).modes(&Constant, &empty, &mut Workspace::default()).unwrap();
    assert_eq!((none.counted, none.modes.len()), (0, 0));
}

#[test]
fn exact_regions_are_checked() {
    let mut work = Workspace::default();
    let region = Region { sigma: [1.0, -1.0], omega: [10.0, 100.0] };
    assert!(matches!(closed_by(-1.0).modes(&Constant, &region, &mut work), Err(NetworkError::Region { .. })));
    // A mode on the border.
    let region = Region { sigma: [0.0, 10.0], omega: [10.0, 2000.0] };
    let error = closed_by(-1.0).modes(&Constant, &region, &mut work).unwrap_err();
    assert!(matches!(error, NetworkError::Border { .. } | NetworkError::NotFinite { .. }), "{error}");
}

/// A tube whose downstream end is chosen so that F is proportional to `product`(s).
fn with_zeros(roots: Vec<C64>) -> (Network, impl Coefficients) {
    let mut net = Network::new(vec![rig_segment()]).unwrap();
    net.set(Slot::Upstream, c(-1.0, 0.0)).unwrap();
    net.attach(Slot::Downstream, 0, -1.0).unwrap();
    let time = 2.0 / rig_segment().sound_speed;
    let laws = given(0, 1, move |at: &At, laws: &mut Laws| {
        let s = at.s_jet();
        let mut product = at.space().real(1.0);
        for root in &roots {
            product = &product * &s.shift(-root).scale(c(1e-3, 0.0));
        }
        // F = 1 - R_u R_d e^{-2 s L/c} (times e^{sL/c}) = product.
        let one_minus = product.scale(-C64::ONE).shift(C64::ONE);
        laws.set(0, &(&one_minus * &s.scale(c(time, 0.0)).exp()));
    });
    (net, laws)
}

#[test]
fn exact_double_and_nearly_double_roots() {
    let region = Region { sigma: [-700.0, 500.0], omega: [100.0, 3000.0] };
    let mut work = Workspace::default();
    let (net, laws) = with_zeros(vec![c(-20.0, 900.0), c(-20.0, 900.0), c(30.0, 2000.0)]);
    let found = net.modes(&laws, &region, &mut work).unwrap();
    assert_eq!(found.counted, 3);
    assert_eq!(found.modes.iter().map(|m| m.multiplicity).collect::<Vec<_>>(), [2, 1]);
    assert!((found.modes[0].s - c(-20.0, 900.0)).norm() < 1e-4);
    let (net, laws) = with_zeros(vec![c(-20.0, 900.0), c(-20.0, 900.5), c(-20.5, 900.0), c(0.0, 2999.0)]);
    let found = net.modes(&laws, &region, &mut work).unwrap();
    assert_eq!((found.counted, found.modes.len()), (4, 4));
    assert!(found.modes.iter().all(|m| m.multiplicity == 1));
}

struct WithPoles<F>(Given<F>, Vec<Pole>);

impl<F: Fn(&At, &mut Laws)> Coefficients for WithPoles<F> {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        self.0.laws
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        self.0.fill(at, laws);
    }
    fn poles(&self) -> Vec<Pole> {
        self.1.clone()
    }
}

#[test]
fn exact_poles_are_counted_and_not_taken_for_modes() {
    // A filtered source -wc/(s + wc) e^{-s tau} whose pole lies inside the region.
    let cut_off = 120.0;
    let fill = move |at: &At, laws: &mut Laws| {
        let s = at.s_jet();
        let filter = s.shift(c(cut_off, 0.0)).recip().scale(c(-cut_off, 0.0));
        laws.set(0, &(&filter * &s.scale(c(-3e-3, 0.0)).exp()));
    };
    let pole = Pole { law: 0, at: c(-cut_off, 0.0), order: 1 };
    let region = Region { sigma: [-200.0, 300.0], omega: [-500.0, 4100.0] };
    let mut work = Workspace::default();
    let mut net = closed_by(-0.98);
    net.attach(Slot::Eu(1), 0, 1.0).unwrap();
    let found = net.modes(&WithPoles(given(0, 1, fill), vec![pole]), &region, &mut work).unwrap();
    assert_eq!((found.poles, found.counted), (1, found.modes.len()));
    assert!(found.counted >= 4);
    // The same count without a pole in the region.
    let above = Region { omega: [400.0, 4100.0], ..region };
    let oscillating = net.modes(&WithPoles(given(0, 1, fill), vec![pole]), &above, &mut work).unwrap();
    assert_eq!(oscillating.poles, 0);
    assert_eq!(oscillating.counted, found.modes.iter().filter(|m| m.s.im > 400.0).count());
    // A pole that nobody declared makes the count fail rather than lie,.
    let hidden = net.modes(&given(0, 1, fill), &region, &mut work);
    assert!(matches!(hidden, Err(NetworkError::UndeclaredPole { .. })), "{hidden:?}");
    // A declared pole that acts nowhere is no pole and no mode.
    let idle = closed_by(-0.98);
    let found = idle.modes(&WithPoles(given(0, 1, fill), vec![pole]), &above, &mut work).unwrap();
    assert_eq!((found.poles, found.counted), (0, 3));
    // Inside a segment a pole is essential and refused.
    let mut essential = closed_by(-0.98);
    essential.attach(Slot::Viscous(0), 0, 1.0).unwrap();
    let error = essential.modes(&WithPoles(given(0, 1, fill), vec![pole]), &region, &mut work).unwrap_err();
    assert!(matches!(error, NetworkError::PoleInSegment { .. }));
}

#[test]
fn exact_laws_that_are_not_analytic_are_refused_by_name() {
    struct Heater;
    impl Coefficients for Heater {
        fn parameters(&self) -> usize {
            0
        }
        fn laws(&self) -> usize {
            1
        }
        fn fill(&self, at: &At, laws: &mut Laws) {
            let delay = C64::new(0.0, -1e-3 * at.s().im).exp();
            laws.set_analytic(0, [-0.1 * delay, C64::ZERO, C64::ZERO]);
        }
        fn name(&self, _law: usize) -> String {
            "heater: delay in Im(s)".to_owned()
        }
    }
    let mut net = closed_by(-0.98);
    net.attach(Slot::Eu(1), 0, 1.0).unwrap();
    let region = Region { sigma: [-100.0, 100.0], omega: [100.0, 4000.0] };
    let error = net.modes(&Heater, &region, &mut Workspace::default()).unwrap_err();
    assert!(error.to_string().starts_with("heater: delay in Im(s) is not analytic in s"), "{error}");
}

#[test]
fn exact_following_a_mode_keeps_its_branch() {
    // Lengthening a tube from 1 m to 3 m: the third mode passes the frequencies where others were.
    let net = closed_by(-0.95);
    let third = c(rig_segment().sound_speed * 0.95_f64.ln(), 3.0 * PI * rig_segment().sound_speed);
    let mut work = Workspace::default();
    let path = follow(third, PI / net.travel_time(), |t, guess| {
        let mut longer = net.clone();
        longer.set(Slot::Length(1), c(0.7 + 2.0 * t, 0.0))?;
        longer.solve(&Constant, guess, &Newton::default(), &mut work)
    })
    .unwrap();
    let (t, s) = path[path.len() - 1];
    assert!(t == 1.0 && (s - third / 3.0).norm() < 1e-11 * s.norm(), "{s}");
}

/// A random network: passive or active, 1 to 60 segments, delays, losses, area changes.
fn random(seed: u64) -> (Network, impl Coefficients) {
    use rand::RngExt;
    let mut rng = rijke_numerics::Streams::new(seed).stream("network/random");
    let mut draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let n = draw(1.0, 60.999) as usize;
    let total = draw(0.3, 1.5);
    let uniform = draw(0.0, 1.0) < 0.5;
    let mut segments: Vec<Segment> = (0..n)
        .map(|_| {
            let speed = if uniform { 343.0 } else { draw(300.0, 800.0) };
            let area = if uniform { 1e-3 } else { 1e-3 * draw(0.4, 2.5) };
            Segment::new(draw(0.2, 1.0), area, speed, 1.4 * 101_325.0 / (speed * speed))
        })
        .collect();
    let sum: f64 = segments.iter().map(|s| s.length).sum();
    for s in &mut segments {
        s.length *= total / sum;
    }
    let mut net = Network::new(segments).unwrap();
    net.set(Slot::Upstream, C64::from_polar(draw(0.5, 1.0), draw(2.5, 3.8))).unwrap();
    net.set(Slot::Downstream, C64::from_polar(draw(0.5, 1.0), if draw(0.0, 1.0) < 0.5 { PI } else { 0.0 }))
        .unwrap();
    let active = draw(0.0, 1.0) < 0.5;
    let strengths = [draw(0.0, 2.0), draw(0.0, 30.0), draw(0.0, 3e-6)];
    let delays = [draw(0.0, 5e-3), draw(0.0, 1e-3)];
    let heater = draw(0.0, n as f64 + 0.999) as usize;
    for i in 0..n {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
    }
    if active {
        net.attach(Slot::Eu(heater), 1, 1.0).unwrap();
    }
    net.attach(Slot::Mu(heater), 2, 1.0).unwrap();
    net.attach(Slot::Ep(heater), 3, 1.0).unwrap();
    let laws = given(0, 4, move |at, laws| {
        let s = at.s();
        let root = (s * 2e-5).sqrt() * 84.0;
        laws.set_analytic(0, [root, 0.5 * root / s, -0.25 * root / (s * s)]);
        let delay = |a: f64, tau: f64| {
            let e = a * (-s * tau).exp();
            [e, -tau * e, tau * tau * e]
        };
        laws.set_analytic(1, delay(-strengths[0], delays[0]));
        laws.set_analytic(2, delay(strengths[1], 0.0));
        laws.set_analytic(3, delay(strengths[2], delays[1]));
    });
    (net, laws)
}

/// Counts the modes of random networks and compares with Newton from a dense grid of guesses.
fn certify(seeds: std::ops::Range<u64>, grid: usize) {
    let region = Region { sigma: [-250.0, 350.0], omega: [60.0, 6000.0] };
    let mut work = Workspace::default();
    let mut total = 0;
    for seed in seeds {
        let (net, laws) = random(seed);
        let found = net.modes(&laws, &region, &mut work);
        assert!(found.is_ok(), "seed {seed}: {found:?}");
        let found = found.unwrap();
        assert_eq!(found.counted, found.modes.iter().map(|m| m.multiplicity).sum::<usize>(), "seed {seed}");
        assert!(found.modes.iter().all(|m| m.residual < 1e-10), "seed {seed}: {:?}", found.modes);
        total += found.counted;
        let wide = Newton { max_step: Some(200.0), radius: Some(f64::INFINITY), ..Newton::default() };
        for k in 0..grid * grid {
            let (a, b) = ((k % grid) as f64 + 0.5, (k / grid) as f64 + 0.5);
            let guess = c(-250.0 + 600.0 * a / grid as f64, 60.0 + 5940.0 * b / grid as f64);
            let Ok(root) = net.solve(&laws, guess, &wide, &mut work) else { continue };
            let inside = (-249.99..349.99).contains(&root.s.re) && (60.01..5999.99).contains(&root.s.im);
            let known = found.modes.iter().any(|m| (m.s - root.s).norm() < 1e-7 * root.s.norm());
            assert!(known || !inside, "seed {seed}: {} was not found", root.s);
        }
    }
    println!("{total} modes certified");
    assert!(total > 0);
}

#[test]
fn oracle_random_networks_are_certified() {
    certify(0..40, 8);
}

#[test]
#[ignore = "long: 1000 random networks with a dense search"]
fn oracle_a_thousand_random_networks_are_certified() {
    certify(0..1000, 20);
}
