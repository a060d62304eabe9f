//! From an operating point to its duct and its modes.

use super::heater::{Heater, heater, thermocouple};
use crate::acoustics::duct::{FineMode, FineTube, Piece, TubeEnd};
use crate::acoustics::radiation::OpenEnd;
use crate::acoustics::walls::{Rods, Section};
use crate::truth::{LabError, Truth};
use rijke_flow::BaseState;
use rijke_flow::{TubePoint, TubeRig};
use rijke_numerics::C64;

/// The duct of an operating point whose slow flow is `base`, between the open ends `bottom` and `top`.
pub(crate) fn duct(
    rig: &TubeRig,
    truth: &Truth,
    point: &TubePoint,
    base: &BaseState,
    [bottom, top]: [OpenEnd; 2],
) -> FineTube {
    let half = if point.plates { 0.5 * rig.plates.length() } else { 0.0 };
    let centre = point.position.unwrap_or(0.0);
    // Where the prongs end and, above that, the bore of the heater.
    let (tip, bore) = ((centre - half).max(0.0), centre + half);
    let bare = Section { radius: rig.tube.radius(), roughness: truth.wall.roughness, rods: vec![] };
    let prongs = Section { rods: rods(rig, truth), ..bare.clone() };
    let plates = Section { radius: 0.5 * rig.plates.inner_diameter, ..bare.clone() };
    let section = |x: f64| match x {
        x if x < tip => &prongs,
        x if x < bore => &plates,
        _ => &bare,
    };
    let mut marks = vec![(0.0, None), (tip, None), (bore, None)];
    marks.extend(rig.microphones.positions.iter().enumerate().map(|(m, x)| (*x, Some(Piece::Microphone(m)))));
    let obstacle = |x: f64, obstacle| (x, Some(Piece::Obstacle(Box::new(obstacle))));
    if point.plates {
        let Heater { lower_face, middle, upper_face } = heater(rig, truth, point, centre, base);
        marks.extend([obstacle(tip, lower_face), obstacle(centre, middle), obstacle(bore, upper_face)]);
    }
    if point.thermometers {
        marks.extend(rig.thermometers.iter().map(|x| obstacle(*x, thermocouple(rig, truth, *x, base))));
    }
    let uniform = base.temperature.windows(2).all(|pair| pair[0] == pair[1]);
    let step = if uniform { f64::INFINITY } else { STEP };
    let (mut duct_media, mut pieces, mut x) = (Vec::new(), Vec::new(), rig.tube.length);
    // From the top down; what is at the same place in the order given, microphones first.
    marks.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (mark, piece) in marks {
        let cells = ((x - mark) / step).ceil().max(1.0);
        let h = (x - mark) / cells;
        for k in 0..(if h > 0.0 { cells as usize } else { 0 }) {
            let low = x - (k + 1) as f64 * h;
            let media = gauss_points(low, h).map(|at| {
                let medium = (section(low + 0.5 * h).clone(), base.at(at));
                duct_media.iter().position(|known| *known == medium).filter(|_| uniform).unwrap_or_else(
                    || {
                        duct_media.push(medium);
                        duct_media.len() - 1
                    },
                )
            });
            let middle = low + 0.5 * h;
            let drift = base.velocity(middle) / base.sound_speed(middle).powi(2);
            pieces.push(Piece::Line { length: h, media, drift });
        }
        x = mark;
        pieces.extend(piece);
    }
    let entry_loss = (1.0 + truth.flow.closures.entrance_loss) * base.mass_flux.max(0.0);
    FineTube {
        pieces,
        media: duct_media,
        top: TubeEnd {
            end: top,
            open_area: bare.open_area(),
            gas: base.at(rig.tube.length),
            entry_loss: 0.0,
        },
        bottom: TubeEnd { end: bottom, open_area: section(0.0).open_area(), gas: base.at(0.0), entry_loss },
    }
}

/// Longest step of the integrator where the gas is not uniform, m.
const STEP: f64 = 0.01;

/// The two Gauss points of a step.
fn gauss_points(low: f64, h: f64) -> [f64; 2] {
    let offset = h / 12.0_f64.sqrt();
    [low + 0.5 * h - offset, low + 0.5 * h + offset]
}

/// The first `count` modes, lowest first.
///
/// # Errors
/// One was not found.
pub(crate) fn modes(
    duct: &FineTube,
    rig: &TubeRig,
    point: &TubePoint,
    base: &BaseState,
    count: usize,
) -> Result<Vec<FineMode>, LabError> {
    // The time that sound takes from open end to open end, ends included, at rest.
    let ends =
        0.63 * rig.tube.radius() * (1.0 / duct.top.gas.sound_speed + 1.0 / duct.bottom.gas.sound_speed);
    let cells = 50;
    let slowness = |k: usize| 1.0 / base.sound_speed((k as f64 + 0.5) / cells as f64 * rig.tube.length);
    let time = ends + (0..cells).map(slowness).sum::<f64>() * rig.tube.length / cells as f64;
    (1..=count)
        .map(|n| {
            // The n-th half wave of the open tube, corrected for its ends, decaying as losses near 10 1/s
            // make it.
            let guess = C64::new(-10.0, n as f64 * std::f64::consts::PI / time);
            let found =
                duct.mode(guess).filter(|mode| (mode.s - guess).norm() < 0.4 * guess.norm() / n as f64);
            found.ok_or_else(|| LabError::NoMode { point: point.id.clone(), number: n })
        })
        .collect()
}

/// Prongs and feed wires.
fn rods(rig: &TubeRig, truth: &Truth) -> Vec<Rods> {
    let (prongs, surface) = (&rig.insert, &truth.prongs);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apparatus::base::base_state;
    use rijke_flow::TubeCampaign;

    /// The laboratory without the scatter from one installation of the rig to the next.
    fn same_every_time() -> Truth {
        let mut truth = Truth::standard();
        (truth.ends.absorption_sd, truth.ends.extension_sd) = (0.0, 0.0);
        truth
    }

    fn point(id: &str) -> TubePoint {
        TubeCampaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == id).unwrap()
    }

    fn all(truth: &Truth, point: &TubePoint) -> Vec<FineMode> {
        let rig = TubeRig::juniper_yoko_2022();
        let base = base_state(&rig, truth, point, 294.0).unwrap();
        modes(
            &duct(&rig, truth, point, &base, crate::apparatus::open_ends::open_ends(&rig, truth, point, 1)),
            &rig,
            point,
            &base,
            6,
        )
        .unwrap()
    }

    fn first(truth: &Truth, id: &str) -> FineMode {
        all(truth, &point(id)).remove(0)
    }

    #[test]
    fn paper_growth_rate_and_frequency_have_the_size_of_figure_4() {
        // Section 6.1: eta = 1 with |R| = 0.9952 and 0.9953 fits the two empty tubes: (c/L) ln|R| less
        // Kirchhoff's wall loss, -7.1 1/s at 20 C. The truth keeps two thirds of the absorption that this
        // implies: up to 0.4 1/s less.
        let (s, gas) =
            (first(&same_every_time(), "C3-E").s, TubeRig::juniper_yoko_2022().gas.at(294.0, 101_325.0));
        let wall = (s.im * gas.viscosity / gas.density / 2.0).sqrt() / 0.0237
            * (1.0 + (gas.gamma - 1.0) / gas.prandtl.sqrt());
        let printed = gas.sound_speed * 0.99525_f64.ln() - wall;
        assert!((0.0..0.5).contains(&(s.re - printed)), "{s}, from the printed values {printed}");
        // The printed angles 3.0597 and 3.0641 give omega = (c/L) angle, 1051 to 1052 rad/s, less the wall's
        // share.
        assert!((s.im / (gas.sound_speed * 3.06) - 1.0).abs() < 0.01);
    }

    #[test]
    fn exact_prongs_of_no_length_leave_the_empty_tube_but_for_the_mouth() {
        let (rig, truth) = (TubeRig::juniper_yoko_2022(), same_every_time());
        let short = TubePoint { position: Some(1e-6), ..point("C3-05") };
        let base = base_state(&rig, &truth, &short, 294.0).unwrap();
        let mut with = duct(
            &rig,
            &truth,
            &short,
            &base,
            crate::apparatus::open_ends::open_ends(&rig, &truth, &short, 1),
        );
        with.bottom.open_area = rig.tube.area();
        let empty = first(&truth, "C3-E").s;
        assert!((modes(&with, &rig, &short, &base, 1).unwrap()[0].s - empty).norm() < 1e-3);
    }

    #[test]
    fn oracle_a_tube_full_of_smooth_thin_walled_blockage_is_a_narrower_tube() {
        // Prongs all the way: the same line everywhere, so only the ratio of perimeter to area has changed.
        let (rig, mut truth) = (TubeRig::juniper_yoko_2022(), same_every_time());
        (truth.prongs.rod_roughness, truth.prongs.wire_roughness) = (1.0, 1.0);
        let (damped, empty) = (first(&truth, "C3-95").s.re, first(&truth, "C3-E").s.re);
        let perimeters = (rig.tube.perimeter() + rig.insert.perimeter()) / rig.tube.perimeter();
        let mut lossless = truth.clone();
        lossless.wall.roughness = 0.1;
        let wall_share = (empty - first(&lossless, "C3-E").s.re) / 0.9;
        let expected =
            empty + wall_share * (perimeters * rig.tube.area() / (rig.tube.area() - rig.insert.area()) - 1.0);
        assert!((damped / expected - 1.0).abs() < 0.02, "{damped} against {expected}");
    }

    #[test]
    fn lab_every_point_of_the_campaign_has_its_modes_and_is_stable() {
        // Paper, section 3: data only from stable operating points; all 175 are.
        let truth = Truth::standard();
        for point in TubeCampaign::juniper_yoko_2022().points {
            let modes = all(&truth, &point);
            assert!(modes[0].s.re < -0.5, "{} has {}", point.id, modes[0].s);
            let rising = modes.windows(2).all(|pair| pair[1].s.im > pair[0].s.im + 600.0);
            assert!(rising, "{}: {:?}", point.id, modes.iter().map(|m| m.s).collect::<Vec<_>>());
        }
    }

    #[test]
    fn paper_signs_of_what_heater_and_thermocouples_do() {
        let truth = same_every_time();
        let s = |id| first(&truth, id).s;
        // Fig. 5: the heater damps more near the ends than in the middle, and lowers the frequency there.
        assert!(s("C1-15").re < s("C1-50").re && s("C1-15").im < s("C1-50").im);
        // Thermocouples change the growth rate.
        assert!(s("H0-50").re < s("C1-50").re - 0.1);
        // Fig. 10: power drives at a quarter of the tube and damps at three quarters; frequency rises with
        // power.
        assert!(s("H180-25").re > s("H0-25").re && s("H180-75").re < s("H0-75").re);
        assert!(s("H180-25").im > s("H80-25").im && s("H80-25").im > s("H0-25").im);
    }

    #[test]
    fn order_steps_of_the_integrator_are_fine_enough() {
        // Halving every step moves s by less than a fiftieth of the smallest measurement error (0.1 rad/s).
        let (rig, truth, point) = (TubeRig::juniper_yoko_2022(), same_every_time(), point("H180-75"));
        let base = base_state(&rig, &truth, &point, 294.0).unwrap();
        let coarse = duct(
            &rig,
            &truth,
            &point,
            &base,
            crate::apparatus::open_ends::open_ends(&rig, &truth, &point, 1),
        );
        let mut fine = coarse.clone();
        (fine.pieces, fine.media) = (Vec::new(), Vec::new());
        let mut top = rig.tube.length;
        for piece in &coarse.pieces {
            let Piece::Line { length, drift, media } = piece else {
                fine.pieces.push(piece.clone());
                continue;
            };
            for k in 0..2 {
                let low = top - 0.5 * (k + 1) as f64 * length;
                let section = &coarse.media[media[0]].0;
                fine.media.extend(gauss_points(low, 0.5 * length).map(|at| (section.clone(), base.at(at))));
                let last = fine.media.len() - 1;
                fine.pieces.push(Piece::Line {
                    length: 0.5 * length,
                    media: [last - 1, last],
                    drift: *drift,
                });
            }
            top -= length;
        }
        let s = |duct: &FineTube| modes(duct, &rig, &point, &base, 1).unwrap()[0].s;
        assert!((s(&coarse) - s(&fine)).norm() < 2e-3, "{}", s(&coarse) - s(&fine));
    }
}
