//! Laws per metre.

use super::{conditions, study};
use crate::common::tube::speed;
use rijke_engine::{Assembly, PointModel};
use rijke_numerics::C64;
use rijke_study::Catalogue;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

const END: (f64, f64) = (0.95, 3.0);

/// Zero at the eigenvalues of a closed tube of 1 m with p' = -m p - s rho u and u' = -s p/(rho c^2) - e u,
/// whose end reflects R: the matrix of these, less its mean -(m + e)/2, has the square (e - m)^2/4 + s^2/c^2.
fn characteristic(s: C64, [m, e]: [f64; 2]) -> C64 {
    let (half, wave, r) = (0.5 * (e - m), s / speed(), C64::from_polar(END.0, END.1));
    let root = (half * half + wave * wave).sqrt();
    let sine = root.sinh() / root;
    (root.cosh() + half * sine) * (1.0 - r) + wave * sine * (1.0 + r)
}

/// Its zero next to `s`, by secants.
fn eigenvalue(s: C64, couplings: [f64; 2]) -> C64 {
    let (mut a, mut b) = (s, s * (1.0 + 1e-6));
    for _ in 0..20 {
        let [fa, fb] = [a, b].map(|s| characteristic(s, couplings));
        if (fb - fa).norm() == 0.0 {
            break;
        }
        (a, b) = (b, b - fb * (b - a) / (fb - fa));
    }
    b
}

#[test]
fn exact_couplings_per_metre_have_the_waves_of_their_equations() {
    let (r, angle) = END;
    let rig = format!(
        "name = 'tube'\n[search]\nfrequency_hz = [50, 700]\ngrowth_rate = [-100, 100]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'constant'\nmodulus = {r}\nangle = {angle}\n[[element]]\nname = 'tube'\ntype = 'duct'\nlength = 1.0\ndiameter = 0.03\n\
         pieces = 200\nwall = 'none'\n"
    );
    let study = study("along", &rig).unwrap();
    for (coefficient, couplings) in [("mp", [0.03, 0.0]), ("eu", [0.0, 0.03])] {
        let text = format!(
            "[[candidate]]\nid = 'a'\nrole = 'a'\nname = 'a'\ncite = ['a test']\n\
             parameters.k = {{ unit = 'm^-1', prior = {{ normal = {{ mean = 0.03, sd = 0.01 }} }} }}\n\
             [[candidate.effect]]\nacts_at = 'tube'\n{coefficient} = 'k'\n"
        );
        let path = std::env::temp_dir().join(format!("rijke-along-{}.toml", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let read = Catalogue::read(&path, &study.rig).unwrap_or_else(|error| panic!("{error}"));
        std::fs::remove_file(&path).unwrap();
        let candidates = read.candidates().to_vec();
        let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &BTreeMap::new()).unwrap();
        let conditions = conditions(&study);
        let model = PointModel::new(&assembly, &conditions, &[]).unwrap();
        let (_, spectrum) = model.spectrum(&[0.03], [None, None]).unwrap();
        assert_eq!(spectrum.modes.modes.len(), 4);
        for (n, mode) in (0..).zip(&spectrum.modes.modes) {
            let exact = eigenvalue(mode.s, couplings);
            // Without it R e^(-2 s/c) = 1; the pieces are of first order in their length.
            let without = 0.5 * speed() * C64::new(r.ln(), angle + 2.0 * PI * f64::from(n));
            let moved = (exact - without).norm();
            assert!((mode.s - exact).norm() < 2e-3 * moved && moved > 0.3, "{} {exact} {without}", mode.s);
        }
    }
}
