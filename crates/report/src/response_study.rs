//! The page of a study of responses: tables of models, and what was measured beside what they answer.

use crate::StudyHead;
use crate::study::{STYLE, numbers::with_uncertainty};
use rijke_draw::{Axis, COLUMN, Figure, INK, Key, Mark, Panel, Stroke, html, model_stroke};
use rijke_engine::response::{ResponseModelRecord, ResponseStageRecord};
use rijke_engine::run::TrainedParameter;
use rijke_numerics::Failed;
use rijke_rig::DataKind;

const SIZE: [f64; 2] = [COLUMN, 230.0];
/// More responses than this make figures that nobody reads.
const MOST: usize = 6;

/// The files of the page: path within the folder of results, and content; the page comes last. `doubts` are
/// remarks on the data.
///
/// # Errors
/// If no stage was run.
pub(crate) fn response_page(
    head: &StudyHead,
    doubts: &[String],
    stages: &[ResponseStageRecord],
) -> Result<Vec<(String, Vec<u8>)>, Failed> {
    if stages.is_empty() {
        return Err(Failed::of_work("no numbers of any stage"));
    }
    let (mut files, mut body) = (Vec::new(), String::new());
    for stage in stages {
        body += &format!("<h2 id=\"{}\">{}</h2>\n", stage.id, html(&stage.title));
        body += &ranking(stage);
        let Some(winner) = stage.models.iter().find(|m| m.id == stage.winner) else { continue };
        body += &numbers(winner);
        let figure = figure(head, stage, winner);
        body += &format!(
            "<figure>{}<figcaption>{}</figcaption></figure>\n",
            figure.html(),
            html(&figure.caption)
        );
        let svg = figure.svg();
        files.push((format!("figures/{}.pdf", stage.id), rijke_draw::pdf(&svg)?));
        files.push((format!("figures/{}.svg", stage.id), svg.into_bytes()));
    }
    let data = match head.kind {
        DataKind::Measured => "Measured data",
        DataKind::Virtual => "Virtual data: no instrument recorded them",
    };
    let answers: String = answers(stages).iter().map(|a| format!("<p class=\"answer\">{a}</p>\n")).collect();
    let doubts: String = doubts.iter().map(|d| format!("<p class=\"warn\">{}</p>\n", html(d))).collect();
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\"><title>{name}</title><style>{STYLE}</style></head><body>\n<main>\n<h1>{name}</h1>\n<p>{question}</p>\n{answers}\
         <p class=\"data\">{data}. Source: {source}.</p>\n{doubts}{body}</main></body></html>\n",
        name = html(&head.name),
        question = html(&head.question),
        source = html(&head.source),
    );
    files.push(("index.html".to_owned(), page.into_bytes()));
    Ok(files)
}

/// What the competitions found, a sentence of HTML for each.
pub(crate) fn answers(stages: &[ResponseStageRecord]) -> Vec<String> {
    stages.iter().filter_map(answer).collect()
}

/// What a competition found, in a sentence; nothing for a stage of one model.
fn answer(stage: &ResponseStageRecord) -> Option<String> {
    let models = stage.by_evidence();
    let [first, second, ..] = models[..] else { return None };
    let lead = first.ln_evidence() - second.ln_evidence();
    let (title, a, b) = (html(&stage.title), html(&first.label), html(&second.label));
    Some(if lead >= stage.decides {
        let doubt =
            if first.too_sure { " Its residuals are not noise, so its lead is overstated." } else { "" };
        format!("{title}: <b>{a}</b>, {lead:.1} nats ahead of {b}.{doubt}")
    } else {
        format!(
            "{title}: not decided. <b>{a}</b> is {lead:.1} nats ahead of {b}, which is less than the {} nats that decide.",
            stage.decides
        )
    })
}

fn ranking(stage: &ResponseStageRecord) -> String {
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    let row = |m: &&ResponseModelRecord| {
        let remark = m
            .remark
            .as_deref()
            .map_or(String::new(), |r| format!("<br><small>{}</small>", html(r).replace('\n', "<br>")));
        let name = format!("<td>{}{remark}</td><td><code>{}</code></td>", html(&m.label), html(&m.id));
        match m.evidence {
            Some(e) => format!(
                "<tr{}>{name}<td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.2e}</td>\
                 <td class=\"n\">{:.2}</td></tr>\n",
                if m.id == stage.winner { " class=\"chosen\"" } else { "" },
                best - e.ln_marginal,
                e.ln_best_fit,
                e.ln_occam,
                m.residual,
                m.neighbours
            ),
            None => format!("<tr class=\"failed\">{name}<td colspan=\"5\">no evidence</td></tr>\n"),
        }
    };
    let count: usize = stage.loads.iter().map(|l| l.frequency_hz.len()).sum();
    let all: usize = stage.loads.iter().map(|l| l.of).sum();
    let rows: String = models.iter().map(row).collect();
    format!(
        "<p>Trained on {}, {count} of the {all} complex numbers in their files.</p>\n<div class=\"wide\" tabindex=\"0\"><table><thead><tr><th>model</th><th>name in \
         files</th><th>nats behind</th><th>ln best fit</th><th>ln Occam</th><th>residual, rms</th><th>correlation of \
         neighbours</th></tr></thead><tbody>\n{rows}</tbody></table></div>\n",
        match stage.loads.len() {
            1 => "one response".to_owned(),
            n => format!("{n} responses"),
        }
    )
}

/// Parameters and noise of a model.
fn numbers(model: &ResponseModelRecord) -> String {
    let cells = |name: &str, value: String, unit: &str| {
        let unit = if unit == "1" { "" } else { unit };
        format!("<tr><td>{}</td><td class=\"n\">{value}</td><td>{}</td></tr>\n", html(name), html(unit))
    };
    let of = |list: &[TrainedParameter]| -> String {
        list.iter().map(|p| cells(&p.name, with_uncertainty(p.value, p.sd), &p.unit)).collect()
    };
    let noise =
        model.noise.iter().filter(|n| n.floats).map(|n| cells(&n.name, format!("{:.3e}", n.sd), &n.unit));
    let (own, errors, channels) = model.by_kind();
    let table = |what: &str, rows: String| {
        format!(
            "<div class=\"wide\" tabindex=\"0\"><table><thead><tr><th>{what}</th><th>value</th><th>unit</th></tr></thead><tbody>\n\
             {rows}</tbody></table></div>\n"
        )
    };
    let mut all = table("parameter, or size of an error", of(own) + &noise.collect::<String>());
    for (summary, what, list) in [
        ("Errors of factors and temperatures, in their stated standard deviations", "error", errors),
        ("Delays and gains of the channels", "channel", channels),
    ] {
        if !list.is_empty() {
            let table = table(what, of(list));
            all += &format!("<details><summary>{summary}</summary>{table}</details>\n");
        }
    }
    all
}

/// Modulus measured and modelled, and what is left.
fn figure(head: &StudyHead, stage: &ResponseStageRecord, model: &ResponseModelRecord) -> Figure {
    let mut panels = Vec::new();
    let norm = |z: &[f64; 2]| z[0].hypot(z[1]);
    for (k, load) in stage.loads.iter().enumerate().take(MOST) {
        let x = || Axis::covering("frequency / Hz", load.frequency_hz.iter().copied());
        let curve = |values: &[[f64; 2]]| -> Vec<[f64; 2]> {
            load.frequency_hz.iter().zip(values).map(|(f, z)| [*f, norm(z)]).collect()
        };
        let (rig, heard) = (curve(&model.predicted[k]), curve(&model.heard[k]));
        let measured = curve(&load.measured);
        let all = measured.iter().chain(&rig).map(|p| p[1]);
        let label = format!("|{}|", load.what);
        let mut panel = Panel::new(&load.point, SIZE, x(), Axis::covering(&label, all));
        for point in &measured {
            panel.dot(*point, 1.8, INK, &format!("{} Hz", point[0]));
        }
        panel.curve(&rig, &model_stroke(0));
        panel.curve(&heard, &model_stroke(1));
        panels.push(panel);
        let left = |part: usize| -> Vec<[f64; 2]> {
            let pairs = load.measured.iter().zip(&model.heard[k]);
            load.frequency_hz.iter().zip(pairs).map(|(f, (m, h))| [*f, m[part] - h[part]]).collect()
        };
        let parts = [left(0), left(1)];
        let mut panel = Panel::new(
            "",
            SIZE,
            x(),
            Axis::covering("measured less heard", parts.iter().flatten().map(|p| p[1])),
        );
        panel.horizontal(0.0, &Stroke::solid("#bbb", 1.0));
        for (index, part) in parts.iter().enumerate() {
            panel.curve(part, &model_stroke(2 + index));
        }
        panels.push(panel);
    }
    let line = |k: usize, label: &str| Key { mark: Mark::Line(model_stroke(k)), label: label.to_owned() };
    Figure {
        title: stage.title.clone(),
        caption: "Left: what was measured, what the rig does, and what the instrument makes of it. Right: what is left.".to_owned(),
        columns: 2,
        panels,
        legend: vec![
            Key { mark: Mark::Dot(INK), label: "measured".to_owned() },
            line(0, "the rig's model"),
            line(1, "heard through the instrument"),
            line(2, "left, real part"),
            line(3, "left, imaginary part"),
        ],
        data: Some(head.kind),
    }
}
