//! Ducts whose gas or area varies, in pieces: against closed forms, and what more pieces would change.

use rijke_network::Workspace;
use rijke_network::file::{moved_by_pieces, read};
use rijke_numerics::C64;
use std::f64::consts::PI;

fn modes(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    let found = built.modes(&built.region).unwrap();
    found.modes.iter().map(|m| m.s).collect()
}

/// A duct by its keys between two ideal ends.
fn duct(up: &str, down: &str, keys: &str) -> String {
    format!(
        "[search]\nfrequency_hz = [50, 2000]\ngrowth_rate = [-100, 100]\n[upstream]\ntype = '{up}'\n[downstream]\n\
         type = '{down}'\n[[element]]\ntype = 'duct'\nlength = 0.5\n{keys}\n"
    )
}

#[test]
fn oracle_cones_have_the_modes_of_spherical_waves() {
    // r p = sin(k r + phase) with r from the apex; at a closed end d(p)/dr = 0, at an open one p = 0.
    let (narrow, wide, length) = (0.05, 0.12, 0.5);
    let cone = format!("diameter = {narrow}\ndiameter_end = {wide}\nsound_speed = 340\ndensity = 1.2258\n");
    let from = length * narrow / (wide - narrow);
    let to = from + length;
    let closed = |k: f64| (k * length).sin() + k * from * (k * length).cos();
    let both = |k: f64| (1.0 + k * k * from * to) * (k * length).sin() - k * length * (k * length).cos();
    for (up, down, missed) in
        [("closed", "open", &closed as &dyn Fn(f64) -> f64), ("closed", "closed", &both)]
    {
        let found = modes(&duct(up, down, &cone));
        assert!(found.len() >= 4, "{found:?}");
        for s in &found {
            let (k, h) = (s.im / 340.0, 1e-6);
            let off = missed(k) * 2.0 * h / (missed(k + h) - missed(k - h));
            assert!(off.abs() < 1e-6 * k && s.re.abs() < 1e-6, "{up} {down} {s}: {:e}", off / k);
        }
    }
    let open = modes(&duct("open", "open", &cone));
    for (n, s) in open.iter().enumerate() {
        let exact = PI * (n + 1) as f64 * 340.0 / length;
        assert!((s.im / exact - 1.0).abs() < 1e-6, "{s} for {exact}");
    }
}

#[test]
fn order_pieces_that_are_said_to_move_modes_do() {
    let slope =
        "diameter = 0.05\ndiameter_end = 0.12\ntemperatures = [600, 500, 480, 400]\nwall = 'kirchhoff'\n";
    for (flow, pieces) in [("", 6), ("[flow]\nvelocity = 2\nentropy_waves = false\n", 20)] {
        let text = |pieces: usize| {
            let text = duct("unflanged", "unflanged", &format!("{slope}pieces = {pieces}"));
            format!("{flow}{}", text.replace("2000]", "1200]").replace("-100", "-900"))
        };
        let (coarse, fine) = (modes(&text(pieces)), modes(&text(2 * pieces)));
        assert!(coarse.len() >= 2 && coarse.len() == fine.len());
        let said = moved_by_pieces(&text(pieces), &coarse).unwrap();
        for ((a, b), by) in coarse.iter().zip(&fine).zip(said) {
            let by = by.unwrap();
            assert!(
                by.norm() > 1e-4 && (by - (b - a)).norm() < 1e-6 * a.norm(),
                "{flow} {a}: {by} for {}",
                b - a
            );
        }
    }
    let lumped = duct("open", "closed", "diameter = 0.05\nwall = 'paper'\nscheme = 'lumped'\npieces = 10");
    let built = read(&lumped).unwrap();
    let uniform = read(&duct("open", "closed", "diameter = 0.05\npieces = 10")).unwrap();
    assert!(!built.in_pieces && !uniform.in_pieces);
    let found = built.network.modes(&built.laws, &built.region, &mut Workspace::default()).unwrap();
    let places: Vec<C64> = found.modes.iter().map(|m| m.s).collect();
    // The pieces of the lumped scheme are what it says.
    assert!(moved_by_pieces(&lumped, &places).unwrap().iter().all(|by| by.unwrap().norm() < 1e-8));
}
