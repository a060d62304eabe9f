//! From an operating point to its duct and its modes.

use crate::duct::{Duct, Mode, Mouth, Piece};
use crate::radiation::OpenEnd;
use crate::truth::{LabError, Truth};
use crate::walls::{Rods, Section};
use rijke_numerics::C64;
use rijke_rig::{OperatingPoint, Rig};

/// The duct of a cold operating point without heater and thermocouples, gas at `temperature` (K).
///
/// # Errors
/// The point has a heater, thermocouples or power.
pub(crate) fn duct(
    rig: &Rig,
    truth: &Truth,
    point: &OperatingPoint,
    temperature: f64,
) -> Result<Duct, LabError> {
    if point.heater || point.thermocouples || point.power > 0.0 {
        let what = "the laboratory measures the empty tube and the prongs alone; choose row C3";
        return Err(LabError::NotCovered { point: point.id.clone(), what });
    }
    let gas = rig.gas.at(temperature, rig.pressure);
    let bare = Section { radius: rig.tube.radius(), roughness: truth.wall.roughness, rods: vec![] };
    let prongs = Section { rods: rods(rig, truth), ..bare.clone() };
    let end = |absorption| OpenEnd {
        inner_radius: rig.tube.radius(),
        outer_radius: rig.tube.radius() + rig.tube.wall_thickness,
        absorption,
    };
    let tip = point.position.unwrap_or(0.0);
    let at_bottom = if tip > 0.0 { &prongs } else { &bare };
    Ok(Duct {
        pieces: pieces(rig, tip),
        top: Mouth { end: end(truth.ends.absorption_top), open_area: bare.open_area(), gas },
        bottom: Mouth { end: end(truth.ends.absorption_bottom), open_area: at_bottom.open_area(), gas },
        media: vec![(prongs, gas), (bare, gas)],
    })
}

/// The first `count` modes, lowest first.
///
/// # Errors
/// One was not found.
pub(crate) fn modes(
    duct: &Duct,
    rig: &Rig,
    point: &OperatingPoint,
    count: usize,
) -> Result<Vec<Mode>, LabError> {
    let tube = &rig.tube;
    let length = tube.length + 2.0 * 0.63 * tube.radius();
    (1..=count)
        .map(|n| {
            // The n-th half wave of the open tube, corrected for its ends, decaying as losses near 10 1/s make it.
            let guess = C64::new(-10.0, n as f64 * std::f64::consts::PI * duct.top.gas.sound_speed / length);
            let found =
                duct.mode(guess).filter(|mode| (mode.s - guess).norm() < 0.4 * guess.norm() / n as f64);
            found.ok_or_else(|| LabError::NoMode { point: point.id.clone(), number: n })
        })
        .collect()
}

/// Prongs and feed wires.
fn rods(rig: &Rig, truth: &Truth) -> Vec<Rods> {
    let (prongs, surface) = (&rig.prongs, &truth.prongs);
    let group = |count: u32, diameter: f64, roughness: f64| Rods {
        count: f64::from(count),
        radius: 0.5 * diameter,
        roughness,
    };
    vec![
        group(prongs.rods, prongs.rod_diameter, surface.rod_roughness),
        group(prongs.wires, prongs.wire_diameter, surface.wire_roughness),
    ]
}

/// Lines (medium 0 below the tip of the prongs, 1 above) and microphones, from the top down. Pressure and volume
/// velocity are continuous at the tip: there the area changes as it really does.
fn pieces(rig: &Rig, tip: f64) -> Vec<Piece> {
    let microphones = rig.microphones.positions.iter().enumerate().map(|(m, x)| (*x, Some(m)));
    let mut marks: Vec<(f64, Option<usize>)> = microphones.chain([(tip, None), (0.0, None)]).collect();
    marks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut x, mut pieces) = (rig.tube.length, Vec::new());
    for (mark, microphone) in marks {
        if mark < x {
            let medium = usize::from(mark >= tip);
            pieces.push(Piece::Line { length: x - mark, media: [medium; 2], drift: 0.0 });
            x = mark;
        }
        pieces.extend(microphone.map(Piece::Microphone));
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Campaign;

    fn point(id: &str) -> OperatingPoint {
        Campaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == id).unwrap()
    }

    fn first(truth: &Truth, id: &str) -> Mode {
        let (rig, point) = (Rig::juniper_yoko_2022(), point(id));
        let duct = duct(&rig, truth, &point, 294.0).unwrap();
        modes(&duct, &rig, &point, 6).unwrap().remove(0)
    }

    #[test]
    fn paper_growth_rate_and_frequency_have_the_size_of_figure_4() {
        // Section 6.1: eta = 1 with |R| = 0.9952 and 0.9953 fits the two empty tubes: (c/L) ln|R| less Kirchhoff's wall
        // loss, -7.1 1/s at 20 C. The truth keeps two thirds of the absorption that this implies: up to 0.4 1/s less.
        let (s, gas) =
            (first(&Truth::standard(), "C3-E").s, Rig::juniper_yoko_2022().gas.at(294.0, 101_325.0));
        let wall = (s.im * gas.viscosity / gas.density / 2.0).sqrt() / 0.0237
            * (1.0 + (gas.gamma - 1.0) / gas.prandtl.sqrt());
        let printed = gas.sound_speed * 0.99525_f64.ln() - wall;
        assert!((0.0..0.5).contains(&(s.re - printed)), "{s}, from the printed values {printed}");
        // The printed angles 3.0597 and 3.0641 give omega = (c/L) angle, 1051 to 1052 rad/s, less the wall's share.
        assert!((s.im / (gas.sound_speed * 3.06) - 1.0).abs() < 0.01);
    }

    #[test]
    fn exact_prongs_of_no_length_leave_the_empty_tube_but_for_the_mouth() {
        let (rig, truth) = (Rig::juniper_yoko_2022(), Truth::standard());
        let mut short = point("C3-05");
        short.position = Some(1e-6);
        let mut with = duct(&rig, &truth, &short, 294.0).unwrap();
        with.bottom.open_area = rig.tube.area();
        let empty = first(&truth, "C3-E").s;
        assert!((modes(&with, &rig, &short, 1).unwrap()[0].s - empty).norm() < 1e-3);
    }

    #[test]
    fn oracle_a_tube_full_of_smooth_thin_walled_blockage_is_a_narrower_tube() {
        // Prongs all the way: the same line everywhere, so only the ratio of perimeter to area has changed.
        let (rig, mut truth) = (Rig::juniper_yoko_2022(), Truth::standard());
        (truth.prongs.rod_roughness, truth.prongs.wire_roughness) = (1.0, 1.0);
        let (damped, empty) = (first(&truth, "C3-95").s.re, first(&truth, "C3-E").s.re);
        let perimeters = (rig.tube.perimeter() + rig.prongs.perimeter()) / rig.tube.perimeter();
        let mut lossless = truth.clone();
        lossless.wall.roughness = 0.1;
        let wall_share = (empty - first(&lossless, "C3-E").s.re) / 0.9;
        let expected =
            empty + wall_share * (perimeters * rig.tube.area() / (rig.tube.area() - rig.prongs.area()) - 1.0);
        assert!((damped / expected - 1.0).abs() < 0.02, "{damped} against {expected}");
    }

    #[test]
    fn exact_uncovered_points_are_refused() {
        let rig = Rig::juniper_yoko_2022();
        let refused = duct(&rig, &Truth::standard(), &point("H180-25"), 294.0);
        assert!(matches!(refused, Err(LabError::NotCovered { .. })));
    }
}
