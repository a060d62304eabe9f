//! Sensitivities along x against inserting the change, and against the derivatives by slots.

use crate::common_laws::{c, root};
use crate::derivatives::{EVERYTHING, everything};
use rijke_network::{Device, Network, Places, Region, Root, Segment, Sensitivities, Slot, Workspace};
use rijke_numerics::C64;

/// Integral over a segment by Simpson's rule in its stations.
fn integral(values: &[C64], length: f64) -> C64 {
    let n = values.len() - 1;
    let weight = |k: usize| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    values.iter().enumerate().map(|(k, v)| v * weight(k)).sum::<C64>() * (length / (3 * n) as f64)
}

#[test]
fn oracle_stations_add_up_to_the_derivatives_of_segments() {
    let (net, laws) = everything(EVERYTHING);
    let found = root(&net, &laws, c(-40.0, 1120.0));
    let (mut work, mut adjoint) = (Workspace::default(), Sensitivities::default());
    let places = Places { at: vec![], reference: 2 };
    net.sensitivities(&laws, &found, &places, &mut adjoint, &mut work).unwrap();
    let samples = 201;
    let stations = net.along(&laws, &found, samples, &mut work).unwrap();
    assert_eq!(stations.len(), 4 * samples);
    let by = |slot| adjoint.with_respect_to(&adjoint.s, slot);
    let values = |i: usize| {
        let h = &stations[i * samples..(i + 1) * samples];
        (h[samples - 1].x - h[0].x, h)
    };
    for i in 0..4 {
        let (length, here) = values(i);
        // Losses: dk_mu/dx is feedback per metre.
        for (k, slot) in [(0, Slot::Viscous(i)), (3, Slot::Thermal(i))] {
            let sum: C64 = integral(&here.iter().map(|s| s.feedback[k]).collect::<Vec<_>>(), length);
            assert!((sum - by(slot)).norm() < 1e-8 * by(slot).norm(), "{slot:?}: {sum} against {}", by(slot));
        }
    }
}

#[test]
fn oracle_small_changes_anywhere_do_what_stations_say() {
    let segments = || {
        vec![
            Segment::new(0.4, 1e-3, 343.0, 1.2),
            Segment::new(0.5, 1.6e-3, 420.0, 0.8),
            Segment::new(0.3, 1.1e-3, 380.0, 0.98),
        ]
    };
    let close = |mut net: Network| {
        net.set(Slot::Upstream, c(-0.9, 0.1)).unwrap();
        net.set(Slot::Downstream, c(0.4, -0.7)).unwrap();
        net.set(Slot::Eu(1), c(-0.2, 0.1)).unwrap();
        net
    };
    let net = close(Network::new(segments()).unwrap());
    let none = rijke_network::Constant;
    let region = Region { sigma: [-200.0, 100.0], omega: [200.0, 3000.0] };
    let mut work = Workspace::default();
    let found = net.modes(&none, &region, &mut work).unwrap().modes[1];
    let root = Root { s: found.s, steps: 0, residual: 0.0 };
    let stations = net.along(&none, &root, 11, &mut work).unwrap();
    let solve = |net: &Network| {
        let newton = rijke_network::Newton { tolerance: 1e-14, ..Default::default() };
        net.solve(&none, found.s, &newton, &mut Workspace::default()).unwrap().s
    };
    // Cut the second segment at a station; put weak devices there, or change a short piece of it.
    let cut = |piece: f64, change: &dyn Fn(&mut Segment)| {
        let mut all = segments();
        let whole = all[1];
        let middle = Segment { length: piece, ..whole };
        let mut changed = middle;
        change(&mut changed);
        let (before, after) = (0.2 - 0.5 * piece, 0.3 - 0.5 * piece);
        let parts = [Segment { length: before, ..whole }, changed, Segment { length: after, ..whole }];
        all.splice(1..2, parts);
        close(Network::new(all).unwrap())
    };
    let here = stations[11 + 4];
    assert!((here.x - 0.6).abs() < 1e-12 && here.segment == 1 && (here.impedance - 336.0).abs() < 1e-9);
    let slope = |f: &dyn Fn(f64) -> C64, h: f64| (f(h) - f(-h)) / (2.0 * h);
    let put = |slot: Slot, unit: f64| {
        move |h: f64| {
            let mut net = cut(1e-9, &|_| ());
            net.set(slot, c(unit * h, 0.0)).unwrap();
            solve(&net)
        }
    };
    for (device, slot, unit) in [
        (Device::Drag, Slot::Mu(2), 336.0),
        (Device::Heat, Slot::Eu(2), -1.0),
        (Device::Leak, Slot::Ep(2), 1.0 / 336.0),
    ] {
        let got = slope(&put(slot, unit), 1e-4);
        let expected = here.device(device);
        assert!((got - expected).norm() < 1e-6 * expected.norm(), "{device:?}: {got} against {expected}");
    }
    // A piece of 1 mm: its mean density of sensitivity is that at its middle, to second order in its length.
    let piece = 1e-3;
    let area = slope(&|h| solve(&cut(piece, &|s| s.area *= 1.0 + h)), 1e-3) / piece;
    assert!((area - here.area).norm() < 1e-4 * here.area.norm(), "{area} against {}", here.area);
    let warm = |h: f64| {
        solve(&cut(piece, &|s| {
            s.density /= 1.0 + h;
            s.sound_speed *= (1.0 + h).sqrt();
        }))
    };
    let got = slope(&warm, 1e-3) / piece;
    assert!(
        (got - here.temperature).norm() < 1e-4 * here.temperature.norm(),
        "{got} against {}",
        here.temperature
    );
    // The loudest station has pressure 1.
    let loudest = stations.iter().map(|s| s.pressure.norm()).fold(0.0, f64::max);
    assert!((loudest - 1.0).abs() < 1e-12);
}
