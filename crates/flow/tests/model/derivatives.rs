//! Derivatives against differences.

use super::{AMBIENT, pipe};
use rijke_flow::{Dual, Number, SENSITIVE_TO, Single, Transient, TubeParameters, UNKNOWNS, Unknowns};
use rijke_numerics::check::{slopes_from, slopes_near};

const MIDDLE: [f64; UNKNOWNS] = [8.0, 1.0, 5.0, 0.12, 1.2, 1.0, 1.0, 0.0, 35.0, 0.05];
/// Sizes of a plausible change, one per unknown.
const SCALE: [f64; UNKNOWNS] = [2.0, 0.2, 2.0, 0.05, 0.3, 0.5, 0.05, 1.0, 10.0, 0.02];

fn transient<N: Single>(a: [N; UNKNOWNS]) -> (Vec<N>, N) {
    let pipe = pipe(0.25, 1);
    let u = Unknowns::from_array(a);
    let implicit = pipe.implicit(15.0);
    let mut state = Transient::cold(&pipe, &u, AMBIENT).unwrap();
    for power in [15.0, 80.0] {
        for _ in 0..10 {
            state.step(&pipe, &implicit, &u, power, AMBIENT + 0.5, 1e-13).unwrap();
        }
    }
    let mut times = Vec::new();
    pipe.arrival_times(&state.gas, u.orifice_length, &mut times);
    let velocity = pipe.heater_velocity(&state.gas);
    (times, velocity)
}

#[test]
fn order_transient_remainder_falls_as_h2() {
    let mut seeds = [Dual::<{ UNKNOWNS + 1 }>::constant(0.0); UNKNOWNS];
    for (i, seed) in seeds.iter_mut().enumerate() {
        *seed = Dual::variable(MIDDLE[i], i);
    }
    let (times, velocity) = transient(seeds);
    for unknown in 0..UNKNOWNS {
        let moved = |h: f64| {
            let mut a = MIDDLE;
            a[unknown] += h * SCALE[unknown];
            transient(a)
        };
        let remainder = |h: f64| {
            let (t, u) = moved(h);
            let time = t[7] - times[7].value - h * SCALE[unknown] * times[7].slopes[unknown];
            let speed = u - velocity.value - h * SCALE[unknown] * velocity.slopes[unknown];
            // The orifice length acts linearly, and on the time alone.
            if unknown == 9 { time.abs() } else { (time * 1e3).abs() + speed.abs() }
        };
        if unknown == 9 {
            assert!(remainder(1.0) < 1e-15);
        } else {
            slopes_near(&slopes_from(0.4, remainder), 2.0, 0.05);
        }
    }
}

#[test]
fn order_steady_remainder_falls_as_h2() {
    let pipe = pipe(0.65, 1);
    let solve = |a: &[f64]| {
        let p = TubeParameters {
            heater_drag: a[0],
            outer_nusselt: a[1],
            mount_resistance: a[2],
            wall_share: a[3],
            inner_nusselt: a[4],
            jet_enhancement: a[5],
        };
        pipe.steady(&p, 130.0 * a[6], AMBIENT + a[7]).unwrap()
    };
    let at = solve(&MIDDLE);
    let sensitivities = at.sensitivities(&pipe).unwrap();
    for k in 0..SENSITIVE_TO.len() {
        let s = &sensitivities[k];
        let remainder = |h: f64| {
            let mut a = MIDDLE;
            let step = h * SCALE[k];
            a[k] += step;
            let moved = solve(&a);
            let velocity = pipe.heater_velocity(&moved.gas) - pipe.heater_velocity(&at.gas);
            let faces = moved.gas.march.face.iter().zip(&at.gas.march.face).zip(&s.temperature);
            let worst = faces.map(|((m, t), d)| (m - t - step * d).abs()).fold(0.0, f64::max);
            let walls = moved.wall.iter().zip(&at.wall).zip(&s.wall);
            let worst = walls.map(|((m, t), d)| (m - t - step * d).abs()).fold(worst, f64::max);
            worst + (velocity - step * s.heater_velocity).abs()
        };
        slopes_near(&slopes_from(0.4, remainder), 2.0, 0.05);
    }
}
