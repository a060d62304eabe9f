//! Share, heat transfer and scatter from readings that a known gas makes.

mod coverage;
mod walk;

use super::fit::{Found, fit};
use super::gas::{GasReading, Heated, VALUES, Varies};
use super::{heated_states, measured_states};
use crate::base::PointState;
use crate::cause::{Cause, Sharing};
use crate::plan::{HeatedFlow, MeasuredGas};
use crate::source::Source;
use crate::{Campaign, Rig};
use rand_distr::{Distribution, StandardNormal, StudentT};
use rijke_numerics::{Cholesky, Matrix, Stream, Streams};

const PRIOR: [[f64; 2]; 2] = [[0.9, 0.15], [5.0, 3.0]];

/// Priors of all values: those of how the heat transfer differs from one constant are unit normal.
const PRIORS: [[f64; 2]; VALUES] = [PRIOR[0], PRIOR[1], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]];

/// The values of a heat transfer that is one constant.
fn constant([share, cooling]: [f64; 2]) -> [f64; VALUES] {
    [share, cooling, 0.0, 0.0, 0.0, 0.0]
}

fn heated(power: f64, flow: f64, day: &str) -> Heated {
    let (mass_flow, c_p) = (1.2 * flow, 1005.0);
    Heated {
        ambient: [293.0, 0.15],
        cause: Cause::Ambient(Sharing::Day(day.to_owned())),
        mass_flow,
        rise: power / (mass_flow * c_p),
        at: 0.3,
        cooling: 0.157 / (mass_flow * c_p),
        growth: [1e-4, 2e-7, -1e-10],
        varies: Varies { by: 0.0, diameter: 0.05, doublings: [0.0; 2] },
    }
}

/// Points of two days, two powers and two flows, their errors of the ambient temperature and of the rise, and
/// their readings.
struct Drawn {
    points: Vec<Option<Heated>>,
    errors: Vec<[f64; 2]>,
    readings: Vec<GasReading>,
}

fn normal(stream: &mut Stream) -> f64 {
    StandardNormal.sample(stream)
}

/// `count` points with readings of 0.5 K, and another one without.
fn drawn(count: usize, truth: [f64; 2], scatter: f64, stream: &mut Stream) -> Drawn {
    let days = [normal(stream), normal(stream)].map(|z| 0.15 * z);
    let (mut points, mut errors, mut readings) = (Vec::new(), Vec::new(), Vec::new());
    for point in 0..=count {
        let h = heated([40.0, 80.0][point / 2 % 2], [7e-4, 1.3e-3][point / 4 % 2], ["one", "two"][point % 2]);
        let error = [days[point % 2], scatter * normal(stream)];
        for at in [0.35, 0.5, 0.7].into_iter().filter(|_| point < count) {
            let temperature = gas(&h, at, truth, error) + 0.5 * normal(stream);
            readings.push(GasReading { point, at, temperature, sd: 0.5 });
        }
        points.push(Some(h));
        errors.push(error);
    }
    Drawn { points, errors, readings }
}

fn gas(h: &Heated, at: f64, values: [f64; 2], [ambient, relative]: [f64; 2]) -> f64 {
    let (t, _) = h.temperature(at, constant(values));
    t + ambient + relative * (t - h.ambient[0])
}

/// How far the gas of a point lies from what is handed on, in standard deviations.
fn off(found: &Found, drawn: &Drawn, truth: [f64; 2], point: usize) -> f64 {
    let (h, at) = (drawn.points[point].as_ref().unwrap(), 0.45);
    let (t, slopes) = h.temperature(at, found.values);
    let shared = found.covariance.quadratic(&slopes);
    let variance = shared + h.ambient[1].powi(2) + (found.scatter * (t - h.ambient[0])).powi(2);
    (gas(h, at, truth, drawn.errors[point]) - t) / variance.sqrt()
}

/// Readings without noise of a rise and a cooling inside the priors.
#[test]
fn oracle_readings_give_back_what_made_them() {
    let truth = [0.82, 6.5];
    let mut all = drawn(3, truth, 0.0, &mut Streams::new(1).stream("heated"));
    for r in &mut all.readings {
        r.temperature = all.points[r.point].as_ref().unwrap().temperature(r.at, constant(truth)).0;
    }
    let found = fit(&all.points, &all.readings, PRIORS, [0.0; 2]).unwrap();
    for i in 0..2 {
        let sd = found.covariance[(i, i)].sqrt();
        // The priors pull by less than the readings' own error.
        assert!((found.values[i] - truth[i]).abs() < 0.5 * sd, "{:?} +- {sd}", found.values);
    }
    // Three points do not prove that a fourth is like them.
    assert!(found.scatter > 0.003 && found.scatter < 0.02, "{}", found.scatter);
    assert!(found.within[0] < 1e-3 && found.within[1] > found.scatter, "{:?}", found.within);
}

/// Where flows of a table are exchanged, no share and no cooling explain the readings. They are fitted all
/// the same, and their scatter says so.
#[test]
fn behaviour_readings_that_contradict_the_flow_are_fitted() {
    let mut all = drawn(24, [0.9, 5.0], 0.0, &mut Streams::new(3).stream("exchanged"));
    for (point, h) in all.points.iter_mut().enumerate() {
        let day = ["one", "two"][point % 2];
        let exchanged = heated([40.0, 80.0][point / 2 % 2], [1.3e-3, 7e-4][point / 4 % 2], day);
        let doublings = [exchanged.mass_flow.log2() + 10.0, exchanged.rise.log2() - 5.5];
        *h = Some(Heated { varies: Varies { by: 0.4, diameter: 0.05, doublings }, ..exchanged });
    }
    let found = fit(&all.points, &all.readings, PRIORS, [0.8, 0.0]).unwrap();
    assert!(found.values.iter().all(|v| v.is_finite()) && found.scatter > 0.1, "{found:?}");
}

/// Moments by brute force: the density of readings with its dense covariance, on a grid of share, heat
/// transfer and ln tau.
#[test]
fn oracle_moments_by_sums_over_a_grid() {
    for (count, scatter, wrong) in
        [(3, 0.0, [0.0; 2]), (3, 0.03, [0.4, 0.0]), (8, 0.01, [0.0, 0.03]), (8, 0.01, [0.6, 0.0])]
    {
        let stream = &mut Streams::new(7).stream(&format!("heated/{count}/{scatter}"));
        let all = drawn(count, [0.85, 6.0], scatter, stream);
        let found = fit(&all.points, &all.readings, PRIORS, wrong).unwrap();
        let sd = [0, 1].map(|i| found.covariance[(i, i)].sqrt());
        let mut sum = [0.0; 6];
        let mut most = f64::NEG_INFINITY;
        for k in 0..40 {
            let tau = 1e-4 * (f64::from(k) * 0.2).exp();
            // Of a smooth density sums over steps of half a deviation are as good as integrals.
            for (i, j) in (0..21 * 21).map(|n| (f64::from(n / 21) - 10.0, f64::from(n % 21) - 10.0)) {
                let values = [found.values[0] + i * sd[0] / 2.0, (found.values[1] + j * sd[1] / 2.0)];
                if values[1] < 0.0 {
                    continue;
                }
                let ln = density(&all, constant(values), tau, wrong);
                if ln > most {
                    sum.iter_mut().for_each(|s| *s *= (most - ln).exp());
                    most = ln;
                }
                let d = [0, 1].map(|i| values[i] - found.values[i]);
                let moments = [1.0, d[0], d[1], d[0] * d[0], d[1] * d[1], tau * tau];
                sum.iter_mut().zip(moments).for_each(|(s, m)| *s += m * (ln - most).exp());
            }
        }
        let moments = sum.map(|s| s / sum[0]);
        let slow = [0, 1].map(|i| (moments[3 + i] - moments[1 + i].powi(2)).sqrt());
        for i in 0..2 {
            println!("{count} {scatter}: off {} sd, sd {} of {}", moments[1 + i] / sd[i], sd[i], slow[i]);
            assert!(moments[1 + i].abs() < 0.1 * sd[i]);
            assert!((sd[i] / slow[i] - 1.0).abs() < 0.1);
        }
        println!("scatter {} of {}", found.scatter, moments[5].sqrt());
        assert!((found.scatter / moments[5].sqrt() - 1.0).abs() < 0.05);
    }
}

/// ln of the density of readings times the priors, tau by its logarithm.
fn density(all: &Drawn, values: [f64; VALUES], tau: f64, [offset_sd, excess_sd]: [f64; 2]) -> f64 {
    let of = |r: &GasReading| all.points[r.point].as_ref().unwrap();
    let rises: Vec<f64> =
        all.readings.iter().map(|r| of(r).temperature(r.at, values).0 - of(r).ambient[0]).collect();
    let covariance = Matrix::from_fn(all.readings.len(), all.readings.len(), |i, j| {
        let (a, b) = (&all.readings[i], &all.readings[j]);
        let own = if i == j { a.sd.powi(2) } else { 0.0 };
        let day = if of(a).cause == of(b).cause { 0.15 * 0.15 } else { 0.0 };
        let point = if a.point == b.point { tau * tau * rises[i] * rises[j] } else { 0.0 };
        let offset = offset_sd.powi(2) * (1.0 + f64::from(u8::from(a.at == b.at)));
        own + day + point + offset + excess_sd.powi(2) * rises[i] * rises[j]
    });
    let left = |(r, rise): (&GasReading, &f64)| r.temperature - of(r).ambient[0] - rise;
    let off: Vec<f64> = all.readings.iter().zip(&rises).map(left).collect();
    let factor = Cholesky::new(&covariance).unwrap();
    let white = factor.whiten(&off);
    let misfit: f64 = white.iter().map(|w| w * w).sum::<f64>()
        + (0..VALUES).map(|i| ((values[i] - PRIORS[i][0]) / PRIORS[i][1]).powi(2)).sum::<f64>();
    let student = -2.5 * (1.0 + (tau / 0.03).powi(2) / 4.0).ln();
    -0.5 * (misfit + factor.ln_det()) + student + tau.ln()
}

/// Readings that scatter a little less or more change what is stated a little.
#[test]
fn behaviour_the_scatter_has_no_step() {
    let all = drawn(20, [0.85, 6.0], 0.0, &mut Streams::new(3).stream("heated"));
    let exact =
        |r: &GasReading| all.points[r.point].as_ref().unwrap().temperature(r.at, constant([0.85, 6.0])).0;
    let scatter = |k: f64| {
        let moved = |r: &GasReading| GasReading {
            temperature: exact(r) + k * (r.temperature - exact(r)),
            ..r.clone()
        };
        let readings: Vec<GasReading> = all.readings.iter().map(moved).collect();
        fit(&all.points, &readings, PRIORS, [0.0; 2]).unwrap().scatter
    };
    let by: Vec<f64> = (0..=40).map(|k| scatter(0.05 * f64::from(k))).collect();
    assert!(by[0] > 1e-3, "{by:?}");
    for pair in by.windows(2) {
        assert!((pair[1] / pair[0] - 1.0).abs() < 0.25, "{by:?}");
    }
}

#[test]
fn order_slopes_of_the_temperature_are_its_derivatives() {
    let varies = Varies { by: 0.4, diameter: 0.05, doublings: [0.5, -0.7] };
    let (h, at, x) = (Heated { varies, ..heated(60.0, 9e-4, "one") }, [0.8, 5.0, 0.6, -0.4, 0.9, 1.1], 0.55);
    let (_, slopes) = h.temperature(x, at);
    for i in 0..VALUES {
        let moved = |d: f64| {
            let mut v = at;
            v[i] += d;
            h.temperature(x, v).0
        };
        let central = (moved(1e-4) - moved(-1e-4)) / 2e-4;
        assert!(slopes[i].abs() > 0.1, "{slopes:?}");
        assert!((central - slopes[i]).abs() < 1e-6 * slopes[i].abs(), "{central} {}", slopes[i]);
    }
}

/// The enthalpy of the gas and its cooling by many small steps, in a gas whose heat capacity grows by a
/// third.
#[test]
fn oracle_a_flame_heats_gas_whose_heat_capacity_grows() {
    let gas = crate::rig::GasModel::Real(rijke_rig::Gas::air());
    let c_p = |t: f64| gas.at(t, 101_325.0).specific_heat;
    let (watts, mass_flow, perimeter, ambient) = (2500.0, 2e-3, 0.2, 291.0);
    let [share, h] = [0.8, 25.0];
    let capacity = mass_flow * c_p(ambient);
    let heated = Heated {
        ambient: [ambient, 0.1],
        cause: Cause::Ambient(Sharing::All),
        mass_flow,
        rise: watts / capacity,
        at: 0.2,
        cooling: perimeter / capacity,
        growth: gas.growth_of_heat_capacity(ambient),
        varies: Varies { by: 0.4, diameter: 0.05, doublings: [1.0, -0.5] },
    };
    let z = [0.9, -0.5, 0.7, 0.3];
    let steps = 200_000;
    let mut t = ambient;
    for _ in 0..steps {
        let half = t + 0.5 * share * watts / mass_flow / c_p(t) / f64::from(steps);
        t += share * watts / mass_flow / c_p(half) / f64::from(steps);
    }
    let values = [share, h, z[0], z[1], z[2], z[3]];
    let at_the_flame = heated.temperature(0.2 + 1e-12, values).0;
    assert!((at_the_flame - t).abs() < 1e-6 * t, "{at_the_flame} for {t}");
    // The rise with the c_p of the cold gas is 8 % more.
    assert!((share * heated.rise / (t - ambient) - 1.0) > 0.08, "{t}");
    let dx = 0.6 / f64::from(steps);
    // Larger for twice the flow, less for a smaller rise, and changed behind the flame.
    let h_at = |x: f64| {
        h * (0.4 * (z[2] - 0.5 * z[3])).exp()
            * (1.0 + 0.4 * (z[0] * (-x / 0.1_f64).exp() + z[1] * (-x / 0.5_f64).exp()))
    };
    let slope = |x: f64, t: f64| -h_at(x) * perimeter * (t - ambient) / (mass_flow * c_p(t));
    for k in 0..steps {
        let x = f64::from(k) * dx;
        t += dx * slope(x + 0.5 * dx, t + 0.5 * dx * slope(x, t));
    }
    let behind = heated.temperature(0.8, values).0;
    assert!((behind - t).abs() < 1e-6 * t, "{behind} for {t}");
}

/// A gauze that sits 10 um higher takes the rise of the gas along; one with more power makes it larger.
#[test]
fn exact_the_gas_follows_a_factor_that_is_not_known_exactly() {
    let source = |file: &str, text: &str| Source { file: file.into(), text: text.to_owned() };
    let campaign =
        "point,x_g [m],x_g_sd [mm],Q [W],Q_sd [W],flow [L/min],gauze,T_amb [K]\na,0.3,0.5,50,1,40,1,293\n";
    let campaign = Campaign::parse(&source("campaign.csv", campaign)).unwrap();
    let rig = "name = \"tube\"\n[upstream]\ntype = \"free\"\n[downstream]\ntype = \"free\"\n[[element]]\nname = \"tube\"\n\
               type = \"duct\"\nlength = 0.8\ndiameter = 0.05\n[[element]]\nname = \"gauze\"\ntype = \"device\"\n\
               at = \"x_g\"\npresent = \"gauze\"\n";
    let rig = Rig::parse(&source("rig.toml", rig), &campaign).unwrap();
    let [at, power, flow] = ["gauze", "Q", "flow"].map(str::to_owned);
    let plan = HeatedFlow {
        at,
        power,
        flow,
        share: PRIOR[0],
        cooling: PRIOR[1],
        cooling_varies: 0.0,
        offset_sd: None,
        excess_sd: 0.0,
    };
    let layouts = [Some(rig.at(&campaign.points[0], 293.0).unwrap())];
    let (states, _) = heated_states(&rig, &campaign, &plan, &[], &[Some([293.0, 0.1])], &layouts).unwrap();
    let state = states[0].as_ref().unwrap();
    let [(place, higher), (power, hotter)] = &state.moved[..] else { panic!("{:?}", state.moved) };
    assert_eq!(
        (campaign.factors[*place].name.as_str(), campaign.factors[*power].name.as_str()),
        ("x_g", "Q")
    );
    let rise = |state: &PointState, x: f64| state.temperatures(x)[1] - 293.0;
    for x in [0.31, 0.5, 0.79] {
        // As the gas 10 um upstream, and 50.02 W for 50.
        assert!((rise(higher, x) - rise(state, x - 1e-5)).abs() < 1e-6 * rise(state, x), "{x}");
        assert!((rise(hotter, x) / rise(state, x) - 1.0004).abs() < 1e-9, "{x}");
    }
    assert_eq!((rise(higher, 0.300_005), higher.errors.len()), (0.0, state.errors.len()));
    // With a thermometer the power matters to the laws alone.
    let reading = GasReading { point: 0, at: 0.5, temperature: 340.0, sd: 0.5 };
    let (states, _) =
        heated_states(&rig, &campaign, &plan, &[reading], &[Some([293.0, 0.1])], &layouts).unwrap();
    let read = states[0].as_ref().unwrap();
    assert_eq!(read.moved[1].1, PointState { moved: Vec::new(), ..read.clone() });
    assert!(read.moved[0].1.places[1] != read.places[1]);
    assert!(rise(state, 0.300_005) > 40.0);
}

/// A point without readings: at the factors of one that was read, cold, or of heat that nobody measured.
#[test]
fn exact_gas_that_was_not_read_is_ambient_only_where_nothing_heats() {
    let source = |file: &str, text: &str| Source { file: file.into(), text: text.to_owned() };
    let campaign = "point,x_g [m],Q1 [W],Q2 [W],flow [L/min],T_amb [K]\na,0.3,60,0,40,293\nb,0.3,0,30,40,293\n\
                    again,0.3,60,0,40,293\nwarmer,0.3,60,0,40,299\ncold,0.3,0,0,40,293\nboth,0.3,60,45,40,293\n\
                    more,0.3,90,0,40,293\n";
    let campaign = Campaign::parse(&source("campaign.csv", campaign)).unwrap();
    let rig = "name = \"tube\"\n[upstream]\ntype = \"free\"\n[downstream]\ntype = \"free\"\n[[element]]\nname = \"tube\"\n\
               type = \"duct\"\nlength = 0.8\ndiameter = 0.05\n";
    let rig = Rig::parse(&source("rig.toml", rig), &campaign).unwrap();
    let plan = MeasuredGas { flow: Some("flow".into()), offset_sd: 0.0 };
    let readings: Vec<GasReading> = [(0, 0.1, 293.2), (0, 0.6, 360.0), (1, 0.1, 293.0), (1, 0.6, 320.0)]
        .map(|(point, at, temperature)| GasReading { point, at, temperature, sd: 0.5 })
        .to_vec();
    let ambient: Vec<_> = campaign.points.iter().map(|p| p.ambient).collect();
    let layouts: Vec<_> = campaign.points.iter().map(|p| rig.at(p, 293.0).ok()).collect();
    let states = measured_states(&rig, &campaign, &plan, &readings, &ambient, &layouts).unwrap();
    let hottest = states.iter().map(|s| Some(s.as_ref()?.temperature.iter().copied().fold(0.0, f64::max)));
    let expected = [Some(360.0), Some(320.0), Some(360.0), None, Some(293.0), None, None];
    assert_eq!(hottest.collect::<Vec<_>>(), expected);
}
