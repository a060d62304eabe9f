//! Published statements, and whether they hold here.

use crate::draw::html;
use rijke_engine::run::Judgement;
use rijke_study::Claims;

/// The statements about one table.
pub(super) fn of(verdicts: &[Judgement], id: &str) -> String {
    let line = |v: &Judgement| {
        let (class, mark) = if v.holds { ("holds", "holds") } else { ("fails", "does not hold") };
        let why = v.explanation.as_deref().map_or(String::new(), |e| format!("<br>{}", html(e)));
        format!(
            "<li class=\"{class}\"><b>{mark}:</b> {} <small>{}</small>{why}</li>\n",
            html(&v.statement),
            html(&v.figure)
        )
    };
    let lines: String = verdicts.iter().filter(|v| v.of == id).map(line).collect();
    if lines.is_empty() { lines } else { format!("<ul class=\"claims\">\n{lines}</ul>\n") }
}

/// How many statements hold.
pub(super) fn summary(claims: &Claims, verdicts: &[Judgement]) -> String {
    if verdicts.is_empty() {
        return String::new();
    }
    let holds = verdicts.iter().filter(|v| v.holds).count();
    format!(
        "<p>{holds} of {} statements of {} hold here; each stands beside its numbers below.</p>\n",
        verdicts.len(),
        html(&claims.source)
    )
}
