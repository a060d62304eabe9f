//! Tables of a stage: models by evidence, parameters, laws, residuals.

use super::head::StudyHead;
use super::numbers::{chance, three_digits, with_uncertainty};
use rijke_draw::html;
use rijke_engine::run::{CarriedOn, ModelRecord, StageRecord, TrainedParameter};
use rijke_numerics::words::capitalised;
use std::collections::BTreeMap;

/// The model that goes on.
pub(super) fn chosen(stage: &StageRecord) -> Option<&ModelRecord> {
    stage.models.iter().find(|m| m.id == stage.chosen)
}

/// ln of its evidence, nats.
pub(super) fn total(model: &ModelRecord) -> Option<f64> {
    model.evidence.map(|e| e.ln_marginal)
}

/// The models, best first.
pub(super) fn ranking(stage: &StageRecord, published: Option<&BTreeMap<String, [f64; 3]>>) -> String {
    let models = stage.by_evidence();
    // Nothing competes; what speaks against the only model is said all the same.
    if let [] | [_] = models[..] {
        let said = |line: &str| format!("<p class=\"warn\">{}.</p>\n", html(&capitalised(line)));
        return models.iter().flat_map(|only| only.remarks().map(said)).collect();
    }
    // Where pressures were heard.
    let shapes = models.iter().any(|m| m.misfit[2] > 0.0);
    let (columns, heard) = if shapes { (8, "<th>misfit of relative pressures</th>") } else { (7, "") };
    let probabilities = stage.probabilities();
    let best = models.first().and_then(|m| total(m)).unwrap_or(0.0);
    let of_all = stage.remarks_of_all();
    let row = |m: &&ModelRecord| {
        let class = if m.id == stage.chosen { " class=\"chosen\"" } else { "" };
        let own = m.remarks().filter(|line| !of_all.contains(line));
        let remark: String = own.map(|line| format!("<br><small>{}</small>", html(line))).collect();
        let name = format!("<td>{}{remark}</td><td><code>{}</code></td>", html(&m.label), html(&m.id));
        let printed = published.map_or(String::new(), |rows| match rows.get(&m.id) {
            Some([.., ml]) => format!(
                "<td class=\"n\">{:.4}</td><td class=\"n\">{ml:.4}</td>",
                m.evidence.map_or(f64::NAN, |e| e.per_observation()[2])
            ),
            None => "<td></td><td></td>".to_owned(),
        });
        let place = stage.models.iter().position(|other| other.id == m.id);
        let probability = place.and_then(|k| probabilities.get(k)).map_or(String::new(), |p| chance(*p));
        match m.evidence {
            Some(e) => format!(
                "<tr{class}>{name}<td class=\"n\">{}</td><td class=\"n\">{probability}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td>\
                 <td class=\"n\">{}</td><td class=\"n\">{}</td>{}{printed}</tr>\n",
                tenth(best - e.ln_marginal),
                e.ln_best_fit,
                e.ln_occam,
                e.ln_marginal,
                three_digits(m.misfit[0]),
                three_digits(rijke_study::hertz(m.misfit[1])),
                if shapes {
                    format!("<td class=\"n\">{}</td>", three_digits(m.misfit[2]))
                } else {
                    String::new()
                }
            ),
            None => format!(
                "<tr class=\"failed\">{name}<td colspan=\"{columns}\">no evidence</td>{printed}</tr>\n"
            ),
        }
    };
    let behind = |m: &ModelRecord| total(m).map_or(f64::INFINITY, |all| best - all);
    let is_shown = |(k, m): (usize, &&ModelRecord)| {
        let stated = published.is_some_and(|rows| rows.contains_key(&m.id));
        k < FEW || behind(m) < FAR || m.id == stage.chosen || stated
    };
    let (mut shown, mut folded) = (Vec::new(), Vec::new());
    for (k, m) in models.iter().enumerate() {
        if is_shown((k, m)) { shown.push(*m) } else { folded.push(*m) }
    }
    // A few more are no burden.
    if folded.len() < FEW / 2 {
        shown.append(&mut folded);
    }
    let printed = if published.is_some() { "<th>per point</th><th>published</th>" } else { "" };
    let table = |models: &[&ModelRecord]| {
        let rows: String = models.iter().map(row).collect();
        format!(
            "<div class=\"wide\"><table><thead><tr><th>model</th><th>name in files</th><th>nats behind</th><th>probability</th><th>ln best fit</th><th>ln Occam</th>\
         <th>ln evidence</th><th>misfit of growth rate, 1/s</th><th>misfit of frequency, Hz</th>{heard}{printed}</tr></thead><tbody>\n{rows}</tbody></table></div>\n"
        )
    };
    let rest = if folded.is_empty() {
        String::new()
    } else {
        let count = folded.len();
        let nearest = folded.iter().map(|m| behind(m)).fold(f64::INFINITY, f64::min);
        let said = if nearest.is_finite() {
            format!("at least {nearest:.1} nats behind")
        } else {
            "without evidence".into()
        };
        format!("<details><summary>{count} further models, {said}</summary>{}</details>\n", table(&folded))
    };
    let said: String = of_all.iter().map(|line| format!("<p>Of all these: {}.</p>\n", html(line))).collect();
    table(&shown) + &said + &rest
}

/// Models of a table that are always shown.
const FEW: usize = 8;
/// Nats behind the best above which a model may be folded away.
const FAR: f64 = 6.0;

/// With one decimal; what rounds to zero has no sign.
fn tenth(value: f64) -> String {
    let text = format!("{value:.1}");
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// What later stages make of the models that a stage leaves open.
pub(super) fn carried_on(stage: &StageRecord) -> String {
    let label = |id: &str| stage.models.iter().find(|m| m.id == id).map_or(id, |m| &m.label).to_owned();
    let all = stage.carried_below_best();
    if all.iter().filter(|(_, nats)| nats.is_some()).count() < 2 {
        return String::new();
    }
    let row = |(c, nats): &(&CarriedOn, Option<f64>)| {
        let class = if c.id == stage.chosen { " class=\"chosen\"" } else { "" };
        let behind = nats.map_or("cannot be fitted".to_owned(), |nats| tenth(-nats));
        let later: Vec<String> = c.later.iter().map(|l| format!("<code>{}</code>", html(&l.model))).collect();
        format!(
            "<tr{class}><td>{}</td><td><code>{}</code></td><td class=\"n\">{behind}</td><td>{}</td></tr>\n",
            html(&label(&c.id)),
            html(&c.id),
            later.join(", ")
        )
    };
    let rows: String = all.iter().map(row).collect();
    format!(
        "<p>These points leave some models open. The later stages were trained with each of them, and the evidence of all these stages says which \
         goes on.</p>\n<div class=\"wide\"><table><thead><tr><th>model</th><th>name in files</th><th>nats behind, with later stages</th>\
         <th>best models of later stages</th></tr></thead><tbody>\n{rows}</tbody></table></div>\n{}",
        stage.not_carried().map_or_else(String::new, |said| format!("<p>{}.</p>\n", html(&said)))
    )
}

/// The parameters of the chosen model.
pub(super) fn parameters(model: &ModelRecord) -> String {
    parameter_table(&model.parameters)
}

/// A row per parameter.
pub(super) fn parameter_table(parameters: &[TrainedParameter]) -> String {
    if parameters.is_empty() {
        return String::new();
    }
    let averaged = parameters.iter().any(|p| p.averaged.is_some());
    let row = |p: &TrainedParameter| {
        let over = p.averaged.map_or(String::new(), |[value, sd]| with_uncertainty(value, sd));
        let over = if averaged { format!("<td class=\"n\">{over}</td>") } else { String::new() };
        let unit = if p.unit == "1" { "" } else { &p.unit };
        let small = |words: String| match words.trim() {
            "" => String::new(),
            words => format!("<br><small>{}</small>", html(words)),
        };
        let (tied, interval) = (small(p.tied_words()), small(p.interval_words()));
        let prior =
            p.prior_sds.map_or(String::new(), |z| format!("{:+.1}", if z.abs() < 0.05 { 0.0 } else { z }));
        format!(
            "<tr><td>{}</td><td><code>{}</code>{tied}</td><td class=\"n\">{}{interval}</td>{over}<td>{}</td><td class=\"n\">{prior}</td></tr>\n",
            html(&p.symbol),
            html(&p.name),
            with_uncertainty(p.value, p.sd),
            html(unit)
        )
    };
    let rows: String = parameters.iter().map(row).collect();
    let over = if averaged { "<th>averaged over the models that earlier stages leave open</th>" } else { "" };
    format!(
        "<div class=\"wide\"><table><thead><tr><th>parameter</th><th>name in files</th><th>value</th>{over}<th>unit</th><th>from its prior, in prior \
         sd</th></tr></thead><tbody>\n{rows}</tbody></table></div>\n"
    )
}

/// Sentences on parameters that contradict what was known before, and on those of which nothing was learnt.
pub(super) fn conflicts(model: &ModelRecord) -> Vec<String> {
    let before: Vec<String> =
        model.parameters.iter().filter(|p| p.is_as_before()).map(|p| html(&p.symbol)).collect();
    let nothing = (!before.is_empty())
        .then(|| format!("Not identified by these data, as their priors: {}.", before.join(", ")));
    let far = model.parameters.iter().filter_map(|p| Some((p, p.conflict()?)));
    far.map(|(p, z)| {
        format!(
            "{} lies {z:.1} standard deviations of its prior from what was known before: prior and data contradict each other, or the model is \
             wrong.",
            html(&p.symbol)
        )
    })
    .chain(nothing)
    .collect()
}

/// A formula in print.
pub(super) fn formula(law: &str) -> String {
    html(&law.replace('*', " \u{b7} "))
}

/// The formulas of the chosen model.
pub(super) fn laws(model: &ModelRecord) -> String {
    let row = |(place, law): &(String, String)| {
        format!("<tr><td>{}</td><td><code>{}</code></td></tr>\n", html(place), formula(law))
    };
    let rows: String = model.laws.iter().map(row).collect();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "<details><summary>Laws of this model</summary><div class=\"wide\"><table><tbody>\n{rows}</tbody></table></div></details>\n"
    )
}

/// Measured and predicted, point by point.
pub(super) fn residuals(head: &StudyHead, stage: &StageRecord) -> String {
    let all = |m: &&ModelRecord| !stage.measured.is_empty() && m.predicted.len() == stage.measured.len();
    let Some(model) = chosen(stage).filter(all) else {
        return String::new();
    };
    // A factor that is the same at all points is none here.
    let first = |k: usize| stage.measured.first().and_then(|m| m.factors.get(k));
    let varies = |k: &usize| stage.measured.iter().any(|m| m.factors.get(*k) != first(*k));
    let varying: Vec<usize> = (0..head.factors.len()).filter(varies).collect();
    let heading = |&k: &usize| {
        let (name, unit) = (&head.factors[k].name, head.factors[k].shown.text());
        match unit {
            "1" => format!("<th>{}</th>", html(name)),
            unit => format!("<th>{} / {}</th>", html(name), html(unit)),
        }
    };
    let factors: String = varying.iter().map(heading).collect();
    let number = |pair: Option<[f64; 2]>, predicted: f64| match pair {
        Some([value, sd]) => {
            // With the digits of what was measured.
            let places = if sd > 0.0 { (1.0 - sd.log10().floor()).clamp(0.0, 9.0) as usize } else { 3 };
            let predicted = format!("{predicted:.places$}");
            format!("<td class=\"n\">{}</td><td class=\"n\">{predicted}</td>", with_uncertainty(value, sd))
        }
        None => format!("<td></td><td class=\"n\">{predicted:.3}</td>"),
    };
    let with = if model.fitted.is_empty() { "" } else { ", with the errors that points share as estimated" };
    let rows: String = stage
        .measured
        .iter()
        .zip(model.shown())
        .map(|(m, p)| {
            let value = |k: &usize| {
                let shown = m.factors.get(*k).copied().flatten().map(|v| head.factors[*k].shown_of(v));
                shown.map_or(String::new(), |v| format!("{v:.4}"))
            };
            let factors: String =
                varying.iter().map(|k| format!("<td class=\"n\">{}</td>", value(k))).collect();
            format!(
                "<tr><td>{} {}</td>{factors}{}{}</tr>\n",
                html(&m.point),
                html(&m.mode),
                number(m.growth_rate, p[0]),
                number(m.angular_frequency, p[1])
            )
        })
        .collect();
    format!(
        "<details><summary>Measured and predicted, point by point{with}</summary><div class=\"wide\"><table><thead><tr><th>point</th>{factors}<th>growth \
         rate, 1/s</th><th>predicted</th><th>angular frequency, rad/s</th><th>predicted</th></tr></thead><tbody>\n{rows}</tbody></table></div></details>\n"
    )
}
