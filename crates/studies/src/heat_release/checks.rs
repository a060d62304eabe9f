//! The statements of section 6.5, and what the evidence says of candidates beyond the paper.

use crate::competition::marginal;
use crate::{Check, ProngModel};

pub(super) fn checks(models: &[ProngModel]) -> Vec<Check> {
    let Some([one, two, three, four, five, six, seven, eight, nine]) = models.first_chunk() else {
        return Vec::new();
    };
    let ml = |m: &ProngModel| format!("{:.4}", marginal(m));
    let compare = |statement: &str, better: &ProngModel, worse: &ProngModel, why: &str| {
        let holds = marginal(better) > marginal(worse);
        Check {
            statement: statement.into(),
            holds,
            figure: format!("ln ML per datapoint {} against {}", ml(better), ml(worse)),
            explanation: (!holds).then(|| why.to_owned()),
        }
    };
    let best = |list: &[&ProngModel]| list.iter().map(|m| marginal(m)).fold(f64::NEG_INFINITY, f64::max);
    let worst = |list: &[&ProngModel]| list.iter().map(|m| marginal(m)).fold(f64::INFINITY, f64::min);
    let constant = [one, two, three, four, five, six];
    let best_constant = best(&constant);
    let all = [one, two, three, four, five, six, seven, eight, nine];
    let king = "The virtual rig's wire cools as King's law says, and its lag falls with velocity.";
    let mut list = vec![
        Check {
            statement: "Of the models with constant drag (1 to 6), model 2 has the highest marginal likelihood.".into(),
            holds: marginal(two) >= best_constant,
            figure: constant.map(ml).join(", "),
            explanation: (marginal(two) < best_constant).then(|| king.to_owned()),
        },
        compare("The extra freedom of model 3, a power law of Q_h, is not beneficial: model 3 is less probable than model 2.", two, three, king),
        compare("King's law with a constant delay (5) is less probable than Q_h with a constant delay (2).", two, five, king),
        compare("A constant delay is more probable than a constant angle: model 2 against 1.", two, one, king),
        compare("A constant delay is more probable than a constant angle: model 8 against 9.", eight, nine, king),
        compare("The extra viscous drag raises the evidence: model 7 against 2.", seven, two, king),
        compare("The extra thermal drag raises it further: model 8 against 7.", eight, seven, king),
        Check {
            statement: "Models 7, 8 and 9, whose drag drifts with power, are more probable than all models of constant drag.".into(),
            holds: worst(&[seven, eight, nine]) > best_constant,
            figure: format!("worst of the three {:.4}, best of the others {best_constant:.4}", worst(&[seven, eight, nine])),
            explanation: (worst(&[seven, eight, nine]) <= best_constant).then(|| king.to_owned()),
        },
        Check {
            statement: "Model 8 has the highest marginal likelihood.".into(),
            holds: marginal(eight) >= best(&all),
            figure: all.map(ml).join(", "),
            explanation: (marginal(eight) < best(&all)).then(|| king.to_owned()),
        },
    ];
    list.extend(drift(models, two, eight));
    list
}

/// Is the paper's drag that drifts with power really mean flow and viscosity?
fn drift(models: &[ProngModel], two: &ProngModel, eight: &ProngModel) -> Vec<Check> {
    let find = |id: &str| models.iter().find(|m| m.id == id);
    let Some(best) = models
        .iter()
        .filter(|m| m.published.is_none() && !m.id.contains("heat-release.8"))
        .max_by(|a, b| marginal(a).total_cmp(&marginal(b)))
    else {
        return Vec::new();
    };
    let mut list = vec![Check {
        statement: "Beyond the paper: mean flow, steady drag and viscosity explain the hot points better than a drag that drifts with power."
            .into(),
        holds: marginal(best) > marginal(eight),
        figure: format!(
            "{} ({}) has ln ML {:.4} per datapoint, model 8 has {:.4}, model 2 has {:.4}",
            best.id,
            best.label,
            marginal(best),
            marginal(eight),
            marginal(two)
        ),
        explanation: None,
    }];
    if let Some(both) = find("heat-release.8 + mean-flow.convection") {
        let drift = |m: &ProngModel| {
            let k3 = m.parameters.iter().find(|p| p.name == "k3");
            k3.map_or([f64::NAN; 2], |p| [p.value, p.sd])
        };
        let ([alone, sd], [with, with_sd]) = (drift(eight), drift(both));
        list.push(Check {
            statement: "Beyond the paper: with mean flow in the model, less viscous drag is left to drift with power.".into(),
            holds: with.abs() < alone.abs(),
            figure: format!(
                "k_3 = {alone:.2e} +- {sd:.1e} 1/W without, {with:.2e} +- {with_sd:.1e} 1/W with; acceleration of the heated gas alone is \
                 1/(A c_p T rho c) = 4.7e-6 1/W; evidence {:.4} against {:.4}",
                marginal(eight),
                marginal(both)
            ),
            explanation: None,
        });
    }
    list
}
