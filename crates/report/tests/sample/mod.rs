//! Hand-made numbers in the shape of the studies' records; only their shape means anything.

mod hot;

use rijke_report::Numbers;
use rijke_studies::*;

pub(crate) fn numbers() -> Numbers {
    let mut numbers = Numbers {
        campaign: Some(campaign()),
        empty_tube: Some(empty_tube()),
        prongs: Some(prongs()),
        heater: None,
        microphones: Some(microphones()),
        consistency: Some(consistency()),
        lumped_convergence: Some(lumped()),
        ..Numbers::default()
    };
    hot::fill(&mut numbers);
    numbers
}

fn campaign() -> CampaignRead {
    let point = |id: &str, position_m, published| PointRead {
        id: id.into(),
        position_m,
        recorded: 40,
        published,
        pings: 39,
        clicks: 40,
        growth_rate: Some(-9.8),
        angular_frequency: Some(1061.0),
    };
    let row = CampaignRow {
        id: "C3".into(),
        heater: false,
        thermocouples: false,
        power_w: 0.0,
        points: vec![point("C3-E", None, Some(40)), point("C3-03", Some(0.03), None)],
    };
    CampaignRead {
        provenance: provenance(),
        clicks: 80,
        rows: vec![row],
        checks: vec![check("All is there.", false)],
    }
}

fn provenance() -> Provenance {
    let rejected =
        vec![RejectedRecord { record: "C3-35/ping-07".into(), reason: "clipped: 31 samples".into() }];
    let (rig, source) = ("Hand-made rig".into(), "hand-made".into());
    Provenance { data: DataKind::Virtual, rig, source, points: 20, pings: 797, rejected }
}

fn check(statement: &str, holds: bool) -> Check {
    let explanation = (!holds).then(|| "These numbers were made by hand.".to_owned());
    Check { statement: statement.into(), holds, figure: "0.998 in absolute value".into(), explanation }
}

fn empty_tube() -> EmptyTube {
    let names = [("abs_R", "|*R*|"), ("arg_R", "\u{2220}*R*"), ("eta", "*\u{3b7}*")];
    let parameters = names.map(|(name, symbol)| ParameterName {
        name: name.into(),
        symbol: symbol.into(),
        unit: if name == "arg_R" { "rad" } else { "1" }.into(),
    });
    let case = |microphones: Vec<usize>, mean: [f64; 3], sd: [f64; 3], rho: [f64; 3]| {
        let r = vec![vec![1.0, rho[0], rho[1]], vec![rho[0], 1.0, rho[2]], vec![rho[1], rho[2], 1.0]];
        let covariance = (0..3).map(|i| (0..3).map(|j| r[i][j] * sd[i] * sd[j]).collect()).collect();
        Case { microphones, mean: mean.to_vec(), covariance, correlation: r }
    };
    EmptyTube {
        provenance: provenance(),
        point: "C3-E".into(),
        parameters: parameters.to_vec(),
        cases: vec![
            case(vec![5], [0.9953, 3.0597, 1.02], [0.0016, 0.0006, 0.11], [0.3, 0.996, 0.31]),
            case((0..8).collect(), [0.99521, 3.05902, 1.004], [3.0e-5, 4.0e-5, 0.0031], [0.1, 0.62, -0.2]),
        ],
        predicted: vec![0.9952, 3.0584, 1.0],
        prior: vec![[1.0, 0.02], [3.1, 0.1], [1.0, 0.5]],
        truth: Some(vec![0.99523, 3.05899, 1.0]),
        checks: vec![check("With one microphone |R| and \u{3b7} are correlated above 0.95.", true)],
    }
}

fn prongs() -> Prongs {
    let labels = [
        "real drag, one factor",
        "complex drag, one factor",
        "two real drags",
        "two complex drags",
        "blockage only",
        "real drag and blockage",
        "two real drags and blockage",
    ];
    let at = |model: usize, x: f64| {
        let wave = (std::f64::consts::PI * x).sin();
        CurvePoint {
            position_m: x,
            growth_rate: -10.0 - if model == 4 { 0.0 } else { 2.6 * x + 0.4 * wave }
                + 0.02 * model as f64 * wave,
            angular_frequency: 1061.0
                - if model < 3 { 3.0 } else { 8.0 + 0.1 * model as f64 } * (2.0 * x * wave + x),
        }
    };
    let positions: Vec<f64> = (0..20).map(|i| 0.05 * f64::from(i)).collect();
    let measured = positions.iter().map(|&x| {
        let p = at(5, x);
        MeasuredPoint {
            id: format!("C3-{:02}", (100.0 * x).round()),
            position_m: x,
            growth_rate: p.growth_rate + 0.05 * (40.0 * x).sin(),
            growth_rate_sd: 0.02,
            angular_frequency: p.angular_frequency + 0.2 * (53.0 * x).cos(),
            angular_frequency_sd: 0.02,
            ambient_temperature: 293.0,
        }
    });
    let parameter = |k: usize| ParameterValue {
        name: format!("k{k}"),
        symbol: format!("*k*_{{{k}}}"),
        unit: "1".into(),
        value: 1.2 / k as f64,
        sd: 0.03,
    };
    let evidence = |bfl: f64, of: f64| Evidence { ln_best_fit: bfl, ln_occam: of, ln_marginal: bfl + of };
    let models = labels.iter().enumerate().map(|(i, label)| ProngModel {
        id: format!("prongs.{}", i + 1),
        number: Some(i as u32 + 1),
        label: (*label).into(),
        laws: vec![("wall".into(), "1 + alpha * P_p / P_t".into())],
        parameters: (1..=[1, 2, 2, 4, 1, 2, 3][i]).map(parameter).collect(),
        growth_rate_noise_sd: if i == 4 { 0.9 } else { 0.08 + 0.01 * i as f64 },
        angular_frequency_noise_sd: if i < 3 { 3.1 } else { 0.5 },
        pressure_noise_sd: 0.001,
        at_points: positions.iter().map(|&x| at(i, x)).collect(),
        line: (0..=100).map(|n| at(i, 0.0095 * f64::from(n))).collect(),
        evidence: (i != 3).then(|| evidence(0.5 - 0.3 * (i as f64 - 5.0).abs(), -0.2 * (i + 1) as f64)),
        remark: None,
        published: Some(evidence(0.6705, -0.5767)),
    });
    Prongs {
        provenance: provenance(),
        measured: measured.collect(),
        models: models.collect(),
        winner: "prongs.6".into(),
        published_winner: "prongs.6".into(),
        kendall_tau: 0.81,
        checks: vec![
            check("Models without blockage miss the frequency.", true),
            check("A false statement.", false),
        ],
    }
}

fn consistency() -> Consistency {
    let row = |radius: f64, angle: f64, published: f64| ConsistencyRow {
        scheme: "exact line".into(),
        reflection: [radius, angle],
        eigenvalue: [-9.9, 1056.0],
        eta: published + 0.01,
        eta_range: [published, published + 0.02],
        published,
    };
    Consistency {
        temperature: 293.15,
        rows: vec![row(0.9953, 3.0597, 1.1235), row(0.9952, 3.0641, 1.1198)],
        checks: vec![],
    }
}

fn lumped() -> LumpedConvergence {
    let row = |elements: usize| LumpedRow {
        elements,
        eigenvalue: [-9.9, 1056.0],
        growth_rate_error: -1.16 / elements as f64,
        angular_frequency_error: 0.01 / elements as f64,
        order: (elements > 10).then_some(1.0),
    };
    LumpedConvergence { exact: [-9.9, 1056.0], rows: [10, 20, 40].map(row).to_vec(), checks: vec![] }
}

fn microphones() -> Microphones {
    let tube = empty_tube();
    Microphones {
        provenance: tube.provenance,
        point: tube.point,
        parameters: tube.parameters,
        positions_m: (0..8).map(|m| 0.25 + 0.1 * f64::from(m)).collect(),
        sets: tube.cases,
        pressure_noise_sd: 0.001,
        predicted: tube.predicted,
        truth: tube.truth,
        checks: vec![],
    }
}
