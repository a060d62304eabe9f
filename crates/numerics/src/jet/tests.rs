//! Derivatives of jets against differences, at the ends of their ranges, and in another space.

use super::{Jet, JetSpace, Order};
use crate::C64;
use crate::check::{remainder_slopes, slopes_near};

/// A function that uses every operation, of three real variables.
fn everything(space: JetSpace, x: &[f64]) -> Jet {
    let v: Vec<Jet> = (0..3).map(|i| space.seed(i, C64::new(x[i], 0.0))).collect();
    let z = &v[0] + &v[1].scale(C64::new(0.3, 0.8));
    let w = &(&z.exp() / &z.sqrt()) - &(&v[2] * &z).sin();
    let y = &(&w.ln() * &z.cos()) + &(&v[2].tanh() * &z.powi(3));
    let k = &y.powf(1.7) + &(&z.abs() * &w.conj().re());
    let mut all = &k.shift(C64::new(0.1, 0.2)) + &(-&y.im());
    all.add_scaled(&w, C64::new(0.2, -0.4));
    all
}

#[test]
fn order_remainders_fall_as_h2_and_h3() {
    let (x, direction) = ([0.7, 0.4, 1.1], [0.5, -0.3, 0.8]);
    let jet = everything(JetSpace::new(3, Order::Second), &x);
    let (mut first, mut second) = (C64::ZERO, C64::ZERO);
    for i in 0..3 {
        first += jet.gradient()[i] * direction[i];
        for j in 0..3 {
            second += 0.5 * jet.hessian(i, j) * direction[i] * direction[j];
        }
    }
    let at = |h: f64| {
        let moved: Vec<f64> = x.iter().zip(direction).map(|(x, d)| x + h * d).collect();
        everything(JetSpace::new(3, Order::Value), &moved).value() - jet.value()
    };
    slopes_near(&remainder_slopes(|h| (at(h) - first * h).norm()), 2.0, 0.05);
    slopes_near(&remainder_slopes(|h| (at(h) - first * h - second * h * h).norm()), 3.0, 0.05);
}

#[test]
fn exact_tanh_far_out_is_one() {
    for x in [19.0, 21.0, 1e5, -1e5] {
        let jet = JetSpace::new(1, Order::Second).seed(0, C64::new(x, 0.3)).tanh();
        let [off, slope] = [jet.value() - x.signum(), jet.gradient()[0]];
        assert!(off.norm() < 1e-15 && slope.norm() < 1e-15, "{off} {slope}");
    }
}

#[test]
fn exact_powers_at_zero_are_finite() {
    let jet = JetSpace::new(1, Order::Second).seed(0, C64::ZERO);
    assert_eq!(jet.powi(2).hessian(0, 0), C64::new(2.0, 0.0));
    assert_eq!(jet.powi(1).gradient()[0], C64::ONE);
    assert_eq!(jet.powi(0).gradient()[0], C64::ZERO);
}

#[test]
fn exact_a_jet_taken_elsewhere_is_the_function_of_the_seeds_there() {
    // Seeds 0, 1, 2 become 3, 0 and none.
    let (x, wide) = ([0.7, 0.4, 1.1], JetSpace::new(4, Order::Second));
    let place = |i: usize| [Some(3), Some(0), None][i];
    let jet = everything(JetSpace::new(3, Order::Second), &x);
    let taken = wide.take(&jet, place);
    assert_eq!(taken.value(), jet.value());
    let from = |k: usize| (0..3).find(|i| place(*i) == Some(k));
    for i in 0..4 {
        let slope = from(i).map_or(C64::ZERO, |i| jet.gradient()[i]);
        assert_eq!(taken.gradient()[i], slope);
        for j in 0..4 {
            let bend = from(i).zip(from(j)).map_or(C64::ZERO, |(i, j)| jet.hessian(i, j));
            assert_eq!(taken.hessian(i, j), bend);
        }
    }
    assert_eq!(JetSpace::new(4, Order::First).take(&jet, place).order(), Order::First);
}
