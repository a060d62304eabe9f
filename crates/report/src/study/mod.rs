//! The page of a study: any rig, any stages, any questions. Draws the records of the engine and computes no
//! physics of its own.
//!
//! Knows the records of the engine, and neither models nor files of a study.

mod asked;
mod checks;
mod claims;
mod figure;
mod first;
mod groups;
mod head;
mod map;
pub(crate) mod numbers;
mod series;
mod sliders;
mod tables;

use rijke_draw::html;
use rijke_engine::run::{
    Answer, Frame, Judgement, Missing, ModelRecord, Sliders, StageRecord, gains_along, left_out_table,
    models, residuals_over_factors,
};
use rijke_numerics::words::capitalised;
use rijke_numerics::{Classify, Failed};
use rijke_rig::{DataKind, files::csv_table};
use std::{fs, path::Path};
use tables::{chosen, total};

pub use head::StudyHead;

/// The files of the page of a study, in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyPage {
    files: Vec<(String, Vec<u8>)>,
}

pub(crate) const STYLE: &str = include_str!("page.css");

/// Shows what is known of a point under the pointer, and marks it in every figure.
const SCRIPT: &str = include_str!("page.js");

/// The figure of an answer as the text of an SVG file; none where there is nothing to draw.
#[must_use]
pub fn answer_svg(kind: Option<DataKind>, answer: &Answer) -> Option<String> {
    figure::of(kind, answer, &figure::PAPER).map(|figure| figure.svg())
}

impl StudyPage {
    /// The page, `index.html`; a figure and a table for every stage and every question that has one.
    /// `overviews` are the figures of stages, by the stage's name; `sliders` is a stage whose model the page
    /// solves itself, or why it cannot. The settings at which its solver can be checked become
    /// `tables/sliders.csv`.
    ///
    /// # Errors
    /// If no stage was run.
    pub fn new(
        head: &StudyHead,
        stages: &[StageRecord],
        answers: &[Answer],
        verdicts: &[Judgement],
        sliders: Option<&(String, Result<Sliders, String>)>,
    ) -> Result<Self, Failed> {
        if stages.is_empty() {
            return Err(Failed::of_work("no numbers of any stage"));
        }
        let mut page = Self { files: Vec::new() };
        let mut body = String::new();
        let shown = first::stage(stages);
        let (mut top, mut compared) = (String::new(), String::new());
        for stage in stages {
            body += &section(head, stage);
            page.table(&stage.id, &models(stage))?;
            let mut figures = String::new();
            for answer in answers.iter().filter(|a| a.id == stage.id) {
                figures += &page.figure(head, answer, Some(stage))?;
            }
            if shown.is_some_and(|s| s.id == stage.id) {
                top = first::section(stage, &figures);
                body += "<p>Measured and predicted: <a href=\"#found\">above</a>.</p>\n";
            } else {
                body += &figures;
            }
            body += &checks::section(stage);
            if let Some(found) = &stage.checks {
                page.table(&format!("{}-points", stage.id), &left_out_table(found))?;
            }
            if let Some(answer) = residuals_over_factors(&head.factors, stage) {
                body += &page.figure(head, &answer, Some(stage))?;
            }
            body += &asked::section(stage);
            if let Some(missing) = &stage.missing {
                body += &page.figure(head, &gains_along(stage, missing), Some(stage))?;
            }
            compared += &claims::of(verdicts, &stage.id, &stage.title);
            if let Some((_, found)) = sliders.filter(|(id, _)| *id == stage.id) {
                body += &sliders::section(found, stage);
                if let Ok(model) = found {
                    page.files.push(("tables/sliders.csv".to_owned(), sliders::checks(model)));
                }
            }
        }
        for answer in answers.iter().filter(|a| stages.iter().all(|s| s.id != a.id)) {
            body += &format!("<h2 id=\"{}\">{}</h2>\n", answer.id, html(&answer.title));
            body += &page.figure(head, answer, None)?;
            body += &tables::parameter_table(&answer.parameters);
            compared += &claims::of(verdicts, &answer.id, &answer.title);
        }
        body += &claims::section(&head.claims, verdicts, &compared);
        // Hypertext ends cells and rows by itself; thousands of ends are a twentieth of a large page.
        let body =
            body.replace("</td>", "").replace("</tr>\n", "\n").replace("<td class=\"n\">", "<td class=n>");
        let data = match head.kind {
            DataKind::Measured => "Measured data",
            DataKind::Virtual => "Virtual data: no instrument recorded them",
        };
        let of_responses = head.found_beside.iter().cloned();
        let answer: String = of_responses
            .chain(stages.iter().filter_map(answer))
            .map(|a| format!("<p class=\"answer\">{a}</p>\n"))
            .collect();
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, \
             initial-scale=1\"><title>{name}</title><style>{STYLE}</style></head><body>\n<main>\n<h1>{name}</h1>\n<p>{question}</p>\n{answer}\
             <p class=\"data\">{data}. Source: {source}.</p>\n{beside}{top}{contents}{body}</main>\n\
             <script type=\"application/json\" id=\"points\">{points}</script>\n<script>\n{SCRIPT}</script>\n{scripts}</body></html>\n",
            name = html(&head.name),
            question = html(&head.question),
            source = html(&head.source),
            beside = head.beside.as_ref().map_or(String::new(), |path| {
                format!(
                    "<p>Stages that train on responses have <a href=\"{}\">a page of their own</a>.</p>\n",
                    html(path)
                )
            }),
            contents = contents(
                stages,
                answers,
                sliders.is_some_and(|(_, found)| found.is_ok()),
                !verdicts.is_empty()
            ),
            scripts =
                sliders.and_then(|(_, found)| found.as_ref().ok()).map_or(String::new(), sliders::scripts),
            points = checks::said(stages),
        );
        page.files.push(("index.html".to_owned(), text.into_bytes()));
        Ok(page)
    }

    /// Keeps the figure of an answer and its tables; the figure as HTML.
    fn figure(
        &mut self,
        head: &StudyHead,
        answer: &Answer,
        stage: Option<&StageRecord>,
    ) -> Result<String, Failed> {
        let prefix = if answer.frames.len() > 1 && !map::is_one(answer) { "-measured" } else { "" };
        for (k, frame) in answer.frames.iter().enumerate() {
            let name =
                if k == 0 { format!("{}{prefix}", answer.id) } else { format!("{}-{}", answer.id, k + 1) };
            // The table of a stage's models has the stage's name.
            self.table(&name, &frame.in_print())?;
        }
        let Some(figure) = figure::of(Some(head.kind), answer, &figure::PAGE) else {
            return Ok(String::new());
        };
        if let Some(svg) = answer_svg(Some(head.kind), answer) {
            self.files.push((format!("figures/{}.pdf", answer.id), rijke_draw::pdf(&svg)?));
            self.files.push((format!("figures/{}.svg", answer.id), svg.into_bytes()));
        }
        let of = stage.map_or(String::new(), |s| format!(" data-stage=\"{}\"", s.id));
        Ok(format!(
            "<figure{of}>{}<figcaption>{}</figcaption></figure>\n",
            figure.html(),
            html(&figure.caption)
        ))
    }

    fn table(&mut self, name: &str, frame: &Frame) -> Result<(), Failed> {
        let unit = |c: &rijke_engine::run::FrameColumn| format!("{} [{}]", c.name, c.unit);
        // Where points have several modes.
        let several = frame.rows.iter().any(|row| !row.mode.is_empty());
        let own = ["name", "series", "mode"].into_iter().filter(|name| several || *name != "mode");
        let mut table = vec![own.map(str::to_owned).chain(frame.columns.iter().map(unit)).collect()];
        for row in &frame.rows {
            let numbers = row.values.iter().map(|v| v.map_or(String::new(), |v| format!("{v}")));
            let own = [row.label.clone(), row.series.clone()].into_iter();
            let own = own.chain(several.then(|| row.mode.clone()));
            let lacking = frame.columns.len().saturating_sub(row.values.len());
            table.push(own.chain(numbers).chain(std::iter::repeat_n(String::new(), lacking)).collect());
        }
        self.files.push((format!("tables/{name}.csv"), csv_table(table)?.into_bytes()));
        Ok(())
    }

    /// Writes the files into a folder, the page last. Each appears under its name only when it is complete;
    /// what killed runs left of it is removed.
    ///
    /// # Errors
    /// Names the file that could not be written.
    pub fn write(&self, folder: &Path) -> Result<(), Failed> {
        for (name, content) in &self.files {
            let path = folder.join(name);
            let made = path.parent().map_or(Ok(()), fs::create_dir_all);
            made.or_failed().map_err(|failed| failed.at(&path))?;
            rijke_numerics::write_output(&path, content)?;
        }
        Ok(())
    }
}

fn contents(stages: &[StageRecord], answers: &[Answer], sliders: bool, compared: bool) -> String {
    let link = |id: &str, title: &str| format!("<li><a href=\"#{id}\">{}</a></li>\n", html(title));
    let of_stages: String = stages.iter().map(|s| link(&s.id, &s.title)).collect();
    let others = answers.iter().filter(|a| stages.iter().all(|s| s.id != a.id));
    let of_answers: String = others.map(|a| link(&a.id, &a.title)).collect();
    let of_sliders = if sliders { link("sliders", sliders::TITLE) } else { String::new() };
    let of_claims = if compared { link("compared", claims::TITLE) } else { String::new() };
    format!("<nav aria-label=\"Contents\"><ul>\n{of_stages}{of_answers}{of_sliders}{of_claims}</ul></nav>\n")
}

/// What a competition found, in a sentence; nothing for a stage of one model.
fn answer(stage: &StageRecord) -> Option<String> {
    let ranked = stage.models.iter().filter(|m| m.evidence.is_some()).count();
    if ranked < 2 {
        return None;
    }
    // Of models that were carried on, later stages judge too.
    let later = stage.with_later(&stage.chosen).is_some();
    let worth = |m: &ModelRecord| if later { stage.with_later(&m.id) } else { total(m) };
    let mut all: Vec<(&ModelRecord, f64)> =
        stage.models.iter().filter_map(|m| Some((m, worth(m)?))).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let [(first, best), (second, next), ..] = all[..] else { return None };
    let lead = best - next;
    let name = |m: &ModelRecord| html(&m.label);
    let (title, by) = (html(&stage.title), if later { " by this and later stages" } else { "" });
    if lead > stage.decides.max(3.0) {
        return Some(format!(
            "{title}: <b>{}</b>, {lead:.1} nats ahead of {}{by}.",
            name(first),
            name(second)
        ));
    }
    let (one, other, mut rest) = apart(&first.label, &second.label);
    let open = all.iter().filter(|(_, worth)| best - worth < stage.decides).count();
    if let Some(goes_on) = chosen(stage).filter(|_| open > 2) {
        rest += &format!(
            " In all {open} models are within {} nats; the numbers below are those of {}.",
            stage.decides, goes_on.label
        );
    }
    Some(format!(
        "{title}: not decided between <b>{}</b> and {}, which is {lead:.1} nats behind{by}: odds of {:.1} to 1.{}",
        html(&one),
        html(&other),
        lead.exp(),
        html(&rest)
    ))
}

/// What two models are called where they differ, and a sentence if they share more than that.
fn apart(a: &str, b: &str) -> (String, String, String) {
    let [one, other] = [a, b].map(|label| label.split("; ").collect::<Vec<_>>());
    let differ: Vec<(&str, &str)> =
        one.iter().copied().zip(other.iter().copied()).filter(|(x, y)| x != y).collect();
    if one.len() != other.len() || differ.is_empty() || differ.len() == one.len() {
        return (a.to_owned(), b.to_owned(), String::new());
    }
    let (first, second): (Vec<&str>, Vec<&str>) = differ.into_iter().unzip();
    (first.join("; "), second.join("; "), " All else is the same in both.".to_owned())
}

fn section(head: &StudyHead, stage: &StageRecord) -> String {
    let mut text = format!("<h2 id=\"{}\">{}</h2>\n", stage.id, html(&stage.title));
    let n = stage.measured.len();
    let modes = if n == 1 { "one mode".to_owned() } else { format!("{n} modes") };
    let points = stage.measured.iter().map(|m| &m.point).collect::<std::collections::BTreeSet<_>>().len();
    let points =
        if points == 1 { "one operating point".to_owned() } else { format!("{points} operating points") };
    text += &if n == 0 {
        "<p>No mode was measured at its points: the model is as earlier stages have it.</p>\n".to_owned()
    } else {
        format!("<p>Trained on {modes} at {points}.</p>\n")
    };
    if stage.one_start {
        text += &format!("<p class=\"warn\">Of all models, {}.</p>\n", html(StageRecord::ONE_START));
    }
    for assumed in &stage.assumes {
        text += &format!("<p class=\"warn\">Stands on what is not decided. {}.</p>\n", html(assumed));
    }
    for said in stage.behind_by_a_prior() {
        text += &format!("<p class=\"warn\">{}.</p>\n", html(&said));
    }
    for said in &stage.undescribed {
        text += &format!("<p class=\"warn\">{}.</p>\n", html(&capitalised(said)));
    }
    if let Some(missed) = &stage.missed {
        text += &format!("<p class=\"warn\">Of the model that goes on, {}.</p>\n", html(missed));
    }
    let doubtful = chosen(stage).map(tables::conflicts).unwrap_or_default();
    for conflict in doubtful {
        text += &format!("<p class=\"warn\">{conflict}</p>\n");
    }
    text += &tables::ranking(stage, head.claims.published.get(&stage.id));
    text += &tables::carried_on(stage);
    if let Some(tau) = rijke_engine::run::agreement(&head.claims, stage) {
        text += &format!(
            "<p>Kendall's tau between this order and that of {}: {tau:.2}.</p>\n",
            html(&head.claims.source)
        );
    }
    if let Some(model) = chosen(stage) {
        text += &tables::parameters(model);
        text += &tables::laws(model);
    }
    for said in stage.missing.iter().flat_map(Missing::disagreeing) {
        text += &format!("<p class=\"warn\">{}.</p>\n", html(&capitalised(&said)));
    }
    text += &tables::residuals(head, stage);
    text
}
