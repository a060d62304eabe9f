//! Folders of OSCILOS_lite inputs.

use crate::common_laws::c;
use rijke_network::file::{OscilosError, OscilosTexts, by_the_rule_of_oscilos, read_oscilos};
use rijke_network::{Chain, Constant, Workspace};
use std::f64::consts::PI;

fn texts() -> OscilosTexts {
    OscilosTexts {
        geometry: "x[m] r[m] SectionIndex TubeIndex\n0 0.01 0 0\n1 0.01 0 0\n2 0.01 0 0\n".to_owned(),
        mean_flow: "P1 T1 choice M1 gamma dT\n101325.0 293.0 1 0.001 1 1\n".to_owned(),
        flame: None,
        inlet: "Type Param_1 Param_2 Param_3\n2 - - -\n".to_owned(),
        outlet: "Type Param_1 Param_2 Param_3\n1 - - -\n".to_owned(),
        scan_range: "f f n g g n\n0 1000 50 -200 200 50\n".to_owned(),
    }
}

#[test]
fn exact_oscilos_inputs() {
    // A closed-open duct of 2 m at M = 0.001: f = c (1 - M^2)/(4 L) (2k + 1).
    let (chain, region) = read_oscilos(&texts()).unwrap();
    let found = chain.modes(&Constant, &region, &mut Workspace::default()).unwrap();
    let speed = (1.4 * 8.3145 / 28.96512 * 1000.0 * 293.0_f64).sqrt();
    let first = 0.5 * std::f64::consts::PI * speed * (1.0 - 1e-6) / 2.0;
    assert_eq!(found.counted, 12);
    for (k, mode) in found.modes.iter().enumerate() {
        let exact = c(0.0, first * (2 * k + 1) as f64);
        assert!((mode.s - exact).norm() < 1e-12 * exact.norm(), "{} against {exact}", mode.s);
    }
    // A cone is a staircase; a flame needs its file; what is not read is named.
    let cone =
        OscilosTexts { geometry: "x r s t\n0 0.01 0 1\n1 0.03 0 0\n2 0.03 0 0\n".to_owned(), ..texts() };
    assert_eq!(read_oscilos(&cone).unwrap().0.states().len(), 50);
    let flame =
        OscilosTexts { geometry: "x r s t\n0 0.01 0 0\n1 0.01 11 0\n2 0.01 0 0\n".to_owned(), ..texts() };
    assert_eq!(read_oscilos(&flame).unwrap_err(), OscilosError::NoFlame);
    let untitled = OscilosTexts { geometry: "0 0.01 0 0\n1 0.01 0 0\n2 0.01 0 0\n".to_owned(), ..texts() };
    let said = read_oscilos(&untitled).unwrap_err().to_string();
    assert!(said.starts_with("Geometry.txt: the first line, `0 0.01 0 0`, holds numbers"), "{said}");
    let twice = OscilosTexts {
        geometry: "x r s t\n0 0.01 0 0\n1 0.01 11 0\n1.5 0.01 11 0\n2 0.01 0 0\n".to_owned(),
        flame: Some("t a b\n1 0.3 2.1".to_owned()),
        ..texts()
    };
    assert_eq!(read_oscilos(&twice).unwrap_err(), OscilosError::Flames { row: 3 });
    let lit = OscilosTexts { flame: Some("t a b\n1 0.3 2.1".to_owned()), ..flame };
    let modes = read_oscilos(&lit)
        .map(|(chain, region)| chain.modes(&Constant, &region, &mut Workspace::default()).unwrap())
        .unwrap();
    assert!(modes.counted >= 8);
    let choked = OscilosTexts { outlet: "t a b c\n3 - - -\n".to_owned(), ..texts() };
    let said = read_oscilos(&choked).unwrap_err().to_string();
    assert_eq!(said, "Outlet.txt: Type 3 is not supported; supported are 1, 2, 4, 5, 11 and 12");
    let broken = OscilosTexts { scan_range: "f f n g g n\n0 many 50\n".to_owned(), ..texts() };
    let said = read_oscilos(&broken).unwrap_err().to_string();
    assert_eq!(said, "Scan_range.txt, line 2: 6 numbers are needed, found `0 many 50`");
}

#[test]
fn oracle_eigenvalues_that_oscilos_prints() {
    // The burner of the user guide of OSCILOS_lite (MorgansLab), with its fluctuating flame. Its table 2 has
    // 53.71 Hz with -197.95 1/s and 186.36 Hz with +160.34 1/s, found with its own open ends.
    let burner = OscilosTexts {
        geometry: "x[m] r[m] SectionIndex TubeIndex\n0 0.0325 0 0\n0.295 0.011 0 0\n0.315 0.020 0 0\n0.345 0.007348 0 0\n\
                   0.353 0.01 0 0\n0.409 0.046263 11 0\n0.663 0.0325 0 0\n1.323 0.0325 0 0\n"
            .to_owned(),
        mean_flow: "P1[Pa] T1[K] choice_M1_u1 M1_u1 Choice_gamma Delta_T_HS\n101325.0 293.0 2 3 1 6\n".to_owned(),
        flame: Some("Type Param_1 Param_2\n1 1 2.1\n".to_owned()),
        inlet: "Type Param_1 Param_2 Param_3\n2 - - -\n".to_owned(),
        outlet: "Type Param_1 Param_2 Param_3\n11 - - -\n".to_owned(),
        scan_range: "f f n g g n\n0 400 50 -250 250 50\n".to_owned(),
    };
    let (chain, region) = read_oscilos(&burner).unwrap();
    let modes = chain.modes(&Constant, &region, &mut Workspace::default()).unwrap();
    let ruled: Vec<_> =
        modes.modes.iter().filter_map(|m| by_the_rule_of_oscilos(&chain, m.s).unwrap()).collect();
    // The second of its numbers is not a zero of its own equation to all digits printed: its search ends
    // before.
    for ([hertz, growth], within) in [([53.71, -197.95], [0.006, 0.006]), ([186.36, 160.34], [0.02, 0.11])] {
        let near = ruled.iter().min_by(|a, b| {
            let off = |s: &rijke_numerics::C64| (s.im - 2.0 * PI * hertz).abs();
            off(a).total_cmp(&off(b))
        });
        let s = near.unwrap();
        assert!((s.im / (2.0 * PI) - hertz).abs() < within[0], "{s} {hertz}");
        assert!((s.re - growth).abs() < within[1], "{s} {growth}");
    }
}
