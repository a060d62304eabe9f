//! What a watch shows: counts, files that do not count, the leading models, and the page of the study below.

use crate::failure::Failure;
use crate::staging::write_whole;
use rijke_engine::run::StageRecord;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// What there is to say. A page that was opened looks for another `version` and loads itself again.
#[derive(Default, Serialize)]
pub(super) struct Status {
    version: u64,
    pub(super) whole: usize,
    pub(super) awaited: usize,
    pub(super) points: usize,
    /// Files that cannot be read, and why.
    pub(super) unusable: BTreeMap<String, String>,
    /// Records that were read and rejected, and why.
    pub(super) rejected: Vec<(String, String)>,
    /// Stage, and its best models with how far they are behind, nats.
    stages: Vec<(String, Vec<(String, f64)>)>,
    pub(super) said: String,
    /// When the flow of each ramp is settled.
    pub(super) settling: Vec<String>,
    /// The page of the finished study.
    results: Option<String>,
}

/// Models that are named for each stage.
const NAMED: usize = 3;

impl Status {
    /// What training found.
    pub(super) fn trained(&mut self, stages: &[StageRecord], all: bool) {
        let best = |stage: &StageRecord| {
            let models = stage.by_evidence();
            let first = models.first().map_or(0.0, |m| m.ln_evidence());
            let named = models.into_iter().filter(|m| m.evidence.is_some()).take(NAMED);
            (stage.title.clone(), named.map(|m| (m.id.clone(), m.ln_evidence() - first)).collect())
        };
        self.stages = stages.iter().map(best).collect();
        let which = if all { "all models" } else { "the leading models" };
        self.said = format!("{which} of {} stages trained", stages.len());
    }

    /// The study is complete; its page lies at `results`.
    pub(super) fn finished(&mut self, results: &Path) {
        self.said = "finished".to_owned();
        self.results = Some(results.display().to_string());
    }

    /// One line for a terminal.
    pub(super) fn line(&self, changed: &[String]) -> String {
        let files = match changed {
            [one] => one.clone(),
            many => format!("{} files", many.len()),
        };
        let leads = |(stage, models): &(String, Vec<(String, f64)>)| match &models[..] {
            [first, second, ..] => Some(format!("{stage}: {} by {:.1} nats", first.0, -second.1)),
            _ => None,
        };
        let leads: Vec<String> = self.stages.iter().filter_map(leads).collect();
        format!(
            "{files}: {} of {} files, {} points; {}{}",
            self.whole,
            self.whole + self.awaited,
            self.points,
            self.said,
            leads.iter().map(|l| format!("; {l}")).collect::<String>()
        )
    }

    /// Writes `status.json` and the page, each whole.
    pub(super) fn write(&mut self, live: &Path) -> Result<(), Failure> {
        self.version += 1;
        let html = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        let list = |title: &str, of: Vec<(&String, &String)>| {
            if of.is_empty() {
                return String::new();
            }
            let items = of.iter().map(|(f, why)| format!("<li><code>{}</code>: {}</li>", html(f), html(why)));
            format!(
                "<details><summary>{title}: {}</summary><ul>{}</ul></details>",
                of.len(),
                items.collect::<String>()
            )
        };
        let stage = |(title, models): &(String, Vec<(String, f64)>)| {
            let models = models.iter().map(|(id, behind)| format!("{} ({behind:.1})", html(id)));
            format!("<li>{}: {}</li>", html(title), models.collect::<Vec<_>>().join(", "))
        };
        let study = if live.join("study/index.html").is_file() {
            "<iframe src=\"study/index.html\" title=\"The study so far\"></iframe>"
        } else {
            ""
        };
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, \
             initial-scale=1\"><title>Measuring</title><style>{STYLE}</style></head><body data-version=\"{}\">\n<main><h1>Measuring</h1>\n\
             <p role=\"status\">{} of {} files, {} operating points; {}.</p>\n{}<p>Leading models, nats behind the first:</p><ul>{}</ul>\n{}{}\
             </main>\n{study}\n<script>{SCRIPT}</script></body></html>\n",
            self.version,
            self.whole,
            self.whole + self.awaited,
            self.points,
            html(&self.said),
            self.settling.iter().map(|said| format!("<p>{}.</p>\n", html(said))).collect::<String>(),
            self.stages.iter().map(stage).collect::<String>(),
            list("Files that do not count", self.unusable.iter().collect()),
            list("Records rejected", self.rejected.iter().map(|(f, why)| (f, why)).collect()),
        );
        let status = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        write_whole(&live.join("index.html"), text.as_bytes())?;
        write_whole(&live.join("status.json"), status.as_bytes())
    }
}

const STYLE: &str = ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;margin:0}main{max-width:60rem;\
margin:auto;padding:0 1rem}iframe{border:0;border-top:1px solid;width:100%;height:80vh}";

/// Loads the page again when its version is another.
const SCRIPT: &str = "setInterval(()=>fetch('status.json',{cache:'no-store'}).then(r=>r.json()).then(s=>{\
if(String(s.version)!==document.body.dataset.version)location.reload()}).catch(()=>{}),500)";
