//! The page beside an acquisition, which shows itself again when it changed: counts, the last record with its
//! fit, the leading models with their posteriors, what to measure next, files that do not count, and the page
//! of the study below.

use rijke_draw::escape;
use rijke_engine::run::{Lead, Leads, Next};
use rijke_numerics::words::{counted, with_sd};
use rijke_numerics::{Failed, write_output};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// What there is to say. A page that was opened looks for another `version` and shows what changed.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LivePage {
    version: u64,
    /// Files that count.
    pub whole: usize,
    /// Files that are listed and not there yet.
    pub awaited: usize,
    /// Operating points at which something was measured.
    pub points: usize,
    /// Files that cannot be read, and why.
    pub unusable: BTreeMap<String, String>,
    /// Records that were read and rejected, and why.
    pub rejected: Vec<(String, String)>,
    /// The leading models of every stage, with all that is observed.
    pub stages: Vec<Leads>,
    /// What is going on.
    pub said: String,
    /// The last record, in words.
    pub last: String,
    /// When the flow of each ramp is settled.
    pub settling: Vec<String>,
    /// What to measure next.
    pub next: Vec<String>,
    /// How often the figures of the last record and of what to measure next, and the page of the study, were
    /// written.
    figures: [u64; 3],
    /// The page of the finished study.
    results: Option<String>,
}

/// A figure of the page, or the page of the study below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LivePart {
    /// The last record with its fit.
    Last,
    /// What further points would tell.
    Next,
    /// The page of the study.
    Study,
}

impl LivePart {
    fn file(self) -> &'static str {
        match self {
            Self::Last => "last.svg",
            Self::Next => "next.svg",
            Self::Study => "study/index.html",
        }
    }
}

/// Parameters of a model that are shown in a table.
const SHOWN: usize = 8;

impl LivePage {
    /// A part of the page was written anew.
    pub fn renewed(&mut self, part: LivePart) {
        self.figures[part as usize] += 1;
    }

    /// Writes a figure.
    pub fn draw(&mut self, live: &Path, part: LivePart, svg: &str) -> Result<(), Failed> {
        self.renewed(part);
        write_output(&live.join(part.file()), svg.as_bytes())
    }

    /// What to measure next, in words.
    pub fn suggest(&mut self, found: &Next) {
        let step = |s: &rijke_engine::run::Step| format!("{}: {:.3} nats", s.point, s.adds);
        self.next = found.plan.iter().map(step).collect();
        self.next.extend(
            found.further.iter().map(|(point, nats)| format!("after these {point} would add {nats:.3} nats")),
        );
    }

    /// The study is complete; its page lies at `results`.
    pub fn finished(&mut self, results: &Path) {
        self.said = "finished".to_owned();
        self.results = Some(results.display().to_string());
        self.renewed(LivePart::Study);
    }

    /// One line for a terminal.
    pub fn line(&self, changed: &[String]) -> String {
        let files = match changed {
            [one] => one.clone(),
            many => format!("{} new files", many.len()),
        };
        let said = if self.said.is_empty() { String::new() } else { format!("; {}", self.said) };
        let leads = |leads: &Leads| match &leads.models[..] {
            [first, second, ..] => Some(format!(
                "; {}: {} by {:.1} nats",
                leads.title,
                first.id,
                first.ln_evidence - second.ln_evidence
            )),
            _ => None,
        };
        format!(
            "{files}: {} of {} read, {} operating points{said}{}",
            self.whole,
            self.whole + self.awaited,
            self.points,
            self.stages.iter().filter_map(leads).collect::<String>()
        )
    }

    /// Writes `status.json` and the page, each whole.
    pub fn write(&mut self, live: &Path) -> Result<(), Failed> {
        self.version += 1;
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, \
             initial-scale=1\"><title>Measuring</title><style>{STYLE}</style></head><body data-version=\"{}\">\n<main>{}</main>\n{}\n\
             <script>{SCRIPT}</script></body></html>\n",
            self.version,
            self.body(live),
            self.part(live, LivePart::Study, "The study so far"),
        );
        let status = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        write_output(&live.join("index.html"), text.as_bytes())?;
        write_output(&live.join("status.json"), status.as_bytes())
    }

    fn body(&self, live: &Path) -> String {
        let mut body = format!(
            "<h1>Measuring</h1>\n<p role=\"status\">{} of {} files, {} operating points; {}.</p>\n",
            self.whole,
            self.whole + self.awaited,
            self.points,
            escape(&self.said)
        );
        body.extend(self.settling.iter().map(|said| format!("<p>{}.</p>\n", escape(said))));
        if !self.last.is_empty() {
            let figure = self.part(live, LivePart::Last, "The last record with its fit");
            let _ = writeln!(
                body,
                "<section id=\"last\"><h2>Last record</h2><p>{}</p>{figure}</section>",
                escape(&self.last)
            );
        }
        if !self.stages.is_empty() {
            let last = self.stages.len() - 1;
            let tables = self.stages.iter().enumerate().map(|(k, leads)| table(leads, k == last));
            let _ = writeln!(
                body,
                "<section id=\"models\"><h2>Leading models</h2>{}</section>",
                tables.collect::<String>()
            );
        }
        if !self.next.is_empty() {
            let figure = self.part(live, LivePart::Next, "What further points would tell");
            let items = self.next.iter().map(|said| format!("<li>{}</li>", escape(said)));
            let _ = writeln!(
                body,
                "<section id=\"next\"><h2>What to measure next</h2><ul>{}</ul>{figure}</section>",
                items.collect::<String>()
            );
        }
        body + &list("Files that do not count", self.unusable.iter().collect())
            + &list("Records rejected", self.rejected.iter().map(|(f, why)| (f, why)).collect())
    }

    /// A part, once it is there, under an address that changes with it.
    fn part(&self, live: &Path, part: LivePart, title: &str) -> String {
        let file = part.file();
        let address = format!("{file}?{}", self.figures[part as usize]);
        match part {
            _ if !live.join(file).is_file() => String::new(),
            LivePart::Study => format!("<iframe src=\"{address}\" title=\"{title}\"></iframe>"),
            _ => format!("<img src=\"{address}\" alt=\"{title}\">"),
        }
    }
}

fn list(title: &str, of: Vec<(&String, &String)>) -> String {
    if of.is_empty() {
        return String::new();
    }
    let items = of.iter().map(|(f, why)| format!("<li><code>{}</code>: {}</li>", escape(f), escape(why)));
    format!(
        "<details><summary>{title}: {}</summary><ul>{}</ul></details>",
        of.len(),
        items.collect::<String>()
    )
}

/// The leading models of a stage, how far they are behind, and their parameters.
fn table(leads: &Leads, open: bool) -> String {
    let first = leads.models.first().map_or(0.0, |m| m.ln_evidence);
    let row = |model: &Lead| {
        let shown = |p: &rijke_engine::run::TrainedParameter| {
            format!("{} = {}", escape(&p.name), escape(&with_sd(p.value, p.sd)))
        };
        let mut parameters: Vec<String> = model.parameters.iter().take(SHOWN).map(shown).collect();
        let more = model.parameters.len().saturating_sub(SHOWN);
        parameters.extend((more > 0).then(|| format!("{more} more")));
        format!(
            "<tr><td>{}</td><td>{:.1}</td><td>{}</td></tr>",
            escape(&model.id),
            first - model.ln_evidence,
            parameters.join(", ")
        )
    };
    let new = match leads.new.len() {
        0 => String::new(),
        n => format!(", {} newer than the training", counted(n, "point")),
    };
    format!(
        "<details{}><summary>{}{new}</summary><table><tr><th>model</th><th>nats behind</th><th>parameters</th></tr>{}</table></details>\n",
        if open { " open" } else { "" },
        escape(&leads.title),
        leads.models.iter().map(row).collect::<String>()
    )
}

const STYLE: &str = ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;margin:0}main{max-width:60rem;\
margin:auto;padding:0 1rem}iframe{border:0;border-top:1px solid;width:100%;height:80vh}img{max-width:100%;background:#fff}\
table{border-collapse:collapse;display:block;overflow-x:auto}td,th{text-align:left;padding:0 .7rem 0 0;vertical-align:top}";

/// Shows what changed when the version is another. A file that was opened without a server loads itself
/// again.
const SCRIPT: &str = "const get=async(f,as)=>(await fetch(f,{cache:'no-store'}))[as]();\
const look=async()=>{const v=String((await get('status.json','json')).version);if(v===document.body.dataset.version)return;\
const now=new DOMParser().parseFromString(await get('index.html','text'),'text/html');\
const folds=d=>[...d.querySelectorAll('main details')];\
const was=new Map(folds(document).map(f=>[f.textContent.split(':')[0].slice(0,20),f.open]));\
folds(now).forEach(f=>{const o=was.get(f.textContent.split(':')[0].slice(0,20));if(o!==undefined)f.open=o});\
document.querySelector('main').replaceWith(now.querySelector('main'));document.body.dataset.version=now.body.dataset.version;\
const [old,frame]=[document,now].map(d=>d.querySelector('iframe'));\
if(frame&&!old)document.querySelector('main').after(frame);\
else if(frame&&frame.getAttribute('src')!==old.getAttribute('src'))old.replaceWith(frame)};\
if(location.protocol==='file:')setTimeout(()=>location.reload(),2000);\
else(async()=>{for(;;){await look().catch(()=>{});await new Promise(r=>setTimeout(r,250))}})()";
