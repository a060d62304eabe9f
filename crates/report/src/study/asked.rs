//! What the data still ask for: a table, and gains along the rig.

use super::numbers::{chance, with_uncertainty};
use rijke_draw::html;
use rijke_engine::run::{Family, StageRecord};
use rijke_numerics::words::capitalised;

/// Members of a family that are named.
const NAMED: usize = 5;

/// The terms in words and as a table.
pub(super) fn section(stage: &StageRecord) -> String {
    let Some(missing) = &stage.missing else { return String::new() };
    let Some(first) = missing.families.first() else { return String::new() };
    let sentence = if !first.is_required() {
        format!(
            "Of {} further terms none gains more than chance would: the best, {}, has p = {:.2}.",
            missing.tried,
            html(&first.first.words()),
            first.beyond.1
        )
    } else {
        let asked = missing.required().count();
        format!(
            "Of {} further terms, {} of those below {} more than chance would give: {:.1} nats in one of twenty data sets of the model itself.",
            missing.tried,
            match asked {
                1 => "the first".to_owned(),
                _ if asked == missing.families.len() => "all".to_owned(),
                _ => format!("the first {asked}"),
            },
            if asked == 1 { "gains" } else { "gain" },
            missing.by_chance
        )
    };
    let row = |f: &Family| {
        let a = &f.first;
        let mut like: Vec<String> = f.like.iter().take(NAMED).map(|t| html(t)).collect();
        if f.like.len() > NAMED {
            like.push(format!("and {} more", f.like.len() - NAMED));
        }
        let also: String = f.also.iter().map(|t| format!("<br><small>and {}</small>", html(t))).collect();
        let between = f.between.filter(|b| b[1] > b[0]);
        let range = between
            .map_or(String::new(), |[a, b]| format!("<br><small>between {a:.3} m and {b:.3} m</small>"));
        let unit = if a.unit == "1" { String::new() } else { format!(" {}", html(&a.unit)) };
        format!(
            "<tr{}><td>{}{also}{range}</td><td class=\"n\">{}{unit}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{:.3}</td><td class=\"n\">{:.3}</td><td><small>{}</small></td></tr>\n",
            if f.is_required() { "" } else { " class=\"failed\"" },
            html(&a.words()),
            with_uncertainty(a.strength[0], a.strength[1]),
            a.gain,
            f.beyond.0,
            chance(f.beyond.1),
            a.moves[0],
            a.moves[1],
            like.join("; ")
        )
    };
    let rows: String = missing.families.iter().map(row).collect();
    let unexplained = stage
        .unexplained()
        .map_or_else(String::new, |said| format!("<p>{}.</p>\n", html(&capitalised(&said))));
    format!(
        "<h3 id=\"{}-missing\">What these data still ask for</h3>\n<p>{sentence} A term describes what is missing. It is no cause: the data cannot distinguish it \
         from those of its family, and what is there may be in no library.</p>\n{unexplained}<details{}><summary>The terms</summary><div class=\"wide\"><table><thead><tr><th>term</th><th>strength</th><th>gain \
         expected, nats</th><th>beyond the terms above</th><th>by chance</th><th>moves growth rates, 1/s</th><th>moves frequencies, \
         rad/s</th><th>cannot be distinguished from</th></tr></thead><tbody>\n{rows}</tbody></table></div></details>\n",
        stage.id,
        if first.is_required() { " open" } else { "" }
    )
}
