//! The section of the page in which a reader moves parameters and factors, and the scripts that solve the
//! model there.

use rijke_draw::html;
use rijke_engine::run::{Sliders, StageRecord};

/// What the section is called.
pub(super) const TITLE: &str = "The model to try";

/// Solves the model.
const SOLVER: &str = include_str!("solver.js");

/// Sliders and figures that follow them.
const SCRIPT: &str = include_str!("sliders.js");

/// The section; a sentence where the page cannot solve the model.
pub(super) fn section(found: &Result<Sliders, String>, stage: &StageRecord) -> String {
    match found {
        Ok(model) => format!(
            "<section id=\"sliders\" aria-labelledby=\"sliders-title\"><h2 id=\"sliders-title\">{TITLE}</h2>\n<p>{}: {}.{} The page solves this \
             model by itself, with the laws of the study and the state of the gas interpolated between the measured points.</p>\n<p \
             class=\"unscripted\">The sliders need scripts; figures and tables do not.</p>\n</section>\n",
            html(&stage.title),
            html(&model.model),
            model.instead.as_ref().map_or_else(String::new, |why| format!(
                " The model that went on cannot be solved here: {}. This is the next best.",
                html(why)
            ))
        ),
        Err(why) => format!("<p>This page has no sliders for {}: {}.</p>\n", html(&stage.title), html(why)),
    }
}

/// The model, its solver, and the sliders.
pub(super) fn scripts(model: &Sliders) -> String {
    // A script ends where this text stands, whatever it is in.
    let data = serde_json::to_string(model).unwrap_or_default().replace('<', "\\u003c");
    format!(
        "<script type=\"application/json\" id=\"model\">{data}</script>\n<script>\n{SOLVER}</script>\n<script>\n{SCRIPT}</script>\n"
    )
}

/// Settings and the engine's eigenvalues there, as a table.
pub(super) fn checks(model: &Sliders) -> Vec<u8> {
    let axes = model.axes().iter().map(|axis| &model.factors[axis.factor]).map(|f| (&f.name, &f.unit));
    let settings = axes.chain(model.parameters.iter().map(|p| (&p.name, &p.unit)));
    let settings: Vec<String> = settings.map(|(name, unit)| format!("{name} [{unit}]")).collect();
    let mut text = format!("mode,{},growth_rate [1/s],angular_frequency [rad/s]\n", settings.join(","));
    for check in &model.checks {
        let numbers: Vec<String> = check.iter().map(f64::to_string).collect();
        text += &(numbers.join(",") + "\n");
    }
    text.into_bytes()
}
