//! The page of a study: any rig, any stages. Draws the records of the engine and computes nothing of its own.

mod figure;
pub(crate) mod tables;

use crate::draw::html;
use crate::{ReportError, draw};
use rijke_engine::run::{ModelRecord, StageRecord};
use rijke_studies::DataKind;
use std::{fs, path::Path};

/// What a page says of a study, beside its stages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyHead {
    /// Its name.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where the data come from.
    pub source: String,
    /// The factors of the campaign: name, unit on axes, and SI units per that unit.
    pub factors: Vec<(String, String)>,
}

/// The files of the page of a study, in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyPage {
    files: Vec<(String, Vec<u8>)>,
}

pub(crate) const STYLE: &str = "body{font:16px/1.5 'Helvetica Neue',Helvetica,Arial,sans-serif;max-width:72rem;margin:0 auto;padding:1rem;color:#1a1a1a;\
background:#fff}h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.5rem;border-top:1px solid #bbb;padding-top:1rem}.answer{font-size:1.1rem;\
border-left:4px solid #0072b2;padding-left:.8rem}.data{color:#555}.wide{overflow-x:auto}table{border-collapse:collapse;margin:.5rem 0}\
td,th{padding:.2rem .6rem;text-align:left;border-bottom:1px solid #ddd}td.n{text-align:right;font-variant-numeric:tabular-nums}\
tr.chosen{background:#eef5fb;font-weight:600}tr.failed{color:#777}code{font-size:.9em}.panels{display:flex;flex-wrap:wrap;gap:.5rem}\
.panels svg{max-width:100%;height:auto}.legend .key{margin-right:1rem;white-space:nowrap}details{margin:.5rem 0}.warn{background:#fff4e0;\
padding:.5rem .8rem;border-left:4px solid #d55e00}@media print{details{display:block}}";

impl StudyPage {
    /// The page, `index.html`, and a figure for every stage that has one.
    ///
    /// # Errors
    /// [`ReportError::Nothing`] if no stage was run.
    pub fn new(head: &StudyHead, stages: &[StageRecord]) -> Result<Self, ReportError> {
        if stages.is_empty() {
            return Err(ReportError::Nothing);
        }
        let mut files = Vec::new();
        let mut body = String::new();
        for stage in stages {
            body += &section(head, stage);
            for (k, figure) in figure::of(head, stage).iter().enumerate() {
                body += &format!(
                    "<figure>{}<figcaption>{}</figcaption></figure>\n",
                    figure.html(),
                    html(&figure.caption)
                );
                files.push((format!("figures/{}-{}.svg", stage.id, k + 1), figure.svg().into_bytes()));
            }
        }
        let data = match head.kind {
            DataKind::Measured => "Measured data",
            DataKind::Virtual => "Virtual data: no instrument recorded them",
        };
        let answer: String =
            stages.iter().filter_map(answer).map(|a| format!("<p class=\"answer\">{a}</p>\n")).collect();
        let page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, \
             initial-scale=1\"><title>{name}</title><style>{STYLE}</style></head><body>\n<h1>{name}</h1>\n<p>{question}</p>\n{answer}\
             <p class=\"data\">{data}. Source: {source}.</p>\n{body}</body></html>\n",
            name = draw::html(&head.name),
            question = draw::html(&head.question),
            source = draw::html(&head.source),
        );
        files.push(("index.html".to_owned(), page.into_bytes()));
        Ok(Self { files })
    }

    /// Writes the files into a folder, the page last.
    ///
    /// # Errors
    /// [`ReportError::Write`] names the file that could not be written.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        for (name, content) in &self.files {
            let path = folder.join(name);
            let written =
                path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&path, content));
            written.map_err(|source| ReportError::Write { path, source })?;
        }
        Ok(())
    }
}

/// The model that goes on.
fn chosen(stage: &StageRecord) -> Option<&ModelRecord> {
    stage.models.iter().find(|m| m.id == stage.chosen)
}

fn total(model: &ModelRecord) -> Option<f64> {
    model.evidence.map(|e| e.ln_marginal)
}

/// What a competition found, in a sentence; nothing for a stage of one model.
fn answer(stage: &StageRecord) -> Option<String> {
    let ranked = stage.models.iter().filter(|m| m.evidence.is_some()).count();
    if ranked < 2 {
        return None;
    }
    let (winner, best) =
        stage.models.iter().find(|m| m.id == stage.winner).and_then(|m| Some((m, total(m)?)))?;
    let others = stage.models.iter().filter(|m| m.id != stage.winner).filter_map(|m| Some((m, total(m)?)));
    let (second, next) = others.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let lead = best - next;
    let name = |m: &ModelRecord| draw::html(&m.label);
    let title = draw::html(&stage.title);
    Some(if lead > stage.decides.max(3.0) {
        format!("{title}: <b>{}</b>, {lead:.1} nats ahead of {}.", name(winner), name(second))
    } else {
        format!(
            "{title}: not decided. <b>{}</b> is {lead:.1} nats ahead of {}, which is odds of {:.1} to 1.",
            name(winner),
            name(second),
            lead.exp()
        )
    })
}

fn section(head: &StudyHead, stage: &StageRecord) -> String {
    let mut text = format!("<h2 id=\"{}\">{}</h2>\n", stage.id, draw::html(&stage.title));
    let n = stage.measured.len();
    let modes = if n == 1 { "mode".to_owned() } else { format!("{n} modes") };
    text += &format!(
        "<p>Trained on {modes} at {} operating points.</p>\n",
        stage.measured.iter().map(|m| &m.point).collect::<std::collections::BTreeSet<_>>().len()
    );
    let doubtful = chosen(stage).map(tables::conflicts).unwrap_or_default();
    for conflict in doubtful {
        text += &format!("<p class=\"warn\">{conflict}</p>\n");
    }
    text += &tables::ranking(stage);
    if let Some(model) = chosen(stage) {
        text += &tables::parameters(model);
        text += &tables::laws(model);
    }
    text += &tables::residuals(head, stage);
    text
}
