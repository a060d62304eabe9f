//! Published statements, and whether they hold here.

use rijke_draw::html;
use rijke_engine::run::Judgement;
use rijke_study::Claims;

/// Heading of the section.
pub(super) const TITLE: &str = "Compared with what was published";

/// The section, of the lists of all tables; nothing where nothing was compared.
pub(super) fn section(claims: &Claims, verdicts: &[Judgement], lists: &str) -> String {
    if lists.is_empty() {
        return String::new();
    }
    format!("<h2 id=\"compared\">{TITLE}</h2>\n{}{lists}", summary(claims, verdicts))
}

/// The statements about the table of a stage or question.
pub(super) fn of(verdicts: &[Judgement], id: &str, title: &str) -> String {
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
    if lines.is_empty() {
        return lines;
    }
    format!("<h3><a href=\"#{id}\">{}</a></h3>\n<ul class=\"claims\">\n{lines}</ul>\n", html(title))
}

/// How many statements hold.
fn summary(claims: &Claims, verdicts: &[Judgement]) -> String {
    if verdicts.is_empty() {
        return String::new();
    }
    let holds = verdicts.iter().filter(|v| v.holds).count();
    format!("<p>{holds} of {} statements of {} hold here.</p>\n", verdicts.len(), html(&claims.source))
}
