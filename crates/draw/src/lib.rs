#![doc = include_str!("../README.md")]

mod axis;
mod bar;
mod figure;
mod files;
mod metrics;
mod panel;
mod pdf;
mod plot;
mod style;
mod symbol;
mod text;

pub use axis::{Axis, multiples, round_step};
pub use bar::ColourBar;
pub use figure::{Figure, Key, Mark};
pub use files::{is_file_of_figures, write_figure, write_figure_as};
pub use panel::{COLUMN, DOT, Panel};
pub use pdf::pdf;
pub use plot::plot_svg;
pub use style::{INK, Stroke, fill_colour, model_stroke, scale_colour, scale_stroke};
pub use symbol::Symbol;
pub use text::{escape, fixed, html};

/// A coordinate with one decimal, the same bytes on every run.
fn px(value: f64) -> String {
    short(&format!("{value:.1}"))
}

/// A number with two decimals.
fn number(value: f64) -> String {
    short(&format!("{value:.2}"))
}

fn short(text: &str) -> String {
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    #[test]
    fn exact_coordinates_are_short() {
        assert_eq!([12.0, 0.5, -0.001, 7.3456].map(super::px), ["12", "0.5", "0", "7.3"]);
    }
}
