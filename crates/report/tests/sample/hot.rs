//! Hand-made numbers in the shape of the records of the hot campaign; only their shape means anything.

use super::{check, provenance};
use rijke_report::{BaseFlow, FlowAt, FlowAtPower, FlowRun, FlowUnknown, Numbers};
use rijke_studies::*;

pub(super) fn fill(numbers: &mut Numbers) {
    numbers.flow = Some(flow());
    numbers.cold = Some(cold());
    numbers.feedback = Some(feedback(0.0));
    numbers.feedback_naive = Some(feedback(0.6));
    numbers.heat_release = Some(heat_release());
    numbers.predictions = [8, 9, 10, 11].map(|figure| Some(predictions(figure)));
    numbers.truths = Some(truths());
}

const POWERS: [f64; 7] = [7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0];

fn parameter(name: &str, symbol: &str, value: f64, sd: f64) -> ParameterValue {
    ParameterValue { name: name.into(), symbol: symbol.into(), unit: "1".into(), value, sd }
}

fn measured(row: &str, x: f64, growth_rate: f64, angular_frequency: f64) -> MeasuredPoint {
    MeasuredPoint {
        id: format!("{row}-{:02}", (100.0 * x).round()),
        position_m: x,
        growth_rate,
        growth_rate_sd: 0.02,
        angular_frequency,
        angular_frequency_sd: 0.02,
        ambient_temperature: 293.0,
    }
}

fn predicted(growth_rate: f64, angular_frequency: f64) -> PredictedPoint {
    PredictedPoint { growth_rate, growth_rate_sd: 0.1, angular_frequency, angular_frequency_sd: 0.4 }
}

fn cold() -> Cold {
    let rows = [("C1", 0.0), ("C2", 0.3), ("C3", 3.0), ("H0", -2.0)];
    let series = rows.map(|(row, shift)| {
        let at = |i: u32| {
            let x = 0.05 * f64::from(i);
            [x, -14.0 + shift + 2.0 * (6.0 * x).cos(), 1058.0 - 6.0 * (3.0 * x).sin()]
        };
        ColdSeries {
            row: row.into(),
            label: "what is in the tube".into(),
            measured: (1..20)
                .map(at)
                .map(|[x, s, w]| measured(row, x, s + 0.03 * (50.0 * x).sin(), w))
                .collect(),
            predicted: (1..20).map(at).map(|[_, s, w]| predicted(s, w)).collect(),
        }
    });
    Cold {
        provenance: provenance(),
        candidates: vec!["wall.rayleigh".into(), "prongs.6".into()],
        parameters: vec![parameter("eta", "*\u{3b7}*", 1.02, 0.01)],
        series: series.to_vec(),
        checks: vec![check("The model fits the cold experiments.", true)],
    }
}

/// Points by power and position, and where each lies between the two ends.
fn places() -> impl Iterator<Item = (f64, f64)> {
    POWERS.into_iter().flat_map(|power| (3..18).map(move |i| (power, 0.05 * f64::from(i))))
}

fn feedback(jump: f64) -> Feedback {
    let point = |(power_w, x): (f64, f64)| {
        let weak = 1.0 / (0.05 + (std::f64::consts::TAU * x).sin().abs()) / power_w.sqrt();
        let lag = 0.5 + if x < 0.5 { jump } else { -jump } + 0.02 * (40.0 * x).sin();
        let modulus = 4e-4 * power_w;
        FeedbackPoint {
            id: format!("H{power_w}-{:02}", (100.0 * x).round()),
            position_m: x,
            power_w,
            heater_velocity: 0.3,
            k_eu: [-modulus * lag.cos(), modulus * lag.sin()],
            covariance: [[1e-8, 0.0], [0.0, 1e-8]],
            modulus_per_watt: 4e-4 * (1.0 + 0.03 * (30.0 * x).cos()),
            modulus_per_watt_sd: 2e-5 * weak,
            lag,
            lag_sd: 0.05 * weak,
        }
    };
    Feedback {
        provenance: provenance(),
        model: "prongs and heater as trained".into(),
        points: places().map(point).collect(),
        checks: vec![check("The standard deviation is largest near 0.5.", true)],
    }
}

fn hot_points() -> Vec<HotPoint> {
    let point = |(power_w, x): (f64, f64)| {
        let drive = power_w / 180.0 * (std::f64::consts::TAU * x).sin();
        let growth = -16.0 + 4.0 * drive - 3.0 * (2.0 * x - 1.0).powi(2);
        HotPoint {
            measured: measured(
                &format!("H{power_w}"),
                x,
                growth,
                1060.0 + 1.1 * power_w.powf(0.8) * (1.0 - 0.6 * x),
            ),
            power_w,
            heater_velocity: 0.3,
            heater_velocity_sd: 0.01,
        }
    };
    places().map(point).collect()
}

fn heat_release() -> HeatRelease {
    let model = |i: u32| ProngModel {
        id: format!("heat-release.{i}"),
        number: (i < 10).then_some(i),
        label: format!("model of the hot heater {i}"),
        laws: vec![],
        parameters: vec![parameter("k1", "*k*_{1}", 4.0e-4, 2.0e-6)],
        growth_rate_noise_sd: 0.3,
        angular_frequency_noise_sd: 1.0,
        pressure_noise_sd: 0.001,
        at_points: vec![],
        line: vec![],
        evidence: Some(Evidence {
            ln_best_fit: f64::from(i),
            ln_occam: -0.5,
            ln_marginal: f64::from(i) - 0.5,
        }),
        remark: None,
        published: (i < 10).then_some(Evidence { ln_best_fit: -4.0, ln_occam: -0.1, ln_marginal: -4.1 }),
    };
    HeatRelease {
        provenance: provenance(),
        measured: hot_points(),
        models: (1..12).map(model).collect(),
        winner: "heat-release.9".into(),
        published_winner: "heat-release.8".into(),
        chosen: "heat-release.11".into(),
        kendall_tau: 0.61,
        checks: vec![check("A constant delay has more evidence than a constant angle.", false)],
    }
}

fn predictions(figure: u32) -> HotPredictions {
    let measured = hot_points();
    let off = if figure == 8 { 5.0 } else { 0.1 };
    let predicted =
        measured.iter().map(|m| predicted(m.measured.growth_rate + off, m.measured.angular_frequency + off));
    let few = figure == 11;
    HotPredictions {
        provenance: provenance(),
        figure,
        candidates: vec!["wall.rayleigh".into(), "heat-release.2".into()],
        model: "the model of this figure, in words".into(),
        parameters: vec![parameter("eta", "*\u{3b7}*", 1.6, 0.02), parameter("k1", "*k*_{1}", 4e-4, 0.0)],
        growth_rate_noise_sd: 0.2 * off,
        angular_frequency_noise_sd: off,
        predicted: predicted.collect(),
        trained_on: measured
            .iter()
            .step_by(if few { 13 } else { 1 })
            .map(|m| m.measured.id.clone())
            .collect(),
        measured,
        coverage: [0.95, 0.96],
        coverage_elsewhere: few.then_some([0.94, 0.97]),
        checks: vec![],
    }
}

fn truths() -> Truths {
    let row = TruthRow { quantity: "\u{3b7}".into(), value: 1.01, sd: 0.02, truth: 1.0 };
    Truths { rows: vec![row], checks: vec![check("\u{3b7} lies within three sd.", true)] }
}

fn flow() -> BaseFlow {
    let run = |i: u32| {
        let heater_m = 0.05 * f64::from(i);
        let at = |power_w: f64| FlowAtPower {
            power_w,
            heater_velocity: 0.1 * power_w.powf(0.33) * (1.2 - heater_m),
            heater_velocity_sd: 0.02 + 0.05 * heater_m,
            profile: (0..=20)
                .map(|k| {
                    let x = 0.05 * f64::from(k);
                    let rise = if x < heater_m {
                        0.0
                    } else {
                        power_w * (0.4 + 0.3 * heater_m) * (heater_m - x).exp()
                    };
                    FlowAt {
                        x,
                        temperature: 293.0 + 1.8 * rise,
                        sound_speed: 343.0 + rise,
                        sound_speed_sd: 1.0 + x,
                    }
                })
                .collect(),
        };
        let unknown = |k: u32| FlowUnknown {
            name: format!("parameter_{k}"),
            unit: "1".into(),
            value: f64::from(k),
            low: f64::from(k) - 0.2,
            high: f64::from(k) + 0.2,
            shrinkage: 0.1 * f64::from(k),
        };
        FlowRun {
            heater_m,
            unknowns: (1..=8).map(unknown).collect(),
            powers: [0.0].into_iter().chain(POWERS).map(at).collect(),
        }
    };
    BaseFlow { kind: DataKind::Virtual, rig: "Hand-made rig".into(), runs: (3..18).map(run).collect() }
}
